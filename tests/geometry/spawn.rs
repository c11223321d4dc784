//! A ray that starts on a surface does not meet that surface again where it must not.
//!
//! All shapes here are convex, so: a ray that leaves outward meets nothing; one that leaves
//! inward meets the other side from within, if anything.

use glam::{DMat4, DVec3};
use nephroid::internals::geometry::{
    Bounds, Cylinder, Disk, MeshParts, Ray, Rectangle, Shape, Sphere, SurfacePoint, Transform,
    World,
};
use proptest::prelude::*;

use crate::support::geometry::{Random, closest, icosphere, mesh, placed, world_of};

const SCALES: [f64; 5] = [1e-6, 1e-3, 1.0, 1e3, 1e6];
const OFFSETS: [f64; 4] = [0.0, 1.0, 1000.3, 1_048_576.0];

/// All kinds of shapes, about as large as `scale`, near `offset` on all axes.
fn shapes(scale: f64, offset: f64) -> Vec<Shape> {
    let center = DVec3::new(offset, -0.7 * offset, 0.3 * offset);
    let matrix = DMat4::from_translation(center)
        * DMat4::from_axis_angle(DVec3::new(0.6, 0.0, 0.8), 0.7)
        * DMat4::from_scale(DVec3::splat(scale));
    let to_world = Transform::from_matrix(matrix).expect("can be inverted");
    vec![
        Shape::Sphere(Sphere::new(&to_world, false).expect("round")),
        Shape::Rectangle(Rectangle::new(&to_world, false).expect("any map")),
        Shape::Disk(Disk::new(&to_world, false).expect("any map")),
        Shape::Cylinder(Cylinder::new(&to_world, false).expect("round")),
        Shape::Mesh(mesh(placed(icosphere(2), scale, center))),
    ]
}

/// A ray from outside or inside through a random point of the box.
fn random_ray(bounds: &Bounds, random: &mut Random) -> Ray {
    let (center, reach) = (bounds.center(), bounds.radius());
    let from = center + random.direction() * (reach * 3.0 * random.unit());
    let to = center + random.in_cube() * (0.4 * bounds.extent());
    let direction = (to - from).try_normalize().unwrap_or(DVec3::X);
    Ray::new(from, direction)
}

/// A random direction, every other one all but tangent to the surface.
fn leaving(point: &SurfacePoint, random: &mut Random) -> DVec3 {
    let direction = random.direction();
    if random.below(2) == 0 {
        return direction;
    }
    let normal = point.geometric_normal;
    let tangent = (direction - normal * normal.dot(direction)).normalize();
    let tilt = random.signed() * 10f64.powi(-(random.below(17) as i32));
    (tangent + normal * tilt).normalize()
}

/// Checks one shape with many rays.
fn assert_no_self_hits(shape: Shape, rays: usize, seed: u64) {
    let flat = matches!(shape, Shape::Rectangle(_) | Shape::Disk(_));
    let name = format!("{shape:?}").chars().take(60).collect::<String>();
    let world = World::new(vec![shape]);
    let mut random = Random(seed);
    let mut met = 0;
    for _ in 0..rays {
        let ray = random_ray(&world.bounds(), &mut random);
        let Some(hit) = closest(&world, &ray) else {
            continue;
        };
        met += 1;
        let point = world.surface_point(&ray, &hit);
        assert!(
            world.bounds().contains(point.position),
            "{name}: {point:?} is outside of the bounds"
        );
        let spawned = point.spawn(leaving(&point, &mut random));
        let again = closest(&world, &spawned);
        let outward = point.geometric_normal.dot(spawned.direction) >= 0.0;
        if outward || flat {
            assert_eq!(again, None, "{name}: from {point:?} by {spawned:?}");
        } else if let Some(again) = again {
            let other = world.surface_point(&spawned, &again);
            assert!(
                other.geometric_normal.dot(spawned.direction) > 0.0,
                "{name}: from {point:?} by {spawned:?} to {other:?}"
            );
        }
    }
    assert!(met > rays / 20, "{name}: only {met} of {rays} rays hit");
}

#[test]
fn spawned_rays_never_meet_the_surface_they_leave_on_the_wrong_side() {
    for (i, scale) in SCALES.into_iter().enumerate() {
        for (j, offset) in OFFSETS.into_iter().enumerate() {
            for (k, shape) in shapes(scale, offset).into_iter().enumerate() {
                assert_no_self_hits(shape, 20_000, (100 * i + 10 * j + k) as u64);
            }
        }
    }
}

/// Whole and half errors leave it off the surface alike on nearly every ray: that the start is moved by all
/// of the bound is seen from the bound alone.
#[test]
fn a_spawned_ray_starts_off_the_surface_by_the_bound_on_the_places_error() {
    let mut random = Random(47);
    for scale in SCALES {
        for offset in OFFSETS {
            for shape in shapes(scale, offset) {
                let name = format!("{shape:?}").chars().take(60).collect::<String>();
                let world = World::new(vec![shape]);
                let mut met = 0;
                while met < 200 {
                    let ray = random_ray(&world.bounds(), &mut random);
                    let Some(hit) = closest(&world, &ray) else {
                        continue;
                    };
                    met += 1;
                    let point = world.surface_point(&ray, &hit);
                    let normal = point.geometric_normal;
                    let start = point.spawn(leaving(&point, &mut random)).origin;
                    let off = (start - point.position).abs();
                    let bound = normal.abs().dot(point.position_error);
                    for axis in 0..3 {
                        // The product is rounded, by u of itself; the sum is too, but then a float farther
                        // out is taken.
                        let wanted = bound * normal[axis].abs() * (1.0 - f64::EPSILON);
                        assert!(off[axis] >= wanted, "{name}, axis {axis}: {off}, {bound:e}");
                        // And no farther than the sum's own rounding makes it, twice.
                        let most = wanted + 4.0 * f64::EPSILON * (start[axis].abs() + bound);
                        assert!(off[axis] <= most, "{name}, axis {axis}: {off}, {bound:e}");
                    }
                }
            }
        }
    }
}

