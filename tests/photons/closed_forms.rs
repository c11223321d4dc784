//! Photon estimates of whole scenes against closed forms, one path signature at a time.
//!
//! The closed forms (`nephroid::reference::closed_form`) trace nothing: each is a map derived by
//! hand. Three questions are put to every scene:
//!
//! - **regions**: does the flux of every region of a coarse grid, and that of the whole receiver, lie
//!   within Student's quantile of the truth, in units of the estimate's own error bar?
//! - **texels**: do the z-scores of a fine grid have the mean 0 and the variance of Student's t?
//! - **darkness**: where no light can come, is there exactly none?
//!
//! All of this file together fails a right program with a probability below [`ALPHA`]; as the
//! seeds are fixed, it either always passes or never.

use std::fs;

use glam::{DVec2, DVec3};
use nephroid::generate::write_ply;
use nephroid::geometry::{MeshParts, Shape};
use nephroid::numeric::StreamKind;
use nephroid::reference::closed_form::{
    CupLight, FlatFacets, FlatSlab, GlassBall, KnownPath, MirrorCup, ParallelLight, SineWater,
    SineWave, TexelGrid, lambert_irradiance, point_irradiance,
};
use nephroid::reference::{Estimate, LayerName};
use nephroid::scene::Scene;

use crate::support::oracles::{PANE, dish_fluxes};
use crate::support::scenes::layer;
use crate::support::{Compared, Photons, bundled, bundled_file, loaded, student};

/// The probability that a right program fails this file.
const ALPHA: f64 = 1e-6;

/// More than the comparisons of this file: about 60 layers of at most 256 regions, and a handful
/// of moments. ALPHA is shared among them.
const COMPARISONS: usize = 20_000;

/// Regions a side of a coarse grid: large enough for thousands of photons each.
const REGIONS: usize = 16;

impl Compared {
    fn assert_regions(&self, least: usize) {
        self.assert_every_texel_agrees(least, ALPHA, COMPARISONS);
    }

    fn assert_texels(&self, least: usize) {
        self.assert_every_texel_agrees(least, ALPHA, COMPARISONS);
        self.assert_honest_errors(least, ALPHA, COMPARISONS);
    }
}

/// Both kinds of sample points.
const STREAMS: [StreamKind; 2] = [StreamKind::Sobol, StreamKind::Random];

/// Direct light is no random estimate: its error is a bound, and the closed form must lie within.
///
/// 2 x 2 Gauss points on leaves below 1/64 of the distance err by less than 1e-8 of the irradiance. A corner of
/// a shadow may hide between two points that are 1/16 of a texel apart: at most a right-angled triangle of
/// (1/16)²/4 of the texel.
fn assert_direct_light_is_within_its_bound(estimate: &Estimate, truth: &[f64]) {
    let (values, bounds) = layer(estimate, "LD", 0);
    let brightest = truth.iter().fold(0.0, |most: f64, value| most.max(*value));
    assert!(brightest > 0.0);
    let hidden = brightest / 1024.0;
    let mut error = 0.0;
    for texel in 0..truth.len() {
        let off = (values[texel] - truth[texel]).abs();
        let allowed = bounds[texel] + 1e-8 * truth[texel] + hidden;
        error += bounds[texel];
        assert!(
            off <= allowed,
            "texel {texel}: {} ± {}, the closed form {}: off by {off:e}, allowed {allowed:e}",
            values[texel],
            bounds[texel],
            truth[texel]
        );
    }
    // Bounds that allow anything would prove nothing. A texel on an edge is uncertain by about 1e-4 of its light
    // (`tests/lights/direct.rs`), where edges of several things run by 1/64 of it.
    let lit: f64 = truth.iter().sum();
    println!("LD: the bounds are {:.1e} of all light", error / lit);
    assert!(error < 2e-3 * lit, "{error} of {lit}");
}

// ---- glass-ball: a lamp straight above a ball straight above a floor -------------------------

fn ball_grid(side: usize) -> TexelGrid {
    TexelGrid::square(2.0, side)
}

/// Of the paths that begin with T and R, each photon takes the flux (1 − F) F ≤ 1/4 along:
/// both events are split, later ones keep the flux whole.
const AFTER_TR: f64 = 0.25;

