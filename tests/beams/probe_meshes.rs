//! Probes of meshes: flat facets, smooth ones, and water with one wave, against closed forms and exact maps
//! of the mesh itself.

use std::path::Path as File;

use glam::{DVec2, DVec3};
use nephroid::internals::generate::{
    BrilliantCut, Wave, geodesic_sphere, height_field, round_brilliant,
};
use nephroid::internals::geometry::{Mesh, MeshParts, Shape};
use nephroid::internals::mitsuba;
use nephroid::internals::optics::dielectric_reflectance;
use nephroid::internals::reference::closed_form::{
    FlatFacets, ParallelLight, SineWater, SineWave, TexelRect,
};
use nephroid::internals::scene::Scene;

use crate::support::probes::{of, probe_at, sign_changes, sum};
use crate::support::{bundled, bundled_file};

/// A bundled scene with another mesh in place of its first.
fn with_mesh(name: &str, mesh: MeshParts) -> Scene {
    let mut parts = mitsuba::load_parts(File::new(&bundled_file(name)), &[]).unwrap();
    let place = parts
        .shapes
        .iter_mut()
        .find(|shape| matches!(shape, Shape::Mesh(_)))
        .unwrap();
    *place = Shape::Mesh(Mesh::new(mesh).unwrap());
    Scene::new(parts).unwrap()
}

/// The mesh of the scene `diamond` as its file places it, in double precision.
fn diamond() -> MeshParts {
    let mut mesh = round_brilliant(0.325, BrilliantCut::TOLKOWSKY);
    let (sin, cos) = 165.0_f64.to_radians().sin_cos();
    for position in &mut mesh.positions {
        let (x, z) = (position.x, position.z);
        *position = DVec3::new(cos * x + sin * z, position.y, cos * z - sin * x + 0.4);
    }
    mesh.face_normals = true;
    mesh
}

/// The scene's only mesh.
fn solid(scene: &Scene) -> MeshParts {
    let mesh = scene.world().shapes().iter().find_map(|shape| match shape {
        Shape::Mesh(mesh) => Some(mesh),
        _ => None,
    });
    let mesh = mesh.unwrap();
    MeshParts {
        positions: mesh.positions().to_vec(),
        triangles: mesh.triangles().to_vec(),
        face_normals: true,
        ..MeshParts::default()
    }
}

/// Distance of a point from the border of a convex polygon in either orientation, negative outside.
fn depth_in(corners: &[DVec2], at: DVec2) -> f64 {
    let count = corners.len();
    let sides = || (0..count).map(|i| (corners[i], corners[(i + 1) % count]));
    let area: f64 = sides().map(|(a, b)| a.perp_dot(b)).sum();
    sides()
        .filter(|(a, b)| a != b)
        .map(|(a, b)| (b - a).normalize().perp_dot(at - a) * area.signum())
        .fold(f64::INFINITY, f64::min)
}

/// The diameter of the circle that has as much area for its circumference.
fn width(corners: &[DVec2]) -> f64 {
    let count = corners.len();
    let sides = || (0..count).map(|i| (corners[i], corners[(i + 1) % count]));
    let area = 0.5 * sides().map(|(a, b)| a.perp_dot(b)).sum::<f64>().abs();
    4.0 * area / sides().map(|(a, b)| a.distance(b)).sum::<f64>()
}

