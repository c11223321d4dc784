//! Beams from spots, however narrow or wide, against closed forms and photons.

use std::f64::consts::{PI, TAU};

use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::closed_form::{
    FlatSlab, KnownPath, RadialMap, RadialSheet, TexelGrid,
};
use nephroid::internals::run::Estimate;
use nephroid::internals::scene::Scene;

use crate::support::beams::{
    PANE, RECTANGLES, assert_photons_are_within_bounds, beams_to, known_by,
};
use crate::support::scenes::over_floor;

/// Texels a side of the receiver, which is the square of half width 1 in the plane z = 0.
const SIDE: usize = 32;

/// The area [m²] of a texel.
const TEXEL: f64 = 4.0 / (SIDE * SIDE) as f64;

/// The probability that a right program fails a test of photons against beams.
const ALPHA: (f64, usize) = (1e-6, 1 << 16);

/// A scene of an emitter, specular things and the receiver.
fn scene(emitter: &str, things: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    over_floor(folder.path(), &format!("{emitter}{things}"), SIDE)
}

/// A spot; angles in degrees.
fn spot(from: [f64; 3], to: [f64; 3], cutoff: f64, beam_width: f64, intensity: f64) -> String {
    let at = |[x, y, z]: [f64; 3]| format!("{x}, {y}, {z}");
    format!(
        r#"<emitter type="spot">
    <transform name="to_world"><lookat origin="{}" target="{}" up="0, 1, 0"/></transform>
    <rgb name="intensity" value="{intensity:e}, {intensity:e}, {intensity:e}"/>
    <float name="cutoff_angle" value="{cutoff:e}"/><float name="beam_width" value="{beam_width:e}"/>
  </emitter>"#,
        at(from),
        at(to)
    )
}

/// Lower bounds, values and upper bounds of what goes straight through.
fn through(estimate: &Estimate) -> [Vec<f64>; 3] {
    let name = nephroid::internals::run::LayerName::Path("LTTD".parse().unwrap());
    let layer = estimate.layers.iter().find(|one| one.name == name).unwrap();
    let interval = layer.interval.as_ref().unwrap();
    let first = |values: &[Rgb]| values.iter().map(|value| value.0[0]).collect();
    [
        first(&interval.low),
        first(&layer.values),
        first(&interval.high),
    ]
}

/// What a spot sends out [sr], for an intensity of 1 at its axis: of a factor that falls linearly from 1 at b
/// to 0 at c, 2π ∫ sin θ f dθ = 2π [1 − (sin c − sin b)/(c − b)]. Below a degree by its series, whose next
/// term is below c⁴/840.
fn solid_angle(cutoff: f64, beam_width: f64) -> f64 {
    let (c, b) = (cutoff.to_radians(), beam_width.to_radians());
    if c < PI / 180.0 {
        let squares = b * b + b * c + c * c;
        let fourths = (0..=4).map(|i| b.powi(i) * c.powi(4 - i)).sum::<f64>();
        TAU * (squares / 6.0 - fourths / 120.0)
    } else {
        TAU * (1.0 - (c.sin() - b.sin()) / (c - b))
    }
}

/// Straight down at normal incidence n = 1.5 reflects 4 % at each of two surfaces, and a part of order θ⁴
/// more.
const THROUGH: f64 = 0.96 * 0.96;

