//! Far and near: surfaces and lights from a ten-thousandth to a hundred million radii away, and receivers in
//! a focus.

use std::f64::consts::{FRAC_PI_2, PI, TAU};

use glam::{DMat4, DVec3};
use nephroid::internals::geometry::{MeshParts, Ray, Shape, Sphere, Transform, World};
use nephroid::internals::numeric::distributions::critical_value;
use nephroid::internals::numeric::quadrature::GaussLegendre;
use nephroid::internals::optics::dielectric_reflectance;
use nephroid::internals::reference::closed_form::{AxialLight, GlassBall, KnownPath, TexelGrid};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::first_surface::{Source, patches};

use crate::support::extremes::double_double::{Exact, Exact3};
use crate::support::extremes::{
    ORACLE, U, assert_as_asked, beams, error_as_asked, judged, layer, photons, scene, specular,
};
use crate::support::geometry::{Random, closest, world_of};

/// Distances of rays' starts from what they meet, in radii.
const DISTANCES: [f64; 9] = [1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8];

/// Rays for each distance.
const RAYS: usize = 20_000;

/// The distance at which a ray meets a sphere from outside, and the tangent of its angle of incidence, for
/// the `f64` numbers of ray and sphere taken as exact.
fn exact_sphere_hit(ray: &Ray, center: DVec3, radius: f64) -> (Exact, f64) {
    let (direction, radius) = (Exact3::from(ray.direction), Exact::from(radius));
    let from_center = Exact3::from(ray.origin) - Exact3::from(center);
    // |f + t d|² = r², with |d|² as it is: 1 to rounding only.
    let a = direction.dot(direction);
    let approach = -from_center.dot(direction) / a;
    let miss = from_center + direction.scaled(approach);
    let half_chord_squared = radius * radius - miss.dot(miss);
    let half_chord = (half_chord_squared / a).sqrt();
    let tangent = (miss.dot(miss) / half_chord_squared).sqrt();
    (approach - half_chord, tangent.value())
}

/// Units in the last place of a hit's distance that are promised within 37° of the normal (tan i < 3/4).
/// Newton's step leaves the roundings of f, of t d and of their sum, 1 u of D each along the ray and as much
/// across it, times tan i, and those of the step and the difference, 1 u of t: 3 (1 + 3/4) u D + 2 u t if all
/// add up, which they hardly do. An ulp is u t at least and 2 u t at most; D is 2 t one radius away, and t
/// far off.
const ULPS: f64 = 4.0;

/// Where the ray's line passes the centre is known to the roundings of f (1 u of D, the distance of the
/// centre), of f·d (3 u), of its product with d and the sum (2 u): 6 u D, which moves the hit by tan i as
/// much, i the angle of incidence. The quotient c/(approach + h): |f|² 3 (and r² as much), difference, sum
/// and quotient 1 each, f·d 3 and f 1: 10 u; their difference, farther off, takes 5 u. |d| is 1 to 2 u.
fn sphere_bound(center_distance: f64, tangent: f64) -> f64 {
    U * center_distance * (12.0 + 6.0 * tangent)
}

#[test]
fn spheres_are_hit_to_a_few_ulps_from_any_distance() {
    println!(
        "sphere: error of the hit's distance in ulps of it, within 0.6 radii of the middle; anywhere, of what is allowed"
    );
    let mut random = Random(11);
    for distance in DISTANCES {
        let (mut worst_ulps, mut of_bound) = (0.0_f64, 0.0_f64);
        for _ in 0..RAYS {
            let radius = f64::powf(10.0, random.signed());
            let center = random.in_cube() * radius;
            let to_world =
                DMat4::from_translation(center) * DMat4::from_scale(DVec3::splat(radius));
            let to_world = Transform::from_matrix(to_world).expect("can be inverted");
            let sphere = Sphere::new(&to_world, false).expect("round");
            let (center, radius) = (sphere.center(), sphere.radius());
            let world = World::new(vec![Shape::Sphere(sphere)]);
            let outward = random.direction();
            let start = center + outward * (radius * (1.0 + distance));
            let across = outward.any_orthonormal_vector() * (radius * 0.999 * random.unit());
            let ray = Ray::new(start, (center + across - start).normalize());
            let (exact, tangent) = exact_sphere_hit(&ray, center, radius);
            let hit = closest(&world, &ray).expect("aimed at the inside");
            let error = exact.error_of(hit.distance);
            let bound = sphere_bound((start - center).length(), tangent);
            assert!(
                error <= bound,
                "{distance:e} radii: {error:e}, allowed {bound:e}"
            );
            of_bound = of_bound.max(error / bound);
            // sin i < 0.6: tan i < 0.75.
            if tangent < 0.75 {
                let ulp = exact.value().next_up() - exact.value();
                worst_ulps = worst_ulps.max(error / ulp);
            }
        }
        println!("  {distance:.0e}: {worst_ulps:5.2} ulps; {of_bound:4.2}");
        assert!(worst_ulps <= ULPS, "{distance:e} radii: {worst_ulps} ulps");
    }
}

