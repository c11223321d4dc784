//! Direct light of lamps without size, texel by texel, against the areas of shadows.

use std::f64::consts::TAU;

use glam::{DVec2, DVec3};
use nephroid::internals::generate::{bumpy_ball, write_ply};
use nephroid::internals::geometry::{MeshParts, TraversalCounters};
use nephroid::internals::mitsuba;
use nephroid::internals::scene::{Emitter, Scene};
use nephroid::internals::transport::direct::{AREA_SAMPLES, DirectTexel, direct};
use nephroid::internals::transport::receiver::Receiver;
use nephroid::internals::transport::visibility::transmittance;

/// Texels a side, on a floor from -1 to 1.
const SIDE: usize = 64;

/// 1 W/m² from straight above.
const SUN: &str = r#"<emitter type="directional">
    <vector name="direction" x="0" y="0" z="-1"/><rgb name="irradiance" value="1"/></emitter>"#;

/// A floor under a light, and a shape between the two.
fn scene(light: &str, shape: &str) -> Scene {
    let text = format!(
        r#"<scene version="3.0.0">
            {light}
            {shape}
            <shape type="rectangle">
                <bsdf type="diffuse"/>
                <sensor type="irradiancemeter">
                    <film type="hdrfilm">
                        <integer name="width" value="{SIDE}"/>
                        <integer name="height" value="{SIDE}"/>
                    </film>
                </sensor>
            </shape>
        </scene>"#
    );
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("shadow.xml");
    std::fs::write(&file, text).unwrap();
    mitsuba::load(&file, &[]).unwrap()
}

fn measured(scene: &Scene) -> (Vec<DirectTexel>, TraversalCounters) {
    let receiver = Receiver::new(scene, &scene.sensors()[0]).unwrap();
    let found = direct(scene, &receiver, 0, AREA_SAMPLES, &|| false).unwrap();
    (found.texels, found.counters)
}

/// The part of the square from `low`, of side `size`, that lies within a polygon, counter-clockwise and
/// convex: Sutherland and Hodgman.
fn part_inside(low: DVec2, size: f64, polygon: &[DVec2]) -> f64 {
    let mut piece: Vec<DVec2> = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        .map(|(x, y)| low + DVec2::new(x, y) * size)
        .to_vec();
    for index in 0..polygon.len() {
        let (a, b) = (polygon[index], polygon[(index + 1) % polygon.len()]);
        let side = |point: DVec2| (b - a).perp_dot(point - a);
        let mut kept = Vec::new();
        for at in 0..piece.len() {
            let (p, q) = (piece[at], piece[(at + 1) % piece.len()]);
            let (sp, sq) = (side(p), side(q));
            if sp >= 0.0 {
                kept.push(p);
            }
            if sp * sq < 0.0 {
                kept.push(p + (q - p) * (sp / (sp - sq)));
            }
        }
        piece = kept;
    }
    let area: f64 = (0..piece.len())
        .map(|at| piece[at].perp_dot(piece[(at + 1) % piece.len()]))
        .sum();
    0.5 * area / (size * size)
}

/// A circle as a polygon of n sides, which lie within it by radius · π²/(2n²): 2e-8 m, 6e-7 of a texel.
fn circle(center: DVec2, radius: f64) -> Vec<DVec2> {
    const SIDES: usize = 12_000;
    (0..SIDES)
        .map(|index| {
            let angle = std::f64::consts::TAU * index as f64 / SIDES as f64;
            center + radius * DVec2::from_angle(angle)
        })
        .collect()
}

/// The largest error of a texel beyond its bar, the mean error, and the mean bar, all over texels on the
/// edge.
struct Verdict {
    beyond: f64,
    error: f64,
    bar: f64,
}

fn judged(texels: &[DirectTexel], shadow: &[DVec2]) -> Verdict {
    let size = 2.0 / SIDE as f64;
    let mut verdict = Verdict {
        beyond: 0.0,
        error: 0.0,
        bar: 0.0,
    };
    let mut edges = 0.0;
    for (index, texel) in texels.iter().enumerate() {
        let low = DVec2::new((index % SIDE) as f64, (index / SIDE) as f64) * size - 1.0;
        let covered = part_inside(low, size, shadow);
        let (value, bar) = (texel.irradiance.0[0], texel.error.0[0]);
        let error = (value - (1.0 - covered)).abs();
        verdict.beyond = verdict.beyond.max(error - bar);
        if covered > 0.0 && covered < 1.0 {
            edges += 1.0;
            verdict.error += error;
            verdict.bar += bar;
        }
    }
    verdict.error /= edges;
    verdict.bar /= edges;
    verdict
}

