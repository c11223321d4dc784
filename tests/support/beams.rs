//! Beam runs, and how their bounds hold against what is known.

use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::beams::run::Setup;
use nephroid::internals::reference::beams::{BeamReport, BeamSettings, Forecast, run};
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, Layer, LayerName, Progress};
use nephroid::internals::scene::Scene;

use super::comparison::Compared;
use super::oracles::{DEPTH, Known, Oracle};
use super::scenes::{Photons, meter};

/// A pane of glass of half width 1.5 from z = 1.95 to 2.05: a mesh of flat faces.
pub const PANE: &str = r#"<shape type="cube" id="pane">
    <transform name="to_world"><scale x="1.5" y="1.5" z="0.05"/><translate z="2"/></transform><ref id="glass"/>
  </shape>"#;

/// The same as two rectangles.
pub const RECTANGLES: &str = r#"<shape type="rectangle">
    <transform name="to_world"><scale x="1.5" y="1.5"/><translate z="2.05"/></transform><ref id="glass"/>
  </shape>
  <shape type="rectangle">
    <transform name="to_world"><rotate x="1" angle="180"/><scale x="1.5" y="1.5"/><translate z="1.95"/></transform>
    <ref id="glass"/>
  </shape>"#;

/// A beam run to a relative error, a layer for each signature.
pub fn beams(scene: &Scene, error: f64) -> (Estimate, BeamReport) {
    beams_to(DEPTH, scene, error)
}

/// A beam run that follows `depth` events.
pub fn beams_to(depth: u32, scene: &Scene, error: f64) -> (Estimate, BeamReport) {
    let budget = Budget {
        relative_error: Some(error),
        ..Budget::default()
    };
    beams_within(depth, scene, &budget)
}

/// A beam run that follows `depth` events, a layer for each signature.
pub fn beams_within(depth: u32, scene: &Scene, budget: &Budget) -> (Estimate, BeamReport) {
    let progress = Progress::default();
    run(scene, meter(scene), settings(depth), budget, &progress).unwrap()
}

/// The same as a truth of other runs: photons in the place of beams are others than theirs.
pub fn finer_within(depth: u32, scene: &Scene, budget: &Budget) -> (Estimate, BeamReport) {
    let settings = BeamSettings {
        seed: 1,
        ..settings(depth)
    };
    let progress = Progress::default();
    run(scene, meter(scene), settings, budget, &progress).unwrap()
}

/// Likely work of runs.
pub fn forecast_within(depth: u32, scene: &Scene, budget: &Budget) -> Forecast {
    let progress = Progress::default();
    let mut setup = Setup::new(scene, meter(scene), settings(depth), &progress).unwrap();
    setup.forecast(budget)
}

/// Settings that follow so many events, a layer for each signature.
pub fn settings(max_depth: u32) -> BeamSettings {
    BeamSettings {
        max_depth,
        max_layers: 256,
        ..BeamSettings::default()
    }
}

/// Check of a layer's bounds against the truth.
#[derive(Clone, Copy, Debug, Default)]
pub struct Held {
    /// Texels that are sure to have light.
    pub lit: usize,
    /// Texels whose truth is out of bounds.
    pub missed: usize,
    /// The largest distance of the truth from its bounds, relative to the mean of the lit texels.
    pub worst: f64,
    /// The texel of that distance.
    pub at: usize,
    /// The median over lit texels whose error shows of bar / |true error|: how much too wide bars are.
    pub tightness: f64,
    /// √(mean squared true error) / mean truth over the lit texels.
    pub rmse: f64,
}

/// A layer's first channel beside what is known of it; lit is where there is truth.
pub fn held(layer: &Layer, low: &[f64], high: &[f64]) -> Held {
    let bounds = layer.interval.as_ref().unwrap();
    let truth = |texel: usize| 0.5 * (low[texel] + high[texel]);
    let lit: Vec<usize> = (0..low.len()).filter(|&texel| low[texel] > 0.0).collect();
    let mean = lit.iter().map(|&texel| truth(texel)).sum::<f64>() / lit.len().max(1) as f64;
    let mut held = Held {
        lit: lit.len(),
        ..Held::default()
    };
    for texel in 0..low.len() {
        let (bound_low, bound_high) = (bounds.low[texel].0[0], bounds.high[texel].0[0]);
        // False for NaN.
        if bound_low <= high[texel] && low[texel] <= bound_high {
            continue;
        }
        held.missed += 1;
        let beyond = (bound_low - high[texel]).max(low[texel] - bound_high) / mean;
        if beyond > held.worst || beyond.is_nan() {
            (held.worst, held.at) = (beyond, texel);
        }
    }
    let mut ratios = Vec::with_capacity(lit.len());
    let mut squares = 0.0;
    for &texel in &lit {
        let value = layer.values[texel].0[0];
        // What is not known of the truth is no error.
        let off = (value - high[texel]).max(low[texel] - value).max(0.0);
        squares += off * off;
        if off > 0.0 {
            ratios.push((bounds.high[texel].0[0] - value) / off);
        }
    }
    ratios.sort_by(f64::total_cmp);
    held.tightness = ratios.get(ratios.len() / 2).copied().unwrap_or(f64::NAN);
    held.rmse = (squares / lit.len().max(1) as f64).sqrt() / mean;
    held
}