/// The distance at which a ray meets a triangle's plane, the tangent of its angle of incidence, and whether
/// it meets the inside, at least a part of 1e-6 of the triangle's height away from each edge.
fn exact_triangle_hit(ray: &Ray, corners: &[DVec3; 3]) -> (Exact, f64, bool) {
    let [a, b, c] = corners.map(Exact3::from);
    let (origin, direction) = (Exact3::from(ray.origin), Exact3::from(ray.direction));
    let normal = (b - a).cross(c - a);
    let along = direction.dot(normal);
    let distance = (a - origin).dot(normal) / along;
    let hit = origin + direction.scaled(distance);
    let squared = normal.dot(normal);
    let weight = |p: Exact3, q: Exact3| ((q - p).cross(hit - p).dot(normal) / squared).value();
    let inside = [weight(a, b), weight(b, c), weight(c, a)]
        .iter()
        .all(|weight| *weight > 1e-6);
    let cos = (along / (normal.length() * direction.length()))
        .value()
        .abs();
    (
        distance,
        ((1.0 - cos) * (1.0 + cos)).max(0.0).sqrt() / cos,
        inside,
    )
}

#[test]
fn triangles_are_hit_within_four_ulps_from_any_distance() {
    println!(
        "triangle: error of the hit's distance in ulps of it, steeper than 45°; anywhere, of what is allowed"
    );
    let mut random = Random(12);
    for distance in DISTANCES {
        let (mut worst_ulps, mut of_bound) = (0.0_f64, 0.0_f64);
        for _ in 0..RAYS {
            let corners = std::array::from_fn(|_| random.in_cube());
            let [a, b, c] = corners;
            let world = world_of(MeshParts {
                positions: corners.to_vec(),
                triangles: vec![[0, 1, 2]],
                ..MeshParts::default()
            });
            let (x, y) = (random.unit().sqrt(), random.unit());
            let aim = a * (1.0 - x) + b * (x * (1.0 - y)) + c * (x * y);
            let start = aim + random.direction() * distance;
            let ray = Ray::new(start, (aim - start).normalize());
            let (exact, tangent, inside) = exact_triangle_hit(&ray, &corners);
            if !inside || tangent > 1e3 {
                continue;
            }
            let hit = closest(&world, &ray).expect("aimed at the inside");
            let error = exact.error_of(hit.distance);
            // A corner's image is off by the roundings of its differences to the start (1 u of the
            // distance), of the shear (1.5: quotient and product by the direction) and of the shear's product
            // and difference (2): 6 u of it on each axis, 9 u across, which moves the hit by tan i as
            // much. Depths, weights' sum, quotient and products are each rounded: 8 u. |d| is 1 to 2 u.
            let reach = exact.value() + 4.0;
            let bound = U * reach * (10.0 + 9.0 * tangent);
            assert!(
                error <= bound,
                "{distance:e} away: {error:e}, allowed {bound:e}"
            );
            of_bound = of_bound.max(error / bound);
            if tangent < 1.0 && distance > 4.0 {
                let ulp = exact.value().next_up() - exact.value();
                assert!(
                    error <= 4.0 * ulp,
                    "{distance:e} away: {} ulps",
                    error / ulp
                );
                worst_ulps = worst_ulps.max(error / ulp);
            }
        }
        println!("  {distance:.0e}: {worst_ulps:5.2} ulps; {of_bound:4.2}");
    }
}

/// Texels a side.
const SIDE: usize = 16;
/// Half the receiver's width, in radii of the ball.
const HALF: f64 = 2.0;

