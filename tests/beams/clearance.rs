//! Where the clearance says that a cell of light is of one kind, all light in it is.
//!
//! Cells of many sizes are looked at, most of them at the borders of things: each patch is
//! divided at random until the clearance is content. Then paths all over the cell must meet what its
//! nodes met. The same cells judged by their nodes alone fail that, so the test can fail.

use std::fmt::Write as _;
use std::path::Path;

use glam::DVec2;
use nephroid::internals::generate::{bumpy_ball, write_ply};
use nephroid::internals::geometry::{Hit, Ray, Shape, TraversalCounters};
use nephroid::internals::mitsuba;
use nephroid::internals::numeric::{Stream, StreamKind};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::camera::Camera;
use nephroid::internals::transport::clearance::{CellClearance, Clearance, Trail};
use nephroid::internals::transport::first_surface::{Source, SurfaceChart, SurfacePatch, patches};
use nephroid::internals::transport::fixed_signature::PathFollower;
use nephroid::internals::transport::path_end::End;
use nephroid::internals::transport::receiver::Receiver;
use nephroid::internals::transport::scatter::ShadingNormals;
use nephroid::internals::transport::screen::Screen;

use crate::support::bundled;

/// Random numbers in [0, 1), the same each time.
struct Random {
    stream: Stream,
    index: u64,
}

impl Random {
    fn new(seed: u64) -> Self {
        Self {
            stream: Stream::new(StreamKind::Random, seed),
            index: 0,
        }
    }

    fn pair(&mut self) -> [f64; 2] {
        self.index += 1;
        self.stream.point2(self.index)
    }

    fn next(&mut self) -> f64 {
        self.pair()[0]
    }

    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.next()
    }

    /// A point of a triangle.
    fn inside(&mut self, [a, b, c]: [DVec2; 3]) -> DVec2 {
        let [mut x, mut y] = self.pair();
        if x + y > 1.0 {
            (x, y) = (1.0 - x, 1.0 - y);
        }
        a + (b - a) * x + (c - a) * y
    }
}

fn middles([a, b, c]: [DVec2; 3]) -> [DVec2; 3] {
    [0.5 * (b + c), 0.5 * (c + a), 0.5 * (a + b)]
}

fn nodes(corners: [DVec2; 3]) -> [DVec2; 6] {
    let [a, b, c] = corners;
    let [bc, ca, ab] = middles(corners);
    [a, b, c, bc, ca, ab]
}

fn quarter(corners: [DVec2; 3], number: usize) -> [DVec2; 3] {
    let [a, b, c] = corners;
    let [bc, ca, ab] = middles(corners);
    [[a, ab, ca], [ab, b, bc], [ca, bc, c], [bc, ca, ab]][number]
}

/// What a path met: shapes, and of flat meshes the faces.
#[derive(Clone, Debug, PartialEq)]
struct Way {
    met: Vec<Option<(u32, u32)>>,
    end: &'static str,
    topology: u64,
}

/// Whether anything is in front of a place on the first surface, by more than rounding: a place that is off
/// by δ is met δ / cos i too soon, and where a surface of radius r is grazed, by the half chord √(2 r δ) on
/// either side at most, or as much longer as a ray runs along a tube rather than across it. A surface point
/// and a ray's start are each off by up to 32 u of their coordinates (`position_error`), u = ε/2.
fn is_hidden(scene: &Scene, ray: &Ray, hit: &Hit) -> bool {
    let normal = scene.world().surface_point(ray, hit).geometric_normal;
    let off = 32.0 * f64::EPSILON * (ray.origin.length() + hit.distance);
    let across = match &scene.world().shapes()[hit.shape as usize] {
        Shape::Cylinder(tube) => ray.direction.cross(tube.axis()).length(),
        _ => 1.0,
    };
    let chord = (8.0 * scene.world().bounds().radius() * off).sqrt() / across;
    let near = hit.distance - (off / normal.dot(ray.direction).abs()).min(chord);
    let mut counters = TraversalCounters::default();
    scene.world().any_hit(ray, near, |_| true, &mut counters)
}

