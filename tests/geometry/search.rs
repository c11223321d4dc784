//! Promises of a world's search.

use glam::{DMat4, DVec2, DVec3};
use nephroid::internals::geometry::{
    Bounds, Disk, Hit, MeshParts, Ray, Rectangle, Segment, Shape, Sphere, Transform,
    TraversalCounters, World,
};

use crate::support::geometry::{Random, bumpy_torus, closest, icosphere, mesh, placed, world_of};

fn ball(center: DVec3, radius: f64) -> Shape {
    let matrix = DMat4::from_translation(center) * DMat4::from_scale(DVec3::splat(radius));
    let to_world = Transform::from_matrix(matrix).expect("can be inverted");
    Shape::Sphere(Sphere::new(&to_world, false).expect("round"))
}

fn square(height: f64) -> Shape {
    let matrix = DMat4::from_translation(DVec3::new(0.0, 0.0, height));
    let to_world = Transform::from_matrix(matrix).expect("can be inverted");
    Shape::Rectangle(Rectangle::new(&to_world, false).expect("any map"))
}

fn random_balls(count: usize) -> Vec<Shape> {
    let mut random = Random(21);
    (0..count)
        .map(|_| ball(random.in_cube() * 3.0, 0.1 + 0.4 * random.unit()))
        .collect()
}

fn random_ray(random: &mut Random) -> Ray {
    Ray::new(random.in_cube() * 5.0, random.direction())
}

/// The nearest hit, each shape searched as a world of its own.
fn one_by_one(shapes: &[Shape], ray: &Ray) -> Option<Hit> {
    let mut best: Option<Hit> = None;
    for (index, shape) in shapes.iter().enumerate() {
        if let Some(hit) = closest(&World::new(vec![shape.clone()]), ray)
            && best.is_none_or(|best| hit.distance < best.distance)
        {
            best = Some(Hit {
                shape: index as u32,
                ..hit
            });
        }
    }
    best
}

#[test]
fn many_shapes_are_searched_by_a_tree_and_few_in_turn_with_the_same_result() {
    for count in [0, 1, 8, 9, 60] {
        let mut shapes = random_balls(count);
        if count == 60 {
            shapes.push(Shape::Mesh(mesh(bumpy_torus(20, 10))));
        }
        let world = World::new(shapes.clone());
        let mut random = Random(22);
        for _ in 0..2000 {
            let ray = random_ray(&mut random);
            assert_eq!(closest(&world, &ray), one_by_one(&shapes, &ray), "{ray:?}");
        }
    }
}

#[test]
fn many_rays_at_a_time_hit_what_each_hits_alone() {
    for count in [0, 1, 8, 9, 60] {
        let mut shapes = random_balls(count);
        if count % 2 == 1 {
            // Large enough for searches by turns.
            shapes.push(Shape::Mesh(mesh(bumpy_torus(400, 100))));
            shapes.rotate_right(1);
        }
        let world = World::new(shapes);
        // Ten shapes have a tree over them, which rays go down one by one.
        assert_eq!(world.gains_by_many(), count == 1, "{count} balls");
        let mut random = Random(23);
        let segments: Vec<Segment> = (0..3000)
            .map(|i| Segment {
                ray: random_ray(&mut random),
                length: [f64::INFINITY, 5.0 * random.unit()][i % 2],
            })
            .collect();
        let (mut together, mut alone) =
            (TraversalCounters::default(), TraversalCounters::default());
        let mut found = vec![None; 7];
        for batch in segments.chunks(1000) {
            world.closest_hits(batch, &mut found, &mut together);
            let expected: Vec<Option<Hit>> = batch
                .iter()
                .map(|it| world.closest_hit(&it.ray, it.length, &mut alone))
                .collect();
            assert_eq!(found, expected, "{count} balls");
        }
        assert_eq!(together, alone, "{count} balls");
        world.closest_hits(&[], &mut found, &mut together);
        assert!(found.is_empty());
    }
}