/// A glass ball of radius 1 under a light, its centre `height` over the receiver.
fn ball(light: &str, height: f64, half: f64, side: usize) -> Scene {
    scene(
        &format!(
            r#"{light}
<shape type="sphere">
  <point name="center" x="0" y="0" z="{height:?}"/>
  <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>
</shape>
<shape type="rectangle">
  <transform name="to_world"><scale x="{half:?}" y="{half:?}"/></transform>
  <bsdf type="diffuse"/>{{meter}}
</shape>"#
        ),
        None,
        side,
    )
}

/// The probability that a right program fails the test of photons below, and the fluxes that they are asked
/// for.
const RISK: f64 = 1e-4;
const FLUXES: usize = 10;

/// Most error of a texel that a shadow's edge runs through, relative to the brightest texel. A convex edge
/// meets each of the 2 · 7 lines between its 8 x 8 cells twice at most, so it enters no more than 4 · 8 of
/// them, and each may leave 1e-4 of the texel uncertain (`transport/direct/edge.rs`).
const EDGE: f64 = 4.0 * 8.0 * 1e-4;

/// On a receiver of one texel, the standard error of photons is that of the flux: their 32 replicates are
/// independent estimates of it.
#[test]
fn a_lamp_may_be_a_ten_thousandth_of_a_radius_or_a_million_radii_from_the_ball() {
    println!(
        "lamp over a ball, radii from its surface: of beams asked for 1e-2, worst texel and root mean square error, of all specular light; flux by photons \
         and its standard error, relative, and the largest that points drawn at random would have"
    );
    let errors = critical_value(1.0 - RISK / FLUXES as f64, 31.0);
    let mut fluxes = 0;
    for gap in [1e-4, 1e-2, 1e0, 1e2, 1e4, 1e6] {
        let (center, lamp) = (1.4, 2.4 + gap);
        // What falls on the ball is about as much from any distance.
        let intensity = 100.0 * (1.0 + gap) * (1.0 + gap);
        let light = format!(
            r#"<emitter type="point"><point name="position" x="0" y="0" z="{lamp:?}"/><rgb name="intensity" value="{intensity:?}"/></emitter>"#
        );
        let known = GlassBall {
            radius: 1.0,
            center_height: center,
            ior: 1.5,
            light: AxialLight::Point {
                height: lamp,
                intensity,
            },
        };
        let by_beams = beams(&ball(&light, center, HALF, SIDE), 1e-2, 2);
        let by_photons = photons(&ball(&light, center, HALF, 1), 1 << 17, 2);
        let mut all = vec![0.0; SIDE * SIDE];
        for (signature, path) in [
            ("LD", KnownPath::Direct),
            ("LRD", KnownPath::Reflected(1)),
            ("LTTD", KnownPath::Through(0)),
        ] {
            let truth = known.sheet(path).map(&TexelGrid::square(HALF, SIDE));
            // From near by the ball shades all of the receiver, and reflects nothing onto it.
            if truth.iter().all(|e| *e == 0.0) {
                continue;
            }
            let flux = truth.iter().sum::<f64>() / (SIDE * SIDE) as f64;
            let found = layer(&by_photons, signature).expect("photons find it");
            let away = found.values[0].0[0] / flux - 1.0;
            let error = found.standard_error[0].0[0] / flux;
            if signature == "LD" {
                let (missed, off) = judged(layer(&by_beams, "LD").expect("direct light"), &truth);
                println!("  {gap:.0e} LD    : {off:.1e}; {away:+.1e} ± {error:.1e}");
                assert!(missed <= ORACLE, "{gap:e} LD: {missed:e}");
                assert!(off <= EDGE, "{gap:e} LD: {off:e}");
                // Photons have it from the same quadrature, with a bound, not a standard error.
                assert!(error <= EDGE, "{gap:e} LD: {error:e}");
                assert!(away.abs() <= error + ORACLE, "{gap:e} LD: {away:e}");
                continue;
            }
            for (sum, one) in all.iter_mut().zip(&truth) {
                *sum += one;
            }
            let name = format!("{gap:e}");
            let [off, of_all] = assert_as_asked(&name, &by_beams, signature, &truth, 1e-2);
            // Of n photons that carry Φ/n each, a part p of Φ arrives: at random that has a variance of p (1
            // − p) Φ²/n at most, as none carries more than it set out with. Standard errors of 32 replicates
            // are 1.6 times the true one with a probability of 4e-6.
            let share = flux * (2.0 * HALF).powi(2) / by_photons.ledger.emitted.0[0];
            let random = ((1.0 - share) / (share * by_photons.paths as f64)).sqrt();
            println!(
                "  {gap:.0e} {signature:6}: {off:.1e}, {of_all:.1e}; {away:+.1e} ± {error:.1e}, {random:.1e}"
            );
            assert!(error <= 1.6 * random, "{gap:e} {signature}: {error:e}");
            assert!(
                away.abs() <= errors * error + ORACLE,
                "{gap:e} {signature}: {away:e} ± {error:e}"
            );
            fluxes += 1;
        }
        let of_all = error_as_asked(&by_beams, &all, &specular(&by_beams));
        assert!(of_all <= 1e-2, "{gap:e}: {of_all:e}");
    }
    assert_eq!(fluxes, FLUXES);
}

