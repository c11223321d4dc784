//! Meshes at their worst, from the single ray to the whole run: what holds, and what is said where it cannot.
//!
//! `tests/geometry/` tests the parts (hits, spawned rays, diagnostics); here a mesh file goes in and a map with its
//! ledger comes out.

use std::io::Read;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use flate2::Compression;
use flate2::read::GzDecoder;
use glam::{DQuat, DVec3};
use nephroid::geometry::{Mesh, MeshParts, Ray, World};
use nephroid::mitsuba;
use nephroid::numeric::ExactSum;
use nephroid::optics::dielectric_reflectance;
use nephroid::reference::beams::{self, BeamBudget, BeamSettings};
use nephroid::reference::photons::run::Setup;
use nephroid::reference::photons::{Budget, PhotonSettings};
use nephroid::reference::{Estimate, LayerName, Progress};
use nephroid::scene::Scene;
use nephroid::transport::chain::ChainSettings;
use nephroid::transport::ledger::FluxByFate;
use nephroid::transport::signature::Signature;
use rayon::prelude::*;
use tempfile::TempDir;

use crate::support::geometry::{
    Leaks, Random, bumpy_torus, closest, delicate_point, icosphere, is_lost, leaks, placed,
    unshared, within_torus, world_of,
};
use crate::support::mutation::{obj, ply, serialized, serialized_contents};

/// The index of the glass.
const IOR: f64 = 1.5;

/// Flux is rounded to 2⁻⁶⁰ of the light's at every step of a photon: 10⁵ of them sum to 1e-13 at worst (see `tests/photons/ledger.rs`).
const ROUNDING: f64 = 1e-12;

/// A closed ball of slivers: meridians from pole to pole in bundles of `bundle`, 1e-8 rad apart, with one vertex each on the
/// equator. Length by width of a face: √2 / 1e-8 = 1.4e8.
fn sliver_ball(bundles: u32, bundle: u32) -> MeshParts {
    let mut positions = vec![DVec3::Z, -DVec3::Z];
    for i in 0..bundles {
        for j in 0..bundle {
            let longitude =
                std::f64::consts::TAU * f64::from(i) / f64::from(bundles) + 1e-8 * f64::from(j);
            positions.push(DVec3::new(longitude.cos(), longitude.sin(), 0.0));
        }
    }
    let around = bundles * bundle;
    let triangles = (0..around).flat_map(|k| {
        let (here, next) = (2 + k, 2 + (k + 1) % around);
        [[0, here, next], [1, next, here]]
    });
    MeshParts {
        triangles: triangles.collect(),
        positions,
        ..MeshParts::default()
    }
}

/// A line out of a solid.
struct Line {
    /// Within, or on the surface where `is_deep` is false.
    start: DVec3,
    /// On the surface.
    target: DVec3,
    is_deep: bool,
}

/// A line out of a convex solid, symmetric in x about the plane `x = middle`, through a place where a test that is not watertight leaks: a vertex, the
/// middle of an edge or any place on it; or parallel to x through a vertex, so that two coordinates agree to the bit and every edge function
/// of the vertex is exactly 0.
fn delicate_line(parts: &MeshParts, (scale, middle): (f64, DVec3), random: &mut Random) -> Line {
    let triangle = parts.triangles[random.below(parts.triangles.len())];
    let first = random.below(3);
    let [a, b] = [first, (first + 1) % 3].map(|i| parts.positions[triangle[i] as usize]);
    let start = middle + random.in_cube() * (0.3 * scale);
    let (start, target, is_deep) = match random.below(4) {
        0 => (start, a, true),
        1 => (start, a + (b - a) * 0.5, true),
        2 => (start, a + (b - a) * random.unit(), true),
        // The vertex opposite is at the other end of the way from start. Where no edge is as long (0.32 at most, but for those to
        // the poles, which are in the plane of symmetry), the way is not along the surface.
        _ => (
            DVec3::new(
                middle.x + 0.9 * random.signed() * (a.x - middle.x),
                a.y,
                a.z,
            ),
            a,
            (a.x - middle.x).abs() > 0.2 * scale,
        ),
    };
    Line {
        start,
        target,
        is_deep,
    }
}