#[test]
fn a_cone_much_narrower_than_a_pane_delivers_all_its_light_to_one_texel() {
    // 0.496 and 0.688 of a texel off its corner, and so off all the pane's edges and diagonals.
    let from = [0.031, 0.043, 4.0];
    for things in [PANE, RECTANGLES] {
        for cutoff in [1e-8, 1e-6, 1e-3, 0.1] {
            let beam_width = 0.5 * cutoff;
            let intensity = 1.0 / solid_angle(cutoff, beam_width);
            let lamp = spot(from, [0.031, 0.043, 0.0], cutoff, beam_width, intensity);
            for error in [0.1, 1e-3] {
                let (estimate, _) = beams_to(2, &scene(&lamp, things), error);
                let [low, value, high] = through(&estimate);
                let flux = |values: &[f64]| values.iter().sum::<f64>() * TEXEL;
                let own = 16 * SIDE + 16;
                println!(
                    "{cutoff} {error}: {} in {} .. {}",
                    flux(&value),
                    low[own] * TEXEL,
                    high[own] * TEXEL
                );
                // A direction is known to 1e-15, and so a cone of 1e-8 degrees to 1e-5 of itself.
                let rounding = 1e-9 + 2e-15 / cutoff.to_radians();
                assert!(low[own] * TEXEL <= THROUGH + rounding, "{cutoff} {error}");
                assert!(high[own] * TEXEL >= THROUGH - rounding, "{cutoff} {error}");
                assert!((flux(&value) / THROUGH - 1.0).abs() <= error, "{cutoff}");
                // And nothing is said to be anywhere else for sure.
                let elsewhere = (0..SIDE * SIDE).filter(|texel| *texel != own);
                assert!(elsewhere.map(|texel| low[texel]).all(|low| low == 0.0));
            }
        }
    }
}

/// At 1e-12 degrees, 1.7e-14, a cone is about as wide as directions are rounded to.
#[test]
fn a_cone_narrower_than_rounding_comes_to_an_end() {
    for things in [PANE, RECTANGLES] {
        let lamp = spot([0.031, 0.043, 4.0], [0.031, 0.043, 0.0], 1e-12, 5e-13, 1e27);
        let (estimate, _) = beams_to(2, &scene(&lamp, things), 0.1);
        let known = |value: &Rgb| value.is_finite();
        assert!(estimate.total.values.iter().all(known));
        // Roots of some hundredths of a pane down to the cone, 45 halvings of those at the cone, and some thousand cells.
        assert!(
            estimate.counters.rays < 1_000_000,
            "{}",
            estimate.counters.rays
        );
    }
}

/// Light of a spot, pointed down from the height `height`, through a pane 0.1 m thick.
struct SpotThroughPane {
    height: f64,
    cutoff: f64,
    beam_width: f64,
}

impl SpotThroughPane {
    const PANE: FlatSlab = FlatSlab {
        thickness: 0.1,
        ior: 1.5,
    };

    /// The texels' irradiance [W/m²] for an intensity of 1, by parts that are smooth in the angle.
    fn map(&self) -> Vec<f64> {
        let grid = TexelGrid::square(1.0, SIDE);
        let [b, c] = [self.beam_width, self.cutoff].map(f64::to_radians);
        let mut sum = vec![0.0; SIDE * SIDE];
        // Beyond 70 degrees the light of a lamp 2 m over the pane is beside the receiver.
        let end = c.min(70_f64.to_radians());
        for (from, to, falls) in [(0.0, b.min(end), false), (b, end, true)] {
            if from >= to {
                continue;
            }
            let part = Part {
                height: self.height,
                range: (from, to),
                falloff: falls.then_some((b, c)),
            };
            for (sum, value) in sum.iter_mut().zip(RadialSheet::new(part).map(&grid)) {
                *sum += value;
            }
        }
        sum
    }
}

/// The light of a range of angles.
struct Part {
    height: f64,
    range: (f64, f64),
    falloff: Option<(f64, f64)>,
}

impl RadialMap for Part {
    fn range(&self) -> (f64, f64) {
        self.range
    }

    fn radius(&self, u: f64) -> Option<f64> {
        Some(self.height * u.tan() - SpotThroughPane::PANE.foot_shift(u, 0))
    }

    fn flux_density(&self, u: f64) -> f64 {
        let factor = self.falloff.map_or(1.0, |(b, c)| (c - u) / (c - b));
        let passed = SpotThroughPane::PANE.transmitted_fraction(u.cos(), KnownPath::Through(0));
        TAU * factor * u.sin() * passed
    }
}

