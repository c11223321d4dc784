//! Faces that are slivers, have no area, are given twice, or share no vertices.

use glam::{DQuat, DVec3};
use nephroid::internals::geometry::{Mesh, MeshParts, Ray};
use nephroid::internals::optics::dielectric_reflectance;

use super::runs::{FLAT, IOR, ROUNDING, load, load_over, met, photons, row, says, share, unseen};
use crate::support::geometry::{
    Leaks, Random, closest, delicate_point, icosphere, leaks, placed, unshared, world_of,
};
use crate::support::mutation::obj;

#[test]
fn slivers_reflect_their_share_as_exactly_as_their_normals_are_known() {
    /// Error of a sliver's normal, in u · length / width: a vertex that is turned is rounded by 4u of
    /// its length on each of three axes, and two of them tilt a face by twice that over its width (14); the
    /// products of long edges in the normal itself are rounded to 3u of their length, over the width again
    /// (6).
    const TILT: f64 = 20.0;
    // The light comes from straight above, so that the floor sees some of what the sheet lets through.
    let turn =
        DQuat::from_rotation_z(37_f64.to_radians()) * DQuat::from_rotation_x(-60_f64.to_radians());
    let angle = 60_f64.to_radians();
    let sun = turn * DVec3::new(0.0, angle.sin(), -angle.cos());
    for decades in 0..=4 {
        let length = 10_f64.powi(decades);
        let strips = 10_u32.pow(decades as u32);
        let width = 1.0 / f64::from(strips);
        // A sheet of strips of two faces each, every one as long as the sheet.
        let positions = (0..=strips).flat_map(|strip| {
            let x = f64::from(strip) * width - 0.5;
            [-0.5, 0.5].map(|y| DVec3::new(x, y * length, 0.0))
        });
        let sheet = MeshParts {
            positions: positions.collect(),
            triangles: (0..strips)
                .flat_map(|k| {
                    [
                        [2 * k, 2 * k + 2, 2 * k + 1],
                        [2 * k + 1, 2 * k + 2, 2 * k + 3],
                    ]
                })
                .collect(),
            ..MeshParts::default()
        };
        let placing = format!(
            r#"{FLAT}<transform name="to_world"><rotate x="1" angle="-60"/><rotate z="1" angle="37"/><translate z="1"/></transform>"#
        );
        let scene = load_over(
            2.0 + 0.05 * length,
            "sheet.obj",
            &obj(&sheet),
            &placing,
            sun,
        )
        .unwrap();
        let estimate = photons(&scene);
        let aspect = length / width;
        let tilt = TILT * f64::EPSILON / 2.0 * aspect;
        let reflectance = |angle: f64| dielectric_reflectance(angle.cos(), IOR);
        let passed = share(&estimate, "LTD");
        assert!(passed > 0.0, "the floor sees nothing of what passes");
        let found = share(&estimate, "LRD") + unseen(&estimate);
        println!(
            "aspect {aspect:e}: off by {:.1e}, allowed {:.1e}",
            found - reflectance(angle),
            reflectance(angle + tilt) - reflectance(angle)
        );
        assert!(
            found > reflectance(angle - tilt) - ROUNDING
                && found < reflectance(angle + tilt) + ROUNDING,
            "aspect {aspect:e}: {found}, not {}",
            reflectance(angle)
        );
        // The sums are rounded to parts of all light, most of which passes the narrow sheet by.
        let all = estimate.ledger.emitted.mean() / met(&estimate);
        assert!(
            (passed + found - 1.0).abs() < ROUNDING * all,
            "aspect {aspect:e}: {passed} and {found}"
        );
    }
}

