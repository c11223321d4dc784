//! Scenes whose every texel is known, each beside its closed forms, path by path.

use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::fs;

use glam::{DVec2, DVec3};
use nephroid::internals::generate::{BrilliantCut, round_brilliant, write_ply};
use nephroid::internals::geometry::{MeshParts, Shape};
use nephroid::internals::numeric::quadrature::GaussLegendre;
use nephroid::internals::optics::{conductor_reflectance, dielectric_reflectance};
use nephroid::internals::reference::closed_form::{
    Bundled, FlatFacets, FlatSlab, KnownPath, ParabolicMirror, ParallelLight, SineWave, TexelGrid,
};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::signature::Signature;

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
    fn new(path: KnownPath, map: Vec<f64>, accuracy: f64) -> Self {
        Self {
            signature: path.signature().parse().unwrap(),
            low: map.iter().map(|value| value - accuracy).collect(),
            high: map.iter().map(|value| value + accuracy).collect(),
        }
    }

    /// Allows for what the quadrature of direct light may not see (its bar is no matter of beams): a corner
    /// of a shadow between two points 1/16 of a texel apart; see `tests/photons/closed_forms/`.
    fn with_hidden_corners(self) -> Self {
        self.widened_by(1.0 / 1024.0 + 1e-8)
    }

    /// Allows for a part of the brightest texel.
    fn widened_by(mut self, part: f64) -> Self {
        let brightest = self.high.iter().copied().fold(0.0, f64::max);
        self.low.iter_mut().for_each(|low| *low -= part * brightest);
        self.high
            .iter_mut()
            .for_each(|high| *high += part * brightest);
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
/// A sheet of the ball is known to 1e-12 of the flux of the circles that meet a texel (`RadialSheet`); a
/// circle of radius r has 2πr/width texels, and where it is bright it is no longer than that of the fold,
/// some hundred texels: 1e-10 of a texel's value, 1e-9 of the mean with the brightest texel ten times the
/// mean and more. A texel of a cup is integrated to 1e-8 of the unshaded irradiance on each of its windows,
/// of which at most a handful hold a kink that keeps the estimate from being far better than asked.
fn round(depth: u32, name: &'static str, side: usize) -> (Scene, Vec<Known>) {
    let known = Bundled::all(0)
        .into_iter()
        .find(|bundled| bundled.scene == name)
        .unwrap();
    let is_cup = name != "glass-ball";
    let cup = |most: u32| {
        std::iter::once(KnownPath::Direct)
            .chain((1..=most).map(KnownPath::Reflected))
            .collect()
    };
    let paths: Vec<KnownPath> = match name {
        "coffee-cup" => cup(depth),
        // What meets the ring, 0.6 as high as the lamp, has come down within c/(1 − 0.6) = 2.5 chords.
        "mirror-ring" => cup(depth.min(2)),
        _ => body(depth),
    };
    let maps: Vec<(KnownPath, Vec<f64>)> = paths
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
                (KnownPath::Direct, "mirror-ring" | "coffee-cup") => known.with_hidden_corners(),
                // A disc's shadow has none, only the error of Gauss points.
                (KnownPath::Direct, _) => known.widened_by(1e-8),
                _ => known,
            }
        })
        .collect();
    (bundled(name, side), layers)
}

/// All paths of a convex body in the open.
fn body(depth: u32) -> Vec<KnownPath> {
    [KnownPath::Direct, KnownPath::Reflected(1)]
        .into_iter()
        .chain((0..=depth - 2).map(KnownPath::Through))
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
            if path == KnownPath::Direct {
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

/// Top and bottom of a pane, 2 m x 2 m, 0.1 m apart, above a floor of 1 m x 1 m; a lamp 2 m above the floor.
///
/// The closed form's pane has no borders. Here light that lands on the floor after LTT or LTRRT has met
/// the faces nearer to the axis than it lands, within the faces; the sides are open, so that
/// none is reflected back there (it leaves as LT, no path that is compared).
pub const PANE: &str = r#"<scene version="3.0.0">
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
            let path = KnownPath::Through(reflections);
            let map = pane.sheet(2.0, 100.0, path).map(&grid);
            // As the ball's sheets; a smooth one.
            let accuracy = 1e-9 * map.iter().copied().fold(0.0, f64::max);
            Known::new(path, map, accuracy)
        })
        .collect();
    (scene, layers)
}

