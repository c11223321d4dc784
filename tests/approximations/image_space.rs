//! Image-space refraction against closed forms of that approximation: ball, slab, side, pane.

use std::f64::consts::FRAC_PI_4;

use glam::{DVec2, DVec3};
use nephroid::internals::approximation::caustic_map::buffers::{Back, Backs, Front, back, front};
use nephroid::internals::approximation::caustic_map::lens::Lens;
use nephroid::internals::approximation::caustic_map::loss::Loss;
use nephroid::internals::approximation::caustic_map::refraction::{Arrival, Exit, Wanted};
use nephroid::internals::approximation::caustic_map::variants::{BackFaces, Mode};
use nephroid::internals::approximation::caustic_map::{CausticMap, Settings};
use nephroid::internals::approximation::interface::{self, Fresnel};
use nephroid::internals::approximation::{Extent, LightView, Precision, Technique};
use nephroid::internals::geometry::TraversalCounters;
use nephroid::internals::scene::Scene;
use nephroid::internals::setting::{Given, Values};
use nephroid::internals::transport::first_surface::Source;
use nephroid::internals::transport::path_end::next_hit;
use nephroid::internals::transport::scatter::Way;

use super::approximate_ball::{ApproximateBall, BALL, fresnel, schlick};
use crate::support::approximation::{GLASS, ball, lit_by, over_floor, scene_of};

/// An odd number of pixels: the middle row goes through the axis.
const SIDE: u32 = 513;

fn settings(pairs: &[(&str, &str)]) -> Settings {
    let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
    let given: Given = pairs.iter().map(owned).collect();
    let table = CausticMap.settings().iter().collect();
    Settings::of(&Values::new("caustic-map", table, &given).unwrap()).unwrap()
}

/// The middle row of a photon buffer of exact numbers, and the picture of back faces.
struct Row {
    scene: Scene,
    view: LightView,
    backs: Backs,
}

impl Row {
    fn new(scene: Scene, which: BackFaces) -> Self {
        let source = Source::all(&scene)[0];
        let things: Vec<Extent> = scene.world().shapes().iter().map(Extent::of).collect();
        let view = LightView::around(&source, &things, SIDE)[0];
        let side = SIDE as usize;
        let mut pixels: Vec<Option<Back>> = vec![None; side * side];
        for (index, pixel) in pixels.iter_mut().enumerate() {
            let at = DVec2::new((index % side) as f64, (index / side) as f64) + 0.5;
            let mut counters = TraversalCounters::default();
            let found = Self::front_of(&scene, &view, at);
            *pixel = found.and_then(|front| {
                let kind = (which, Precision::Exact);
                back(&scene, &view, &front, kind, &mut counters)
            });
        }
        let backs = Backs {
            pixels,
            shift: DVec2::ZERO,
        };
        Self { scene, view, backs }
    }

    fn at(column: usize) -> DVec2 {
        DVec2::new(column as f64, (SIDE / 2) as f64) + 0.5
    }

    fn front_of(scene: &Scene, view: &LightView, at: DVec2) -> Option<Front> {
        let found = next_hit(scene, view.ray(at), &mut TraversalCounters::default());
        front(scene, found, Mode::Refraction, Precision::Exact).unwrap()
    }

    /// The photon of a column, if it meets the object.
    fn exit(
        &self,
        column: usize,
        fresnel: Fresnel,
        pairs: &[(&str, &str)],
    ) -> Option<Result<Exit, Loss>> {
        let at = Self::at(column);
        let front = Self::front_of(&self.scene, &self.view, at)?;
        let arrival = Arrival {
            scene: &self.scene,
            view: &self.view,
            at,
            front: &front,
            fresnel,
            wanted: Wanted::Curvatures,
        };
        let mut counters = TraversalCounters::default();
        Some(arrival.image_space(&self.backs, &settings(pairs), &mut counters))
    }

    /// Pixels by slope.
    fn scale(&self) -> f64 {
        0.5 * f64::from(SIDE) / self.view.half()
    }

    /// The slope of a column's photon.
    fn slope(&self, column: usize) -> f64 {
        (column as f64 + 0.5 - 0.5 * f64::from(SIDE)) / self.scale()
    }

    /// The slope of the middle of the pixel that a slope is seen in.
    fn pixel(&self, slope: f64) -> f64 {
        let column = (slope * self.scale() + 0.5 * f64::from(SIDE)).floor();
        self.slope(column as usize)
    }
}