#[test]
fn faces_without_area_and_faces_said_twice_change_no_bit_of_the_map() {
    let sun = DVec3::new(0.1, 0.2, -1.0);
    let ball = placed(icosphere(3), 0.7, DVec3::Z * 1.4);
    let [a, b, c] = ball.triangles[11];
    let middle = 0.5 * (ball.positions[a as usize] + ball.positions[b as usize]);
    let mut points_and_lines = ball.clone();
    points_and_lines.positions.push(middle);
    let m = points_and_lines.positions.len() as u32 - 1;
    points_and_lines
        .triangles
        .extend([[a, a, b], [c, c, c], [a, m, b]]);
    let mut twice = ball.clone();
    twice.triangles.extend_from_within(..);
    let mut turned_round = ball.clone();
    turned_round.triangles.push([b, c, a]);
    let run = |parts: &MeshParts| {
        let scene = load("ball.obj", &obj(parts), FLAT, sun).unwrap();
        (photons(&scene), scene)
    };
    let (plain, scene) = run(&ball);
    assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
    for (case, parts, warning) in [
        ("points and lines", points_and_lines, "faces of zero area"),
        (
            "each face twice",
            twice,
            "1280 faces that repeat an earlier face",
        ),
        (
            "a face from another corner on",
            turned_round,
            "1 faces that repeat",
        ),
    ] {
        let (estimate, scene) = run(&parts);
        assert!(says(&scene, warning), "{case}: {:?}", scene.warnings());
        assert_eq!(estimate.ledger, plain.ledger, "{case}");
        assert_eq!(estimate.total.values, plain.total.values, "{case}");
    }
}

#[test]
fn faces_that_share_no_vertices_are_met_as_those_that_do_to_the_bit() {
    let mut hits = 0;
    for place in [
        (1.0, DVec3::ZERO),
        (1e-6, DVec3::ZERO),
        (1e6, DVec3::ZERO),
        (1.0, DVec3::new(1048576.0, -524288.0, 3.0)),
    ] {
        let shared = placed(icosphere(4), place.0, place.1);
        let apart = unshared(&shared);
        let worlds = [&shared, &apart].map(|parts| world_of(parts.clone()));
        let mesh = Mesh::new(apart.clone()).unwrap();
        let diagnosis = mesh.diagnose();
        assert!(diagnosis.is_closed(), "{diagnosis}");
        let repeated = apart.positions.len() - shared.positions.len();
        assert_eq!(diagnosis.repeated_positions.count, repeated);
        let found = leaks(&apart, &worlds[1], place, 20_000, |p| 0.5 * p);
        let none = Leaks {
            rays: 20_000,
            seen: 20_000,
            ..Leaks::default()
        };
        assert_eq!(found, none, "{place:?}");
        let mut random = Random(11);
        for turn in 0..20_000 {
            // Half of them at places on edges and vertices, where faces tie; half anywhere, some of them past
            // the ball.
            let start = place.1 + 2.0 * place.0 * random.in_cube();
            let target = if turn % 2 == 0 {
                delicate_point(&shared, &mut random)
            } else {
                place.1 + place.0 * random.in_cube()
            };
            let Some(direction) = (target - start).try_normalize() else {
                continue;
            };
            let ray = Ray::new(start, direction);
            let [one, other] = [0, 1].map(|i| closest(&worlds[i], &ray));
            assert_eq!(one, other, "{place:?}, {ray:?}");
            hits += u32::from(one.is_some());
        }
    }
    println!("{hits} hits of 80000 rays have the same bits");
    assert!(hits > 40_000, "{hits}");
    // And a whole run from the file: the reader of OBJ keeps vertices apart that the file has apart.
    let run = |parts: &MeshParts| {
        let ball = placed(parts.clone(), 0.7, DVec3::Z * 1.4);
        let sun = DVec3::new(0.1, 0.2, -1.0);
        let scene = load("ball.obj", &obj(&ball), FLAT, sun).unwrap();
        assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
        photons(&scene)
    };
    let ball = icosphere(3);
    let [shared, apart] = [&ball, &unshared(&ball)].map(run);
    assert!(row(&shared, "LTTD").received.mean() > 0.0);
    assert_eq!(apart.ledger, shared.ledger);
    assert_eq!(apart.total.values, shared.total.values);
}