/// The wave that stands in for those of the scene `water`.
///
/// Its crests focus n/((n − 1) A k²) = 1.04 m below it: the floor is before that, and the sheet does not fold
/// on it.
pub const WAVE: SineWave = SineWave {
    depth: 0.8,
    amplitude: 0.012,
    wave_number: 18.0,
    phase: 0.3,
    ior: 1.33,
    irradiance: 1000.0,
    half_width: 1.05,
};

/// Cells of the wave's mesh along x: each sends its light over some two texels of 128, and nine of 512, so
/// that beams have to divide it.
const CELLS: u32 = 64;

/// The wave as a strip of `cells` cells along x, normals exact at the vertices.
fn strip(cells: u32) -> MeshParts {
    let mut mesh = MeshParts::default();
    let mut normals = Vec::new();
    for i in 0..=cells {
        let x = WAVE.half_width * (2.0 * f64::from(i) / f64::from(cells) - 1.0);
        let (sin, cos) = (WAVE.wave_number * x + WAVE.phase).sin_cos();
        let slope = WAVE.amplitude * WAVE.wave_number * cos;
        for y in [-WAVE.half_width, WAVE.half_width] {
            mesh.positions
                .push(DVec3::new(x, y, WAVE.depth + WAVE.amplitude * sin));
            normals.push(DVec3::new(-slope, 0.0, 1.0).normalize());
        }
        if i < cells {
            let low = 2 * i;
            mesh.triangles.push([low, low + 2, low + 3]);
            mesh.triangles.push([low, low + 3, low + 1]);
        }
    }
    mesh.normals = Some(normals);
    mesh
}

/// The scene `water` with one wave, a strip of `cells` cells.
pub fn one_wave(cells: u32, side: usize) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("water.xml");
    fs::copy(bundled_file("water"), &file).unwrap();
    let mut bytes = Vec::new();
    write_ply(&strip(cells), "one wave", &mut bytes).unwrap();
    fs::write(folder.path().join("water.ply"), bytes).unwrap();
    loaded(&file, side)
}

/// The scene `water` with one wave as a coarse mesh, whose light is known as that of the mesh.
fn sine_water(side: usize) -> (Scene, Vec<Known>) {
    let scene = one_wave(CELLS, side);
    let row = below_a_strip(&scene, &TexelGrid::square(0.9, side));
    // An end of a branch is known to 1e-8 of a cell, √ε, and a cell is half a texel of 512 at least: with two
    // ends in each texel, 1e-8 · 10 · 2 of the light of sun on it. The rest is rounding.
    let accuracy = 2e-7 * WAVE.irradiance;
    let layer = Known {
        signature: "LTD".parse().unwrap(),
        low: row
            .iter()
            .map(|value| value - accuracy)
            .collect::<Vec<_>>()
            .repeat(side),
        high: row
            .iter()
            .map(|value| value + accuracy)
            .collect::<Vec<_>>()
            .repeat(side),
    };
    (scene, vec![layer])
}