fn ball_row() -> Row {
    Row::new(scene_of(&over_floor(&ball(GLASS), 4)), BackFaces::Farthest)
}

/// How far from the axis, x = 0 = y, an exit's ray meets z = 0.
fn on_floor(exit: &Exit) -> f64 {
    let ray = exit.ray;
    let at = ray.at(-ray.origin.z / ray.direction.z);
    assert!(ray.direction.z < 0.0, "upward");
    at.truncate().length()
}

#[test]
fn photons_of_a_ball_land_where_the_papers_formula_puts_them() {
    let row = ball_row();
    for (thickness, by_view) in [("interpolated", false), ("view", true)] {
        let expected = ApproximateBall { by_view, ..BALL };
        let pairs = [
            ("thickness", thickness),
            ("total-reflection", "drop"),
            ("no-back-face", "drop"),
        ];
        let (mut landed, mut total) = (0, 0);
        for column in 0..SIDE as usize {
            let slope = row.slope(column).abs();
            let Some(found) = row.exit(column, Fresnel::None, &pairs) else {
                assert!(slope > BALL.edge() - 1e-12, "{column}");
                continue;
            };
            // The pixel of the exit is on the same side of the axis as the photon.
            let sign = row.slope(column).signum();
            let pixel = |seen: f64| sign * row.pixel(sign * seen);
            let expected = expected.trace(slope, pixel);
            match (found, expected.map(|ray| ray.radius)) {
                (Ok(exit), Some(Some(radius))) => {
                    // Rounding of a dozen operations, magnified by 1/cos near the critical angle.
                    let found = on_floor(&exit);
                    let allowed = 1e-9 * (1.0 + radius.abs());
                    assert!(
                        (found - radius.abs()).abs() < allowed,
                        "{column}: {found} {radius}"
                    );
                    landed += 1;
                }
                (Err(Loss::TotalReflection), Some(None)) => total += 1,
                (Err(Loss::NoBackFace), None) => {}
                (found, expected) => panic!("{column}: {found:?} {expected:?}"),
            }
        }
        // Most of the row lands, and the rim is reflected: neither case is empty.
        assert!(landed > 250 && total > 20, "{landed} {total}");
    }
}

#[test]
fn pixels_of_the_normal_move_landings_by_no_more_than_their_size() {
    // Half a pixel is 0.5005 / 513 of slope: 3.5e-3 across the back face, which is 3.6 from the lamp at most. The
    // normal there turns by that over cos 40 degrees, and the ray by no more than the normal. On its way of
    // 0.8 to the floor, 1.3 times that for its slope, that is 5e-3.
    let row = ball_row();
    for column in (SIDE / 2 + 1..SIDE).step_by(8) {
        let slope = row.slope(column as usize);
        let Some(smooth) = BALL.trace(slope, |seen| seen) else {
            continue;
        };
        // Up to 60 degrees, before rays graze.
        if smooth.incidence > 1.0 {
            continue;
        }
        let exit = row
            .exit(column as usize, Fresnel::None, &[])
            .unwrap()
            .unwrap();
        let off = (on_floor(&exit) - smooth.radius.unwrap().abs()).abs();
        assert!(off < 5e-3, "{column}: {off}");
    }
}

#[test]
fn the_exit_of_a_ball_at_45_degrees_is_65_thousandths_of_its_diameter_short() {
    let row = ball_row();
    let columns = SIDE as usize / 2..SIDE as usize;
    let at = |column: &usize| BALL.trace(row.slope(*column), |seen| seen);
    let off = |column: &usize| at(column).map_or(9.0, |ray| (ray.incidence - FRAC_PI_4).abs());
    let column = columns.min_by(|a, b| off(a).total_cmp(&off(b))).unwrap();
    let sine = at(&column).unwrap().incidence.sin();
    let exit = row.exit(column, Fresnel::None, &[]).unwrap().unwrap();
    let chord = 2.0 * (1.0 - (sine / 1.5).powi(2)).sqrt();
    let short = (chord - exit.lens.thickness) / 2.0;
    println!(
        "at {:.2} degrees: short by {short:.4} diameters",
        sine.asin().to_degrees()
    );
    // 0.0649 at 45 degrees; within a pixel, of 0.5 degrees there, it changes by 0.0016.
    assert!((short - 0.0649).abs() < 0.0016, "{short}");
}

