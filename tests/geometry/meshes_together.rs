//! Promises of searches among meshes that share a tree.

use glam::DVec3;
use nephroid::internals::geometry::{
    Bounds, Hit, Mesh, MeshParts, PlanePair, Ray, Segment, Shape, TraversalCounters, World,
};

use crate::support::geometry::{Random, bumpy_torus, closest, icosphere, mesh, placed};

/// A floor, tori on it, a mesh whose only face has no area, one too tiny for the others' tree, and one so far away
/// that all would be tiny beside it.
fn meshes() -> Vec<Mesh> {
    let mut random = Random(41);
    let mut parts = vec![
        MeshParts {
            positions: vec![
                DVec3::new(-9.0, -9.0, -1.0),
                DVec3::new(9.0, -9.0, -1.0),
                DVec3::new(0.0, 9.0, -1.0),
            ],
            triangles: vec![[0, 1, 2]],
            ..MeshParts::default()
        },
        placed(icosphere(2), 1e-6, DVec3::splat(0.3)),
        MeshParts {
            positions: vec![DVec3::ZERO, DVec3::X],
            triangles: vec![[0, 1, 1]],
            ..MeshParts::default()
        },
        placed(icosphere(1), 1.0, DVec3::X * 1e9),
    ];
    parts.extend((0..12u32).map(|n| {
        let torus = bumpy_torus(8 + 3 * n, 6 + n);
        placed(torus, 0.2 + random.unit(), random.in_cube() * 3.0)
    }));
    parts.into_iter().map(mesh).collect()
}

/// Rays from here and there to a corner of a mesh, or anywhere.
fn rays(meshes: &[Mesh], count: usize) -> Vec<Ray> {
    let mut random = Random(42);
    (0..count)
        .map(|n| {
            let from = random.in_cube() * 6.0;
            let corners = meshes[n % meshes.len()].positions();
            let to = corners[random.below(corners.len())];
            let towards = (to - from).normalize();
            Ray::new(
                from,
                if n % 3 == 0 {
                    random.direction()
                } else {
                    towards
                },
            )
        })
        .collect()
}

fn alone(mesh: &Mesh) -> World {
    World::new(vec![Shape::Mesh(mesh.clone())])
}

/// The hit of a ray on each mesh alone, as a shape among all.
fn hits_alone(worlds: &[World], ray: &Ray) -> Vec<Hit> {
    let each = (0..).zip(worlds);
    each.filter_map(|(shape, world)| {
        let hit = closest(world, ray)?;
        Some(Hit { shape, ..hit })
    })
    .collect()
}

#[test]
fn meshes_that_share_a_tree_are_hit_where_each_is_hit_alone() {
    let meshes = meshes();
    let worlds: Vec<World> = meshes.iter().map(alone).collect();
    let world = World::new(meshes.iter().cloned().map(Shape::Mesh).collect());
    let mut counters = TraversalCounters::default();
    let (mut segments, mut expected) = (Vec::new(), Vec::new());
    let mut met = vec![0; meshes.len()];
    for ray in rays(&meshes, 6000) {
        let hits = hits_alone(&worlds, &ray);
        let nearest = hits
            .iter()
            .min_by(|a, b| {
                let by_distance = a.distance.total_cmp(&b.distance);
                by_distance.then(a.shape.cmp(&b.shape))
            })
            .copied();
        assert_eq!(closest(&world, &ray), nearest, "{ray:?}");
        for shape in 0..meshes.len() as u32 {
            let of_shape = hits.iter().find(|hit| hit.shape == shape).copied();
            assert_eq!(
                world.hit_on(shape, &ray, &mut counters),
                of_shape,
                "{ray:?}"
            );
            // Whatever else is in the way, and not at the hit itself.
            let reach = of_shape.map_or(f64::INFINITY, |hit| hit.distance);
            for (limit, is_met) in [(reach, false), (reach.next_up(), of_shape.is_some())] {
                let blocks = |hit: &Hit| hit.shape == shape;
                assert_eq!(world.any_hit(&ray, limit, blocks, &mut counters), is_met);
            }
        }
        if let Some(hit) = nearest {
            met[hit.shape as usize] += 1;
        }
        expected.push(nearest);
        segments.push(Segment {
            ray,
            length: f64::INFINITY,
        });
    }
    let mut found = Vec::new();
    world.closest_hits(&segments, &mut found, &mut counters);
    assert_eq!(found, expected);
    met.remove(2);
    assert!(
        met.iter().all(|&hits| hits > 20),
        "{met:?}: the rays test little"
    );
}