#[test]
fn a_spots_falloff_is_within_bounds_on_every_texel() {
    // Narrower than a texel at its foot, as wide as some, wider than the receiver; all falling, and hardly
    // any.
    for (cutoff, beam_width) in [
        (0.3, 0.1),
        (6.0, 0.0),
        (10.0, 5.0),
        (12.0, 11.9),
        (80.0, 20.0),
        (180.0, 0.0),
        (180.0, 180.0),
    ] {
        let truth = SpotThroughPane {
            height: 4.0,
            cutoff,
            beam_width,
        }
        .map();
        let brightest = truth.iter().copied().fold(0.0, f64::max);
        let lamp = spot([0.0, 0.0, 4.0], [0.0; 3], cutoff, beam_width, 1.0);
        for things in [PANE, RECTANGLES] {
            for error in [0.1, 0.01, 1e-3] {
                let (estimate, _) = beams_to(2, &scene(&lamp, things), error);
                let [low, _, high] = through(&estimate);
                // A sheet is known to 1e-12 of the flux of the circles that meet a texel, some tens of texels
                // long.
                let rounding = 1e-10 * brightest;
                for texel in 0..truth.len() {
                    assert!(
                        low[texel] - rounding <= truth[texel]
                            && truth[texel] <= high[texel] + rounding,
                        "{cutoff} {beam_width} at {error}, texel {} {}: {} not in {} .. {}",
                        texel % SIDE,
                        texel / SIDE,
                        truth[texel],
                        low[texel],
                        high[texel]
                    );
                }
            }
        }
    }
}

#[test]
fn photons_agree_with_a_spot_on_the_surface_of_a_pane() {
    // Its light starts on the upper face, at a height without rounding, and first meets the lower one.
    let mesh = PANE.replace("0.05", "0.0625");
    let rectangles = RECTANGLES
        .replace("2.05", "2.0625")
        .replace("1.95", "1.9375");
    for things in [mesh, rectangles] {
        let lamp = spot([0.031, 0.043, 2.0625], [0.2, 0.1, 0.0], 20.0, 10.0, 1.0);
        let scene = scene(&lamp, &things);
        let (estimate, _) = beams_to(4, &scene, 3e-3);
        let found = known_by(&estimate);
        println!(
            "{:?}",
            found
                .iter()
                .map(|one| one.signature.to_string())
                .collect::<Vec<_>>()
        );
        assert_photons_are_within_bounds("on a pane", &scene, (4, &estimate), 1 << 19, ALPHA);
    }
}

#[test]
fn photons_agree_with_a_cone_much_narrower_than_a_ball_and_its_facets() {
    // A ball of 0.5 m, and one of 2,000 triangles of some 4 cm: cones of 0.5 degrees are 3 cm wide there,
    // those of 0.05 degrees 3 mm.
    let mut mesh = Vec::new();
    let ball = nephroid::internals::generate::geodesic_sphere(0.5, 10);
    nephroid::internals::generate::write_ply(&ball, "ball", &mut mesh).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("ball.ply");
    std::fs::write(&file, mesh).unwrap();
    let smooth = format!(
        r#"<shape type="ply"><string name="filename" value="{}"/>
    <transform name="to_world"><translate z="1"/></transform><ref id="glass"/></shape>"#,
        file.display()
    );
    let sphere = r#"<shape type="sphere"><point name="center" x="0" y="0" z="1"/>
    <float name="radius" value="0.5"/><ref id="glass"/></shape>"#;
    for (name, things) in [("ball", sphere), ("mesh", smooth.as_str())] {
        for cutoff in [0.05, 0.5] {
            let lamp = spot(
                [0.1, 0.2, 4.5],
                [0.13, 0.27, 1.4],
                cutoff,
                0.6 * cutoff,
                1e3,
            );
            let scene = scene(&lamp, things);
            for error in [0.1, 1e-3] {
                let (estimate, _) = beams_to(4, &scene, error);
                let name = format!("{name} {cutoff} {error}");
                let judged =
                    assert_photons_are_within_bounds(&name, &scene, (4, &estimate), 1 << 18, ALPHA);
                println!("{name}: {judged}");
                assert!(judged >= 1, "{name}");
            }
        }
    }
}