fn way(scene: &Scene, follower: &mut PathFollower<1>, chart: &SurfaceChart, at: DVec2) -> Way {
    let mut met = Vec::new();
    let mut hidden = false;
    let path = follower.follow_legs(chart, at, true, |ray: &Ray, hit: Option<&Hit>| {
        if met.is_empty() {
            hidden = hit.is_none_or(|hit| is_hidden(scene, ray, hit));
        }
        met.push(hit.map(|hit| {
            let flat = match &scene.world().shapes()[hit.shape as usize] {
                Shape::Mesh(mesh) => !mesh.has_vertex_normals(),
                _ => false,
            };
            (hit.shape, if flat { hit.face } else { 0 })
        }));
    });
    if hidden {
        met.truncate(1);
    }
    let end = match path.end {
        _ if hidden => "hidden",
        End::Landed(at) => {
            // On the receiver or beyond its border: that is the same, whatever is behind.
            met.pop();
            match follower.screen() {
                Screen::Camera { .. } if !follower.screen().is_on_film(at) => "beside",
                _ => "landed",
            }
        }
        End::Hidden => "hidden",
        // After the last event, what light meets instead of the receiver makes no difference.
        _ if met.len() > follower.events() => {
            met.pop();
            "lost"
        }
        End::Escaped => "escaped",
        End::Stopped | End::TurnedBack => "stopped",
    };
    Way {
        met,
        end,
        topology: if hidden { 0 } else { path.topology },
    }
}

/// How light that is seen beside a camera's film may end a little further on.
const BESIDE: [&str; 3] = ["beside", "landed", "lost"];

impl Way {
    /// Total reflection stops light at a surface; where it sets in is not the clearance's business. All
    /// paths that go on must meet the same.
    fn agrees(&self, other: &Self) -> bool {
        // Beside a camera's film light gets lost somewhere: that is no border of anything to be seen.
        if [self.end, other.end].contains(&"beside") {
            let ends = [self.end, other.end];
            return self.met == other.met && ends.iter().all(|end| BESIDE.contains(end));
        }
        let common = self.met.len().min(other.met.len());
        let stops_early = |short: &Self, long: &Self| {
            short.end == "stopped" && short.met.len() <= long.met.len() && long.end != "hidden"
        };
        self.met[..common] == other.met[..common]
            && (self.met.len() == other.met.len() && self.end == other.end
                || stops_early(self, other)
                || stops_early(other, self))
    }
}

#[derive(Debug, Default)]
struct Found {
    cells: u32,
    clear: u32,
    /// Cells of one topology by their nodes.
    by_nodes: u32,
    /// ... whose inner paths say otherwise.
    by_nodes_wrong: u32,
    paths: u64,
}

/// Divides random patches at random until the clearance is content, and tries paths in what it allows.
fn try_cells(name: &str, scene: &Scene, signatures: &[&str], descents: u32) -> Found {
    let clearance = Clearance::new(scene);
    let receiver = scene
        .sensors()
        .iter()
        .find_map(|sensor| Receiver::new(scene, sensor).ok())
        .unwrap();
    let screen = Screen::Receiver(&receiver);
    let mut found = Found::default();
    let mut random = Random::new(1);
    for source in Source::all(scene) {
        let patches = patches(scene, &source);
        for signature in signatures {
            let signature = signature.parse().unwrap();
            let mut follower =
                PathFollower::<1>::new(scene, &source, &screen, signature, ShadingNormals::Flux);
            for _ in 0..descents {
                let patch: &SurfacePatch =
                    &patches[(random.next() * patches.len() as f64) as usize];
                let (follower, random) = (&mut follower, &mut random);
                descend(name, &clearance, follower, patch, None, random, &mut found);
            }
        }
    }
    println!("{name}: {found:?}");
    found
}

/// Divides a patch at random, or round a place, until the clearance is content, and tries paths in what it allows.
fn descend<'a>(
    name: &str,
    clearance: &Clearance<'a>,
    follower: &mut PathFollower<'a, 1>,
    patch: &SurfacePatch,
    goal: Option<DVec2>,
    random: &mut Random,
    found: &mut Found,
) {
    const LEVELS: u32 = 9;
    const PATHS: u32 = 48;
    let scene = follower.scene();
    let mut corners = patch.corners;
    let mut known = CellClearance::default();
    for _ in 0..LEVELS {
        let places = nodes(corners);
        let sees = known.is_in_sight();
        let trails = places.map(|at| Trail::follow(follower, &patch.chart, at, sees));
        known = clearance.clear(follower, &patch.chart, &trails, known);
        let ways = places.map(|at| way(scene, follower, &patch.chart, at));
        let one = ways.iter().all(|way| way.topology == ways[0].topology);
        found.cells += 1;
        found.by_nodes += u32::from(one);
        found.clear += u32::from(known.all);
        assert!(one || !known.all, "{name}: nodes differ");
        if one {
            let mut wrong = false;
            let tried = (0..PATHS).map(|_| random.inside(corners));
            for at in goal.into_iter().chain(tried) {
                let inner = way(scene, follower, &patch.chart, at);
                found.paths += 1;
                let right = inner.agrees(&ways[0]);
                wrong |= !right;
                assert!(
                    right || !known.all,
                    "{name}: at {at} of {:?} {corners:?}\n{inner:?}\n{:?}",
                    patch.chart,
                    ways[0]
                );
            }
            found.by_nodes_wrong += u32::from(wrong);
        }
        if known.all {
            break;
        }
        let next = (random.next() * 4.0) as usize;
        let towards = goal.and_then(|at| (0..4).find(|&n| holds(quarter(corners, n), at)));
        corners = quarter(corners, towards.unwrap_or(next));
    }
}

