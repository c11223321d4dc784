//! Far from the origin: what a translation costs, which is the rounding of coordinates and nothing else.

mod extremes_support;
mod geometry_support;

use extremes_support::{
    BALL, DIAMOND, ORACLE, Placement, RING, U, WATER, beams, distance, judged, layer, photons, red,
};
use geometry_support::{Random, bumpy_torus, closest, icosphere, placed, world_of};
use glam::{DVec2, DVec3};
use nephroid::geometry::{MeshParts, Ray, TraversalCounters};
use nephroid::reference::closed_form::{GlassBall, Path, TexelGrid};
use nephroid::scene::Scene;
use nephroid::transport::chain::{Arrival, ChainSettings, ChainSink, ChainTracer};
use nephroid::transport::flux::Flux;
use nephroid::transport::ledger::Fate;
use nephroid::transport::signature::Signature;

/// Exponents of two of the offsets.
const EXPONENTS: [i32; 8] = [10, 12, 14, 16, 18, 20, 22, 24];

/// About 2^k from the origin, on no axis; whole numbers, so that the offset itself is exact.
fn offset(exponent: i32) -> DVec3 {
    (DVec3::new(0.6, -0.7, 0.4) * f64::powi(2.0, exponent)).round()
}

/// Where light of one signature lands, in the receiver's uv.
struct Landing {
    signature: Signature,
    receiver: u32,
    position: Option<DVec3>,
}

impl ChainSink<1> for Landing {
    fn arrived(&mut self, arrival: &Arrival<1>, _: &mut TraversalCounters) -> Fate {
        if arrival.hit.shape == self.receiver && arrival.signature == self.signature {
            self.position = Some(arrival.point.position);
        }
        Fate::Received
    }
    fn ended(&mut self, _: Signature, _: Fate, _: Flux<1>) {}
    fn gained(&mut self, _: Flux<1>) {}
    fn choice(&mut self, _: Signature, _: u32) -> f64 {
        0.5
    }
}

fn landing(scene: &Scene, ray: Ray, signature: &str) -> Option<DVec3> {
    let settings = ChainSettings {
        max_depth: 4,
        split_depth: 4,
        ..ChainSettings::default()
    };
    let mut sink = Landing {
        signature: signature.parse().expect("a signature"),
        receiver: scene.objects().len() as u32 - 1,
        position: None,
    };
    ChainTracer::<1>::new(scene, settings).trace(ray, Flux([1.0]), &mut sink);
    sink.position
}

/// A ray through the ball lands where the same ray landed at home, to the rounding of coordinates times what the optics
/// make of it.
///
/// The lamp, the sphere's centre, the two hits and their starts, the receiver and the landing are rounded to u 2^k on each axis
/// at most. Where one is moved by δ, the landing moves by up to (1 + |dr/db|) δ, with r(b) the landing by the ray's distance
/// from the axis: taken from neighbouring rays at home.
#[test]
fn landings_of_rays_move_as_conditioning_says() {
    println!(
        "landing of rays through glass: worst error / (2^k u), and the worst share of what is allowed"
    );
    let home = BALL.scene(Placement::HOME, 1);
    let lamp = DVec3::new(0.0, 0.0, 4.0);
    // sin of the angle of incidence.
    let aims: Vec<f64> = (0..400).map(|i| 0.99 * f64::from(i) / 400.0).collect();
    let ray = |sin_incidence: f64, turn: f64| {
        let sin = sin_incidence / 2.6;
        let across = DVec2::from_angle(turn) * sin;
        Ray::new(lamp, across.extend(-((1.0 - sin) * (1.0 + sin)).sqrt()))
    };
    for exponent in EXPONENTS {
        let offset = offset(exponent);
        let away = BALL.scene(Placement::moved(offset), 1);
        let size = f64::powi(2.0, exponent);
        let (mut worst, mut of_bound) = (0.0_f64, 0.0_f64);
        for (index, &aim) in aims.iter().enumerate() {
            let turn = 0.1 * index as f64;
            let first = ray(aim, turn);
            let moved = Ray::new(lamp + offset, first.direction);
            let at_home = landing(&home, first, "LTTD").expect("light through the ball");
            let there = landing(&away, moved, "LTTD").expect("light through the ball, moved");
            // sin i is the ray's distance from the axis, in radii.
            let step = 1e-6;
            let beside = landing(&home, ray(aim + step, turn), "LTTD").expect("light beside");
            let spread = (beside - at_home).length() / step;
            let error = ((there - offset) - at_home).length();
            // Six places, each off by √3 u 2^k at most.
            let bound = 6.0 * 3f64.sqrt() * U * size * (1.0 + spread);
            assert!(
                error <= bound,
                "2^{exponent}, sin i {aim}: {error:e}, allowed {bound:e}"
            );
            worst = worst.max(error / (size * U));
            of_bound = of_bound.max(error / bound);
        }
        println!("  2^{exponent}: {worst:6.2} {of_bound:5.2}");
    }
}