#[test]
fn a_probe_of_facets_finds_the_polygons_that_cover_the_point() {
    for (name, half, ior, direction, reflections, points) in [
        ("cube", 2.0, 1.5, DVec3::new(0.5, 0.2, -1.0), 3, 24),
        ("diamond", 1.2, 2.418, DVec3::new(0.3, 0.1, -1.0), 3, 10),
    ] {
        // The file's diamond has vertices of single precision, whose facets are not quite flat.
        let scene = if name == "diamond" {
            with_mesh(name, diamond())
        } else {
            bundled(name, 16)
        };
        let light = ParallelLight {
            direction: direction.normalize(),
            irradiance: 1000.0,
        };
        let truth = FlatFacets::new(&solid(&scene), ior, light, reflections).unwrap();
        let mut paths = 0;
        // All over the floor; and, as a diamond leaves most of it dark, somewhere within each of the widest
        // polygons.
        let lattice = (0..points).map(|number| {
            // The plastic number's lattice: no two points share a coordinate.
            let at = DVec2::new(0.7548776662, 0.5698402910) * f64::from(number) + 0.5;
            (at.fract() - 0.5) * half * 1.2
        });
        let mut widest: Vec<_> = truth.polygons().iter().map(|p| &p.corners[..]).collect();
        widest.sort_by(|a, b| width(b).total_cmp(&width(a)));
        let within = widest
            .iter()
            .map(|corners| {
                let middle = corners.iter().sum::<DVec2>() / corners.len() as f64;
                middle * 0.83 + corners[0] * 0.17
            })
            .filter(|at| at.abs().max_element() < 0.99 * half)
            .take(10);
        for at in lattice.chain(within) {
            let covering = |margin: f64| {
                truth
                    .polygons()
                    .iter()
                    .filter(move |polygon| depth_in(&polygon.corners, at) > margin)
            };
            // On a border itself (to the rounding of polygon corners) both answers are right.
            if covering(-1e-9).count() != covering(1e-9).count() {
                continue;
            }
            // Slivers pass between the nodes, as the probe says of itself: these stand 0.005 apart in the
            // light.
            if covering(0.0).any(|polygon| width(&polygon.corners) < 0.02) {
                continue;
            }
            let probed = probe_at(&scene, half, at, reflections + 2);
            let found: Vec<_> = probed
                .paths
                .iter()
                .filter(|p| !p.signature.is_empty())
                .collect();
            let expected: f64 = covering(0.0).map(|polygon| polygon.irradiance).sum();
            paths += covering(0.0).count();
            assert!(
                (sum(&found) - expected).abs() <= 1e-10 * expected,
                "{name} at {at}: {} for {expected}, {} paths, unresolved {}, polygons {:?}",
                sum(&found),
                found.len(),
                probed.unresolved,
                covering(0.0).collect::<Vec<_>>()
            );
        }
        assert!(paths >= 8, "{name}: only {paths} paths were looked for");
    }
}

/// One wave along x, folded on the floor.
const WAVE: SineWave = SineWave {
    depth: 0.8,
    amplitude: 0.06,
    wave_number: 12.0,
    phase: 0.4,
    ior: 1.33,
    irradiance: 1000.0,
    half_width: 1.05,
};

/// Cells along x of the mesh.
const CELLS: u32 = 96;

/// The mesh's own map, exactly: on each strip between two columns of vertices height and normal are linear in
/// x, the normal up to its length. Returns x', dx'/dx and the irradiance that enters.
fn strip_map(strip: u32, x: f64) -> [f64; 3] {
    let column = |i: u32| WAVE.half_width * (2.0 * f64::from(i) / f64::from(CELLS) - 1.0);
    let vertex = |x: f64| {
        let angle = WAVE.wave_number * x + WAVE.phase;
        let slope = WAVE.amplitude * WAVE.wave_number * angle.cos();
        let normal = DVec2::new(-slope, 1.0).normalize();
        (WAVE.depth + WAVE.amplitude * angle.sin(), normal)
    };
    let (a, b) = (column(strip), column(strip + 1));
    let ((za, na), (zb, nb)) = (vertex(a), vertex(b));
    let (height_slope, normal_slope) = ((zb - za) / (b - a), (nb - na) / (b - a));
    let height = za + height_slope * (x - a);
    let normal = na + normal_slope * (x - a);
    // θ: how far the surface is tilted; light is turned by θ − t to where the water stands higher.
    let tilt = (-normal.x).atan2(normal.y);
    let tilt_slope =
        (normal.x * normal_slope.y - normal.y * normal_slope.x) / normal.length_squared();
    let refracted = (tilt.sin() / WAVE.ior).asin();
    let turned = tilt - refracted;
    let turned_slope = tilt_slope * (1.0 - tilt.cos() / (WAVE.ior * refracted.cos()));
    let landing = x + height * turned.tan();
    let slope = 1.0 + height_slope * turned.tan() + height * turned_slope / turned.cos().powi(2);
    let entering = WAVE.irradiance * (1.0 - dielectric_reflectance(tilt.cos(), WAVE.ior));
    [landing, slope, entering]
}

/// |dx'/dx| and E of all preimages.
fn water_preimages(wanted: f64) -> Vec<[f64; 2]> {
    let column = |i: u32| WAVE.half_width * (2.0 * f64::from(i) / f64::from(CELLS) - 1.0);
    (0..CELLS)
        .flat_map(|strip| {
            let landing = |x: f64| Some(strip_map(strip, x)[0] - wanted);
            sign_changes(column(strip), column(strip + 1), 64, f64::INFINITY, landing)
                .into_iter()
                .map(move |x| {
                    let [_, slope, entering] = strip_map(strip, x);
                    [slope.abs(), entering / slope.abs()]
                })
        })
        .collect()
}