#[test]
fn rays_of_an_image_visit_nodes_together_and_hit_what_each_hits_alone() {
    let mut shapes = random_balls(5);
    shapes.push(Shape::Mesh(mesh(bumpy_torus(200, 50))));
    let world = World::new(shapes);
    // Of all sides, along axes and not: directions have all signs, and some have zeros.
    for eye in [
        DVec3::new(2.0, -3.0, 2.0),
        DVec3::new(-4.0, 0.0, 0.0),
        DVec3::new(0.0, 0.0, -3.0),
        DVec3::new(1.0, 0.1, 0.0),
    ] {
        let forward = -eye.normalize();
        let (right, up) = forward.any_orthonormal_pair();
        let segments: Vec<Segment> = (0..128 * 128)
            .map(|pixel| {
                let at = |k: i32| 0.8 * (f64::from(k) / 64.0 - 1.0);
                let towards = forward + right * at(pixel % 128) + up * at(pixel / 128);
                Segment {
                    ray: Ray::new(eye, towards.normalize()),
                    // Some end before the torus, or within it.
                    length: match pixel % 3 {
                        2 => 0.05 * f64::from(pixel % 100),
                        _ => f64::INFINITY,
                    },
                }
            })
            .collect();
        let [mut together, mut alone] = [TraversalCounters::default(); 2];
        let mut found = Vec::new();
        for row in segments.chunks(128) {
            world.closest_hits(row, &mut found, &mut together);
            let expected: Vec<Option<Hit>> = row
                .iter()
                .map(|it| world.closest_hit(&it.ray, it.length, &mut alone))
                .collect();
            assert_eq!(found, expected, "from {eye}");
        }
        assert_eq!(together.rays, alone.rays);
        // Eight at a time: half leaves room for packets whose rays part, or end early.
        let [few, many] = [together, alone].map(|it| it.node_visits);
        assert!(2 * few < many, "from {eye}: {few} of {many} visits");
        // Few look at faces beyond their hits: that would be two and more a ray here.
        let [together, alone] = [together, alone].map(|it| it.primitive_tests);
        assert!(
            10 * together < 11 * alone,
            "from {eye}: {together} tests, not {alone}"
        );
    }
}

#[test]
fn of_equally_near_hits_the_lowest_shape_and_face_wins_in_any_order() {
    for copies in [2, 20] {
        let world = World::new(vec![square(0.0); copies]);
        let hit = closest(&world, &Ray::new(DVec3::new(0.1, 0.2, 1.0), DVec3::NEG_Z));
        assert_eq!(hit.map(|hit| hit.shape), Some(0));
    }
    // Two faces over an edge that the ray meets in the middle; the ray is as far from both.
    for triangles in [[[0, 1, 2], [1, 0, 3]], [[1, 0, 3], [0, 1, 2]]] {
        let world = world_of(MeshParts {
            positions: vec![
                DVec3::new(-1.0, 0.0, 0.0),
                DVec3::new(1.0, 0.0, 0.0),
                DVec3::new(0.0, 1.0, 0.0),
                DVec3::new(0.0, -1.0, 0.0),
            ],
            triangles: triangles.to_vec(),
            ..MeshParts::default()
        });
        let hit = closest(&world, &Ray::new(DVec3::Z, DVec3::NEG_Z));
        assert_eq!(hit.map(|hit| hit.face), Some(0));
    }
}

#[test]
fn the_greatest_distance_is_exclusive() {
    let mut counters = TraversalCounters::default();
    let down = Ray::new(DVec3::new(0.1, 0.2, 2.0), DVec3::NEG_Z);
    for world in [
        World::new(vec![square(0.0)]),
        World::new(vec![square(0.0); 20]),
        world_of(placed(icosphere(0), 1.0, DVec3::new(0.0, 0.0, -0.5))),
    ] {
        let distance = closest(&world, &down).expect("below").distance;
        let further = distance.next_up();
        assert_eq!(world.closest_hit(&down, distance, &mut counters), None);
        assert!(world.closest_hit(&down, further, &mut counters).is_some());
        assert!(!world.any_hit(&down, distance, |_| true, &mut counters));
        assert!(world.any_hit(&down, further, |_| true, &mut counters));
    }
}