/// The sum of some layers.
fn sum<'a>(known: impl Iterator<Item = &'a Known>, texels: usize) -> (Vec<f64>, Vec<f64>) {
    let mut sums = (vec![0.0; texels], vec![0.0; texels]);
    for one in known {
        for texel in 0..texels {
            sums.0[texel] += one.low[texel];
            sums.1[texel] += one.high[texel];
        }
    }
    sums
}

/// Checks of a whole run: each layer by name, then `E`, the sum of all layers, and the caustic, the sum of
/// the specular ones.
pub struct Verdict {
    /// By layer.
    pub layers: Vec<(String, Held)>,
    /// The sum of all layers.
    pub total: Held,
    /// The sum of the specular layers.
    pub caustic: Held,
}

/// A run's bounds, in place of a closed form.
pub fn known_by(estimate: &Estimate) -> Vec<Known> {
    let known = |layer: &Layer| {
        let LayerName::Path(signature) = layer.name else {
            return None;
        };
        let bounds = layer.interval.as_ref()?;
        let first = |values: &[Rgb]| values.iter().map(|value| value.0[0]).collect();
        Some(Known {
            signature,
            low: first(&bounds.low),
            high: first(&bounds.high),
        })
    };
    estimate.layers.iter().filter_map(known).collect()
}

/// Compares every layer of a run with what is known.
pub fn verdict(oracle: &Oracle, estimate: &Estimate) -> Verdict {
    let texels = estimate.total.values.len();
    let dark = vec![0.0; texels];
    let mut layers = Vec::new();
    let mut followed: Vec<&Known> = Vec::new();
    let mut caustic = Layer::bounded(LayerName::Other, texels);
    for layer in &estimate.layers {
        let LayerName::Path(signature) = layer.name else {
            panic!("{}: every signature has a layer", oracle.name);
        };
        if !signature.is_empty() {
            caustic.add(layer);
        }
        let known = oracle.layers.iter().find(|one| one.signature == signature);
        followed.extend(known);
        let (low, high) = known.map_or((&dark, &dark), |one| (&one.low, &one.high));
        layers.push((signature.to_string(), held(layer, low, high)));
    }
    // The upper bounds of the total hold light that is not followed, too.
    let (low, high) = sum(oracle.layers.iter(), texels);
    let total = held(&estimate.total, &low, &high);
    // The error is that of all light, of paths not followed, too; the bounds are those of the followed.
    let specular = |one: &&Known| !one.signature.is_empty();
    let (low, high) = sum(followed.iter().copied().filter(specular), texels);
    let mut of_followed = held(&caustic, &low, &high);
    let (low, high) = sum(oracle.layers.iter().filter(specular), texels);
    of_followed.rmse = held(&caustic, &low, &high).rmse;
    Verdict {
        layers,
        total,
        caustic: of_followed,
    }
}

/// Asserts that photons lie within the bounds of a beam run of `depth` events, on each texel that they can
/// judge. Also, beams must follow all that a thousandth of the photons' light does. Returns the numbers of
/// texels and layers that were judged.
///
/// `alpha` is the probability that a right program fails one of `comparisons` texels.
pub fn assert_photons_are_within_bounds(
    name: &str,
    scene: &Scene,
    (depth, estimate): (u32, &Estimate),
    count: u64,
    (alpha, comparisons): (f64, usize),
) -> usize {
    let mut photons = Photons::new(count);
    photons.settings.max_layers = 64;
    photons.settings.chains.max_depth = depth;
    let witness = photons.estimate(scene);
    let mut judged = 0;
    for known in known_by(estimate) {
        if known.signature.is_empty() {
            continue;
        }
        let signature = known.signature.to_string();
        let ones = vec![1.0; known.low.len()];
        let per_irradiance = Compared::new(scene, &photons, &witness, &signature, &ones).photons;
        let mut it = Compared::new(scene, &photons, &witness, &signature, &ones);
        for (texel, per_irradiance) in per_irradiance.iter().enumerate() {
            // Where beams see nothing, photons tell which texels can be judged.
            it.photons[texel] = it.estimate[texel].max(known.low[texel]) * per_irradiance;
        }
        (it.low, it.high) = (known.low, known.high);
        judged += it.judged().count();
        it.name = format!("{name} {signature}");
        it.assert_every_texel_agrees(0, alpha, comparisons);
    }
    let received = |row: &nephroid::internals::transport::ledger::FluxByFate| row.received.mean();
    let total: f64 = witness.ledger.rows.values().map(received).sum();
    for (signature, row) in &witness.ledger.rows {
        let wanted = LayerName::Path(*signature);
        assert!(
            received(row) < 1e-3 * total || estimate.layers.iter().any(|one| one.name == wanted),
            "{name}: {signature} is not followed"
        );
    }
    judged
}