#[test]
fn faces_and_boxes_of_one_mesh_are_found_among_those_of_others() {
    let meshes = meshes();
    let world = World::new(meshes.iter().cloned().map(Shape::Mesh).collect());
    let mut random = Random(43);
    let mut between = 0;
    for _ in 0..300 {
        let (along, low) = (random.direction(), random.signed());
        let pairs = [
            PlanePair::above(along, low),
            PlanePair::below(along, low + 0.1),
        ];
        for (shape, mesh) in (0..).zip(&meshes) {
            let mut found = Vec::new();
            world.any_face(shape, pairs.into_iter(), |face, corners| {
                assert_eq!(*corners, mesh.corners(face), "of another mesh");
                found.push(face);
                false
            });
            let distinct = mesh.distinct_faces();
            for face in distinct {
                let corners = mesh.corners(face);
                if pairs.iter().all(|pair| !pair.is_beside(&corners)) {
                    between += 1;
                    assert!(
                        found.contains(&face),
                        "face {face} of shape {shape} is lost"
                    );
                }
            }
            let is_above = |corner: DVec3| corner.dot(along) > low;
            let expected = (0..mesh.triangle_count() as u32)
                .filter(|&face| mesh.corners(face)[1] != mesh.corners(face)[2])
                .any(|face| box_corners(&mesh.corners(face)).into_iter().any(is_above));
            let overlaps = |bounds: &Bounds| bounds.corners().into_iter().any(is_above);
            let any = world.any_primitive_box(|chosen| chosen == shape, overlaps);
            assert_eq!(any, expected, "shape {shape}");
        }
    }
    assert!(
        between > 10_000,
        "only {between} faces: the planes test little"
    );
}

fn box_corners(points: &[DVec3; 3]) -> [DVec3; 8] {
    Bounds::from_points(*points).corners()
}

#[test]
fn of_meshes_in_one_place_the_first_is_hit() {
    let torus = mesh(bumpy_torus(30, 12));
    let mut shapes = vec![Shape::Mesh(mesh(placed(icosphere(1), 0.3, DVec3::ONE)))];
    for copies in [2, 20] {
        shapes.resize(1 + copies, Shape::Mesh(torus.clone()));
        let world = World::new(shapes.clone());
        let one = alone(&torus);
        let mut random = Random(45);
        let mut counters = TraversalCounters::default();
        let mut hits = 0;
        for _ in 0..500 {
            let from = random.in_cube() * 3.0;
            let to = random.in_cube() * DVec3::new(1.0, 1.0, 0.1);
            let ray = Ray::new(from, (to - from).normalize());
            let expected = closest(&one, &ray);
            for shape in 1..=copies as u32 {
                let hit = expected.map(|hit| Hit { shape, ..hit });
                assert_eq!(world.hit_on(shape, &ray, &mut counters), hit);
            }
            if let Some(hit) = closest(&world, &ray).filter(|hit| hit.shape > 0) {
                assert_eq!(Some(hit), expected.map(|hit| Hit { shape: 1, ..hit }));
                hits += 1;
            }
        }
        assert!(hits > 100, "only {hits} hits: the rays test little");
    }
}