#[test]
fn a_balls_shadow_is_a_disc_in_every_texel() {
    let ball = r#"<shape type="sphere">
        <point name="center" x="0.03" y="-0.05" z="2"/><float name="radius" value="0.61"/>
    </shape>"#;
    let (texels, counters) = measured(&scene(SUN, ball));
    let verdict = judged(&texels, &circle(DVec2::new(0.03, -0.05), 0.61));
    println!(
        "beyond {:.1e}, error {:.1e}, bar {:.1e}, {} rays",
        verdict.beyond, verdict.error, verdict.bar, counters.rays
    );
    // The truth's own error: the polygon's.
    assert!(verdict.beyond <= 1e-6, "{:e}", verdict.beyond);
    // The disc's radius is 20 texels: in a cell of 1/8 of a texel its edge bends by (1/8)²/(8 · 20) = 1e-4 of
    // a texel at most. Chord times that, over the 8 to 12 cells of an edge, is 1e-4 of the texel; a chord's
    // ends are known to 2⁻¹⁴ of a cell.
    assert!(verdict.bar < 2e-4, "{:e}", verdict.bar);
    // A parabola's own error is of fourth order.
    assert!(verdict.error < 1e-5, "{:e}", verdict.error);
}

/// A rectangle at a height of 1 m, turned by an angle: half its sides, and the corners of its shadow.
fn plate(angle: f64, half: DVec2) -> (Scene, Vec<DVec2>) {
    let shape = format!(
        r#"<shape type="rectangle"><transform name="to_world">
            <scale x="{}" y="{}"/><rotate z="1" angle="{angle}"/><translate x="0.011" y="0.027" z="1"/>
        </transform></shape>"#,
        half.x, half.y
    );
    let turn = DVec2::from_angle(angle.to_radians());
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
        .map(|(x, y)| DVec2::new(0.011, 0.027) + turn.rotate(half * DVec2::new(x, y)))
        .to_vec();
    (scene(SUN, &shape), corners)
}

#[test]
fn a_plates_shadow_is_right_in_every_texel_but_for_what_hides_at_its_corners() {
    let mut corners = 0.0_f64;
    for degrees in [0.0, 7.0, 21.5, 33.0, 45.0, 71.0] {
        let (scene, shadow) = plate(degrees, DVec2::new(0.5, 0.31));
        let (texels, _) = measured(&scene);
        let verdict = judged(&texels, &shadow);
        println!(
            "{degrees}°: beyond {:.1e}, error {:.1e}, bar {:.1e}",
            verdict.beyond, verdict.error, verdict.bar
        );
        corners = corners.max(verdict.beyond);
        // Straight edges are known to the precision of bisection, 2⁻¹⁴ of a cell of 1/8; the bar to its sum
        // over the cells, and a few corners.
        assert!(verdict.error < 3e-5, "{degrees}: {:e}", verdict.error);
        assert!(verdict.bar < 3e-4, "{degrees}: {:e}", verdict.bar);
    }
    // A corner can poke out between two points of which it is seen by none. Beside an edge these are 1/16 of
    // a texel apart: a right angle that hides there has an area of (1/16)²/4 at most.
    assert!(corners <= 1.0 / 1024.0, "{corners:e}");
}