/// The whole flux of a path on the floor is that of the rays whose foot lies in the square: the
/// sum of the radial map's texels, here one texel of 4 m.
#[test]
fn the_glass_balls_flux_is_right_in_every_path() {
    let scene = bundled("glass-ball", 1);
    let photons = Photons::new(1 << 22);
    let estimate = photons.estimate(&scene);
    let compare = |path: KnownPath, largest_share: f64| {
        let truth = GlassBall::SHIPPED.sheet(path).map(&ball_grid(1));
        Compared::new(&scene, &photons, &estimate, &path.signature(), &truth)
            .photons_carry_at_most(largest_share)
    };
    compare(KnownPath::Through(0), 1.0).assert_regions(1);
    compare(KnownPath::Reflected(1), 1.0).assert_regions(1);
    for reflections in [2, 3, 7] {
        compare(KnownPath::Through(reflections), AFTER_TR).assert_regions(1);
    }
    // One reflection inside sends all light upward or far away: none of it on this floor.
    let none = compare(KnownPath::Through(1), AFTER_TR);
    assert_eq!((none.high[0], none.estimate[0]), (0.0, 0.0));
}

/// In each region of the floor, LTTD, LRD and LTRRRTD carry the flux of those rays of the radial map that
/// land there. (By symmetry most of LTTD is in the middle; LRD is faint and everywhere.)
#[test]
fn the_glass_balls_light_falls_into_the_right_regions() {
    for (path, side, largest_share, least) in [
        (KnownPath::Through(0), REGIONS, 1.0, 12),
        (KnownPath::Reflected(1), 4, 1.0, 4),
        (KnownPath::Through(3), 2, AFTER_TR, 4),
    ] {
        let scene = bundled("glass-ball", side);
        let photons = Photons::new(1 << 20);
        let estimate = photons.estimate(&scene);
        let truth = GlassBall::SHIPPED.sheet(path).map(&ball_grid(side));
        let it = Compared::new(&scene, &photons, &estimate, &path.signature(), &truth)
            .photons_carry_at_most(largest_share);
        println!("{}: {:?}", it.name, it.agreement());
        it.assert_regions(least);
        it.assert_darkness_is_exact(&ball_grid(side), 0);
    }
}

/// Fold, axis focus and all: the texel-exact radial map against each texel of the caustic.
#[test]
fn the_glass_balls_texels_scatter_about_the_truth_as_their_error_bars_say() {
    const SIDE: usize = 128;
    let scene = bundled("glass-ball", SIDE);
    let truth = GlassBall::SHIPPED
        .sheet(KnownPath::Through(0))
        .map(&ball_grid(SIDE));
    for stream in STREAMS {
        let photons = Photons::new(1 << 21).stream(stream);
        let estimate = photons.estimate(&scene);
        let it = Compared::new(&scene, &photons, &estimate, "LTTD", &truth);
        println!("{stream:?} {}: {:?}", it.name, it.agreement());
        it.assert_texels(300);
        it.assert_darkness_is_exact(&ball_grid(SIDE), 1000);
    }
}

/// Outside of the shadow disc of radius (D + h) tan asin(R/D) each texel has the lamp's solid-angle
/// irradiance; on the disc's border the part of it that is outside.
#[test]
fn the_glass_balls_shadow_is_a_disc() {
    let scene = bundled("glass-ball", 64);
    let estimate = Photons::new(64).estimate(&scene);
    let truth = GlassBall::SHIPPED
        .sheet(KnownPath::Direct)
        .map(&ball_grid(64));
    assert_direct_light_is_within_its_bound(&estimate, &truth);
}

