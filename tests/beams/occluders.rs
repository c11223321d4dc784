//! Things in the way of light between flat facets: beams must not look past them.

use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, LayerName};
use nephroid::internals::scene::Scene;

use crate::support::Photons;
use crate::support::beams::{beams_to, beams_within};
use crate::support::scenes::{layer, over_floor};

/// Texels a side of the receiver, which is the square of half width 1 in the plane z = 0.
const SIDE: usize = 32;

/// A pane of glass of half width 1.5 from z = 1.95 to 2.05, a bead in some place, and a receiver.
fn pane(emitter: &str, [x, y, z]: [f64; 3], radius: f64) -> Scene {
    let things = format!(
        r#"{emitter}
  <shape type="cube" id="pane">
    <transform name="to_world"><scale x="1.5" y="1.5" z="0.05"/><translate z="2"/></transform>
    <ref id="glass"/>
  </shape>
  <shape type="sphere" id="bead">
    <point name="center" x="{x}" y="{y}" z="{z}"/><float name="radius" value="{radius}"/>
    <bsdf type="diffuse"/>
  </shape>"#
    );
    let folder = tempfile::tempdir().unwrap();
    over_floor(folder.path(), &things, SIDE)
}

fn sun(x: f64, y: f64) -> String {
    format!(
        r#"<emitter type="directional"><vector name="direction" x="{x}" y="{y}" z="-1"/>
        <rgb name="irradiance" value="100,100,100"/></emitter>"#
    )
}

/// Lower and upper bounds of what goes straight through the pane.
fn bounds(estimate: &Estimate) -> (Vec<f64>, Vec<f64>) {
    let name = LayerName::Path("LTTD".parse().unwrap());
    let layer = estimate.layers.iter().find(|one| one.name == name).unwrap();
    let interval = layer.interval.as_ref().unwrap();
    let first = |values: &[nephroid::internals::radiometry::Rgb]| {
        values.iter().map(|value| value.0[0]).collect()
    };
    (first(&interval.low), first(&interval.high))
}

/// The area that the square of side `side` from (`x`, `y`) shares with a disc round the origin.
fn shared_area(x: f64, y: f64, side: f64, radius: f64) -> f64 {
    // Heights are those of a circle's chord, cut off at the square: the midpoint rule errs by
    // about (side / STEPS)^1.5 √radius where the chord begins, below 1e-8 here.
    const STEPS: u32 = 1 << 14;
    let step = side / f64::from(STEPS);
    (0..STEPS)
        .map(|index| {
            let at = x + step * (f64::from(index) + 0.5);
            let half = (radius * radius - at * at).max(0.0).sqrt();
            step * (half.min(y + side) - (-half).max(y)).max(0.0)
        })
        .sum()
}

#[test]
fn the_shadow_of_a_bead_under_a_pane_is_within_bounds_on_every_texel() {
    let center = [0.43, 0.29];
    for radius in [0.2, 0.05, 0.01] {
        let scene = pane(&sun(0.0, 0.0), [center[0], center[1], 1.0], radius);
        for error in [0.1, 0.01, 0.001] {
            let (estimate, report) = beams_to(2, &scene, error);
            let (low, high) = bounds(&estimate);
            let side = 2.0 / SIDE as f64;
            // At normal incidence n = 1.5 reflects 4 % at each of two surfaces.
            let lit = 100.0 * 0.96 * 0.96;
            let mut shadowed = 0;
            for texel in 0..SIDE * SIDE {
                // Columns run along x and rows along y, from the corner (-1, -1).
                let (column, row) = (texel % SIDE, texel / SIDE);
                let x = -1.0 + side * column as f64 - center[0];
                let y = -1.0 + side * row as f64 - center[1];
                let dark = shared_area(x, y, side, radius) / (side * side);
                let truth = lit * (1.0 - dark);
                shadowed += u32::from(dark > 0.0);
                // The quadrature of the shared area errs by 3.3e-9 of a texel's 3.9e-3, times
                // 92 W/m²: 8e-5.
                let rounding = 1e-4;
                assert!(
                    low[texel] <= truth + rounding && truth <= high[texel] + rounding,
                    "radius {radius}, error {error}, texel {column} {row}: {truth} not in {} .. {}",
                    low[texel],
                    high[texel],
                );
                // Where the bead is far off all is exact: bars hold for 3 x 3 texels.
                let far = x.hypot(y) > radius + 6.0 * side + 0.35 * error.sqrt();
                assert!(!far || high[texel] - low[texel] <= 1e-6, "{column} {row}");
            }
            assert!(shadowed >= 1);
            // A border that no line follows exactly is in the report.
            assert!(
                report
                    .signatures
                    .iter()
                    .any(|one| one.uncertain.mean() > 0.0)
            );
        }
    }
}

/// Asserts that photons are within a beam run's bounds, on every texel.
fn agrees_with_photons(name: &str, scene: &Scene, error: f64) {
    let (estimate, _) = beams_to(2, scene, error);
    let (low, high) = bounds(&estimate);
    let mut photons = Photons::new(1 << 21);
    photons.settings.chains.max_depth = 2;
    let (mean, sigma) = layer(&photons.estimate(scene), "LTTD", 0);
    let largest = mean.iter().copied().fold(0.0, f64::max);
    for texel in 0..SIDE * SIDE {
        // 6 standard errors of 32 replicates: exceeded once in a million. Texels with few photons
        // may have none at all in any replicate.
        let off = 6.0 * sigma[texel] + 1e-4 * largest;
        assert!(
            low[texel] <= mean[texel] + off && mean[texel] <= high[texel] + off,
            "{name} at {error}, texel {} {}: {} ± {} not in {} .. {}",
            texel % SIDE,
            texel / SIDE,
            mean[texel],
            sigma[texel],
            low[texel],
            high[texel],
        );
    }
}

#[test]
fn a_bead_before_a_pane_hides_it_from_the_sun() {
    let scene = pane(&sun(0.3, 0.1), [0.3, -0.2, 3.0], 0.3);
    for error in [0.1, 0.01, 0.001] {
        agrees_with_photons("wire", &scene, error);
    }
}

#[test]
fn a_bead_under_a_pane_hides_a_far_lamp() {
    let lamp = r#"<emitter type="point"><point name="position" x="0" y="0" z="50"/>
        <rgb name="intensity" value="10000,10000,10000"/></emitter>"#;
    let scene = pane(lamp, [0.43, 0.29, 1.0], 0.1);
    for error in [0.1, 0.01, 0.001] {
        agrees_with_photons("far", &scene, error);
    }
}

#[test]
fn a_bead_inside_a_pane_is_seen_between_two_facets() {
    let scene = pane(&sun(0.2, 0.0), [0.1, 0.2, 2.0], 0.03);
    for error in [0.1, 0.001] {
        agrees_with_photons("inside", &scene, error);
    }
}

#[test]
fn a_scene_with_an_occluder_costs_a_bounded_number_of_rays() {
    let scene = pane(&sun(0.0, 0.0), [0.43, 0.29, 1.0], 0.2);
    let budget = Budget {
        relative_error: Some(1e-3),
        ..Budget::default()
    };
    let (estimate, _) = beams_within(2, &scene, &budget);
    assert!(estimate.relative_error.unwrap() <= 1e-3);
    assert!(
        estimate.counters.rays < 2_000_000,
        "{}",
        estimate.counters.rays
    );
}
