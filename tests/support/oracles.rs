//! Scenes whose every texel is known, each beside its closed forms, path by path.

use std::fmt::Write as _;
use std::fs;

use glam::DVec3;
use nephroid::generate::{BrilliantCut, round_brilliant, write_ply};
use nephroid::geometry::{MeshParts, Shape};
use nephroid::reference::closed_form::{
    Bundled, FlatFacets, FlatSlab, ParallelLight, Path, SineWater, SineWave, TexelGrid,
};
use nephroid::scene::Scene;
use nephroid::transport::signature::Signature;

use super::scenes::{bundled, bundled_file, loaded};

/// Specular events followed in tests, by beams and by closed forms alike.
pub const DEPTH: u32 = 8;

/// Scenes with a closed form for every texel, all to as many events as wanted, 2 or more.
pub const NAMES: [&str; 8] = [
    "glass-ball",
    "coffee-cup",
    "mirror-ring",
    "prism",
    "cube",
    "diamond",
    "pane",
    "sine-water",
];

/// A scene, and what there is to know of its receiver.
pub struct Oracle {
    /// One of [`NAMES`].
    pub name: &'static str,
    /// With a receiver of `side` x `side` texels.
    pub scene: Scene,
    /// Every path that brings light, `LD` included where it is known.
    pub layers: Vec<Known>,
}

/// The irradiance [W/m²] of every texel by one path: between two bounds, equal but for what the
/// closed form does not know.
pub struct Known {
    /// The path.
    pub signature: Signature,
    /// Not less than this.
    pub low: Vec<f64>,
    /// Not more than this.
    pub high: Vec<f64>,
}

impl Known {
    /// A map, and how far [W/m²] its quadrature may be off.
    fn new(path: Path, map: Vec<f64>, accuracy: f64) -> Self {
        Self {
            signature: path.signature().parse().unwrap(),
            low: map.iter().map(|value| value - accuracy).collect(),
            high: map.iter().map(|value| value + accuracy).collect(),
        }
    }

    /// Allows for what the quadrature of direct light may not see (its bar is no matter of beams): a corner
    /// of a shadow between nine points of a leaf, 0.035 of its area, 1/64² of the texel's times the
    /// 64 leaves of a border; see `tests/closed_forms.rs`.
    fn with_hidden_corners(mut self) -> Self {
        let brightest = self.high.iter().copied().fold(0.0, f64::max);
        let hidden = (0.035 / 64.0 + 1e-8) * brightest;
        self.low.iter_mut().for_each(|low| *low -= hidden);
        self.high.iter_mut().for_each(|high| *high += hidden);
        self
    }

    /// The lamp of `mirror-ring` is right above the ring's edge, at (−1, 0). There the sliver between the circle
    /// and its tangent, y²/2R wide, is shaded, and all points that the quadrature of direct light looks
    /// at in the two texels at the tangent's foot are lit: a part w/(6R) of a texel of width w.
    fn with_hidden_sliver(mut self, side: usize, width: f64) -> Self {
        let brightest = self.high.iter().copied().fold(0.0, f64::max);
        for row in [side / 2 - 1, side / 2] {
            self.high[row * side + side / 4] += brightest * width / 6.0;
        }
        self
    }

    /// The middle of what is known [W/m²].
    pub fn truth(&self, texel: usize) -> f64 {
        0.5 * (self.low[texel] + self.high[texel])
    }
}

/// The scene of a name, at `side` x `side` texels, known to [`DEPTH`] events.
pub fn oracle(name: &'static str, side: usize) -> Oracle {
    oracle_to(DEPTH, name, side)
}

/// The scene of a name, known to `depth` events.
pub fn oracle_to(depth: u32, name: &'static str, side: usize) -> Oracle {
    let (scene, layers) = match name {
        "pane" => pane(depth, side),
        "sine-water" => sine_water(side),
        "prism" => facets(depth, bundled(name, side), side, 0.25, DVec3::NEG_Z, 1.5),
        "cube" => {
            let sun = DVec3::new(0.5, 0.2, -1.0);
            facets(depth, bundled(name, side), side, 2.0, sun, 1.5)
        }
        "diamond" => {
            let sun = DVec3::new(0.3, 0.1, -1.0);
            facets(depth, exact_diamond(side), side, 1.2, sun, 2.418)
        }
        _ => round(depth, name, side),
    };
    Oracle {
        name,
        scene,
        layers,
    }
}