/// Rays through places where a test that is not watertight leaks.
#[derive(Default)]
struct Rays {
    /// From within a solid.
    out: AtomicU64,
    /// Of them those that meet nothing.
    lost_out: AtomicU64,
    /// From without.
    into: AtomicU64,
    /// Of them those that meet nothing before they are within.
    lost_into: AtomicU64,
}

impl Rays {
    /// Sends rays along so many lines through a convex solid, from within and from without.
    fn send(&self, parts: &MeshParts, world: &World, place: (f64, DVec3), lines: u64) {
        /// Lines of one thread at a time.
        const BATCH: u64 = 1 << 14;
        let count = |counter: &AtomicU64, is_so: bool| {
            counter.fetch_add(u64::from(is_so), Ordering::Relaxed);
        };
        let batches = (0..lines.div_ceil(BATCH)).into_par_iter();
        batches.for_each(|batch| {
            let mut random = Random(batch);
            let mut left = BATCH.min(lines - batch * BATCH);
            while left > 0 {
                let line = delicate_line(parts, place, &mut random);
                let through = line.target - line.start;
                let Some(direction) = through.try_normalize() else {
                    continue;
                };
                left -= 1;
                let ray = Ray::new(line.start, direction);
                count(&self.out, true);
                count(&self.lost_out, is_lost(world, &ray, f64::INFINITY));
                // Back from 1e-3 to 1e3 times as far beyond the surface.
                let from = line.target + through * 10f64.powf(3.0 * random.signed());
                let Some(back) = (line.target - from).try_normalize() else {
                    continue;
                };
                if line.is_deep {
                    let reach = line.start.distance(from);
                    count(&self.into, true);
                    count(
                        &self.lost_into,
                        is_lost(world, &Ray::new(from, back), reach),
                    );
                }
            }
        });
    }
}

/// Aims rays along `lines` lines at the vertices and edges of closed solids, slivers among them, over twelve decades of size, from within and from
/// without: none may get out, and none in without meeting the surface.
fn assert_that_nothing_leaks(lines: u64) {
    let places = [
        (1.0, DVec3::ZERO),
        (1e-6, DVec3::ZERO),
        (1e6, DVec3::ZERO),
        (1.0, DVec3::new(1048576.0, -524288.0, 3.0)),
    ];
    let solids = [icosphere(2), icosphere(4), sliver_ball(8, 16)];
    let share = lines / (places.len() * solids.len()) as u64;
    let mut sums = [0; 2];
    for solid in &solids {
        for place in places {
            let parts = placed(solid.clone(), place.0, place.1);
            let world = world_of(parts.clone());
            let rays = Rays::default();
            rays.send(&parts, &world, place, share);
            let case = format!("{} faces, {place:?}", parts.triangles.len());
            assert_eq!(rays.lost_out.into_inner(), 0, "out of {case}");
            assert_eq!(rays.lost_into.into_inner(), 0, "into {case}");
            let sent = [rays.out, rays.into].map(AtomicU64::into_inner);
            // Three kinds of four are deep whatever the vertex.
            assert!(
                sent[0] == share && sent[1] > share * 7 / 10,
                "{case}: {sent:?}"
            );
            sums = [0, 1].map(|way| sums[way] + sent[way]);
        }
    }
    println!(
        "none of {} rays from within is lost, none of {} from without",
        sums[0], sums[1]
    );
}

#[test]
fn no_ray_of_a_million_aimed_at_vertices_and_edges_leaves_a_closed_mesh_or_enters_it_unseen() {
    assert_that_nothing_leaks(600_000);
}

/// Takes eighty CPU-minutes: `cargo test --release --test extremes a_billion -- --ignored`.
#[test]
#[ignore = "a billion rays"]
fn no_ray_of_a_billion_aimed_at_vertices_and_edges_leaves_a_closed_mesh_or_enters_it_unseen() {
    assert_that_nothing_leaks(1_000_000_000);
}

/// Loads a glass mesh over a floor of 4 x 4; see [`load_over`].
fn load(name: &str, mesh: &[u8], more: &str, sun: DVec3) -> Result<Scene, String> {
    load_over(2.0, name, mesh, more, sun)
}