/// A face whose third vertex is `height` from the edge between the others, at the part `along` of it: obtuse
/// where that is well inside, in any order and place.
fn sliver(height: f64, along: f64, scale: f64, random: &mut Random) -> MeshParts {
    let x = random.direction();
    let across = random.direction();
    let y = (across - x * across.dot(x)).normalize();
    let home = random.in_cube() * scale;
    let mut positions = vec![
        home,
        home + x * scale,
        home + (x * along + y * height) * scale,
    ];
    positions.rotate_left(random.below(3));
    MeshParts {
        positions,
        triangles: vec![[0, 1, 2]],
        ..MeshParts::default()
    }
}

/// Ten thousand rays on each of some slivers, up to a million times longer than wide; directions nearer to
/// the face than its normal is known (a few u by length / width) may go either way.
#[test]
fn what_leaves_a_sliver_does_not_meet_it_again() {
    let mut random = Random(41);
    for exponent in 0..=6 {
        let height = 10f64.powi(-exponent);
        let mut left = 0;
        for along in [0.5, 0.27, 0.9, 1e-3, 0.0, 1.0, 1.3] {
            for scale in [1e-3, 1.0, 1e3] {
                let parts = sliver(height, along, scale, &mut random);
                let [a, b, c] = std::array::from_fn(|vertex| parts.positions[vertex]);
                let world = world_of(parts);
                // A vertex that was placed is off by 4u of its place on each axis, and the products of edges
                // by as much.
                let least = 32.0 * f64::EPSILON / height;
                for _ in 0..500 {
                    let (u, v) = (random.unit().sqrt(), random.unit());
                    let aim = a * (1.0 - u) + b * (u * (1.0 - v)) + c * (u * v);
                    let start = aim + random.direction() * (3.0 * scale);
                    let ray = Ray::new(start, (aim - start).normalize());
                    let Some(hit) = closest(&world, &ray) else {
                        continue;
                    };
                    let point = world.surface_point(&ray, &hit);
                    let direction = leaving(&point, &mut random);
                    if direction.dot(point.geometric_normal).abs() < least {
                        continue;
                    }
                    left += 1;
                    assert!(
                        closest(&world, &point.spawn(direction)).is_none(),
                        "height 1e-{exponent}, at {along}, scale {scale:e}: {ray:?}, {direction}"
                    );
                }
            }
        }
        println!("length / width 1e{exponent}: {left} rays");
        assert!(left > 4000, "{left}");
    }
}

#[test]
fn a_ray_that_enters_a_closed_shape_leaves_it_again() {
    for scale in SCALES {
        for shape in [0, 4].map(|i| shapes(scale, 10.0 * scale).swap_remove(i)) {
            let world = World::new(vec![shape]);
            let mut random = Random(3);
            for _ in 0..5000 {
                let center = world.bounds().center();
                let start = center + random.direction() * (4.0 * scale);
                let target = center + random.direction() * (0.9 * scale * random.unit());
                let ray = Ray::new(start, (target - start).normalize());
                let entry = closest(&world, &ray).expect("aimed at the inside");
                let point = world.surface_point(&ray, &entry);
                let inside = point.spawn(ray.direction);
                let exit = closest(&world, &inside).expect("from inside");
                let point = world.surface_point(&inside, &exit);
                assert_eq!(closest(&world, &point.spawn(ray.direction)), None);
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    #[test]
    fn a_sphere_is_hit_at_its_radius_whatever_its_size_and_distance(
        log_radius in -6.0f64..6.0,
        log_distance in 0.01f64..7.0,
        seed in any::<u64>(),
    ) {
        let mut random = Random(seed);
        let radius = 10f64.powf(log_radius);
        let distance = radius * 10f64.powf(log_distance);
        let center = random.in_cube() * radius;
        let matrix = DMat4::from_translation(center) * DMat4::from_scale(DVec3::splat(radius));
        let to_world = Transform::from_matrix(matrix).expect("can be inverted");
        let world = World::new(vec![Shape::Sphere(Sphere::new(&to_world, false).expect("round"))]);
        let from = center + random.direction() * distance;
        let aim = center + random.direction() * (0.99 * radius * random.unit());
        let ray = Ray::new(from, (aim - from).normalize());
        let hit = closest(&world, &ray).expect("aimed inside");
        // The discriminant r² − |miss|² loses nothing to the distance but through `miss`, off
        // by 4u of the distance D; half the chord is at least √(1 − 0.99²) r = 0.14 r, so the
        // hit is off by 4uD / 0.14 at most, and by a few u of itself.
        let u = f64::EPSILON / 2.0;
        let off = ((ray.at(hit.distance) - center).length() - radius).abs();
        prop_assert!(off <= 32.0 * u * distance + 8.0 * u * center.length(), "off by {off:e}");
        let point = world.surface_point(&ray, &hit);
        let off = ((point.position - center).length() - radius).abs();
        prop_assert!(off <= point.position_error.length(), "projected point off by {off:e}");
    }
}