/// The bar of the project: at 512 x 512 texels, 2^24 photons and default settings, the caustic is right to 1.2 %
/// (root mean square over its texels), and the error bars say so.
///
/// The caustic: where LTTD alone is brighter than the bare floor would be, that is, where light is
/// concentrated. There z-scores are Student's with 31 degrees of freedom: variance 31/29 = 1.069.
/// The bar allows 0.9 to 1.1; of 4,500 texels the variance is known to ±0.024.
#[test]
#[ignore = "2^24 photons: half a minute; cargo test --release --test photons bar_ -- --ignored"]
fn bar_the_glass_ball_at_default_settings_is_right_to_1_2_percent() {
    const SIDE: usize = 512;
    let scene = bundled("glass-ball", SIDE);
    let photons = Photons::new(1 << 24);
    assert_eq!(photons.settings, Default::default());
    let estimate = photons.estimate(&scene);
    let grid = ball_grid(SIDE);
    let lamp = DVec3::new(0.0, 0.0, 4.0);
    let bare = grid.map(|texel| point_irradiance(lamp, 100.0, texel));
    let truth = GlassBall::SHIPPED.sheet(KnownPath::Through(0)).map(&grid);
    let caustic = |texel: usize| truth[texel] > bare[texel];
    let layer = Compared::new(&scene, &photons, &estimate, "LTTD", &truth);
    let it = layer.agreement_of(caustic);
    println!("LTTD, caustic: {it:?}");
    // For the record: where the light is faint a texel gets few photons or none, and no error bar worth its name.
    let reflected = GlassBall::SHIPPED.sheet(KnownPath::Reflected(1)).map(&grid);
    let other = Compared::new(&scene, &photons, &estimate, "LRD", &reflected);
    for (layer, truth) in [(&layer, &truth), (&other, &reflected)] {
        let seen = |texel: usize| layer.estimate[texel] > 0.0;
        let lit = |texel: usize| truth[texel] > 0.0;
        println!(
            "{}, all lit texels: {:?}",
            layer.name,
            layer.agreement_of(lit)
        );
        println!(
            "those with photons: {:?}",
            layer.agreement_of(|it| lit(it) && seen(it))
        );
    }
    assert!(it.texels > 4000, "{it:?}");
    assert!(it.relative_rmse <= 0.012, "{it:?}");
    assert!((0.9..=1.1).contains(&it.variance), "{it:?}");
    // Five standard deviations of the mean of so many scores.
    assert!(
        it.mean.abs() <= 5.0 * (it.variance / it.texels as f64).sqrt(),
        "{it:?}"
    );
}

// ---- flat facets: cube, prism, diamond ----------------------------------------------------------

/// The one mesh of a scene that refracts, in world space, and the closed form of its light.
fn facets(scene: &Scene, direction: DVec3, ior: f64, most_reflections: u32) -> FlatFacets {
    let mesh = scene
        .world()
        .shapes()
        .iter()
        .find_map(|shape| match shape {
            Shape::Mesh(mesh) => Some(mesh),
            _ => None,
        })
        .unwrap();
    let parts = MeshParts {
        positions: mesh.positions().to_vec(),
        triangles: mesh.triangles().to_vec(),
        ..MeshParts::default()
    };
    let light = ParallelLight {
        direction: direction.normalize(),
        irradiance: 1000.0,
    };
    FlatFacets::new(&parts, ior, light, most_reflections).unwrap()
}

/// A bundled scene of one convex solid with flat facets in sunlight.
struct Facets {
    name: &'static str,
    /// Of the floor [m].
    half_width: f64,
    /// Of the sunlight; any length.
    direction: DVec3,
    ior: f64,
    /// Inside, followed by the closed form.
    most_reflections: u32,
}

impl Facets {
    /// Every layer of the estimate is one that the closed form has, and agrees with it in every region; at
    /// least `least` regions of all layers together can be judged.
    fn assert_agree(&self, side: usize, least: usize) {
        let scene = bundled(self.name, side);
        let grid = TexelGrid::square(self.half_width, side);
        let solid = facets(&scene, self.direction, self.ior, self.most_reflections);
        let photons = Photons::new(1 << 20);
        let estimate = photons.estimate(&scene);
        let mut judged = 0;
        for found in &estimate.layers {
            let LayerName::Path(signature) = found.name else {
                continue;
            };
            let text = signature.to_string();
            let path = (0..signature.len() as u32)
                .map(KnownPath::Through)
                .chain([KnownPath::Direct, KnownPath::Reflected(1)])
                .find(|path| path.signature() == text)
                .unwrap_or_else(|| panic!("a convex solid has no path {text}"));
            let truth = solid.map(path, &grid);
            if path == KnownPath::Direct {
                assert_direct_light_is_within_its_bound(&estimate, &truth);
            } else if signature.len() as u32 <= self.most_reflections + 2 {
                let it = Compared::new(&scene, &photons, &estimate, &text, &truth);
                println!("{} {side}: {:?}", it.name, it.agreement());
                judged += it.judged().count();
                it.assert_regions(0);
                it.assert_darkness_is_exact(&grid, 0);
            }
        }
        assert!(judged >= least, "{}: {judged} regions judged", self.name);
    }
}