/// Loads a glass mesh over a floor of half width `half` in the light of a sun that shines along `sun`. `name`: of the mesh
/// file, whose ending is its plugin; `more`: of the shape's element.
fn load_over(half: f64, name: &str, mesh: &[u8], more: &str, sun: DVec3) -> Result<Scene, String> {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join(name), mesh).unwrap();
    let plugin = name.rsplit('.').next().unwrap();
    let xml = format!(
        r#"<scene version="3.0.0">
<emitter type="directional"><vector name="direction" x="{}" y="{}" z="{}"/><rgb name="irradiance" value="1"/></emitter>
<shape type="{plugin}"><string name="filename" value="{name}"/>{more}
<bsdf type="dielectric"><float name="int_ior" value="{IOR}"/><float name="ext_ior" value="1"/></bsdf></shape>
<shape type="rectangle"><transform name="to_world"><scale value="{half}"/></transform>
<sensor type="irradiancemeter"><film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/><rfilter type="box"/></film></sensor></shape>
</scene>"#,
        sun.x, sun.y, sun.z
    );
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, xml).unwrap();
    mitsuba::load(&file, &[]).map_err(|error| error.to_string())
}

const FLAT: &str = r#"<boolean name="face_normals" value="true"/>"#;

/// A photon run whose photons split at each of the first six events, so that the flux of each signature is its share by
/// Fresnel to rounding, however few photons there are.
fn photons(scene: &Scene) -> Estimate {
    let settings = PhotonSettings {
        chains: ChainSettings {
            split_depth: 6,
            ..ChainSettings::default()
        },
        ..PhotonSettings::default()
    };
    let budget = Budget {
        photons: Some(1 << 14),
        ..Budget::default()
    };
    let progress = Progress::default();
    let setup = Setup::new(scene, &scene.sensors()[0], settings, &progress).unwrap();
    let estimate = setup.run(&budget).unwrap();
    assert!(estimate.ledger.closure_error().unwrap() < ROUNDING);
    estimate
}

fn row(estimate: &Estimate, signature: &str) -> FluxByFate {
    let signature: Signature = signature.parse().unwrap();
    estimate
        .ledger
        .rows
        .get(&signature)
        .copied()
        .unwrap_or_default()
}

/// All flux that met glass: what has an event behind it, and what ended there without one.
fn met(estimate: &Estimate) -> f64 {
    let direct = row(estimate, "LD");
    let all = estimate.ledger.sum().total() - direct.total() + direct.absorbed;
    let all = all.mean();
    assert!(all > 0.0, "no photon meets the mesh");
    all
}

/// The share of the flux that met glass which ended with these events behind it.
fn share(estimate: &Estimate, signature: &str) -> f64 {
    row(estimate, signature).total().mean() / met(estimate)
}

/// The share that ended with events behind it of which the floor saw nothing: the ledger has them together.
fn unseen(estimate: &Estimate) -> f64 {
    estimate.ledger.other.total().mean() / met(estimate)
}

/// The share that the floor received with these events behind it.
fn received(estimate: &Estimate, signature: &str) -> f64 {
    row(estimate, signature).received.mean() / met(estimate)
}

fn assert_share(found: f64, expected: f64, case: &str) {
    assert!(
        (found - expected).abs() < ROUNDING,
        "{case}: {found}, not {expected}"
    );
}

fn says(scene: &Scene, what: &str) -> bool {
    scene
        .warnings()
        .iter()
        .any(|warning| warning.message.contains(what))
}

/// The box from `low` to `high`, the floor's side last.
fn block(low: DVec3, high: DVec3) -> MeshParts {
    let corner = |i: u32| {
        let pick = |bit: u32, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
        DVec3::new(
            pick(0, low.x, high.x),
            pick(1, low.y, high.y),
            pick(2, low.z, high.z),
        )
    };
    let sides = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [4, 5, 7, 6],
        [0, 2, 3, 1],
    ];
    MeshParts {
        positions: (0..8).map(corner).collect(),
        triangles: sides
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
        ..MeshParts::default()
    }
}

fn cube() -> MeshParts {
    block(DVec3::new(-0.5, -0.5, 1.0), DVec3::new(0.5, 0.5, 2.0))
}

fn together(one: &MeshParts, other: &MeshParts) -> MeshParts {
    let first = one.positions.len() as u32;
    let mut both = one.clone();
    both.positions.extend(&other.positions);
    both.triangles.extend(
        other
            .triangles
            .iter()
            .map(|face| face.map(|vertex| vertex + first)),
    );
    both
}