#[test]
fn a_ball_falsely_reflects_all_beyond_65_degrees_of_incidence() {
    let edge = BALL.false_total_reflection();
    let incidence = (BALL.distance * edge.atan().sin()).asin().to_degrees();
    println!("total reflection from {incidence:.2} degrees on");
    assert!((incidence - 65.1).abs() < 0.05, "{incidence}");
    // With clamping, the ray leaves at a right angle to the normal that was read.
    let row = ball_row();
    let mut clamped = 0;
    for column in SIDE as usize / 2 + 1..SIDE as usize {
        let slope = row.slope(column);
        let pixel = |seen: f64| row.pixel(seen);
        let Some(ray) = BALL.trace(slope, pixel) else {
            continue;
        };
        let found = row.exit(column, Fresnel::None, &[("total-reflection", "clamp")]);
        let exit = found.unwrap().unwrap();
        if ray.radius.is_none() {
            let inside = BALL_CENTER - exit.ray.origin;
            let seen = row.view.project(exit.ray.origin).unwrap().at;
            let normal = row.backs.pixels[seen.y as usize * SIDE as usize + seen.x as usize]
                .unwrap()
                .normal;
            assert!(exit.ray.direction.dot(normal).abs() < 1e-12);
            assert!(inside.length() < 2.0);
            clamped += 1;
        }
    }
    assert!(clamped > 10, "{clamped}");
}

const BALL_CENTER: DVec3 = DVec3::new(0.0, 0.0, 1.4);

#[test]
fn interfaces_of_a_ball_take_what_fresnel_and_schlick_say_at_the_approximate_angles() {
    let row = ball_row();
    type Reflectance = fn(f64, f64) -> f64;
    let variants: [(Fresnel, Reflectance); 3] = [
        (Fresnel::None, |_, _| 0.0),
        (Fresnel::Schlick, schlick),
        (Fresnel::Exact, fresnel),
    ];
    for (variant, reflectance) in variants {
        for column in SIDE as usize / 2..SIDE as usize {
            let pixel = |seen: f64| row.pixel(seen);
            let Some(ray) = BALL.trace(row.slope(column), pixel) else {
                continue;
            };
            if ray.radius.is_none() {
                continue;
            }
            let exit = row.exit(column, variant, &[]).unwrap().unwrap();
            let first = reflectance(ray.incidence.cos(), BALL.eta);
            let second = reflectance(ray.cos_exit, 1.0 / BALL.eta);
            let expected = (1.0 - first) * (1.0 - second);
            let found = exit.throughput.mean();
            // Rounding, magnified where the exit is near the critical angle.
            assert!(
                (found - expected).abs() < 1e-9,
                "{column}: {found} {expected}"
            );
        }
    }
}

#[test]
fn schlicks_formula_is_the_printed_one() {
    for eta in [1.5, 1.0 / 1.5, 2.4] {
        for cos in [1.0, 0.9, 0.8, 0.4, 0.1, 0.0] {
            let found = interface::schlick(cos, eta);
            let expected = schlick(cos, eta);
            assert!(
                (found - expected).abs() < 1e-15,
                "{eta} {cos}: {found} {expected}"
            );
        }
    }
}

#[test]
fn a_balls_curvatures_are_one_over_its_radius_outward_on_both_sides() {
    let row = ball_row();
    let middle = SIDE as usize / 2;
    for column in [middle, middle + 40, middle + 100] {
        let exit = row.exit(column, Fresnel::None, &[]).unwrap().unwrap();
        let lens = exit.lens;
        assert!((lens.front - 1.0).abs() < 1e-12, "{lens:?}");
        assert!((lens.back - 1.0).abs() < 1e-12, "{lens:?}");
        assert!((lens.eta - 1.5).abs() < 1e-15, "{lens:?}");
    }
    // On the axis: d_front = 1.6, d_bg = 0.4, 1/f = (n - 1)(1 + 1) = 1. Eq. 7 with d_image = 1/(1 - 1/1.6).
    let lens = row.exit(middle, Fresnel::None, &[]).unwrap().unwrap().lens;
    let image = 1.0 / (1.0 - 1.0 / 1.6);
    let printed: f64 = 1.6 / 2.0 * (0.4 - image) / image;
    assert!((lens.thin(0.4) - printed.abs()).abs() < 1e-12, "{lens:?}");
}