/// Through top and bottom the cube is a slab (lateral shift, Fresnel's series by signature); through
/// its sides light is totally reflected. All of it polygons.
#[test]
fn the_cubes_light_falls_into_the_right_regions_in_every_path() {
    let cube = Facets {
        name: "cube",
        half_width: 2.0,
        direction: DVec3::new(0.5, 0.2, -1.0),
        ior: 1.5,
        most_reflections: 14,
    };
    cube.assert_agree(1, 3);
    cube.assert_agree(REGIONS, 40);
}

/// At minimum deviation light crosses the prism along its base; each path lands in sharp-edged
/// polygons.
#[test]
fn the_prisms_light_falls_into_the_right_regions_in_every_path() {
    let prism = Facets {
        name: "prism",
        half_width: 0.25,
        direction: DVec3::NEG_Z,
        ior: 1.5,
        most_reflections: 14,
    };
    prism.assert_agree(1, 2);
    prism.assert_agree(REGIONS, 30);
}

/// A brilliant's light leaves after many total reflections, in hundreds of polygons.
#[test]
fn the_diamonds_light_falls_into_the_right_regions_in_every_path() {
    let diamond = Facets {
        name: "diamond",
        half_width: 1.2,
        direction: DVec3::new(0.3, 0.1, -1.0),
        ior: 2.418,
        most_reflections: 6,
    };
    diamond.assert_agree(1, 4);
    diamond.assert_agree(REGIONS, 15);
}

// ---- mirror cups: nephroid and cardioid -------------------------------------------------------

/// The scene `coffee-cup`.
const CUP: MirrorCup = MirrorCup {
    radius: 4.0,
    height: 8.0,
    reflectance: 1.0,
    light: CupLight::Parallel {
        tan_angle: 0.6,
        irradiance: 1000.0,
    },
};

/// The scene `mirror-ring`.
const RING: MirrorCup = MirrorCup {
    radius: 1.0,
    height: 0.6,
    reflectance: 1.0,
    light: CupLight::Point {
        distance: 1.0,
        height: 1.0,
        intensity: 10.0,
    },
};

/// Seen from above a ray in an upright mirror cylinder is a billiard in a circle; what each region cuts out
/// of each reflected chord adds up to its flux. Known to 1e-8 of the bare bottom's irradiance.
fn assert_cup_agrees(name: &str, cup: &MirrorCup, half_width: f64, bare: f64, side: usize) {
    let scene = bundled(name, side);
    let grid = TexelGrid::square(half_width, side);
    for stream in STREAMS {
        let photons = Photons::new(1 << 20).stream(stream);
        let estimate = photons.estimate(&scene);
        for reflections in [1, 2] {
            let path = KnownPath::Reflected(reflections);
            let it = Compared::new(
                &scene,
                &photons,
                &estimate,
                &path.signature(),
                &cup.map(path, &grid),
            )
            .known_to(1e-8 * bare);
            println!("{stream:?} {} {side}: {:?}", it.name, it.agreement());
            if side == 1 {
                it.assert_regions(1);
            } else if reflections == 1 {
                it.assert_texels(80);
            } else {
                it.assert_regions(5);
            }
        }
    }
}

/// LRD is the nephroid's sheet, LRRD the one with its caustic at three quarters of R cos φ.
#[test]
fn the_coffee_cups_nephroid_is_right_in_every_texel() {
    assert_cup_agrees("coffee-cup", &CUP, 4.0, 1000.0, 1);
    assert_cup_agrees("coffee-cup", &CUP, 4.0, 1000.0, 20);
}

/// LRD is the cardioid's sheet of a lamp above the ring's edge.
#[test]
fn the_mirror_rings_cardioid_is_right_in_every_texel() {
    assert_cup_agrees("mirror-ring", &RING, 2.0, 10.0, 1);
    assert_cup_agrees("mirror-ring", &RING, 2.0, 10.0, 32);
}

// ---- a pane under a lamp -------------------------------------------------------------------------