fn holds([a, b, c]: [DVec2; 3], at: DVec2) -> bool {
    let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| (to - from).perp_dot(at - from));
    sides.iter().all(|side| *side >= 0.0) || sides.iter().all(|side| *side <= 0.0)
}

const FLOOR: &str = r#"<shape type="rectangle"><bsdf type="diffuse"/>
    <sensor type="irradiancemeter"><film type="hdrfilm">
    <integer name="width" value="64"/><integer name="height" value="64"/></film></sensor></shape>"#;

const LAMP: &str = r#"<emitter type="point"><point name="position" x="0.2" y="-0.1" z="1.5"/>
    <rgb name="intensity" value="1"/></emitter>"#;

fn scene(folder: &Path, content: &str) -> Scene {
    let path = folder.join("scene.xml");
    std::fs::write(
        &path,
        format!(r#"<scene version="3.0.0">{content}</scene>"#),
    )
    .unwrap();
    mitsuba::load(&path, &[]).unwrap()
}

/// Small glass balls over a floor of 2 m x 2 m.
fn balls(count: u32, seed: u64) -> String {
    let mut random = Random::new(seed);
    (0..count).fold(String::new(), |mut text, _| {
        let (x, y, z) = (
            random.between(-0.5, 0.5),
            random.between(-0.5, 0.5),
            random.between(0.06, 0.5),
        );
        let radius = random.between(0.02, 0.05);
        let _ = write!(
            text,
            r#"<shape type="sphere"><point name="center" x="{x}" y="{y}" z="{z}"/>
            <float name="radius" value="{radius}"/><bsdf type="dielectric"/></shape>"#
        );
        text
    })
}

/// A black strip, 1 mm wide.
fn strip(x: f64, z: f64) -> String {
    format!(
        r#"<shape type="rectangle"><bsdf type="diffuse"/><transform name="to_world">
        <scale x="0.0005" y="0.6"/><rotate z="1" angle="17"/><rotate y="1" angle="12"/>
        <translate x="{x}" z="{z}"/></transform></shape>"#
    )
}

const TREE: [&str; 5] = ["LTTD", "LRD", "LTRTD", "LRTTD", "LTTRD"];

#[test]
fn among_many_small_balls_clear_cells_are_of_one_topology() {
    let folder = tempfile::tempdir().unwrap();
    for seed in 0..4 {
        let content = format!("{LAMP}{FLOOR}{}", balls(24, seed));
        let scene = scene(folder.path(), &content);
        let found = try_cells("24 balls", &scene, &TREE, 1500);
        assert!(found.clear > 3000 && found.by_nodes_wrong > 20, "{found:?}");
    }
}

#[test]
fn a_thin_strip_on_any_leg_is_not_overlooked() {
    let folder = tempfile::tempdir().unwrap();
    let ball = r#"<shape type="sphere"><point name="center" x="0" y="0" z="0.5"/>
        <float name="radius" value="0.3"/><bsdf type="dielectric"/></shape>"#;
    // Between lamp and ball, inside the ball, and between ball and floor.
    for height in [1.1, 0.5, 0.1] {
        for x in [0.013, 0.11] {
            let content = format!("{LAMP}{FLOOR}{ball}{}", strip(x, height));
            let scene = scene(folder.path(), &content);
            let found = try_cells(&format!("strip at {height}"), &scene, &TREE, 700);
            assert!(found.clear > 500 && found.by_nodes_wrong > 5, "{found:?}");
        }
    }
}

#[test]
fn on_every_bundled_scene_clear_cells_are_of_one_topology() {
    for name in [
        "glass-ball",
        "glass-ball-mesh",
        "coffee-cup",
        "mirror-ring",
        "lens",
        "water",
        "pool",
        "prism",
        "diamond",
        "cornell-caustics",
        "parabolic-mirror",
        "turntable-ball",
        "turntable-prism",
        "turntable-ring",
        "turntable-bumpy",
        "turntable-terrain",
    ] {
        let scene = bundled(name, 64);
        let all = ["LRD", "LTD", "LTTD", "LTRTD", "LRRD", "LRRRD"];
        let found = try_cells(name, &scene, &all, 600);
        assert!(found.clear > 100, "{name}: {found:?}");
    }
}

#[test]
fn a_mesh_that_can_shade_itself_is_not_taken_for_a_ball() {
    let folder = tempfile::tempdir().unwrap();
    // Smooth by its normals; and flat, where each face is a surface of its own.
    for (normals, material) in [
        (true, "dielectric"),
        (true, "conductor"),
        (false, "dielectric"),
    ] {
        let mut mesh = bumpy_ball(0.3, 24);
        mesh.normals = mesh.normals.filter(|_| normals);
        let mut file = Vec::new();
        write_ply(&mesh, "", &mut file).unwrap();
        std::fs::write(folder.path().join("bumpy.ply"), file).unwrap();
        let content = format!(
            r#"{LAMP}{FLOOR}<shape type="ply"><string name="filename" value="bumpy.ply"/>
            <transform name="to_world"><translate z="0.45"/></transform>
            <boolean name="face_normals" value="{}"/><bsdf type="{material}"/></shape>{}{}"#,
            !normals,
            balls(6, 9),
            strip(0.05, 0.1)
        );
        let scene = scene(folder.path(), &content);
        let name = format!("bumpy ball, {material}, normals: {normals}");
        let found = try_cells(&name, &scene, &TREE, 2500);
        assert!(found.clear > 500 && found.by_nodes_wrong > 5, "{found:?}");
    }
}

#[test]
fn a_tube_round_or_in_the_light_is_not_overlooked() {
    let folder = tempfile::tempdir().unwrap();
    // A ball inside a wide black tube, a thin mirror tube across the light above and below it.
    let content = format!(
        r#"{LAMP}{FLOOR}<shape type="sphere"><point name="center" x="0" y="0" z="0.5"/>
        <float name="radius" value="0.2"/><bsdf type="dielectric"/></shape>
        <shape type="cylinder"><point name="p0" x="0" y="0" z="0.3"/>
        <point name="p1" x="0.05" y="0" z="0.75"/><float name="radius" value="0.35"/>
        <bsdf type="diffuse"/></shape>
        <shape type="cylinder"><point name="p0" x="-0.5" y="-0.4" z="1"/>
        <point name="p1" x="0.5" y="0.3" z="1"/><float name="radius" value="0.003"/>
        <bsdf type="conductor"/></shape>
        <shape type="cylinder"><point name="p0" x="-0.5" y="0.4" z="0.1"/>
        <point name="p1" x="0.5" y="-0.3" z="0.12"/><float name="radius" value="0.002"/>
        <bsdf type="conductor"/></shape>"#
    );
    let scene = scene(folder.path(), &content);
    let found = try_cells("tubes", &scene, &TREE, 4000);
    assert!(found.clear > 500 && found.by_nodes_wrong > 5, "{found:?}");
}

/// The share of patch cells that are clear at once, and seconds a patch: of the six paths alone, and
/// with the clearance.
fn roots_clear(name: &str, scene: &Scene, signature: &str) -> f64 {
    let clearance = Clearance::new(scene);
    let receiver = Receiver::new(scene, &scene.sensors()[0]).unwrap();
    let screen = Screen::Receiver(&receiver);
    let source = Source::all(scene)[0];
    let patches = patches(scene, &source);
    let signature = signature.parse().unwrap();
    let mut follower =
        PathFollower::<1>::new(scene, &source, &screen, signature, ShadingNormals::Flux);
    let start = std::time::Instant::now();
    let mut landed = 0;
    for patch in &patches {
        for at in nodes(patch.corners) {
            let path = follower.follow(&patch.chart, at, false);
            landed += u32::from(matches!(path.end, End::Landed(_)));
        }
    }
    let paths = start.elapsed().as_secs_f64();
    let start = std::time::Instant::now();
    let clear = patches
        .iter()
        .filter(|patch| {
            let trails = nodes(patch.corners)
                .map(|at| Trail::follow(&mut follower, &patch.chart, at, false));
            clearance
                .clear(
                    &mut follower,
                    &patch.chart,
                    &trails,
                    CellClearance::default(),
                )
                .all
        })
        .count();
    let both = start.elapsed().as_secs_f64();
    let count = patches.len() as f64;
    println!(
        "{name} {signature}: {clear} of {count} roots clear, {landed} nodes landed; \
         six paths {:.2} us, with the guard {:.2} us",
        1e6 * paths / count,
        1e6 * both / count
    );
    clear as f64 / count
}

#[test]
fn a_ball_alone_over_a_floor_is_clear_at_its_roots() {
    let ball = bundled("glass-ball", 64);
    // Nothing can be in the way, and the receiver's plane has no border.
    assert_eq!(roots_clear("glass-ball", &ball, "LTTD"), 1.0);
    // Light that is reflected near the horizon may land far away or not.
    roots_clear("glass-ball", &ball, "LRD");
    roots_clear("glass-ball", &ball, "LTRTD");
    roots_clear("glass-ball-mesh", &bundled("glass-ball-mesh", 64), "LTTD");
    roots_clear("coffee-cup", &bundled("coffee-cup", 64), "LRD");
    roots_clear("water", &bundled("water", 64), "LTD");
    let folder = tempfile::tempdir().unwrap();
    let content = format!("{LAMP}{FLOOR}{}", balls(24, 0));
    roots_clear("24 balls", &scene(folder.path(), &content), "LTTD");
}

/// Cameras that look at where one path ends, and see so little about it that all nodes of its cell miss that;
/// some with a bead before them, that the nodes may see past, or a small table below the ball, which light
/// passes by.
#[test]
fn what_a_camera_may_see_between_the_nodes_is_not_overlooked() {
    const GOALS: u32 = 60;
    let ball = r#"<shape type="sphere"><point name="center" x="0" y="0" z="0.6"/><float name="radius" value="0.4"/>
        <bsdf type="dielectric"/></shape>"#;
    let table = r#"<shape type="disk"><transform name="to_world"><scale value="0.1"/><translate x="0.1" z="0.1"/></transform>
        <bsdf type="diffuse"/></shape>"#;
    let folder = tempfile::tempdir().unwrap();
    let bare = scene(folder.path(), &format!("{LAMP}{FLOOR}{ball}"));
    let receiver = Receiver::new(&bare, &bare.sensors()[0]).unwrap();
    let floor = Screen::Receiver(&receiver);
    let source = Source::all(&bare)[0];
    let all = patches(&bare, &source);
    let mut random = Random::new(2);
    for (name, fov, bead, more) in [
        ("narrow", 1.0, None, ""),
        ("narrower", 0.01, None, ""),
        ("above a table", 0.1, None, table),
        ("bead", 4.0, Some(0.02), ""),
        ("small bead", 4.0, Some(0.002), ""),
    ] {
        let mut found = Found::default();
        for signature in ["LTTD", "LRD", "LTRRTD"] {
            let events = signature.parse().unwrap();
            let mut to_floor =
                PathFollower::<1>::new(&bare, &source, &floor, events, ShadingNormals::Flux);
            let mut left = GOALS;
            while left > 0 {
                let patch = &all[(random.next() * all.len() as f64) as usize];
                let at = random.inside(patch.corners);
                let path = to_floor.follow(&patch.chart, at, false);
                let End::Landed(film) = path.end else {
                    continue;
                };
                if !floor.is_on_film(film) {
                    continue;
                }
                left -= 1;
                // The floor is the square of half width 1, its film has 64 texels a side.
                let [x, y] = (film / 32.0 - 1.0).to_array();
                let bead = bead.map_or_else(String::new, |radius: f64| {
                    let (x, y, z) = (0.5 * (x + 2.5), 0.5 * y, 0.75);
                    format!(
                        r#"<shape type="sphere"><point name="center" x="{x}" y="{y}" z="{z}"/>
        <float name="radius" value="{radius}"/><bsdf type="diffuse"/></shape>"#
                    )
                });
                let scene = scene(
                    folder.path(),
                    &format!(
                        r#"{LAMP}{FLOOR}{ball}{more}{bead}<sensor type="perspective"><float name="fov" value="{fov}"/>
        <transform name="to_world"><lookat origin="2.5,0,1.5" target="{x},{y},0" up="0,0,1"/></transform>
        <film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/><rfilter type="box"/></film>
        </sensor>"#
                    ),
                );
                let mut sensors = scene.sensors().iter();
                let camera = sensors
                    .find_map(|one| Camera::new(&scene, one).ok())
                    .unwrap();
                let screen = Screen::Camera {
                    camera: &camera,
                    etendue: 1.0,
                };
                let clearance = Clearance::new(&scene);
                let mut follower =
                    PathFollower::<1>::new(&scene, &source, &screen, events, ShadingNormals::Flux);
                for goal in [Some(at), None] {
                    let (follower, random) = (&mut follower, &mut random);
                    descend(name, &clearance, follower, patch, goal, random, &mut found);
                }
            }
        }
        println!("{name}: {found:?}");
        assert!(
            found.clear > 50 && found.by_nodes_wrong > 5,
            "{name}: {found:?}"
        );
    }
}