#[test]
fn a_lamp_near_the_floor_casts_the_shadow_that_projection_says() {
    // Texels of 1/32 m, 0.5 m and less from the lamp: quartered before they are cut. A plate of half sides
    // (a, b) at half the lamp's height has a shadow of twice its size.
    let lamp = r#"<emitter type="point"><point name="position" x="0" y="0" z="0.5"/>
        <rgb name="intensity" value="1"/></emitter>"#;
    let plate = r#"<shape type="rectangle"><transform name="to_world">
        <scale x="0.2" y="0.13"/><translate z="0.25"/></transform></shape>"#;
    let scene = scene(lamp, plate);
    let (texels, _) = measured(&scene);
    let (half, size) = (DVec2::new(0.4, 0.26), 2.0 / SIDE as f64);
    let lit = |x: f64, y: f64| x.abs() > half.x || y.abs() > half.y;
    // h / r³, by midpoints of 1/64 of a texel: off by a second difference, (size / 64)² / (24 · 0.5²) of it,
    // 1e-8, and along shadow lines, which fall between midpoints, by half a part each way.
    const PARTS: usize = 64;
    let mut worst = 0.0_f64;
    for (index, texel) in texels.iter().enumerate() {
        let low = DVec2::new((index % SIDE) as f64, (index / SIDE) as f64) * size - 1.0;
        let (mut truth, mut on_edge) = (0.0, false);
        let first = lit(low.x, low.y);
        for part in 0..PARTS * PARTS {
            let place = DVec2::new((part % PARTS) as f64, (part / PARTS) as f64);
            let at = low + (place + 0.5) * (size / PARTS as f64);
            on_edge |= lit(at.x, at.y) != first;
            if lit(at.x, at.y) {
                truth += 0.5 / (at.length_squared() + 0.25).powf(1.5);
            }
        }
        truth /= (PARTS * PARTS) as f64;
        let middle = low + 0.5 * size;
        let brightest = 0.5 / (middle.length_squared() + 0.25).powf(1.5);
        // Two lines at most, half a row of midpoints each.
        let known = if on_edge {
            brightest / PARTS as f64
        } else {
            1e-6 * brightest
        };
        let error = (texel.irradiance.0[0] - truth).abs();
        worst = worst.max((error - texel.error.0[0] - known) / brightest);
    }
    println!("beyond {worst:.1e}");
    assert!(worst <= 1.0 / 1024.0, "{worst:e}");
}