#[test]
fn any_hit_asks_about_every_surface_on_the_way() {
    for count in [3, 30] {
        let shapes: Vec<Shape> = (0..count).map(|i| square(-f64::from(i))).collect();
        let world = World::new(shapes);
        let down = Ray::new(DVec3::new(0.3, 0.1, 1.0), DVec3::NEG_Z);
        let mut seen = Vec::new();
        let mut counters = TraversalCounters::default();
        let blocked = world.any_hit(
            &down,
            2.5,
            |hit| {
                seen.push(hit.shape);
                false
            },
            &mut counters,
        );
        seen.sort_unstable();
        assert!(!blocked);
        assert_eq!(seen, [0, 1]);
    }
}

#[test]
fn any_hit_agrees_with_closest_hit() {
    let world = world_of(bumpy_torus(60, 30));
    let mut random = Random(8);
    let mut counters = TraversalCounters::default();
    for _ in 0..5000 {
        let ray = random_ray(&mut random);
        let limit = 10.0 * random.unit();
        assert_eq!(
            world.any_hit(&ray, limit, |_| true, &mut counters),
            world.closest_hit(&ray, limit, &mut counters).is_some()
        );
    }
    assert_eq!(counters.rays, 10_000);
}

#[test]
fn any_primitive_box_is_true_just_where_a_chosen_primitives_box_overlaps() {
    let torus = mesh(bumpy_torus(30, 15));
    let balls = random_balls(3);
    let boxes: Vec<Bounds> = torus
        .triangles()
        .iter()
        .map(|triangle| {
            Bounds::from_points(triangle.map(|vertex| torus.positions()[vertex as usize]))
        })
        .collect();
    let ball_boxes: Vec<Bounds> = balls.iter().map(Shape::bounds).collect();
    let mut shapes = vec![Shape::Mesh(torus)];
    shapes.extend(balls);
    let world = World::new(shapes);
    let mut random = Random(31);
    let mut overlapping = 0;
    for _ in 0..3000 {
        let center = random.in_cube() * 2.0;
        let cell = Bounds::from_points([center]).padded(0.1 * random.unit());
        let overlaps =
            |other: &Bounds| cell.min.cmple(other.max).all() && other.min.cmple(cell.max).all();
        for (chosen, expected) in [
            (0, boxes.iter().any(overlaps)),
            (2, overlaps(&ball_boxes[1])),
        ] {
            let found = world.any_primitive_box(|shape| shape == chosen, overlaps);
            assert_eq!(found, expected, "shape {chosen}, {cell:?}");
            overlapping += usize::from(found);
        }
    }
    assert!(
        overlapping > 100,
        "only {overlapping} overlaps: the cells test little"
    );
}

#[test]
fn faces_on_top_of_each_other_are_searched_once() {
    let single = icosphere(1);
    let mut parts = single.clone();
    for copy in 0..1000 {
        parts
            .triangles
            .extend(single.triangles.iter().map(
                |&[a, b, c]| {
                    if copy % 2 == 0 { [b, c, a] } else { [a, c, b] }
                },
            ));
    }
    let count = parts.triangles.len();
    let world = world_of(parts);
    let mut counters = TraversalCounters::default();
    let hit = world
        .closest_hit(
            &Ray::new(DVec3::ZERO, DVec3::new(0.6, 0.0, 0.8)),
            f64::INFINITY,
            &mut counters,
        )
        .expect("from inside");
    assert!((hit.face as usize) < single.triangles.len());
    assert!(counters.primitive_tests < 10, "{counters:?}");
    assert!(
        world.memory_bytes() < 50 * count,
        "the copies are in the tree"
    );
}

#[test]
fn a_world_of_nothing_is_never_hit() {
    let world = World::new(Vec::new());
    assert!(world.bounds().is_empty());
    assert_eq!(closest(&world, &Ray::new(DVec3::ZERO, DVec3::X)), None);
}