#[test]
fn a_probe_of_water_with_one_wave_finds_every_preimage() {
    let waves = [Wave {
        amplitude: WAVE.amplitude,
        wave: DVec2::new(WAVE.wave_number, 0.0),
        phase: WAVE.phase,
    }];
    let mesh = height_field(DVec2::splat(WAVE.half_width), WAVE.depth, &waves, CELLS + 1);
    let scene = with_mesh("water", mesh);
    let smooth = SineWater::new(WAVE);
    let mut counts = [0; 8];
    for number in 0..20 {
        let at = DVec2::new(0.7548776662, 0.5698402910) * f64::from(number) + 0.5;
        let at = (at.fract() - 0.5) * 1.7;
        let exact = water_preimages(at.x);
        let probed = probe_at(&scene, 0.9, at, 1);
        let paths = of(&probed, "LTD");
        assert_eq!(paths.len(), exact.len(), "{at}");
        counts[paths.len()] += 1;
        // Vertices, rotated into place by nothing, are the same bits; a root is right to 1e-16, a slope s to
        // 1e-15 · x'' / s of itself with x'' below 100.
        if exact.iter().all(|[slope, _]| *slope > 0.02) {
            let expected: f64 = exact.iter().map(|[_, irradiance]| irradiance).sum();
            let found = sum(&paths);
            assert!(
                (found / expected - 1.0).abs() < 1e-10,
                "{at}: {found} for {expected}"
            );
        }
        // The wave itself: where its mean over a short texel is steady, no fold is near and the mesh's count is the wave's.
        let mean = |half: f64| {
            smooth.texel_irradiance(&TexelRect::new(at.x - half, 0.0, at.x + half, 1.0))
        };
        if (mean(0.01) / mean(0.001) - 1.0).abs() < 0.01 {
            // A strip's turning normal is a chord of the sine's: dx'/dx is off by depth (1 − 1/n) A k² · k h
            // / 2, with h = 2.1 / 96 and a bend of at most A k² = 8.6, so by 1.7 · 0.13 = 0.23 at most where
            // it is steepest.
            let expected = mean(0.001);
            let least = exact
                .iter()
                .map(|[slope, _]| *slope)
                .fold(f64::INFINITY, f64::min);
            assert!(
                (sum(&paths) / expected - 1.0).abs() < 0.23 / least,
                "{at}: {} on the mesh, {expected} under the wave",
                sum(&paths)
            );
        }
    }
    // Folded: points of one and of three preimages.
    assert!(counts[1] > 2 && counts[3] > 2, "{counts:?}");
}

#[test]
fn a_smooth_mesh_of_a_ball_sheds_the_balls_light_up_to_its_facets() {
    let ball = bundled("glass-ball", 16);
    let mut worst = Vec::new();
    for frequency in [16, 64] {
        let mut mesh = geodesic_sphere(1.0, frequency);
        for position in &mut mesh.positions {
            position.z += 1.4;
        }
        let scene = with_mesh("glass-ball-mesh", mesh);
        let mut errors = Vec::new();
        for number in 0..16 {
            let at = DVec2::from_angle(2.399963 * f64::from(number))
                * (0.06 + 0.008 * f64::from(number));
            let exact = probe_at(&ball, 2.0, at, 2);
            let found = probe_at(&scene, 2.0, at, 2);
            let (exact, found) = (of(&exact, "LTTD"), of(&found, "LTTD"));
            assert_eq!((exact.len(), found.len()), (3, 3), "{at} at {frequency}");
            errors.push(sum(&found) / sum(&exact) - 1.0);
        }
        let mean_square = errors.iter().map(|e| e * e).sum::<f64>() / errors.len() as f64;
        worst.push(mean_square.sqrt());
    }
    // A facet is tilted against the sphere by up to half its size, so the derivative of the point where a ray
    // meets it is off in proportion, and det J with it: four times finer, four times nearer. Sixteen points
    // know the root mean square to a factor 1 ± 1/√32 each (one standard deviation), so the ratio lies
    // between 2 and 8 but for four of them.
    let ratio = worst[0] / worst[1];
    assert!((2.0..8.0).contains(&ratio), "{worst:?}");
    // The finer mesh's facets are 0.02 wide: tilts of 0.01 at each of two refractions, amplified by 1/(1 −
    // 1/n) and the like.
    assert!(worst[1] < 0.1, "{worst:?}");
}