#[test]
fn traced_and_mirrored_photons_have_the_balls_curvatures_too() {
    let row = ball_row();
    let column = SIDE as usize / 2 + 60;
    let at = Row::at(column);
    let front = Row::front_of(&row.scene, &row.view, at).unwrap();
    let arrival = Arrival {
        scene: &row.scene,
        view: &row.view,
        at,
        front: &front,
        fresnel: Fresnel::None,
        wanted: Wanted::Curvatures,
    };
    let (first, inside) = arrival.entered().unwrap();
    let found = next_hit(&row.scene, inside, &mut TraversalCounters::default());
    let through = arrival.through(&first, found).unwrap().lens;
    let ray = BALL.trace(row.slope(column), |seen| seen).unwrap();
    // A chord at the angle of refraction.
    let chord = 2.0 * (ray.incidence.sin() / 1.5).asin().cos();
    assert!(
        (through.thickness - chord).abs() < 1e-9,
        "{through:?} {chord}"
    );
    assert!((through.front - 1.0).abs() < 1e-12 && (through.back - 1.0).abs() < 1e-12);
    // A convex mirror of radius 1, and one interface with water's lens of half the power.
    let mirror = arrival.at_once(Way::Reflected).unwrap().lens;
    assert!((mirror.front - 1.0).abs() < 1e-12, "{mirror:?}");
    let once = arrival.at_once(Way::Transmitted).unwrap().lens;
    assert!(
        (once.front - 1.0).abs() < 1e-12 && once.eta == 1.5,
        "{once:?}"
    );
    // Parallel light behind one convex interface of radius 1 is focused n / (n - 1) = 3 behind it.
    let parallel = Lens {
        vergence: 0.0,
        ..once
    };
    assert!(parallel.surface(3.0) < 1e-12);
}

/// A block of glass 4 wide and 0.5 thick over the floor, under parallel light of slope 0.75.
fn slab_row(bsdf: &str) -> Row {
    let sun = r#"<emitter type="directional"><vector name="direction" x="0.75" y="0" z="-1"/>
        <rgb name="irradiance" value="1"/></emitter>"#;
    let block = format!(
        r#"<shape type="cube"><transform name="to_world"><scale x="2" y="2" z="0.25"/><translate z="1"/></transform>
            {bsdf}</shape>"#
    );
    Row::new(scene_of(&lit_by(sun, &block, 4)), BackFaces::Farthest)
}

#[test]
fn a_slab_shifts_light_by_the_approximate_thickness_and_keeps_its_direction() {
    let row = slab_row(GLASS);
    let slope: f64 = 0.75;
    let (incidence, thickness) = (slope.atan(), 0.5);
    let refracted = (incidence.sin() / 1.5).asin();
    let share = refracted / incidence;
    let along_view = thickness / incidence.cos();
    for (variant, approximate) in [
        (
            "interpolated",
            share * along_view + (1.0 - share) * thickness,
        ),
        ("view", along_view),
    ] {
        let mut photons = 0;
        for column in 0..SIDE as usize {
            let pairs = [("thickness", variant), ("no-back-face", "drop")];
            let Some(Ok(exit)) = row.exit(column, Fresnel::None, &pairs) else {
                continue;
            };
            let start = row.view.ray(Row::at(column));
            let front = start.at((start.origin.z - 1.25) / -start.direction.z);
            // What enters by the top and whose pixels' back face is the bottom.
            if front.x < -1.5 || front.x > 1.0 {
                continue;
            }
            photons += 1;
            let along = DVec3::new(refracted.sin(), 0.0, -refracted.cos());
            let expected = front + along * approximate;
            let off = exit.ray.origin.distance(expected);
            assert!(off < 1e-9, "{column}: {off}");
            let turned = exit.ray.direction.distance(start.direction);
            assert!(turned < 1e-9, "{column}: {turned}");
        }
        assert!(photons > 100, "{photons}");
    }
}