fn inside_out(mut parts: MeshParts) -> MeshParts {
    parts.triangles.iter_mut().for_each(|face| face.swap(1, 2));
    parts
}

#[test]
fn slivers_reflect_their_share_as_exactly_as_their_normals_are_known() {
    /// How far a sliver's normal is off, in u · length / width: a vertex that is turned is rounded by 4u of its length on each of
    /// three axes, and two of them tilt a face by twice that over its width (14); the products of long
    /// edges in the normal itself are rounded to 3u of their length, over the width again (6).
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
        assert_eq!(estimate.total.irradiance, plain.total.irradiance, "{case}");
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
        let diagnosis = Mesh::new(apart.clone()).unwrap().diagnose();
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
            // Half of them at places on edges and vertices, where faces tie; half anywhere, some of them past the ball.
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
    assert_eq!(apart.total.irradiance, shared.total.irradiance);
}

#[test]
fn a_closed_block_an_open_one_and_two_in_one_another_share_light_by_their_faces() {
    let passes = 1.0 - dielectric_reflectance(1.0, IOR);
    let down = -DVec3::Z;
    let run = |parts: &MeshParts| {
        let scene = load("block.obj", &obj(parts), FLAT, down).unwrap();
        (photons(&scene), scene)
    };
    let (closed, scene) = run(&cube());
    assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
    assert_share(received(&closed, "LTTD"), passes * passes, "closed");
    assert_share(
        received(&closed, "LTRRTD"),
        (passes * (1.0 - passes)).powi(2),
        "closed, twice reflected",
    );
    // Without its lower side: light goes in and never out.
    let mut open = cube();
    open.triangles.truncate(10);
    let (open, scene) = run(&open);
    assert!(says(&scene, "4 open edges"), "{:?}", scene.warnings());
    assert_share(received(&open, "LTD"), passes, "open");
    assert_share(share(&open, "LTTD"), 0.0, "open");
    // Each face bends light as if the other block were not there.
    let other = block(DVec3::new(-0.5, -0.5, 1.5), DVec3::new(0.5, 0.5, 2.5));
    let (both, scene) = run(&together(&cube(), &other));
    assert!(!says(&scene, "open"), "{:?}", scene.warnings());
    assert_share(
        received(&both, "LTTTTD"),
        passes.powi(4),
        "two in one another",
    );
    assert_share(received(&both, "LTTD"), 0.0, "two in one another");
}

/// A prism along y whose outline is a bow-tie under a roof: a closed mesh with two sides that cross one another along the line
/// x = 0, z = 1.25. Below it all faces have their outside within.
fn bow_tie() -> MeshParts {
    const OUTLINE: [[f64; 2]; 6] = [
        [-1.0, 1.75],
        [1.0, 1.75],
        [1.0, 1.5],
        [-1.0, 1.0],
        [1.0, 1.0],
        [-1.0, 1.5],
    ];
    let count = OUTLINE.len() as u32;
    let ends = [-1.0, 1.0].into_iter();
    let positions = ends.flat_map(|y| OUTLINE.map(|[x, z]| DVec3::new(x, y, z)));
    let sides = (0..count).flat_map(|i| {
        let j = (i + 1) % count;
        [[i, j, count + j], [i, count + j, count + i]]
    });
    let ends = (1..count - 1).flat_map(|k| [[0, k + 1, k], [count, count + k, count + k + 1]]);
    MeshParts {
        positions: positions.collect(),
        triangles: sides.chain(ends).collect(),
        ..MeshParts::default()
    }
}