/// Below the sun in the zenith a lying tube has a rectangle for its shadow, and a leaning one two ellipses with
/// the lines beside them. An upright one has none.
#[test]
fn a_tubes_shadow_is_that_of_its_ends_and_sides_in_every_texel() {
    let tube = |from: DVec3, to: DVec3| {
        format!(
            r#"<shape type="cylinder"><point name="p0" x="{}" y="{}" z="{}"/>
            <point name="p1" x="{}" y="{}" z="{}"/><float name="radius" value="0.21"/></shape>"#,
            from.x, from.y, from.z, to.x, to.y, to.z
        )
    };
    let first = DVec3::new(-0.31, -0.23, 0.9);
    for (name, way) in [
        ("lying", DVec3::new(0.6, 0.5, 0.0)),
        ("leaning", DVec3::new(0.6, 0.5, 0.7)),
    ] {
        let (texels, counters) = measured(&scene(SUN, &tube(first, first + way)));
        // An end's circle is seen as an ellipse: r across the tube, r cos of the axis' lean along it.
        let unit = way.normalize();
        let along = DVec2::new(way.x, way.y).normalize();
        let half = [along * (0.21 * unit.z), along.perp() * 0.21];
        const SIDES: i32 = 12_000;
        let shadow: Vec<DVec2> = (0..=SIDES)
            .flat_map(|index| {
                // From one end's half of its ellipse on to the other's.
                let turn = std::f64::consts::PI * f64::from(index) / f64::from(SIDES);
                let out = half[0] * turn.sin() - half[1] * turn.cos();
                let end = DVec2::new(first.x + way.x, first.y + way.y);
                [
                    (end, out, index),
                    (DVec2::new(first.x, first.y), -out, SIDES + 1 + index),
                ]
            })
            .map(|(end, out, order)| (order, end + out))
            .collect::<std::collections::BTreeMap<_, _>>()
            .into_values()
            .collect();
        let verdict = judged(&texels, &shadow);
        println!(
            "{name}: beyond {:.1e}, error {:.1e}, bar {:.1e}, {} rays",
            verdict.beyond, verdict.error, verdict.bar, counters.rays
        );
        // A corner of the lying one may hide, as in a plate's shadow; the leaning one has none. The polygon's
        // own error is that of a circle.
        let hidden = if way.z == 0.0 { 1.0 / 1024.0 } else { 1e-6 };
        assert!(verdict.beyond <= hidden, "{name}: {:e}", verdict.beyond);
        assert!(verdict.error < 3e-5, "{name}: {:e}", verdict.error);
        assert!(verdict.bar < 3e-4, "{name}: {:e}", verdict.bar);
        // Shafts tell of all texels but those that the shadow's edge crosses, some 110 of 4096.
        assert!(counters.rays < 100_000, "{name}: {}", counters.rays);
    }
    // The sun's direction times 0.7: all three are rounded.
    let slant = DVec3::new(0.2, 0.1, 1.0).normalize();
    let sun = SUN.replace(
        r#"x="0" y="0" z="-1""#,
        &format!(r#"x="{}" y="{}" z="{}""#, -slant.x, -slant.y, -slant.z),
    );
    for (sun, way) in [(SUN.to_owned(), DVec3::Z), (sun, slant)] {
        let (texels, _) = measured(&scene(&sun, &tube(first, first + 0.7 * way)));
        let is_open =
            |it: &DirectTexel| (it.irradiance.0[0] - way.z).abs() < 1e-14 && it.error.0[0] == 0.0;
        assert!(texels.iter().all(is_open), "{way}");
    }
}

/// A tube on the floor below a lamp over its axis shades a ring, from its foot to the shadow of its upper rim.
/// Floors are turned about the origin, where a corner of a shaft is: rounding must not lose the foot.
#[test]
fn a_standing_tubes_foot_is_found_wherever_the_floor_is() {
    const SIDE: usize = 128;
    for degrees in [0.0, 17.0, 29.0, 53.0, 71.0, 88.0] {
        let turn = format!(r#"<rotate x="0.6" y="0.48" z="0.64" angle="{degrees}"/>"#);
        let tube = format!(
            r#"<shape type="cylinder"><transform name="to_world">
            <scale x="0.21" y="0.21" z="0.2"/><translate x="0.3" y="0.4"/>{turn}</transform></shape>"#
        );
        let flux = |tube: &str| -> f64 {
            let text = format!(
                r#"<scene version="3.0.0">
                <emitter type="spot"><transform name="to_world">
                    <lookat origin="0.3, 0.4, 2" target="0.3, 0.4, 0" up="0, 1, 0"/>{turn}</transform>
                    <rgb name="intensity" value="4"/><float name="cutoff_angle" value="80"/>
                    <float name="beam_width" value="79"/></emitter>
                {tube}
                <shape type="rectangle"><transform name="to_world">{turn}</transform><bsdf type="diffuse"/>
                    <sensor type="irradiancemeter"><film type="hdrfilm">
                        <integer name="width" value="{SIDE}"/><integer name="height" value="{SIDE}"/>
                    </film></sensor>
                </shape></scene>"#
            );
            let folder = tempfile::tempdir().unwrap();
            let file = folder.path().join("turned.xml");
            std::fs::write(&file, text).unwrap();
            let (texels, _) = measured(&mitsuba::load(&file, &[]).unwrap());
            let area = (2.0 / SIDE as f64).powi(2);
            texels.iter().map(|it| it.irradiance.0[0] * area).sum()
        };
        // The light of 4 W/sr from 2 m above within a radius; the upper rim's shadow is 1/0.9 as wide.
        let within = |radius: f64| TAU * 4.0 * (1.0 - 2.0 / (4.0 + radius * radius).sqrt());
        let truth = within(0.21 / 0.9) - within(0.21);
        let shaded = flux("") - flux(&tube);
        println!("{degrees}°: {shaded:.6} W of {truth:.6} W are shaded");
        // Two circles cross some 8 · 64 · 0.22 = 113 texels each, whose cuts are known to 1e-4 of a texel with
        // 1 W/m².
        let allowed = 2.0 * 113.0 * 1e-4 * (2.0 / SIDE as f64).powi(2);
        assert!(
            (shaded - truth).abs() < allowed,
            "{degrees}: {shaded} {truth}"
        );
    }
}

#[test]
fn an_open_floor_takes_one_ray() {
    let (texels, counters) = measured(&scene(SUN, ""));
    assert_eq!(counters.rays, 1);
    assert!(texels.iter().all(|texel| texel.irradiance.0[0] == 1.0));
}

#[test]
fn a_ball_round_a_lamp_hides_it_from_all_the_floor_at_the_cost_of_a_ray() {
    let lamp = r#"<emitter type="point"><point name="position" x="0.1" y="0" z="0.8"/>
        <rgb name="intensity" value="1"/></emitter>"#;
    let bulb = r#"<shape type="sphere"><point name="center" x="0.1" y="0" z="0.7"/>
        <float name="radius" value="0.3"/></shape>"#;
    let (texels, counters) = measured(&scene(lamp, bulb));
    assert_eq!(counters.rays, 1);
    assert!(texels.iter().all(|texel| texel.irradiance.0[0] == 0.0));
}

/// The light of a spot that ends in a step at 40 degrees is that of the disc below it: I cos³θ / h² within.
#[test]
fn a_spot_that_ends_in_a_step_lights_a_disc_in_every_texel() {
    let lamp = r#"<emitter type="spot"><transform name="to_world">
        <lookat origin="0.013, 0.021, 0.7" target="0.013, 0.021, 0" up="0, 1, 0"/></transform>
        <rgb name="intensity" value="1"/><float name="cutoff_angle" value="40"/>
        <float name="beam_width" value="40"/></emitter>"#;
    let (texels, _) = measured(&scene(lamp, ""));
    let flux: f64 = texels.iter().map(|texel| texel.irradiance.0[0]).sum();
    let flux = flux * (2.0 / SIDE as f64).powi(2);
    let solid_angle = std::f64::consts::TAU * (1.0 - 40_f64.to_radians().cos());
    // The rim crosses 2π r / size = 118 texels, and 128 leaves of 1/64 in each. A leaf's cells of 1/128 are known to
    // an eighth of their area at least: 118 · 128 / 128² / 8 = 0.12 of the 1,110 texels within.
    assert!(
        (flux / solid_angle - 1.0).abs() < 1e-4,
        "{}",
        flux / solid_angle - 1.0
    );
}

/// What rays see from points a 24th of a texel apart, and what of it would be there without shadows.
fn by_rays(scene: &Scene, receiver: &Receiver, texel: usize) -> [f64; 2] {
    const PARTS: usize = 24;
    let (mut seen, mut all) = (0.0, 0.0);
    for part in 0..PARTS * PARTS {
        let place = DVec2::new((part % PARTS) as f64, (part / PARTS) as f64);
        let point = receiver
            .point(scene, texel, (place + 0.5) / PARTS as f64)
            .unwrap();
        for emitter in scene.emitters() {
            let (light, towards, distance) = match emitter {
                Emitter::Directional {
                    direction,
                    irradiance,
                } => (irradiance.0[0] * -direction.z, -*direction, f64::INFINITY),
                Emitter::Point {
                    position,
                    intensity,
                } => {
                    let way = *position - point.position;
                    let distance = way.length();
                    let light = intensity.0[0] * way.z / distance.powi(3);
                    (light, way / distance, distance)
                }
                other => panic!("{other:?}"),
            };
            let mut counters = TraversalCounters::default();
            seen += light * transmittance(scene, &point, towards, distance, &mut counters);
            all += light;
        }
    }
    [seen, all].map(|sum| sum / (PARTS * PARTS) as f64)
}

/// Shadows whose outlines are silhouettes, borders, and lines where a body enters the floor, against rays.
#[test]
fn shadows_of_all_kinds_of_bodies_are_what_rays_see() {
    const LAMP: &str = r#"<emitter type="point"><point name="position" x="0.9" y="-0.7" z="1.7"/>
        <rgb name="intensity" value="1"/></emitter>"#;
    const LEANING_SUN: &str = r#"<emitter type="directional">
        <vector name="direction" x="0.4" y="0.3" z="-1"/><rgb name="irradiance" value="1"/></emitter>"#;
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("bumpy.ply");
    let mut bytes = Vec::new();
    write_ply(&bumpy_ball(0.4, 9), "a bumpy ball", &mut bytes).unwrap();
    std::fs::write(&file, bytes).unwrap();
    let open = folder.path().join("open.ply");
    // Three faces about an edge, one of them alone: no surface of a solid.
    std::fs::write(
        &open,
        "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\nproperty float z\n\
         element face 3\nproperty list uchar int vertex_indices\nend_header\n\
         -0.5 0 0.5\n0.5 0.1 0.6\n0 0.5 0.4\n0.1 -0.5 0.7\n0 0.1 1.1\n3 0 1 2\n3 1 0 3\n3 0 1 4\n",
    )
    .unwrap();
    let mesh = |file: &std::path::Path, z: f64| {
        format!(
            r#"<shape type="ply"><string name="filename" value="{}"/>
            <transform name="to_world"><translate x="0.1" z="{z}"/></transform></shape>"#,
            file.display()
        )
    };
    let bodies = [
        ("a bumpy ball", mesh(&file, 0.7)),
        ("a bumpy ball in the floor", mesh(&file, 0.1)),
        ("an open mesh", mesh(&open, 0.0)),
        (
            "a ball in the floor",
            r#"<shape type="sphere"><point name="center" x="0" y="0" z="0.2"/>
            <float name="radius" value="0.4"/></shape>"#
                .to_owned(),
        ),
        (
            "a disc",
            r#"<shape type="disk"><transform name="to_world"><scale value="0.4"/>
            <rotate x="1" angle="50"/><translate z="0.6"/></transform></shape>"#
                .to_owned(),
        ),
        (
            "a plate through the floor",
            r#"<shape type="rectangle"><transform name="to_world"><scale value="0.4"/>
            <rotate x="1" angle="70"/><translate z="0.1"/></transform></shape>"#
                .to_owned(),
        ),
        (
            "a tube before a plate",
            r#"<shape type="cylinder"><point name="p0" x="0" y="-0.4" z="0.5"/>
            <point name="p1" x="0.2" y="0.5" z="0.6"/><float name="radius" value="0.2"/></shape>
            <shape type="rectangle"><transform name="to_world"><scale value="0.2"/>
            <translate x="0.3" z="0.3"/></transform></shape>"#
                .to_owned(),
        ),
    ];
    for (name, body) in bodies {
        let scene = scene(&format!("{LAMP}{LEANING_SUN}"), &body);
        let receiver = Receiver::new(&scene, &scene.sensors()[0]).unwrap();
        let (texels, counters) = measured(&scene);
        let (mut sum, mut light, mut worst) = (0.0, 0.0, 0.0_f64);
        for (index, texel) in texels.iter().enumerate() {
            let [seen, all] = by_rays(&scene, &receiver, index);
            let difference = texel.irradiance.0[0] - seen;
            sum += difference;
            light += all;
            worst = worst.max((difference.abs() - texel.error.0[0]) / all);
        }
        println!(
            "{name}: worst {worst:.1e}, in all {:.1e}, {} rays",
            sum / light,
            counters.rays
        );
        // Points know a line's place in a texel to half their distance, 1/48, on a length of up to √2; two
        // lines of two shadows.
        assert!(worst < 4.0 * 1.5 / 48.0, "{name}: {worst}");
        // Over hundreds of texels with an edge, whose errors differ: a twentieth of that, by their share of 4096.
        assert!((sum / light).abs() < 1e-4, "{name}: {}", sum / light);
    }
}

/// Scrambled Sobol' points are never much worse than random ones, whose error goes as N^(−1/2): 64 times the
/// samples make an error eight times less, and less still, where they are taken. Elsewhere it is below a
/// thousandth, which is what half of the eight is left for.
#[test]
fn more_samples_of_an_area_light_sharpen_its_shadow_and_agree() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/cornell-glass.xml");
    let size = [("size".to_owned(), "16".to_owned())];
    let scene = mitsuba::load(path.as_ref(), &size).unwrap();
    let receiver = Receiver::new(&scene, &scene.sensors()[0]).unwrap();
    let texels = |samples| {
        let found = direct(&scene, &receiver, 0, samples, &|| false).unwrap();
        found.texels
    };
    let (few, many) = (texels(AREA_SAMPLES), texels(64 * AREA_SAMPLES));
    let squares = |texels: &[DirectTexel]| -> f64 {
        texels.iter().map(|texel| texel.error.mean().powi(2)).sum()
    };
    let fall = (squares(&few) / squares(&many)).sqrt();
    assert!(fall > 4.0, "{fall}");
    let sum = |texels: &[DirectTexel]| -> f64 {
        texels.iter().map(|texel| texel.irradiance.mean()).sum()
    };
    // Four standard errors of the difference: one seed in 16 000 fails.
    let likely = (squares(&few) + squares(&many)).sqrt();
    let off = sum(&many) - sum(&few);
    assert!(off.abs() < 4.0 * likely, "{off} against {likely}");
    // Where light is easy to measure nothing is measured anew, to the bit.
    assert!(few.iter().zip(&many).any(|(few, many)| few == many));
    assert!(few.iter().zip(&many).any(|(few, many)| few != many));
}

#[test]
fn a_lamp_whose_normals_oppose_its_winding_lights_what_its_normals_see() {
    // A square of side 2 at a height of 1 above a floor as large, wound up or down; normals the other way.
    let lamp = |rise: f64, is_turned: bool| {
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let at = |[x, y]: [f64; 2]| DVec3::new(x, y, 1.0);
        let triangle = |order: [u32; 3]| {
            let [a, b, c] = order;
            if rise > 0.0 { [a, b, c] } else { [a, c, b] }
        };
        let normal = if is_turned { -rise } else { rise };
        MeshParts {
            positions: corners.map(at).to_vec(),
            normals: Some(vec![DVec3::Z * normal; 4]),
            triangles: vec![triangle([0, 1, 2]), triangle([0, 2, 3])],
            ..MeshParts::default()
        }
    };
    let mean = |parts: &MeshParts| {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("lamp.ply");
        let mut bytes = Vec::new();
        write_ply(parts, "", &mut bytes).unwrap();
        std::fs::write(&file, bytes).unwrap();
        let shape = format!(
            r#"<shape type="ply"><string name="filename" value="{}"/>
               <emitter type="area"><rgb name="radiance" value="1"/></emitter></shape>"#,
            file.display()
        );
        let scene = scene("", &shape);
        let mut warnings = scene.warnings().iter();
        let is_warned =
            warnings.any(|one| one.message.contains("2 of its faces shine to the side"));
        let texels = measured(&scene).0;
        let sum: f64 = texels.iter().map(|one| one.irradiance.mean()).sum();
        (sum / texels.len() as f64, is_warned)
    };
    // Of two equal and opposite squares half a side apart, one gets 0.41525 of the other's flux, π for a
    // radiance of one (Howell, C-11). 128 samples of each texel scatter by about their mean: 0.14 % for all.
    let expected = 0.415253 * std::f64::consts::PI;
    for (parts, turned) in [(lamp(-1.0, false), false), (lamp(1.0, true), true)] {
        let (found, is_warned) = mean(&parts);
        assert!((found / expected - 1.0).abs() < 0.005, "{found} {expected}");
        assert_eq!(is_warned, turned);
    }
    for parts in [lamp(-1.0, true), lamp(1.0, false)] {
        assert_eq!(mean(&parts).0, 0.0);
    }
}

/// A mask that holds a mask lets through what either does, and one that holds nothing lets all through.
#[test]
fn masks_within_masks_are_passed_by_the_product_of_their_opacities() {
    let mask = |opacity: &str, inside: &str| {
        format!("<bsdf type=\"mask\"><float name=\"opacity\" value=\"{opacity}\"/>{inside}</bsdf>")
    };
    let matt = "<bsdf type=\"diffuse\"/>";
    for (bsdf, passed) in [
        (mask("0.5", &mask("0.4", matt)), 0.8),
        (mask("1", &mask("0.25", matt)), 0.75),
        (mask("0.25", &mask("1", matt)), 0.75),
        (mask("1", &mask("1", matt)), 0.0),
        (mask("0.5", "<bsdf type=\"null\"/>"), 1.0),
        (mask("1", &mask("0.5", "<bsdf type=\"null\"/>")), 1.0),
    ] {
        let sheet = format!(
            "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/><translate z=\"1\"/></transform>\
             {bsdf}</shape>"
        );
        let (texels, _) = measured(&scene(SUN, &sheet));
        for texel in texels {
            let found = texel.irradiance.0[0];
            // A product of two, a difference and a sum.
            assert!(
                (found - passed).abs() < 1e-14,
                "{bsdf}: {found} is not {passed}"
            );
        }
    }
}
