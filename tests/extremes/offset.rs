//! Far from the origin: what a translation costs, which is the rounding of coordinates and nothing else.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::{MeshParts, Ray, Shape, TraversalCounters};
use nephroid::internals::reference::closed_form::{GlassBall, KnownPath, TexelGrid};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::chain::{Arrival, ChainSettings, ChainSink, ChainTracer};
use nephroid::internals::transport::flux::Flux;
use nephroid::internals::transport::ledger::Fate;
use nephroid::internals::transport::signature::Signature;

use crate::support::chains::light;
use crate::support::extremes::{
    BALL, DIAMOND, ORACLE, Placement, RING, Template, U, WATER, beams, distance, judged, layer,
    photons, red, rmse,
};
use crate::support::geometry::{Random, bumpy_torus, closest, icosphere, placed, world_of};

/// Exponents of two of the offsets.
const EXPONENTS: [i32; 8] = [10, 12, 14, 16, 18, 20, 22, 24];

/// About 2^k from the origin, on no axis; whole numbers, so that the offset itself is exact.
fn offset(exponent: i32) -> DVec3 {
    (DVec3::new(0.6, -0.7, 0.4) * f64::powi(2.0, exponent)).round()
}

/// Place where light met a surface, after the events of `signature`.
#[derive(Clone, Copy, Debug)]
struct Met {
    signature: Signature,
    shape: u32,
    face: u32,
    position: DVec3,
    flux: f64,
}

/// Everything that a ray and its branches meet.
#[derive(Default)]
struct Everything(Vec<Met>);

impl ChainSink<1> for Everything {
    fn arrived(&mut self, arrival: &Arrival<1>, _: &mut TraversalCounters) -> Fate {
        self.0.push(Met {
            signature: arrival.signature,
            shape: arrival.hit.shape,
            face: arrival.hit.face,
            position: arrival.point.position,
            flux: arrival.flux.0[0],
        });
        Fate::Received
    }
    fn ended(&mut self, _: Signature, _: Fate, _: Flux<1>) {}
    fn gained(&mut self, _: Flux<1>) {}
}

/// Surfaces that a ray of unit flux and all its branches meet, after at most so many events.
fn followed(scene: &Scene, ray: Ray, depth: u32) -> Vec<Met> {
    let settings = ChainSettings {
        max_depth: depth,
        split_depth: depth,
        ..ChainSettings::default()
    };
    let mut sink = Everything::default();
    ChainTracer::<1>::new(scene, settings).trace(&light(ray), &mut sink);
    sink.0
}

/// The receiver is the last of a template's shapes.
fn receiver(scene: &Scene) -> u32 {
    scene.objects().len() as u32 - 1
}

/// Places where light of a signature lands on the receiver.
fn landing(scene: &Scene, ray: Ray, signature: Signature) -> Option<Met> {
    let met = followed(scene, ray, signature.len() as u32);
    met.into_iter()
        .find(|met| met.shape == receiver(scene) && met.signature == signature)
}