/// Each ray lands (k + 1) d tan t − d tan θ further out than without the pane, with (1 − F)² F^k of its
/// flux after k = 0, 2 reflections inside; nothing else comes through.
#[test]
fn a_pane_shifts_light_and_dims_it_by_fresnels_series() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("pane.xml");
    fs::write(&file, PANE).unwrap();
    let pane = FlatSlab {
        thickness: 0.1,
        ior: 1.5,
    };
    for side in [1, 8] {
        let scene = loaded(&file, side);
        let photons = Photons::new(1 << 21);
        let estimate = photons.estimate(&scene);
        // Light on the floor has met the pane at less than 20°, where (1 − F) F < 0.04.
        for (reflections, largest_share) in [(0, 1.0), (2, 0.04)] {
            let path = KnownPath::Through(reflections);
            let truth = pane
                .sheet(2.0, 100.0, path)
                .map(&TexelGrid::square(0.5, side));
            let it = Compared::new(&scene, &photons, &estimate, &path.signature(), &truth)
                .photons_carry_at_most(largest_share);
            println!("{} {side}: {:?}", it.name, it.agreement());
            it.assert_regions(if reflections == 0 || side == 1 {
                side * side
            } else {
                0
            });
        }
        let odd = layer(&estimate, "LTRTD", 0).0;
        assert!(odd.iter().all(|value| *value == 0.0));
    }
}

// ---- one wave on water ---------------------------------------------------------------------------

/// The wave that stands in for those of the scene `water`: its crests focus 1.04 m below it, under the floor.
const WAVE: SineWave = SineWave {
    depth: 0.8,
    amplitude: 0.012,
    wave_number: 18.0,
    phase: 0.3,
    ior: 1.33,
    irradiance: 1000.0,
    half_width: 1.05,
};

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

/// How far [m] from the smooth wave's light the strip's light can land.
///
/// In a cell of width h the height errs by h²/8 · A k², and light turned by u lands that times tan u off. The normal's
/// angle φ = atan(A k cos) errs by h²/8 · max |φ''|, φ'' ≤ A k³ + 2 (A k)(A k²)², plus what
/// interpolating unit vectors instead of angles adds, below (h φ')³/24; the file's `f32` normals and
/// positions add 2⁻²⁴ each (times 2 for roundings of both components).
/// The turn θ − t changes by at most 1 − cos θ/n per unit of φ, and its tangent by
/// 1 + tan² u times that, over the height z.
fn displacement(cells: u32) -> f64 {
    let SineWave {
        depth,
        amplitude,
        wave_number,
        ior,
        half_width,
        ..
    } = WAVE;
    let h = 2.0 * half_width / f64::from(cells);
    let slope = amplitude * wave_number;
    let curvature = slope * wave_number;
    let rounding = 2.0_f64.powi(-23);
    let height_error = h * h / 8.0 * curvature + rounding;
    let bend = curvature * wave_number + 2.0 * slope * curvature * curvature;
    let angle_error = h * h / 8.0 * bend + (h * curvature).powi(3) / 24.0 + rounding;
    let steepest = slope.atan();
    let turn = steepest - (steepest.sin() / ior).asin();
    let tangent_error = angle_error * (1.0 - steepest.cos() / ior) * (1.0 + turn.tan().powi(2));
    height_error * turn.tan() + (depth + amplitude) * tangent_error
}

/// The strip's light lands within δ of the smooth wave's, so what falls into a texel is at most what the smooth wave
/// sends into the texel widened by δ on both sides, and at least what it sends into the narrowed one. The rest
/// of the flux, 1 − F, changes by less than 1e-5 with the angle errors above (|dF/dθ| < 0.01 below 13°).
#[test]
fn one_wave_on_water_makes_its_caustic_lines() {
    const CELLS: u32 = 2048;
    const SIDE: usize = 24;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("water.xml");
    fs::copy(bundled_file("water"), &file).unwrap();
    let mut bytes = Vec::new();
    write_ply(&strip(CELLS), "one wave", &mut bytes).unwrap();
    fs::write(folder.path().join("water.ply"), bytes).unwrap();
    let scene = loaded(&file, SIDE);
    let wave = SineWater::new(WAVE);
    let grid = TexelGrid::square(0.9, SIDE);
    let truth = wave.map(&grid);
    let delta = displacement(CELLS);
    let width = 1.8 / SIDE as f64;
    assert!(delta < 1e-4 * width, "{delta} blurs the caustic");
    let moved = |by: f64| {
        grid.map(|texel| {
            let mut wider = *texel;
            wider.min.x -= by;
            wider.max.x += by;
            wave.texel_irradiance(&wider) * (wider.max.x - wider.min.x) / width
        })
    };
    let (narrow, wide) = (moved(-delta), moved(delta));
    for stream in STREAMS {
        let photons = Photons::new(1 << 21).stream(stream);
        let estimate = photons.estimate(&scene);
        let mut it = Compared::new(&scene, &photons, &estimate, "LTD", &truth);
        it.low = narrow.iter().map(|low| low * (1.0 - 1e-5)).collect();
        it.high = wide.iter().map(|high| high * (1.0 + 1e-5)).collect();
        println!("{stream:?} {}: {:?}", it.name, it.agreement());
        it.assert_texels(SIDE * SIDE / 2);
    }
}