#[test]
fn many_rays_among_many_meshes_wait_for_memory_together() {
    let mut random = Random(46);
    let shapes: Vec<Shape> = (0..12)
        .map(|_| {
            Shape::Mesh(mesh(placed(
                bumpy_torus(160, 50),
                1.0,
                random.in_cube() * 3.0,
            )))
        })
        .collect();
    let world = World::new(shapes);
    assert!(world.gains_by_many(), "192,000 faces in one tree");
    let segments: Vec<Segment> = (0..3000)
        .map(|i| Segment {
            ray: Ray::new(random.in_cube() * 5.0, random.direction()),
            length: [f64::INFINITY, 5.0 * random.unit()][i % 2],
        })
        .collect();
    let [mut together, mut alone] = [TraversalCounters::default(); 2];
    let mut found = Vec::new();
    world.closest_hits(&segments, &mut found, &mut together);
    let expected: Vec<Option<Hit>> = segments
        .iter()
        .map(|it| world.closest_hit(&it.ray, it.length, &mut alone))
        .collect();
    assert_eq!(found, expected);
    assert_eq!(together, alone);
    let shapes: std::collections::HashSet<u32> =
        found.iter().flatten().map(|hit| hit.shape).collect();
    assert_eq!(shapes.len(), 12);
}

#[test]
fn a_row_of_thousands_of_meshes_is_one_tree() {
    // Clustering would merge a row one pair at a time: the plain tree joins it.
    let tile = |n: u32| placed(square_parts(), 1.0, DVec3::X * f64::from(n));
    let world = World::new((0..3000).map(|n| Shape::Mesh(mesh(tile(n)))).collect());
    let mut counters = TraversalCounters::default();
    for n in 0..3000u32 {
        let ray = Ray::new(DVec3::new(f64::from(n) + 0.3, 0.2, 1.0), DVec3::NEG_Z);
        let hit = world.closest_hit(&ray, f64::INFINITY, &mut counters);
        assert_eq!(hit.map(|hit| hit.shape), Some(n));
    }
    // Eight children a node: log₈ 3000 < 4 levels if it were full, and twice as many if it is half full.
    assert!(counters.node_visits < 8 * 3000, "{counters:?}");
}

fn square_parts() -> MeshParts {
    MeshParts {
        positions: vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::new(1.0, 1.0, 0.0)],
        triangles: vec![[0, 1, 2], [1, 3, 2]],
        ..MeshParts::default()
    }
}

#[test]
fn many_meshes_cost_hardly_more_than_the_same_faces_as_one() {
    let mut random = Random(44);
    let parts: Vec<MeshParts> = (0..30)
        .map(|_| placed(bumpy_torus(24, 10), 1.0, random.in_cube()))
        .collect();
    let many = World::new(
        parts
            .iter()
            .cloned()
            .map(|it| Shape::Mesh(mesh(it)))
            .collect(),
    );
    let mut whole = MeshParts::default();
    for parts in parts {
        let first = whole.positions.len() as u32;
        whole.positions.extend(parts.positions);
        let moved = parts
            .triangles
            .iter()
            .map(|face| face.map(|corner| corner + first));
        whole.triangles.extend(moved);
    }
    let one = alone(&mesh(whole));
    let [mut of_many, mut of_one] = [TraversalCounters::default(); 2];
    for _ in 0..4000 {
        let ray = Ray::new(random.in_cube() * 2.0, random.direction());
        let hit = many.closest_hit(&ray, f64::INFINITY, &mut of_many);
        let expected = one.closest_hit(&ray, f64::INFINITY, &mut of_one);
        assert_eq!(
            hit.map(|hit| hit.distance),
            expected.map(|hit| hit.distance)
        );
    }
    println!(
        "{} of many, {} of one",
        of_many.node_visits, of_one.node_visits
    );
    assert!(
        2 * of_many.node_visits < 3 * of_one.node_visits,
        "{of_many:?}, {of_one:?}"
    );
}