/// The ball and the cups: shapes of the scene language, without any mesh.
///
/// A sheet of the ball is known to 1e-12 of the flux of the circles that meet a texel (`RadialSheet`); a circle
/// of radius r has 2πr/width texels, and where it is bright it is no longer than that of the fold, some
/// hundred texels: 1e-10 of a texel's value, 1e-9 of the mean with the brightest texel ten times the mean and more. A texel
/// of a cup is integrated to 1e-8 of the unshaded irradiance on each of its windows, of which
/// at most a handful hold a kink that keeps the estimate from being far better than asked.
fn round(depth: u32, name: &'static str, side: usize) -> (Scene, Vec<Known>) {
    let known = Bundled::all(0)
        .into_iter()
        .find(|bundled| bundled.scene == name)
        .unwrap();
    let known_width = 2.0 * known.receiver_half_width;
    let is_cup = name != "glass-ball";
    let cup = |most: u32| {
        std::iter::once(Path::Direct)
            .chain((1..=most).map(Path::Reflected))
            .collect()
    };
    let paths: Vec<Path> = match name {
        "coffee-cup" => cup(depth),
        // What meets the ring, 0.6 as high as the lamp, has come down within c/(1 − 0.6) = 2.5 chords.
        "mirror-ring" => cup(depth.min(2)),
        _ => body(depth),
    };
    let maps: Vec<(Path, Vec<f64>)> = paths
        .into_iter()
        .map(|path| (path, known.map(path, side, 0)))
        .collect();
    let brightest = maps[0].1.iter().copied().fold(0.0, f64::max);
    let accuracy = brightest * if is_cup { 4e-8 } else { 1e-9 };
    let layers = maps
        .into_iter()
        .map(|(path, map)| {
            let known = Known::new(path, map, accuracy);
            match (path, name) {
                (Path::Direct, "mirror-ring") => known
                    .with_hidden_corners()
                    .with_hidden_sliver(side, known_width / side as f64),
                (Path::Direct, _) => known.with_hidden_corners(),
                _ => known,
            }
        })
        .collect();
    (bundled(name, side), layers)
}

/// All paths of a convex body in the open.
fn body(depth: u32) -> Vec<Path> {
    [Path::Direct, Path::Reflected(1)]
        .into_iter()
        .chain((0..=depth - 2).map(Path::Through))
        .collect()
}

/// A convex solid in sunlight. Its polygons are cut from the mesh as the scene has it: a file's `f32`
/// corners are up to 1e-7 off the formulas', which moves every edge by as much.
///
/// Each polygon's share of a texel is a difference of areas of the size of the polygon: 1e-15 of it, that is
/// 1e-11 of a texel for the largest; hundreds of polygons at most add up.
fn facets(
    depth: u32,
    scene: Scene,
    side: usize,
    half_width: f64,
    direction: DVec3,
    ior: f64,
) -> (Scene, Vec<Known>) {
    let parts = scene
        .world()
        .shapes()
        .iter()
        .find_map(|shape| match shape {
            Shape::Mesh(mesh) => Some(MeshParts {
                positions: mesh.positions().to_vec(),
                triangles: mesh.triangles().to_vec(),
                ..MeshParts::default()
            }),
            _ => None,
        })
        .unwrap();
    let light = ParallelLight {
        direction: direction.normalize(),
        irradiance: 1000.0,
    };
    let solid = FlatFacets::new(&parts, ior, light, depth - 2).unwrap();
    let grid = TexelGrid::square(half_width, side);
    let layers = body(depth)
        .into_iter()
        .map(|path| {
            let accuracy = 1e-9 * light.irradiance;
            let known = Known::new(path, solid.map(path, &grid), accuracy);
            if path == Path::Direct {
                known.with_hidden_corners()
            } else {
                known
            }
        })
        .collect();
    (scene, layers)
}

/// The scene `diamond` with corners in `f64`. Rounded to `f32`, the corners of a kite or an octagon are in
/// no plane: the closed form, whose facets are flat, is then off by 1e-5 of a facet's light on its
/// polygon's borders, more than a bar at 0.1 %.
fn exact_diamond(side: usize) -> Scene {
    let mesh = round_brilliant(0.325, BrilliantCut::TOLKOWSKY);
    let mut obj = String::new();
    for at in &mesh.positions {
        // Displayed with as many digits as it takes to read the same bits.
        writeln!(obj, "v {} {} {}", at.x, at.y, at.z).unwrap();
    }
    for [a, b, c] in &mesh.triangles {
        writeln!(obj, "f {} {} {}", a + 1, b + 1, c + 1).unwrap();
    }
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("diamond.obj"), obj).unwrap();
    let xml = fs::read_to_string(bundled_file("diamond")).unwrap();
    let xml = xml
        .replace(r#"type="ply""#, r#"type="obj""#)
        .replace("diamond.ply", "diamond.obj");
    let file = folder.path().join("diamond.xml");
    fs::write(&file, xml).unwrap();
    loaded(&file, side)
}

/// A window between a lamp and a floor, edges out of the way.
const PANE: &str = r#"<scene version="3.0.0">
    <emitter type="point">
        <point name="position" x="0" y="0" z="2"/>
        <rgb name="intensity" value="100, 100, 100"/>
    </emitter>
    <bsdf type="dielectric" id="glass">
        <float name="int_ior" value="1.5"/>
        <float name="ext_ior" value="1"/>
    </bsdf>
    <shape type="rectangle">
        <transform name="to_world"><translate z="1.05"/></transform>
        <ref id="glass"/>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><rotate x="1" angle="180"/><translate z="0.95"/></transform>
        <ref id="glass"/>
    </shape>
    <shape type="rectangle">
        <transform name="to_world"><scale x="0.5" y="0.5"/></transform>
        <bsdf type="diffuse"/>
        <sensor type="irradiancemeter">
            <film type="hdrfilm"><rfilter type="box"/></film>
        </sensor>
    </shape>