/// A point's light goes through a pane of thickness t a height g below it, and falls on a disc d below the
/// pane: at the angle θ to the pane's normal it comes in at the radius (g + d) tan θ + t tan θ', and its flux
/// within that angle is 2π I ∫ (1 − F)² sin θ dθ.
///
/// The pane lies askew, so that the brightest place of it is nowhere near a corner or the middle: a lamp just
/// above it lights a spot that none of its corners sees.
#[test]
fn a_lamp_may_be_a_hundred_millionth_of_a_panes_width_from_it() {
    const RADIUS: f64 = 0.5;
    const BELOW: f64 = 0.2;
    const THICKNESS: f64 = 0.05;
    const IOR: f64 = 1.5;
    println!(
        "lamp over a pane, by its half width: beams asked for 1e-2, worst texel and root mean square error"
    );
    let rule = GaussLegendre::new(64).expect("a rule of 64 points");
    for gap in [1e-8, 1e-6, 1e-4, 1e-2, 1e0] {
        let (lamp, middle) = (BELOW + THICKNESS + gap, BELOW + 0.5 * THICKNESS);
        let scene = scene(
            &format!(
                r#"<emitter type="point"><point name="position" x="0" y="0" z="{lamp:?}"/><rgb name="intensity" value="1"/></emitter>
<shape type="cube">
  <transform name="to_world"><scale x="1.2" y="0.9" z="{half:?}"/><rotate z="1" angle="20"/><translate x="0.2" y="0.1" z="{middle:?}"/></transform>
  <bsdf type="dielectric"><float name="int_ior" value="{IOR}"/><float name="ext_ior" value="1"/></bsdf>
</shape>
<shape type="disk">
  <transform name="to_world"><scale value="{RADIUS:?}"/></transform>
  <bsdf type="diffuse"/>{{meter}}
</shape>"#,
                half = 0.5 * THICKNESS
            ),
            None,
            SIDE,
        );
        let inside = |angle: f64| (angle.sin() / IOR).asin();
        let radius = |angle: f64| (gap + BELOW) * angle.tan() + THICKNESS * inside(angle).tan();
        let passed = |angle: f64| (1.0 - dielectric_reflectance(angle.cos(), IOR)).powi(2);
        // Radii grow with the angle: 60 halvings leave an ulp.
        let angle_at = |wanted: f64| {
            let half = |[low, high]: [f64; 2], _| {
                let angle = 0.5 * (low + high);
                if radius(angle) < wanted {
                    [angle, high]
                } else {
                    [low, angle]
                }
            };
            (0..60).fold([0.0, FRAC_PI_2], half)[0]
        };
        // All of a ring's texels are alike.
        let rings: Vec<f64> = (0..SIDE)
            .map(|ring| {
                let [from, to] = [ring, ring + 1].map(|edge| RADIUS * edge as f64 / SIDE as f64);
                let within = |angle: f64| TAU * passed(angle) * angle.sin();
                let flux = rule.integrate(angle_at(from), angle_at(to), within);
                flux / (PI * (to - from) * (to + from))
            })
            .collect();
        let truth: Vec<f64> = (0..SIDE * SIDE).map(|texel| rings[texel % SIDE]).collect();
        let found = beams(&scene, 1e-2, 2);
        let [off, error] = assert_as_asked(&format!("{gap:e}"), &found, "LTTD", &truth, 1e-2);
        println!("  {gap:.0e}: {off:.1e}, {error:.1e}");
    }
}