/// The irradiance [W/m²] of a row of texels under the sun, below a strip of cells along x whose normals are
/// interpolated.
///
/// The sun's ray at x lands at X(x), by Snell's law in the plane at the strip's own height and normal. A
/// texel gets ∫ E (1 − F) dx over all x with X(x) in it. In a cell X has one extremum at most, a fold, and is
/// inverted by bisection on either side of it. Gauss's rule sums the light between two texel lines, exact to
/// rounding as F hardly changes in a cell.
fn below_a_strip(scene: &Scene, grid: &TexelGrid) -> Vec<f64> {
    let Some(Shape::Mesh(mesh)) = scene
        .world()
        .shapes()
        .iter()
        .find(|shape| matches!(shape, Shape::Mesh(_)))
    else {
        panic!("the water is a mesh");
    };
    let rule = GaussLegendre::new(8).unwrap();
    let (left, width) = (
        grid.bounds.min.x,
        grid.texel(0, 0).max.x - grid.texel(0, 0).min.x,
    );
    let mut flux = vec![0.0; grid.columns];
    for cell in 0..CELLS {
        // The edge at least y of the first of the cell's two triangles.
        let face = 2 * cell;
        let [a, b, _] = mesh.corners(face);
        let step = b.x - a.x;
        let at = |t: f64| mesh.at_barycentric(face, DVec2::new(t, 0.0), DVec3::Z);
        let landing = |t: f64| {
            let point = at(t);
            let angle = f64::atan2(-point.shading_normal.x, point.shading_normal.z);
            let turned = angle - (angle.sin() / WAVE.ior).asin();
            point.position.x + point.position.z * turned.tan()
        };
        let lit = |t: f64| 1.0 - dielectric_reflectance(at(t).shading_normal.z, WAVE.ior);
        let fold = extremum(&landing);
        for [from, to] in [[0.0, fold], [fold, 1.0]] {
            let [x, y] = [landing(from), landing(to)];
            let (low, high) = (x.min(y), x.max(y));
            let first = ((low - left) / width).floor().max(0.0) as usize;
            let mut before = inverse(&landing, from, to, left + width * first as f64);
            for (column, flux) in flux.iter_mut().enumerate().skip(first) {
                if left + width * column as f64 > high {
                    break;
                }
                let after = inverse(&landing, from, to, left + width * (column + 1) as f64);
                let (a, b) = (before.min(after), before.max(after));
                *flux += rule.integrate(a, b, lit) * step;
                before = after;
            }
        }
    }
    flux.iter()
        .map(|flux| flux * WAVE.irradiance / width)
        .collect()
}

/// Place in [0, 1] of the only extremum of a function, by golden sections; an end if there is none.
fn extremum(f: &impl Fn(f64) -> f64) -> f64 {
    /// As near to an end as an extremum is known.
    const END: f64 = 1e-8;
    let golden = 0.5 * (5.0_f64.sqrt() - 1.0);
    let [first, last] = [f(0.0), f(1.0)];
    // A cell has a lowest or a highest point where it first goes away from its other end.
    let sign = if (f(END) - first) * (f(1.0 - END) - last) > 0.0 {
        // Both ends are on the same side of what is between.
        (first - f(END)).signum()
    } else {
        return 1.0;
    };
    let (mut a, mut b) = (0.0, 1.0);
    for _ in 0..64 {
        let (c, d) = (b - golden * (b - a), a + golden * (b - a));
        if sign * f(c) < sign * f(d) {
            b = d;
        } else {
            a = c;
        }
    }
    0.5 * (a + b)
}

/// Place in [from, to] at which a monotone function is `value`, or the end nearest to that.
fn inverse(f: &impl Fn(f64) -> f64, from: f64, to: f64, value: f64) -> f64 {
    let rises = f(to) > f(from);
    let (mut a, mut b) = (from, to);
    if (f(from) >= value) == rises {
        return from;
    }
    if (f(to) <= value) == rises {
        return to;
    }
    for _ in 0..60 {
        let middle = 0.5 * (a + b);
        if (f(middle) < value) == rises {
            a = middle;
        } else {
            b = middle;
        }
    }
    0.5 * (a + b)
}

/// Flux \[W\] that the shipped dish gathers, by channel: the paraboloid's flux without the slivers between
/// its rim's polygon and the circle.
pub fn dish_fluxes() -> [f64; 3] {
    [(1.66, 9.22), (0.88, 6.27), (0.52, 4.84)].map(|(eta, k)| {
        let dish = ParabolicMirror {
            focal_length: 0.5,
            aperture: 0.5,
            receiver_height: 0.45,
            irradiance: 1000.0,
            shade_half_width: 0.08,
            eta,
            k,
        };
        let corners = 6.0 * 28.0;
        let turn = TAU / corners;
        let slivers = 0.5 * corners * (turn - turn.sin()) * dish.aperture.powi(2);
        let rim = 1000.0 * conductor_reflectance(1.0 / 1.0_f64.hypot(0.5), eta, k);
        dish.received_flux() - slivers * rim
    })
}