#[test]
fn a_closed_mesh_that_crosses_itself_bends_light_by_the_side_of_each_face_that_it_meets() {
    // Light from straight above meets the roof, one of the two sides that cross (from within), the other one below it, and the
    // bottom: all of it, for it is bent towards the middle. It stays in planes of constant y; angles are from the vertical there, on the
    // half of positive x towards the middle.
    let slope = 0.25_f64;
    let tilt = slope.atan();
    // The roof, level: from its outside.
    let mut passes = 1.0 - dielectric_reflectance(1.0, IOR);
    // The upper side, from its inside.
    passes *= 1.0 - dielectric_reflectance(tilt.cos(), 1.0 / IOR);
    let between = (IOR * tilt.sin()).asin() - tilt;
    // The lower side is inside out: light comes from its inside, above it, and leaves the glass for what is below.
    let to_lower = tilt - between;
    let before_lower = passes;
    passes *= 1.0 - dielectric_reflectance(to_lower.cos(), 1.0 / IOR);
    let below = tilt - (IOR * to_lower.sin()).asin();
    // The bottom, level, has its outside above it.
    passes *= 1.0 - dielectric_reflectance(below.cos(), IOR);
    let last = (below.sin() / IOR).asin();
    // If the faces below were those of a block like any other:
    let bent = (to_lower.sin() / IOR).asin();
    let otherwise = before_lower
        * (1.0 - dielectric_reflectance(to_lower.cos(), IOR))
        * (1.0 - dielectric_reflectance((tilt - bent).cos(), 1.0 / IOR));
    // Where x from 0 to 1 on the roof comes down to, linear in x: from the upper side, at 1.25 + slope x, to the lower one, at 1.25 - slope x,
    // to the bottom at 1, to the floor.
    let on_floor = |x: f64| {
        let down = 2.0 * slope * x / (1.0 + slope * between.tan());
        let lower = x - down * between.tan();
        let bottom = lower - slope * (1.0 - lower) * below.tan();
        bottom - last.tan()
    };
    let (inner, outer) = (on_floor(0.0), on_floor(1.0));

    let scene = load("tie.obj", &obj(&bow_tie()), FLAT, -DVec3::Z).unwrap();
    // Closed, and more of it is outward than inward.
    assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
    let by_photons = received(&photons(&scene), "LTTTTD");
    println!(
        "share {by_photons}, off by {:.1e}; other sides would make {:.1e} of it",
        by_photons - passes,
        otherwise - passes
    );
    assert!((otherwise - passes).abs() > 1e3 * ROUNDING);
    assert_share(by_photons, passes, "a bow-tie");

    // By beams: two images of the halves, each of constant irradiance, that overlap in the middle.
    let settings = BeamSettings {
        max_layers: 64,
        ..BeamSettings::default()
    };
    let sensor = &scene.sensors()[0];
    let (estimate, _) = beams::run(
        &scene,
        sensor,
        settings,
        &BeamBudget::default(),
        &Progress::default(),
    )
    .unwrap();
    let signature = "LTTTTD".parse().unwrap();
    let layers = estimate.layers.iter();
    let mut layers = layers.filter(|layer| layer.name == LayerName::Path(signature));
    let layer = layers.next().expect("beams find that light");
    let bounds = layer.interval.as_ref().unwrap();
    let overlap = |low: f64, high: f64, texel: usize| {
        let from = -2.0 + 0.25 * texel as f64;
        (high.min(from + 0.25) - low.max(from)).max(0.0) / 0.25
    };
    let (mut lit, mut worst) = (0, 0.0_f64);
    for texel in 0..256 {
        let (column, row) = (texel % 16, texel / 16);
        let across = overlap(inner, outer, column) + overlap(-outer, -inner, column);
        let truth = passes / (outer - inner) * across * overlap(-1.0, 1.0, row);
        let [low, value, high] = [
            bounds.low[texel],
            layer.irradiance[texel],
            bounds.high[texel],
        ]
        .map(|rgb| rgb.0[0]);
        assert!(
            low <= truth + ROUNDING && truth - ROUNDING <= high,
            "texel {column}, {row}: {truth} is not within {low} to {high}"
        );
        lit += usize::from(truth > 0.0);
        worst = worst.max((value - truth).abs());
    }
    println!("{lit} texels with light within bounds; beams are off by {worst:.1e} of E0 at worst");
    assert!(lit >= 64);
}