/// A mirror makes of a lamp a height g over it one as deep below: at the height 1 over the mirror its
/// irradiance is I (1 + g) / ((1 + g)² + ρ²)^(3/2), ρ the distance from the lamp's foot. Cells, not polygons,
/// are divided here: a disc is no facet. Over its center coordinates are stretched without bound, and in its
/// plane there is no light at all.
#[test]
fn a_lamp_may_be_a_millionth_of_a_radius_from_a_mirror() {
    const HALF: f64 = 0.5;
    println!(
        "lamp over a mirror, by its radius: roots; beams asked for 1e-2, worst texel and root mean square error"
    );
    let rule = GaussLegendre::new(8).expect("a rule of 8 points");
    for foot in [[0.0_f64, 0.0], [0.001, 0.002], [0.3, -0.2]] {
        for gap in [0.0_f64, 1e-6, 1e-4, 1e-2, 1e0] {
            let [x, y] = foot;
            let scene = scene(
                &format!(
                    r#"<emitter type="point"><point name="position" x="{x:?}" y="{y:?}" z="{gap:?}"/><rgb name="intensity" value="1"/></emitter>
<shape type="disk"><bsdf type="conductor"><string name="material" value="none"/></bsdf></shape>
<shape type="rectangle">
  <transform name="to_world"><scale x="{HALF:?}" y="{HALF:?}"/><rotate x="1" angle="180"/><translate z="1"/></transform>
  <bsdf type="diffuse"/>{{meter}}
</shape>"#
                ),
                None,
                SIDE,
            );
            let [source] = Source::all(&scene)[..] else {
                panic!("one lamp");
            };
            // Each halving of the distance takes about as many parts: over the center, some of each of 16 sectors' triangles, 20 times.
            let count = patches(&scene, &source).len();
            assert!(count < 1 << 14, "{gap:e} over {foot:?}: {count} roots");
            if gap == 0.0 {
                continue;
            }
            let at = |index: usize| HALF * (2.0 * index as f64 / SIDE as f64 - 1.0);
            let irradiance = |to_x: f64, to_y: f64| {
                let squared = (1.0 + gap).powi(2) + (to_x - x).powi(2) + (to_y - y).powi(2);
                (1.0 + gap) / (squared * squared.sqrt())
            };
            let mean = |texel: usize| {
                let (column, row) = (texel % SIDE, texel / SIDE);
                // Turned over, the receiver's v runs against y.
                let along =
                    |to_x: f64| rule.integrate(at(row), at(row + 1), |v| irradiance(to_x, -v));
                let area = (2.0 * HALF / SIDE as f64).powi(2);
                rule.integrate(at(column), at(column + 1), along) / area
            };
            let truth: Vec<f64> = (0..SIDE * SIDE).map(mean).collect();
            let found = beams(&scene, 1e-2, 1);
            let name = format!("{gap:e} over {foot:?}");
            let [off, error] = assert_as_asked(&name, &found, "LRD", &truth, 1e-2);
            println!("  {foot:?} {gap:.0e}: {count}; {off:.1e}, {error:.1e}");
        }
    }
}

/// A ball has spherical aberration: in the paraxial focus r = O(i³), and E is infinite at a point. Texels are
/// not.
#[test]
fn a_receiver_in_the_focus_is_as_good_as_one_beside_it() {
    println!(
        "receiver so far from a ball's paraxial focus: beams asked for 1e-2, worst texel and root mean square error"
    );
    let light = r#"<emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/><rgb name="irradiance" value="1000"/></emitter>"#;
    let half = 0.5;
    // Odd: the focus is in a texel's middle; even: on a corner of four.
    for side in [15, 16] {
        for away in [-1e-3, -1e-6, -1e-9, 0.0, 1e-9, 1e-6, 1e-3] {
            // n R / (2 (n − 1)) = 1.5 from the centre.
            let center = 1.5 + away;
            let known = GlassBall {
                radius: 1.0,
                center_height: center,
                ior: 1.5,
                light: AxialLight::Parallel { irradiance: 1000.0 },
            };
            let found = beams(&ball(light, center, half, side), 1e-2, 2);
            let grid = TexelGrid::square(half, side);
            let truth = known.sheet(KnownPath::Through(0)).map(&grid);
            let name = format!("{side} {away:e}");
            let [off, error] = assert_as_asked(&name, &found, "LTTD", &truth, 1e-2);
            println!("  {side} {away:+.0e}: {off:.1e}, {error:.1e}");
        }
    }
}