#[test]
fn matched_media_and_panes_are_passed_straight() {
    let matched = r#"<bsdf type="dielectric"><float name="int_ior" value="1.2"/><float name="ext_ior" value="1.2"/></bsdf>"#;
    let pane = r#"<bsdf type="thindielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>"#;
    let cos = 0.8;
    let slab = |reflectance: fn(f64, f64) -> f64| {
        let one = reflectance(cos, 1.5);
        1.0 - 2.0 * one / (1.0 + one)
    };
    for (bsdf, fresnels) in [
        // Without a change of the index, Schlick's formula still has (1 - cos)^5.
        (matched, [1.0, (1.0 - schlick(cos, 1.0)).powi(2), 1.0]),
        (pane, [1.0, slab(schlick).powi(2), slab(fresnel).powi(2)]),
    ] {
        let row = slab_row(bsdf);
        let variants = [Fresnel::None, Fresnel::Schlick, Fresnel::Exact];
        for (variant, expected) in variants.into_iter().zip(fresnels) {
            let middle = SIDE as usize / 2;
            let exit = row.exit(middle, variant, &[]).unwrap().unwrap();
            let start = row.view.ray(Row::at(middle));
            assert!(exit.ray.direction.distance(start.direction) < 1e-12);
            assert!(
                (exit.throughput.mean() - expected).abs() < 1e-12,
                "{exit:?}"
            );
            // Where the light's ray leaves the block.
            let leaves = start.at((start.origin.z - 0.75) / -start.direction.z);
            assert!(exit.ray.origin.distance(leaves) < 1e-9);
        }
    }
}

#[test]
fn an_exit_without_a_back_face_has_a_normal_across_the_views_axis() {
    let mut row = ball_row();
    let column = SIDE as usize / 2 + 120;
    let own = row.backs.pixels[SIDE as usize / 2 * SIDE as usize + column];
    // No back face but that of the photon's own pixel.
    row.backs.pixels.fill(None);
    row.backs.pixels[SIDE as usize / 2 * SIDE as usize + column] = own;
    let exit = |variant| {
        let pairs = [("no-back-face", variant), ("total-reflection", "drop")];
        row.exit(column, Fresnel::None, &pairs).unwrap()
    };
    assert_eq!(exit("drop").unwrap_err(), Loss::NoBackFace);
    // Inside, light goes down at 55 degrees to that normal at least: the critical angle is 41.8.
    assert_eq!(exit("side").unwrap_err(), Loss::TotalReflection);
    let pairs = [("no-back-face", "side"), ("total-reflection", "clamp")];
    let exit = row.exit(column, Fresnel::None, &pairs).unwrap().unwrap();
    // Clamped, it goes on along the side: straight down.
    assert!(exit.ray.direction.distance(-DVec3::Z) < 1e-12, "{exit:?}");
}

#[test]
fn the_nearest_and_the_farthest_back_face_are_those_of_two_blocks_in_one() {
    // One mesh of two boxes above each other: four faces along each ray.
    let folder = tempfile::tempdir().unwrap();
    let mut text = String::new();
    for (low, high) in [(0.5, 0.8), (1.0, 1.4)] {
        for z in [low, high] {
            for (x, y) in [(-1, -1), (1, -1), (1, 1), (-1, 1)] {
                text += &format!("v {x} {y} {z}\n");
            }
        }
    }
    for base in [0, 8] {
        for quad in [
            [4, 3, 2, 1],
            [5, 6, 7, 8],
            [1, 2, 6, 5],
            [2, 3, 7, 6],
            [3, 4, 8, 7],
            [4, 1, 5, 8],
        ] {
            let [a, b, c, d] = quad.map(|index| index + base);
            text += &format!("f {a} {b} {c}\nf {a} {c} {d}\n");
        }
    }
    std::fs::write(folder.path().join("blocks.obj"), text).unwrap();
    let shape = format!(
        r#"<shape type="obj"><string name="filename" value="blocks.obj"/>
            <boolean name="face_normals" value="true"/>{GLASS}</shape>"#
    );
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, over_floor(&shape, 4)).unwrap();
    let load = || nephroid::internals::mitsuba::load(&file, &[]).unwrap();
    let middle = SIDE as usize / 2;
    for (which, expected) in [(BackFaces::Nearest, 3.0), (BackFaces::Farthest, 3.5)] {
        let row = Row::new(load(), which);
        let back = row.backs.pixels[middle * SIDE as usize + middle].unwrap();
        // The lamp is at height 4; the blocks' lower sides are at 1 and 0.5.
        assert!((back.distance - expected).abs() < 1e-12, "{back:?}");
    }
}