</scene>"#;

/// Light on the floor has crossed the pane at less than 20°; each reflection inside moves it by
/// 2 d tan t < 5 cm, so that even the sixth leaves the borders of the pane (2 m) out of play. Direct
/// light there is none.
fn pane(depth: u32, side: usize) -> (Scene, Vec<Known>) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("pane.xml");
    fs::write(&file, PANE).unwrap();
    let scene = loaded(&file, side);
    let pane = FlatSlab {
        thickness: 0.1,
        ior: 1.5,
    };
    let grid = TexelGrid::square(0.5, side);
    let layers = (0..=depth - 2)
        .step_by(2)
        .map(|reflections| {
            let path = Path::Through(reflections);
            let map = pane.sheet(2.0, 100.0, path).map(&grid);
            // As the ball's sheets; a smooth one.
            let accuracy = 1e-9 * map.iter().copied().fold(0.0, f64::max);
            Known::new(path, map, accuracy)
        })
        .collect();
    (scene, layers)
}

/// The wave: its sheet folds above the floor.
pub const WAVE: SineWave = SineWave {
    depth: 0.8,
    amplitude: 0.012,
    wave_number: 18.0,
    phase: 0.3,
    ior: 1.33,
    irradiance: 1000.0,
    half_width: 1.05,
};

/// Cells of the wave's mesh along x.
const CELLS: u32 = 8192;

/// The wave as a strip of cells along x, normals exact at the vertices.
fn strip() -> MeshParts {
    let mut mesh = MeshParts::default();
    let mut normals = Vec::new();
    for i in 0..=CELLS {
        let x = WAVE.half_width * (2.0 * f64::from(i) / f64::from(CELLS) - 1.0);
        let (sin, cos) = (WAVE.wave_number * x + WAVE.phase).sin_cos();
        let slope = WAVE.amplitude * WAVE.wave_number * cos;
        for y in [-WAVE.half_width, WAVE.half_width] {
            mesh.positions
                .push(DVec3::new(x, y, WAVE.depth + WAVE.amplitude * sin));
            normals.push(DVec3::new(-slope, 0.0, 1.0).normalize());
        }
        if i < CELLS {
            let low = 2 * i;
            mesh.triangles.push([low, low + 2, low + 3]);
            mesh.triangles.push([low, low + 3, low + 1]);
        }
    }
    mesh.normals = Some(normals);
    mesh
}

/// How far [m] from the smooth wave's light the strip's can land: derived in `tests/closed_forms.rs`.
fn displacement() -> f64 {
    let h = 2.0 * WAVE.half_width / f64::from(CELLS);
    let slope = WAVE.amplitude * WAVE.wave_number;
    let curvature = slope * WAVE.wave_number;
    let rounding = 2.0_f64.powi(-23);
    let height_error = h * h / 8.0 * curvature + rounding;
    let bend = curvature * WAVE.wave_number + 2.0 * slope * curvature * curvature;
    let angle_error = h * h / 8.0 * bend + (h * curvature).powi(3) / 24.0 + rounding;
    let steepest = slope.atan();
    let turn = steepest - (steepest.sin() / WAVE.ior).asin();
    let tangent_error =
        angle_error * (1.0 - steepest.cos() / WAVE.ior) * (1.0 + turn.tan().powi(2));
    height_error * turn.tan() + (WAVE.depth + WAVE.amplitude) * tangent_error
}

/// The scene `water` with one wave as a fine mesh.
///
/// Its light lands within δ of the smooth wave's: a texel holds no more than the wave sends into it widened by δ
/// on both sides, no less than into it narrowed; in between is what is known. The flux, 1 − F, changes with the
/// mesh's angle errors (below 1e-6) by less than 1e-8, as |dF/dθ| < 0.01 below 13°.
fn sine_water(side: usize) -> (Scene, Vec<Known>) {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("water.xml");
    fs::copy(bundled_file("water"), &file).unwrap();
    let mut bytes = Vec::new();
    write_ply(&strip(), "one wave", &mut bytes).unwrap();
    fs::write(folder.path().join("water.ply"), bytes).unwrap();
    let scene = loaded(&file, side);
    let wave = SineWater::new(WAVE);
    let grid = TexelGrid {
        rows: 1,
        ..TexelGrid::square(0.9, side)
    };
    let width = 1.8 / side as f64;
    let delta = displacement();
    let moved = |by: f64, factor: f64| {
        let row = grid.map(|texel| {
            let mut wider = *texel;
            wider.min.x -= by;
            wider.max.x += by;
            factor * wave.texel_irradiance(&wider) * (wider.max.x - wider.min.x) / width
        });
        row.repeat(side)
    };
    let layer = Known {
        signature: "LTD".parse().unwrap(),
        low: moved(-delta, 1.0 - 1e-8),
        high: moved(delta, 1.0 + 1e-8),
    };
    (scene, vec![layer])
}