#[test]
fn a_block_inside_out_is_found_out_and_flip_normals_mends_it() {
    // 54.7° to three sides: beyond the critical angle of 41.8° for light that takes the outside for glass.
    let sun = DVec3::new(1.0, 1.0, -1.0);
    let inward = obj(&inside_out(cube()));
    let scene = load("block.obj", &inward, FLAT, sun).unwrap();
    assert!(says(&scene, "inside out"), "{:?}", scene.warnings());
    assert_share(share(&photons(&scene), "LRD"), 1.0, "inside out");
    let mended = format!(r#"{FLAT}<boolean name="flip_normals" value="true"/>"#);
    let scene = load("block.obj", &inward, &mended, sun).unwrap();
    assert!(scene.warnings().is_empty(), "{:?}", scene.warnings());
    let reflected = dielectric_reflectance(1.0 / 3_f64.sqrt(), IOR);
    assert_share(share(&photons(&scene), "LRD"), reflected, "mended");
    let scene = load("block.obj", &obj(&cube()), FLAT, sun).unwrap();
    assert_share(share(&photons(&scene), "LRD"), reflected, "outward");
}

#[test]
fn normals_of_no_length_are_those_of_the_faces_and_opposed_ones_absorb() {
    let with_normals = |normal: DVec3| {
        let mut mesh = cube();
        mesh.normals = Some(vec![normal; mesh.positions.len()]);
        let scene = load("block.ply", &ply(&mesh, "ascii"), "", -DVec3::Z).unwrap();
        (photons(&scene), scene)
    };
    let passes = 1.0 - dielectric_reflectance(1.0, IOR);
    let (flat, _) = with_normals(DVec3::ZERO);
    assert_share(received(&flat, "LTTD"), passes * passes, "no length");
    // Light from above meets the upper side, whose normals say that it comes from below.
    let (opposed, scene) = with_normals(-DVec3::Z);
    assert!(
        says(
            &scene,
            "2 faces whose vertex normals point to the other side"
        ),
        "{:?}",
        scene.warnings()
    );
    assert_share(
        row(&opposed, "LD").absorbed.mean() / met(&opposed),
        1.0,
        "opposed",
    );
}

/// The file formats of meshes: the name of a file, how it is written, and whether errors name the vertex or the line.
type Format = (&'static str, fn(&MeshParts) -> Vec<u8>, bool);
const FORMATS: [Format; 5] = [
    ("it.obj", |mesh| obj(mesh), false),
    ("it.ply", |mesh| ply(mesh, "ascii"), true),
    ("it.ply", |mesh| ply(mesh, "binary_little_endian"), true),
    ("it.ply", |mesh| ply(mesh, "binary_big_endian"), true),
    (
        "it.serialized",
        |mesh| serialized(&serialized_contents(mesh), Compression::fast()),
        true,
    ),
];

#[test]
fn numbers_that_are_not_finite_are_refused_by_the_number_of_their_vertex() {
    let mut sound = icosphere(0);
    let count = sound.positions.len();
    sound.normals = Some(sound.positions.clone());
    sound.uvs = Some(sound.positions.iter().map(|p| p.truncate()).collect());
    let mut refused = 0;
    for (name, written, names_vertex) in FORMATS {
        // What is refused below is refused for its one number alone.
        load(name, &written(&sound), "", -DVec3::Z).unwrap();
        for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
            for vertex in [0, 7, count - 1] {
                // x, y, z of the position, then of the normal, then u and v.
                for slot in 0..8 {
                    let mut mesh = sound.clone();
                    let normals = mesh.normals.as_mut().unwrap();
                    let uvs = mesh.uvs.as_mut().unwrap();
                    let line = match slot {
                        0..3 => {
                            mesh.positions[vertex][slot] = value;
                            vertex
                        }
                        3..6 => {
                            normals[vertex][slot - 3] = value;
                            count + vertex
                        }
                        _ => {
                            uvs[vertex][slot - 6] = value;
                            2 * count + vertex
                        }
                    } + 1;
                    let error = load(name, &written(&mesh), "", -DVec3::Z).unwrap_err();
                    let place = if names_vertex {
                        format!("vertex {vertex} ")
                    } else {
                        format!("line {line}: ")
                    };
                    assert!(
                        error.contains(&place) && error.contains("finite"),
                        "{name}, number {slot} of vertex {vertex} is {value}: {error}"
                    );
                    refused += 1;
                }
            }
        }
    }
    println!("{refused} files refused by the place of their number");
    // Finite in the file, and beyond what can be multiplied where it is placed.
    let mut mesh = icosphere(0);
    mesh.positions[7].y = 1e60;
    let far = r#"<transform name="to_world"><scale value="1e20"/></transform>"#;
    let error = load("it.obj", &obj(&mesh), far, -DVec3::Z).unwrap_err();
    assert!(error.contains("vertex") && error.contains("e80"), "{error}");
}

#[test]
fn a_mesh_of_one_triangle_is_an_interface() {
    let triangle = MeshParts {
        positions: vec![
            DVec3::new(-1.0, -1.0, 1.0),
            DVec3::new(1.0, -1.0, 1.0),
            DVec3::new(0.0, 1.0, 1.0),
        ],
        triangles: vec![[0, 1, 2]],
        ..MeshParts::default()
    };
    let scene = load("one.obj", &obj(&triangle), "", -DVec3::Z).unwrap();
    assert!(says(&scene, "3 open edges"), "{:?}", scene.warnings());
    let estimate = photons(&scene);
    let reflected = dielectric_reflectance(1.0, IOR);
    assert_share(unseen(&estimate), reflected, "reflected");
    assert_share(received(&estimate, "LTD"), 1.0 - reflected, "transmitted");
}

#[test]
fn a_generated_mesh_of_more_faces_than_the_dragon_is_built_closes_and_keeps_its_rays() {
    let parts = bumpy_torus(934, 467);
    assert!(parts.triangles.len() > 871_414);
    // What closes has area vectors whose sum is 0, for the very positions that it has: the edges' parts cancel.
    let mut sums = [(); 3].map(|()| ExactSum::new());
    let mut sizes = ExactSum::new();
    for face in &parts.triangles {
        let [a, b, c] = face.map(|vertex| parts.positions[vertex as usize]);
        let (ab, ac) = (b - a, c - a);
        let area = 0.5 * ab.cross(ac);
        sizes.add(ab.length() * ac.length());
        for (sum, part) in sums.iter_mut().zip(area.to_array()) {
            sum.add(part);
        }
    }
    // A part is half the difference of two products of differences. Each product is rounded three times (4u with room for what is of
    // second order), the difference once: 5u of the products' magnitudes, which by Cauchy and Schwarz are at most the
    // edges' lengths multiplied. The sum itself is exact.
    let allowed = 0.5 * 5.0 * 0.5 * f64::EPSILON * sizes.value();
    let off = sums.map(|sum| sum.value().abs()).into_iter();
    let off = off.fold(0.0, f64::max);
    let start = Instant::now();
    let world = world_of(parts.clone());
    let seconds = start.elapsed().as_secs_f64();
    let found = leaks(&parts, &world, (1.0, DVec3::ZERO), 50_000, within_torus);
    println!(
        "{} faces: built in {seconds:.1} s, area vectors sum to {off:.1e}, allowed {allowed:.1e}; {found:?}",
        parts.triangles.len()
    );
    // A face that is missing or turned round is a million million times as large.
    assert!(off <= allowed && allowed < 1e-12, "{off:e}, {allowed:e}");
    assert_eq!((found.rays, found.out, found.into), (50_000, 0, 0));
    assert!(
        found.seen > 10_000,
        "{} points are met from without",
        found.seen
    );
}

#[test]
fn a_mesh_of_871_thousand_triangles_closes_its_ledger() {
    let file =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/meshes/raw/dragon_vrip_871k.ply.gz");
    let Ok(compressed) = std::fs::read(&file) else {
        println!("skipped: there is no {}", file.display());
        return;
    };
    let mut bytes = Vec::new();
    GzDecoder::new(&*compressed)
        .read_to_end(&mut bytes)
        .unwrap();
    let placing =
        r#"<transform name="to_world"><rotate x="1" angle="90"/><scale value="8"/></transform>"#;
    let start = Instant::now();
    let scene = load("dragon.ply", &bytes, placing, DVec3::new(0.1, 0.2, -1.0)).unwrap();
    println!(
        "loaded in {:.1} s, {} MB",
        start.elapsed().as_secs_f64(),
        scene.world().memory_bytes() >> 20
    );
    for warning in scene.warnings() {
        println!("{}", warning.message);
    }
    let estimate = photons(&scene);
    assert!(row(&estimate, "LTTD").total().mean() > 0.0);
    println!("closes to {:.1e}", estimate.ledger.closure_error().unwrap());
}