#[test]
fn a_mesh_of_mere_points_and_lines_is_never_hit() {
    let world = world_of(MeshParts {
        positions: vec![DVec3::ZERO, DVec3::X],
        triangles: vec![[0, 0, 0], [0, 1, 1]],
        ..MeshParts::default()
    });
    assert_eq!(closest(&world, &Ray::new(DVec3::NEG_X, DVec3::X)), None);
    assert!(!world.any_primitive_box(|_| true, |_| true));
}

#[test]
fn rays_that_are_not_numbers_hit_nothing_and_do_no_harm() {
    let shapes = vec![
        Shape::Mesh(mesh(icosphere(2))),
        ball(DVec3::ZERO, 1.0),
        square(0.0),
    ];
    let world = World::new(shapes);
    for bad in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        for axis in 0..3 {
            let mut origin = DVec3::new(0.1, 0.2, 5.0);
            origin[axis] = bad;
            let ray = Ray {
                origin,
                direction: DVec3::NEG_Z,
            };
            assert_eq!(closest(&world, &ray), None, "{ray:?}");
        }
    }
}

/// Light that goes beside a receiver is placed by where it meets the receiver's plane.
#[test]
fn a_flat_shapes_plane_goes_on_beyond_its_border_and_so_do_its_parameters() {
    let mut random = Random(48);
    for _ in 0..2000 {
        let columns = [(); 3].map(|()| random.in_cube());
        let [x, y, _] = columns;
        let sine = x.normalize().cross(y.normalize()).length();
        let matrix = DMat4::from_cols(
            columns[0].extend(0.0),
            columns[1].extend(0.0),
            columns[2].extend(0.0),
            random.in_cube().extend(1.0),
        );
        let Some(to_world) = Transform::from_matrix(matrix).ok() else {
            continue;
        };
        let [u, v] = [(); 2].map(|()| 5.0 * random.signed());
        let place = to_world.point(DVec3::new(u, v, 0.0));
        let start = place + random.direction() * 3.0;
        let ray = Ray::new(start, (place - start).normalize());
        let disk = Disk::new(&to_world, false).expect("any map");
        let rectangle = Rectangle::new(&to_world, false).expect("any map");
        let facing = ray.direction.dot(disk.normal()).abs();
        let least = x.length().min(y.length());
        if sine < 0.1 || facing < 0.1 || least < 0.1 {
            continue; // parameters are not worth much there
        }
        let turn = v.atan2(u) / std::f64::consts::TAU;
        for (shape, uv) in [
            (
                Shape::Disk(disk),
                DVec2::new(u.hypot(v), turn - turn.floor()),
            ),
            (
                Shape::Rectangle(rectangle),
                DVec2::new(0.5 * (u + 1.0), 0.5 * (v + 1.0)),
            ),
        ] {
            let [center, normal] = shape.plane().expect("it is flat");
            // Places are within some 10 units and off by some u on each of a dozen operations, by 1 / facing
            // more along the ray and by 1 / (least · sine) more in parameters: 10 · 12 · 2^-53 · 1e3.
            let tolerance = 2e-11;
            assert!(normal.dot(place - center).abs() <= tolerance);
            let (distance, found) = shape.meet_beyond(&ray).expect("aimed at the plane");
            assert!((distance - 3.0).abs() <= tolerance, "{distance}");
            let mut off = found - uv;
            if matches!(shape, Shape::Disk(_)) {
                off.y -= off.y.round(); // whole turns
                off.y *= uv.x; // none about the center
            }
            assert!(off.length() <= tolerance, "{shape:?}: {found} for {uv}");
            // As within the border.
            let met = closest(&World::new(vec![shape.clone()]), &ray);
            let is_within = match &shape {
                Shape::Disk(_) => u.hypot(v) <= 1.0,
                _ => u.abs().max(v.abs()) <= 1.0,
            };
            assert_eq!(met.is_some(), is_within, "{shape:?}: {u} {v}");
            let back = Ray::new(start, -ray.direction);
            assert_eq!(shape.meet_beyond(&back), None, "behind the start");
        }
    }
    let round = ball(DVec3::ZERO, 1.0);
    assert!(round.plane().is_none() && round.meet_beyond(&random_ray(&mut random)).is_none());
}