/// The nearest triangle that a ray meets for sure: Möller and Trumbore's test, in `f64` and with edges left out.
fn surely_met(parts: &MeshParts, ray: &Ray) -> Option<f64> {
    /// Barycentric distance from edges, far more than rounding: u 2^24 / (edge · cos) ~ 1e-6 at worst.
    const INSIDE: f64 = 1e-5;
    let meets = |triangle: &[u32; 3]| {
        let [a, b, c] = triangle.map(|vertex| parts.positions[vertex as usize]);
        let (ab, ac) = (b - a, c - a);
        let across = ray.direction.cross(ac);
        let determinant = ab.dot(across);
        let from = ray.origin - a;
        let u = from.dot(across) / determinant;
        let normal = from.cross(ab);
        let v = ray.direction.dot(normal) / determinant;
        let distance = ac.dot(normal) / determinant;
        let steep = determinant.abs() > 1e-3 * ab.cross(ac).length();
        (steep && u > INSIDE && v > INSIDE && u + v < 1.0 - INSIDE && distance > 0.0)
            .then_some(distance)
    };
    parts
        .triangles
        .iter()
        .filter_map(meets)
        .min_by(f64::total_cmp)
}

#[test]
fn boxes_in_single_precision_lose_no_hit_however_far_away() {
    let mut random = Random(5);
    for exponent in [0, 10, 17, 24] {
        let offset = offset(exponent);
        for home in [icosphere(3), bumpy_torus(36, 18)] {
            let parts = placed(home, 1.0, offset);
            let world = world_of(parts.clone());
            let mut met = 0;
            for _ in 0..3000 {
                // From inside, beside, and so far off that single precision would not know the mesh's size.
                let reach = [0.5, 3.0, 1e4, 1e8][random.below(4)];
                let start = offset + random.direction() * (reach * random.unit());
                let aim = offset + random.in_cube();
                let ray = Ray::new(start, (aim - start).normalize());
                let Some(distance) = surely_met(&parts, &ray) else {
                    continue;
                };
                met += 1;
                let hit = closest(&world, &ray);
                // Rounding of start and corners, u (2^k + distance), through a cosine of at least 1e-3.
                let allowed = 1e3 * 16.0 * U * (f64::powi(2.0, exponent) + distance);
                assert!(
                    hit.is_some_and(|hit| hit.distance <= distance + allowed),
                    "2^{exponent}: {ray:?} should meet something at {distance}, not {hit:?}"
                );
            }
            assert!(met > 1000, "{met}");
        }
    }
}

#[test]
fn a_closed_mesh_has_no_leaks_however_far_away() {
    let mut random = Random(6);
    for exponent in EXPONENTS {
        let offset = offset(exponent);
        let parts = placed(icosphere(4), 1.0, offset);
        let world = world_of(parts.clone());
        for _ in 0..20_000 {
            let start = offset + random.in_cube() * 0.5;
            let corner = parts.positions[random.below(parts.positions.len())];
            let ray = Ray::new(start, (corner - start).normalize());
            assert!(
                closest(&world, &ray).is_some(),
                "2^{exponent}: {ray:?} leaves"
            );
        }
    }
}

/// Texels a side.
const SIDE: usize = 32;

/// √(mean squared error) / mean truth over the texels that have light.
fn rmse(truth: &[f64], map: &[f64]) -> f64 {
    let lit = truth.iter().filter(|truth| **truth > 0.0).count() as f64;
    let mean = truth.iter().sum::<f64>() / lit;
    let squares: f64 = truth.iter().zip(map).map(|(a, b)| (a - b) * (a - b)).sum();
    (squares / lit).sqrt() / mean
}

