//! Meshes at their worst, from the single ray to the whole run: what holds, and what is said where it cannot.
//!
//! `tests/geometry_*.rs` test the parts (hits, spawned rays, diagnostics); here a mesh file goes in and a map with its
//! ledger comes out.

mod geometry_support;
mod mutation_support;

use std::io::Read;
use std::path::Path;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

use flate2::Compression;
use flate2::read::GzDecoder;
use geometry_support::{Random, closest, icosphere, placed, world_of};
use glam::{DQuat, DVec3};
use mutation_support::{obj, ply, serialized, serialized_contents};
use nephroid::geometry::{MeshParts, Ray, World};
use nephroid::mitsuba;
use nephroid::optics::dielectric_reflectance;
use nephroid::reference::photons::run::Setup;
use nephroid::reference::photons::{Budget, PhotonSettings};
use nephroid::reference::{Estimate, Progress};
use nephroid::scene::Scene;
use nephroid::transport::chain::ChainSettings;
use nephroid::transport::ledger::Row;
use nephroid::transport::signature::Signature;
use rayon::prelude::*;
use tempfile::TempDir;

/// The index of the glass.
const IOR: f64 = 1.5;

/// Flux is rounded to 2⁻⁶⁰ of the light's at every step of a photon: 10⁵ of them sum to 1e-13 at worst (see `tests/ledger.rs`).
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

/// A ray from inside a convex solid, symmetric in x about the plane `x = middle`, to a place where a test that is not watertight leaks: a vertex, the
/// middle of an edge or any place on it; or parallel to x through a vertex, so that two coordinates agree to the bit and every edge function
/// of the vertex is exactly 0.
fn delicate_ray(parts: &MeshParts, (scale, middle): (f64, DVec3), random: &mut Random) -> Ray {
    loop {
        let triangle = parts.triangles[random.below(parts.triangles.len())];
        let first = random.below(3);
        let [a, b] = [first, (first + 1) % 3].map(|i| parts.positions[triangle[i] as usize]);
        let mut start = middle + random.in_cube() * (0.3 * scale);
        let target = match random.below(4) {
            0 => a,
            1 => a + (b - a) * 0.5,
            2 => a + (b - a) * random.unit(),
            _ => {
                start = DVec3::new(
                    middle.x + 0.9 * random.signed() * (a.x - middle.x),
                    a.y,
                    a.z,
                );
                a
            }
        };
        if let Some(direction) = (target - start).try_normalize() {
            return Ray::new(start, direction);
        }
    }
}

/// How many of the rays out of a solid meet nothing.
fn leaks(parts: &MeshParts, world: &World, place: (f64, DVec3), rays: u64) -> u64 {
    /// Rays of one thread at a time.
    const BATCH: u64 = 1 << 14;
    let lost = AtomicU64::new(0);
    (0..rays.div_ceil(BATCH)).into_par_iter().for_each(|batch| {
        let mut random = Random(batch);
        for _ in 0..BATCH.min(rays - batch * BATCH) {
            let ray = delicate_ray(parts, place, &mut random);
            if closest(world, &ray).is_none() {
                lost.fetch_add(1, Ordering::Relaxed);
            }
        }
    });
    lost.into_inner()
}

/// Aims `rays` at the vertices and edges of closed solids, slivers among them, over twelve decades of size; none may get out.
fn assert_that_nothing_leaks(rays: u64) {
    let places = [
        (1.0, DVec3::ZERO),
        (1e-6, DVec3::ZERO),
        (1e6, DVec3::ZERO),
        (1.0, DVec3::new(1048576.0, -524288.0, 3.0)),
    ];
    let solids = [icosphere(2), icosphere(4), sliver_ball(8, 16)];
    let share = rays / (places.len() * solids.len()) as u64;
    for solid in &solids {
        for place in places {
            let parts = placed(solid.clone(), place.0, place.1);
            let world = world_of(parts.clone());
            assert_eq!(
                leaks(&parts, &world, place, share),
                0,
                "{} faces, {place:?}",
                parts.triangles.len()
            );
        }
    }
}

#[test]
fn no_ray_of_a_million_aimed_at_vertices_and_edges_leaves_a_closed_mesh() {
    assert_that_nothing_leaks(1_200_000);
}

/// Takes twenty CPU-minutes: `cargo test --release --test extremes_geometry a_billion -- --ignored`.
#[test]
#[ignore = "a billion rays"]
fn no_ray_of_a_billion_aimed_at_vertices_and_edges_leaves_a_closed_mesh() {
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

fn row(estimate: &Estimate, signature: &str) -> Row {
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
        let mesh = cube();
        let mut text = "ply\nformat ascii 1.0\nelement vertex 8\n".to_owned();
        for name in ["x", "y", "z", "nx", "ny", "nz"] {
            text += &format!("property double {name}\n");
        }
        text += "element face 12\nproperty list uchar int vertex_indices\nend_header\n";
        for position in &mesh.positions {
            let numbers = [position.to_array(), normal.to_array()].concat();
            text += &numbers
                .iter()
                .map(|number| format!("{number} "))
                .collect::<String>();
            text += "\n";
        }
        for [a, b, c] in &mesh.triangles {
            text += &format!("3 {a} {b} {c}\n");
        }
        let scene = load("block.ply", text.as_bytes(), "", -DVec3::Z).unwrap();
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

#[test]
fn coordinates_that_are_not_finite_are_refused_by_the_number_of_their_vertex() {
    for value in [f64::NAN, f64::INFINITY, f64::NEG_INFINITY] {
        let mut mesh = icosphere(0);
        mesh.positions[7].y = value;
        for (name, bytes, place) in [
            // Vertices are the first lines of the file.
            ("it.obj", obj(&mesh), "line 8"),
            ("it.ply", ply(&mesh, "ascii"), "vertex 7"),
            ("it.ply", ply(&mesh, "binary_little_endian"), "vertex 7"),
            (
                "it.serialized",
                serialized(&serialized_contents(&mesh), Compression::fast()),
                "vertex 7",
            ),
        ] {
            let error = load(name, &bytes, "", -DVec3::Z).unwrap_err();
            assert!(
                error.contains(place) && error.contains("finite"),
                "{name}, {value}: {error}"
            );
        }
    }
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
