//! Speed and work of the search for hits: `cargo bench --bench traversal`.
//!
//! Coherent rays leave one point through the texels of an image, in order. Incoherent rays join random points
//! of a ball around the mesh. Inside rays leave random points within the solid.
//!
//! The last table is the price of `f64`: the same rays through obvhs' own `f32` trees and triangles.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a bench, no results"
)]

#[path = "traversal/narrow.rs"]
mod narrow;

#[path = "traversal/rays.rs"]
mod rays;

#[path = "../tests/support/mod.rs"]
mod support;

use std::{hint::black_box, thread, time::Instant};

use glam::{DMat4, DVec3};
use narrow::Narrow;
use nephroid::internals::geometry::{
    Mesh, Ray, Rectangle, Shape, Sphere, Transform, TraversalCounters, World,
};
use rays::{coherent, incoherent, inside, search, search_many, seconds, segments};
use support::geometry::{bumpy_torus, mesh};
use support::measured::times;

fn main() {
    println!(
        "| scene | rays | Mrays/s, 1 thread | many at a time | 2 threads | nodes/ray | tests/ray | hits |"
    );
    println!("|---|---|--:|--:|--:|--:|--:|--:|");
    let meshes = [(400, 100), (820, 200)].map(|(around, across)| mesh(bumpy_torus(around, across)));
    let (mut builds, mut contests) = (Vec::new(), Vec::new());
    for mesh in meshes {
        let triangles = mesh.triangle_count();
        let narrow = Narrow::new(&mesh);
        let (world, seconds) = build(mesh);
        let name = format!("torus {}k", triangles / 1000);
        for (kind, rays) in [
            ("coherent", coherent()),
            ("incoherent", incoherent()),
            ("inside", inside()),
        ] {
            report(&name, kind, &world, &rays);
            contests.push(contest(&name, kind, &world, &narrow, &rays));
        }
        builds.push((name, triangles, seconds, world.memory_bytes()));
    }
    report("ball and floor", "coherent", &ball_and_floor(), &coherent());
    report(
        "ball and floor",
        "incoherent",
        &ball_and_floor(),
        &incoherent(),
    );
    println!("\n| scene | triangles | build, s | bytes/triangle |\n|---|--:|--:|--:|");
    for (name, triangles, seconds, bytes) in builds {
        println!(
            "| {name} | {triangles} | {seconds:.3} | {:.0} |",
            bytes as f64 / triangles as f64
        );
    }
    println!(
        "\nThe price of `f64` hits, one thread: nephroid against obvhs' wide tree with `f32` triangles.\n"
    );
    println!(
        "| scene | rays | f64, ns/ray | f32, ns/ray | price | only one hits | median error of f32 | worst |"
    );
    println!("|---|---|--:|--:|--:|--:|--:|--:|");
    contests.iter().for_each(|line| println!("{line}"));
}

/// A line of the table: both searches of the same rays by turns, so that other work of the machine slows
/// both.
///
/// The error is that of the distance, relative to it, for rays that find the same triangle in both.
fn contest(scene: &str, kind: &str, world: &World, narrow: &Narrow, rays: &[Ray]) -> String {
    let (mut wide_seconds, mut narrow_seconds) = (f64::INFINITY, f64::INFINITY);
    for _ in 0..turns() {
        wide_seconds = wide_seconds.min(seconds(|| {
            black_box(search(world, rays));
        }));
        narrow_seconds = narrow_seconds.min(seconds(|| {
            black_box(
                rays.iter()
                    .filter(|ray| black_box(narrow.hit(ray)).is_some())
                    .count(),
            );
        }));
    }
    let mut errors = Vec::new();
    let mut only_one = 0u64;
    for ray in rays {
        let exact = world.closest_hit(ray, f64::INFINITY, &mut TraversalCounters::default());
        match (exact, narrow.hit(ray)) {
            (Some(exact), Some((face, distance))) if exact.face == face => {
                errors.push((f64::from(distance) - exact.distance).abs() / exact.distance);
            }
            (None, None) | (Some(_), Some(_)) => {}
            _ => only_one += 1,
        }
    }
    errors.sort_by(f64::total_cmp);
    let nanoseconds = |seconds: f64| 1e9 * seconds / rays.len() as f64;
    format!(
        "| {scene} | {kind} | {:.0} | {:.0} | {:.2} | {:.1e} | {:.1e} | {:.1e} |",
        nanoseconds(wide_seconds),
        nanoseconds(narrow_seconds),
        wide_seconds / narrow_seconds,
        only_one as f64 / rays.len() as f64,
        errors.get(errors.len() / 2).copied().unwrap_or(f64::NAN),
        errors.last().copied().unwrap_or(f64::NAN),
    )
}

/// Number of runs of which the fastest counts.
fn turns() -> usize {
    times(12)
}

fn build(mesh: Mesh) -> (World, f64) {
    let start = Instant::now();
    let world = World::new(vec![Shape::Mesh(mesh)]);
    (world, start.elapsed().as_secs_f64())
}

fn ball_and_floor() -> World {
    let floor =
        DMat4::from_translation(DVec3::new(0.0, 0.0, -1.5)) * DMat4::from_scale(DVec3::splat(10.0));
    let floor = Transform::from_matrix(floor).expect("can be inverted");
    World::new(vec![
        Shape::Sphere(Sphere::new(&Transform::IDENTITY, false).expect("round")),
        Shape::Rectangle(Rectangle::new(&floor, false).expect("any map")),
    ])
}

/// The fastest of all [turns], seconds: other programs can only make it slower.
fn best(mut work: impl FnMut()) -> f64 {
    (0..turns())
        .map(|_| seconds(&mut work))
        .fold(f64::INFINITY, f64::min)
}

fn report(scene: &str, kind: &str, world: &World, rays: &[Ray]) {
    let (hits, counters) = search(world, rays);
    let one = best(|| {
        black_box(search(world, rays));
    });
    let segments = segments(rays);
    let many = best(|| {
        black_box(search_many(world, &segments));
    });
    let two = best(|| {
        thread::scope(|scope| {
            for half in rays.chunks(rays.len() / 2) {
                scope.spawn(move || black_box(search(world, half)));
            }
        });
    });
    let n = rays.len() as f64;
    println!(
        "| {scene} | {kind} | {:.2} | {:.2} | {:.2} | {:.1} | {:.2} | {:.0} % |",
        n / one / 1e6,
        n / many / 1e6,
        n / two / 1e6,
        counters.node_visits as f64 / n,
        counters.primitive_tests as f64 / n,
        100.0 * hits as f64 / n
    );
}