/// How far a map may change when its scene is moved by 2^k: six places of a path are rounded to √3 u 2^k, a landing moves by up
/// to `spread` times that, and a texel's flux by what crosses its four sides.
fn allowed(size: f64, spread: f64, texel: f64) -> f64 {
    6.0 * 3f64.sqrt() * U * size * (1.0 + spread) * 4.0 / texel
}

#[test]
fn the_glass_balls_map_is_as_good_anywhere_as_at_home() {
    let truth = GlassBall::SHIPPED
        .sheet(Path::Through(0))
        .map(&TexelGrid::square(2.0, SIDE));
    let run = |offset: DVec3| {
        let scene = BALL.scene(Placement::moved(offset), SIDE);
        let by_beams = beams(&scene, 1e-3, 2);
        let by_beams = layer(&by_beams, "LTTD").expect("a caustic");
        let (missed, _) = judged(by_beams, &truth);
        let reach = allowed(offset.length(), STEEPEST, 4.0 / SIDE as f64);
        assert!(
            missed <= ORACLE + reach,
            "{offset}: {missed:e} out of bounds"
        );
        let by_photons = photons(&scene, 1 << 18, 2);
        let by_photons = red(layer(&by_photons, "LTTD").expect("a caustic"));
        (red(by_beams), by_photons)
    };
    let home = run(DVec3::ZERO);
    println!(
        "glass ball moved: error of beams, root mean square (at home {:.3e}); change of their map, and of photons', worst texel; allowed",
        rmse(&truth, &home.0)
    );
    let places = [10.0, 100.0]
        .map(|x| DVec3::new(x, -x, x))
        .into_iter()
        .chain([10, 15, 20, 24].map(offset));
    for place in places {
        let away = run(place);
        let [by_beams, by_photons] = [distance(&home.0, &away.0), distance(&home.1, &away.1)];
        let allowed = allowed(place.length(), STEEPEST, 4.0 / SIDE as f64);
        let error = rmse(&truth, &away.0);
        println!(
            "  by {:9.0}: {error:.3e}; {by_beams:.1e}, {by_photons:.1e}; {allowed:.1e}",
            place.length(),
        );
        assert!(by_photons <= allowed, "{place}: {by_photons:e}");
        // Where beams are divided is decided by comparisons, of which a symmetric scene leaves some to rounding: their maps
        // may differ by their error, which stays what was asked for.
        assert!(by_beams <= 1e-3 + allowed, "{place}: {by_beams:e}");
        assert!(error <= 1e-3 + allowed, "{place}: {error:e}");
    }
}

/// Landings move by up to twenty times what a surface does, in glass near grazing and in facets of diamond: see the ball's, above.
const STEEPEST: f64 = 20.0;

#[test]
fn maps_of_meshes_and_metal_move_with_their_scenes() {
    println!(
        "scene moved by 2^k: change of the map by beams and by photons, worst texel, relative to the brightest; allowed"
    );
    for template in [RING, DIAMOND, WATER] {
        let run = |offset: DVec3| {
            let scene = template.scene(Placement::moved(offset), 16);
            [
                red(&beams(&scene, 1e-2, 4).total),
                red(&photons(&scene, 1 << 16, 4).total),
            ]
        };
        let home = run(DVec3::ZERO);
        for exponent in [10, 17, 24] {
            let away = run(offset(exponent));
            let size = f64::powi(2.0, exponent);
            // The smallest receiver is 1.6 wide.
            let allowed = allowed(size, STEEPEST, 1.6 / 16.0);
            let changes = [0, 1].map(|method| distance(&home[method], &away[method]));
            println!(
                "  {:10} 2^{exponent}: {:.1e}, {:.1e}; {allowed:.1e}",
                template.name, changes[0], changes[1],
            );
            // Photons are the same photons; beams may be divided elsewhere, within the error asked for.
            assert!(changes[0] <= 1e-2, "{} 2^{exponent}", template.name);
            assert!(changes[1] <= allowed, "{} 2^{exponent}", template.name);
        }
    }
}