// ---- a dish in the sun ---------------------------------------------------------------------------

/// The flux on the receiver is that of the whole dish's paraboloid, without the square that the receiver
/// shades, and without the slivers between the mesh's rim, a polygon of 6 · 28 corners, and the circle. Each channel has its own metal.
///
/// The mesh's interpolated normals err by less than 1e-4 rad, over which the reflectance
/// changes by less than 1e-6; all light still lands well within the receiver (at most 0.067 of 0.08 m).
#[test]
fn the_dish_gathers_its_apertures_flux_in_every_channel() {
    let scene = bundled("parabolic-mirror", 1);
    let photons = Photons::new(1 << 20);
    let estimate = photons.estimate(&scene);
    for (channel, flux) in dish_fluxes().into_iter().enumerate() {
        let truth = [flux / 0.0256];
        let it = Compared::channel(&scene, &photons, &estimate, "LRD", channel, &truth)
            .known_to(1e-6 * truth[0]);
        println!("{}: {:?}", it.name, it.agreement());
        it.assert_regions(1);
    }
}

// ---- an area light ---------------------------------------------------------------------------------

/// Direct light of a square lamp is Lambert's formula wherever the ball cannot stand between: where, as seen
/// from the floor, the cones round the lamp and round the ball are apart.
///
/// The formula is averaged over each texel by 2 x 2 Gauss points, which err by (size/distance)⁴/100 < 1e-9.
/// 16 replicates give each texel's error bar: 15 degrees of freedom.
#[test]
fn the_square_lamps_direct_light_is_lamberts() {
    const SIDE: usize = 64;
    const GAUSS: f64 = 0.288_675_134_594_812_9;
    let scene = bundled("cornell-glass", SIDE);
    let photons = Photons::new(64);
    let estimate = photons.estimate(&scene);
    // Facing down: counter-clockwise as seen from below.
    let corner = |x: f64, y: f64| DVec3::new(0.25 * x, 0.25 * y, 1.98);
    let lamp = [
        corner(-1.0, -1.0),
        corner(-1.0, 1.0),
        corner(1.0, 1.0),
        corner(1.0, -1.0),
    ];
    let lamp_radius = 0.25 * 2.0_f64.sqrt();
    let is_clear = |point: DVec3| {
        let to_lamp = DVec3::new(0.0, 0.0, 1.98) - point;
        let to_ball = DVec3::new(0.3, -0.2, 0.45) - point;
        let cones =
            (lamp_radius / to_lamp.length()).asin() + (0.4 / to_ball.length()).min(1.0).asin();
        to_lamp.angle_between(to_ball) > cones
    };
    let grid = TexelGrid::square(1.0, SIDE);
    let truth = grid.map(|texel| {
        let (middle, size) = (0.5 * (texel.min + texel.max), texel.max - texel.min);
        let points = [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
            .map(|(x, y)| (middle + size * DVec2::new(x, y) * GAUSS).extend(0.0));
        let corners = [(-0.5, -0.5), (-0.5, 0.5), (0.5, -0.5), (0.5, 0.5)]
            .map(|(x, y)| (middle + size * DVec2::new(x, y)).extend(0.0));
        if corners.iter().all(|corner| is_clear(*corner)) {
            points
                .iter()
                .map(|&point| 0.25 * lambert_irradiance(point, DVec3::Z, &lamp, 40.0))
                .sum()
        } else {
            0.0
        }
    });
    let mut it = Compared::new(&scene, &photons, &estimate, "LD", &truth);
    it.freedom = 15;
    it.replicates = 16.0;
    it.name
        .push_str(" (whose error is a bound where the lamp is small and unhidden)");
    // Every texel gets 8 samples of each replicate, whatever falls into it: only where the closed form is
    // not known is nothing judged. Smooth over texel and lamp, they are nearly normal.
    it.photons = truth
        .iter()
        .map(|value| if *value > 0.0 { f64::INFINITY } else { 0.0 })
        .collect();
    println!("{}: {:?}", it.name, it.agreement());
    it.assert_regions(2000);
}

/// In the ball's shadow the lamp's light is a sum over the part of the lamp that a point sees: of those rays that
/// pass the ball's centre at more than its radius.
///
/// 100 x 100 points of the lamp at 2 x 2 Gauss points of the texel. The border of the visible part crosses at most
/// 2 · 100 of 100² cells, so each sum is known to a fiftieth of the whole lamp's light.
///
/// A texel has 128 samples: where a few hundredths of the lamp are hidden, or visible, often none of them tells, and
/// its error bar is of no use. So texels are judged together, by the share h of the lamp that is hidden from them: the
/// variance of their sum is at most that of independent samples, whole² h (1 − h)/128 each (and 2 % of it
/// where nothing is hidden, for the lamp's own shading).
#[test]
fn the_square_lamps_light_fades_into_the_balls_shadow() {
    const SIDE: usize = 64;
    const CUTS: usize = 100;
    const GAUSS: f64 = 0.288_675_134_594_812_9;
    let scene = bundled("cornell-glass", SIDE);
    let photons = Photons::new(64);
    let estimate = photons.estimate(&scene);
    let (ball, radius) = (DVec3::new(0.3, -0.2, 0.45), 0.4);
    let lamp = TexelGrid::square(0.25, CUTS);
    // The whole lamp's and the visible part's.
    let irradiance = |point: DVec3| {
        let mut sums = DVec2::ZERO;
        for i in 0..CUTS * CUTS {
            let cell = lamp.texel(i % CUTS, i / CUTS);
            let offset = (0.5 * (cell.min + cell.max)).extend(1.98) - point;
            let squared = offset.length_squared();
            let value = 40.0 * offset.z * offset.z / (squared * squared) * cell.area();
            let to_ball = ball - point;
            let is_hidden = to_ball.cross(offset).length_squared() < radius * radius * squared;
            sums += DVec2::new(value, if is_hidden { 0.0 } else { value });
        }
        sums
    };
    let grid = TexelGrid::square(1.0, SIDE);
    let average = |texel: &nephroid::reference::closed_form::TexelRect| {
        let (middle, size) = (0.5 * (texel.min + texel.max), texel.max - texel.min);
        [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)]
            .map(|(x, y)| irradiance((middle + size * DVec2::new(x, y) * GAUSS).extend(0.0)) * 0.25)
            .into_iter()
            .sum::<DVec2>()
    };
    let known: std::sync::Mutex<Vec<(DVec2, DVec2)>> = std::sync::Mutex::default();
    grid.map(|texel| {
        known.lock().unwrap().push((texel.min, average(texel)));
        0.0
    });
    let (values, _) = layer(&estimate, "LD", 0);
    // From (nearly) nothing hidden to all.
    for (from, to) in [(0.002, 0.1), (0.1, 0.25), (0.25, 0.75), (0.75, 0.998)] {
        let (mut off, mut variance, mut unknown, mut texels) = (0.0, 0.0, 0.0, 0);
        for (min, sums) in known.lock().unwrap().iter() {
            let hidden = 1.0 - sums.y / sums.x;
            if !(from..to).contains(&hidden) {
                continue;
            }
            let index = |along: f64| ((along + 1.0) * SIDE as f64 / 2.0).round() as usize;
            off += values[index(min.y) * SIDE + index(min.x)] - sums.y;
            variance += sums.x * sums.x * (hidden * (1.0 - hidden) + 0.02) / 128.0;
            unknown += 0.02 * sums.x;
            texels += 1;
        }
        let allowed = student::normal_quantile(ALPHA / COMPARISONS as f64) * variance.sqrt();
        println!(
            "hidden {from}..{to}: {texels} texels, off {off:.3}, allowed {allowed:.3} + {unknown:.3}"
        );
        assert!(texels >= 15, "{texels}");
        assert!(
            off.abs() <= allowed + unknown,
            "hidden {from}..{to}: {off} on {texels} texels, allowed {allowed} + {unknown}"
        );
    }
}