/// A ray through the ball lands where the same ray landed at home, to the rounding of coordinates times what
/// the optics make of it.
///
/// The lamp, the sphere's centre, the two hits and their starts, the receiver and the landing are rounded to
/// u 2^k on each axis at most. Where one is moved by δ, the landing moves by up to (1 + |dr/db|) δ, with r(b)
/// the landing by the ray's distance from the axis: taken from neighbouring rays at home.
#[test]
fn landings_of_rays_move_as_conditioning_says() {
    println!(
        "landing of rays through glass: worst error / (2^k u), and the worst share of what is allowed"
    );
    let home = BALL.scene(Placement::HOME, 1);
    let lamp = DVec3::new(0.0, 0.0, 4.0);
    let signature: Signature = "LTTD".parse().expect("a signature");
    let through = |scene: &Scene, ray: Ray| {
        let landed = landing(scene, ray, signature).expect("light through the ball");
        landed.position
    };
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
            let at_home = through(&home, first);
            let there = through(&away, moved);
            // sin i is the ray's distance from the axis, in radii.
            let step = 1e-6;
            let beside = through(&home, ray(aim + step, turn));
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

/// The nearest triangle that a ray meets for sure: Möller and Trumbore's test, in `f64` and with edges left
/// out.
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

/// How much a map may change where every coordinate is rounded by δ, to first order: of a texel, relative to
/// δ and to the brightest.
///
/// All paths of some rays from the light to the receiver are looked at, at home. By how much a landing moves,
/// and the flux that is left changes, where light is shifted or turned before a surface, is seen from
/// neighbours that set out just before it.
///
/// - A surface's coordinates are rounded, and the place where a path meets it. So is the start from there,
///   which is moved off the surface by a bound on that, and one step farther. So light is shifted by δ four
///   times before each surface.
/// - A mesh without normals of its own has facets through corners that are rounded: they lean by 2 δ / h, h
///   the triangle's least height. Light that leaves is turned as if facet and light were turned together,
///   and the light back: once before the surface, and once after.
///
/// A path whose landing moves by K δ leaves its texel of width w with a probability of 4 K δ / w (four
/// sides), and texels get as much from their neighbours as those lose; a path whose flux changes by L δ,
/// relative, brings so much more or less. So a texel changes by the sum of (4 K / w + L) δ over its paths, by
/// flux.
#[derive(Clone, Copy, Debug)]
struct Conditioning {
    /// Change of the texel that may change most.
    map: f64,
    /// The probability of a path to leave its texel, the mean by flux.
    leaving: f64,
}

impl Conditioning {
    /// What a map may change by, this far from the origin: on each axis, places are rounded by u of their
    /// coordinate at most.
    fn allowed(&self, away: f64) -> f64 {
        self.map * Self::rounding(away)
    }

    fn rounding(away: f64) -> f64 {
        3f64.sqrt() * U * (away + EXTENT)
    }
}

/// No template is farther across, lamp included.
const EXTENT: f64 = 8.0;

/// A ray of a template's light towards what refracts or reflects, at home, and its weight.
fn ray_of(template: &Template, random: &mut Random) -> (Ray, f64) {
    let from_cone = |from: DVec3, axis: DVec3, cos_widest: f64, random: &mut Random| {
        let cos = 1.0 - (1.0 - cos_widest) * random.unit();
        let across = DVec2::from_angle(TAU * random.unit()) * ((1.0 - cos) * (1.0 + cos)).sqrt();
        let [right, up] = [
            axis.any_orthonormal_vector(),
            axis.cross(axis.any_orthonormal_vector()),
        ];
        let direction = axis * cos + right * across.x + up * across.y;
        (Ray::new(from, direction.normalize()), cos.acos())
    };
    let from_sun = |sun: DVec3, around: DVec3, reach: f64, random: &mut Random| {
        let aim = around + DVec3::new(random.signed(), random.signed(), 0.0) * reach;
        let sun = sun.normalize();
        (Ray::new(aim - sun * 4.0, sun), 1.0)
    };
    match template.name {
        "glass ball" => {
            let widest = (1.0_f64 / 2.6).asin().cos();
            let (ray, _) = from_cone(DVec3::Z * 4.0, -DVec3::Z, widest, random);
            (ray, 1.0)
        }
        "metal ring" => {
            let (from, to) = (DVec3::new(-1.3, 0.2, 2.1), DVec3::new(0.4, 0.1, 0.0));
            let widest = 35_f64.to_radians();
            let (ray, angle) = from_cone(from, (to - from).normalize(), widest.cos(), random);
            // A spot's light fades over the outer quarter of its angle.
            (ray, ((widest - angle) / (0.25 * widest)).min(1.0))
        }
        "diamond" => from_sun(DVec3::new(0.3, 0.1, -1.0), DVec3::Z * 0.4, 0.7, random),
        "water" => from_sun(DVec3::new(0.1, 0.0, -1.0), DVec3::Z * 0.5, 1.2, random),
        name => panic!("where does the light of {name} come from?"),
    }
}

/// By how much a triangle without normals of its own leans, where its corners are rounded by 1: 2 / h.
fn leaning(scene: &Scene, met: &Met) -> f64 {
    match &scene.world().shapes()[met.shape as usize] {
        Shape::Mesh(mesh) if !mesh.has_vertex_normals() => {
            let [a, b, c] = mesh.corners(met.face);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            2.0 * longest / (b - a).cross(c - a).length()
        }
        _ => 0.0,
    }
}

/// By how much a landing moves, and its flux changes, relative to a step.
type Change = [f64; 2];

/// [`Change`] of a path's end where it is shifted, and where it is turned, at a place before a surface.
fn changes(scene: &Scene, ray: Ray, signature: Signature) -> Option<[Change; 2]> {
    // Half of the digits remain.
    const STEP: f64 = 1e-7;
    let here = landing(scene, ray, signature)?;
    let across = ray.direction.any_orthonormal_vector();
    let of = |beside: Option<Met>| {
        beside.map(|beside| {
            let moved = (beside.position - here.position).length() / STEP;
            [moved, (beside.flux / here.flux - 1.0).abs() / STEP]
        })
    };
    let mut worst = [[0.0_f64; 2]; 2];
    for axis in [across, ray.direction.cross(across)] {
        for (kind, worst) in worst.iter_mut().enumerate() {
            let beside = |step: f64| {
                let beside = if kind == 0 {
                    Ray::new(ray.origin + axis * step, ray.direction)
                } else {
                    Ray::new(ray.origin, (ray.direction + axis * step).normalize())
                };
                of(landing(scene, beside, signature))
            };
            // On one side there may be an edge, beyond which light goes elsewhere.
            let (a, b) = (beside(STEP), beside(-STEP));
            let change = match (a, b) {
                (Some(a), Some(b)) => [a[0].min(b[0]), a[1].min(b[1])],
                (one, other) => one.or(other)?,
            };
            *worst = [worst[0].max(change[0]), worst[1].max(change[1])];
        }
    }
    Some(worst)
}

/// [`Change`] of where a path ends, for all roundings of what it meets; `None` where it runs along an edge.
fn changes_of(scene: &Scene, start: DVec3, met: &[Met]) -> Option<Change> {
    /// Shifts before each surface.
    const ROUNDINGS: f64 = 4.0;
    /// Distance before a surface at which neighbours set out, as a part of the way to it.
    const BEFORE: f64 = 1e-3;
    let events: Vec<_> = met[met.len() - 1].signature.events().collect();
    let mut sum = [0.0; 2];
    let mut lean_before = 0.0;
    let mut from = start;
    for (index, met) in met.iter().enumerate() {
        let way = met.position - from;
        let origin = met.position - way * BEFORE;
        let rest = events[index..]
            .iter()
            .fold(Signature::DIRECT, |rest, event| rest.then(*event));
        let [shifted, turned] = changes(scene, Ray::new(origin, way.normalize()), rest)?;
        let lean = leaning(scene, met);
        for kind in 0..2 {
            // Light that is turned at the surface before is turned here, and shifted.
            let turned_before = turned[kind] + way.length() * shifted[kind];
            sum[kind] +=
                ROUNDINGS * shifted[kind] + lean_before * turned_before + lean * turned[kind];
        }
        lean_before = lean;
        from = met.position;
    }
    Some(sum)
}

fn conditioning(template: &Template, depth: u32, side: usize) -> Conditioning {
    const RAYS: usize = 30_000;
    let scene = template.scene(Placement::HOME, side);
    let Shape::Rectangle(floor) = &scene.world().shapes()[receiver(&scene) as usize] else {
        panic!("a rectangle");
    };
    let half = 0.5 * floor.edges()[0].length();
    let width = 2.0 * half / side as f64;
    let mut random = Random(17);
    let (mut flux, mut change) = (vec![0.0; side * side], vec![0.0; side * side]);
    let (mut moved, mut largest, mut paths) = (0.0, 0.0_f64, 0);
    for _ in 0..RAYS {
        let (ray, weight) = ray_of(template, &mut random);
        let met = followed(&scene, ray, depth);
        let specular = |met: &&Met| met.shape == receiver(&scene) && !met.signature.is_empty();
        for landed in met.iter().filter(specular) {
            // The way there: what was met after each part of its events.
            let mut so_far = Signature::DIRECT;
            let mut way: Vec<Met> = Vec::new();
            for event in landed.signature.events() {
                way.extend(met.iter().find(|met| met.signature == so_far));
                so_far = so_far.then(event);
            }
            way.push(*landed);
            let Some([k, l]) = changes_of(&scene, ray.origin, &way) else {
                continue;
            };
            let place = ((landed.position.truncate() + half) / width).floor();
            let texel = place.y as usize * side + place.x as usize;
            let brings = weight * landed.flux;
            flux[texel] += brings;
            change[texel] += brings * (4.0 * k / width + l);
            moved += brings * k;
            largest = largest.max(k);
            paths += 1;
        }
    }
    let of_brightest = flux.iter().copied().fold(0.0, f64::max);
    let mean = moved / flux.iter().sum::<f64>();
    let result = Conditioning {
        map: change.iter().copied().fold(0.0, f64::max) / of_brightest,
        leaving: 4.0 * mean / width,
    };
    println!(
        "  {}: a landing moves by up to {largest:.0} times what coordinates are off by, {mean:.1} on average; a texel changes by up to {:.0} times of the brightest ({paths} paths)",
        template.name, result.map
    );
    // A mean over so many is known to a tenth or so.
    assert!(paths > 300, "{}: {paths}", template.name);
    result
}

#[test]
fn the_glass_balls_map_is_as_good_anywhere_as_at_home() {
    const PHOTONS: u64 = 1 << 18;
    let truth = GlassBall::SHIPPED
        .sheet(KnownPath::Through(0))
        .map(&TexelGrid::square(2.0, SIDE));
    println!("glass ball moved");
    let known = conditioning(&BALL, 2, SIDE);
    let run = |offset: DVec3| {
        let scene = BALL.scene(Placement::moved(offset), SIDE);
        let by_beams = beams(&scene, 1e-3, 2);
        let by_beams = layer(&by_beams, "LTTD").expect("a caustic");
        let (missed, _) = judged(by_beams, &truth);
        let reach = known.allowed(offset.length());
        assert!(
            missed <= ORACLE + reach,
            "{offset}: {missed:e} out of bounds"
        );
        let by_photons = photons(&scene, PHOTONS, 2);
        let by_photons = red(layer(&by_photons, "LTTD").expect("a caustic"));
        (red(by_beams), by_photons)
    };
    let home = run(DVec3::ZERO);
    let error_at_home = rmse(&truth, &home.0);
    println!(
        "  error of beams, root mean square (at home {error_at_home:.3e}); change of their map, and of photons', worst texel; allowed; photons expected in another texel, at most"
    );
    // What is known of a texel relative to the brightest is more of the mean.
    let brightest = truth.iter().copied().fold(0.0, f64::max);
    let lit = truth.iter().filter(|truth| **truth > 0.0).count() as f64;
    let of_mean = brightest * lit / truth.iter().sum::<f64>();
    let places = [10.0, 100.0]
        .map(|x| DVec3::new(x, -x, x))
        .into_iter()
        .chain([10, 15, 20, 24].map(offset));
    for place in places {
        let away = run(place);
        let [by_beams, by_photons] = [distance(&home.0, &away.0), distance(&home.1, &away.1)];
        let allowed = known.allowed(place.length());
        let astray = PHOTONS as f64 * known.leaving * Conditioning::rounding(place.length());
        let error = rmse(&truth, &away.0);
        println!(
            "  by {:9.0}: {error:.3e}; {by_beams:.1e}, {by_photons:.1e}; {allowed:.1e}; {astray:.1e}",
            place.length(),
        );
        // A photon in another texel would be a thousandth of it, and more than is allowed.
        assert!(by_photons <= allowed, "{place}: {by_photons:e}");
        // Where beams are divided is decided by comparisons, of which a symmetric scene leaves some to
        // rounding: their maps may differ by their error, which stays what was asked for.
        assert!(by_beams <= 1e-3 + allowed, "{place}: {by_beams:e}");
        // Were every cell divided once less, the error would be four times as large: it is of second order in
        // their size. Ties are few cells: half of that is more than they can do.
        assert!(
            error <= 2.0 * error_at_home + allowed * of_mean,
            "{place}: {error:e}"
        );
        assert!(error <= 1e-3, "{place}: {error:e}");
    }
}

#[test]
fn maps_of_meshes_and_metal_move_with_their_scenes() {
    const PHOTONS: u64 = 1 << 16;
    println!("meshes and metal moved");
    for template in [RING, DIAMOND, WATER] {
        let run = |offset: DVec3| {
            let scene = template.scene(Placement::moved(offset), 16);
            [
                red(&beams(&scene, 1e-2, 4).total),
                red(&photons(&scene, PHOTONS, 4).total),
            ]
        };
        let home = run(DVec3::ZERO);
        let known = conditioning(&template, 4, 16);
        println!(
            "  change of the map by beams and by photons, worst texel, relative to the brightest; allowed; photons expected in another texel, at most"
        );
        for exponent in [10, 17, 24] {
            let away = run(offset(exponent));
            let size = offset(exponent).length();
            let allowed = known.allowed(size);
            let astray = PHOTONS as f64 * known.leaving * Conditioning::rounding(size);
            let changes = [0, 1].map(|method| distance(&home[method], &away[method]));
            println!(
                "  {:10} 2^{exponent}: {:.1e}, {:.1e}; {allowed:.1e}; {astray:.1e}",
                template.name, changes[0], changes[1],
            );
            // The ring is symmetric: its beams may be divided elsewhere, within the error asked for.
            let by_beams = if template.name == RING.name {
                1e-2
            } else {
                allowed
            };
            assert!(changes[0] <= by_beams, "{} 2^{exponent}", template.name);
            // Photons are the same photons.
            assert!(changes[1] <= allowed, "{} 2^{exponent}", template.name);
        }
    }
}
