//! The truth that an attribution is held against.

use std::collections::BTreeMap;

use crate::method::Method;
use crate::radiometry::Rgb;
use crate::run::{Budget, Context, Error, Estimate, LayerName, Light};
use crate::scene::{Scene, Sensor};
use crate::transport::signature::Signature;

/// The truth that an approximation is held against.
#[derive(Clone, Debug)]
pub struct Truth {
    /// The light that the approximation models, texel by texel.
    pub modelled: Vec<Rgb>,
    /// Other light by way of mirrors and glass, by all such light; NaN if that is not known.
    pub not_modelled: f64,
    /// The likely error of the truth, relative.
    pub relative_error: Option<f64>,
    /// True if that is what was asked for: not if time or rays ran out, or somebody stopped it.
    pub is_resolved: bool,
}

/// The part of light by way of mirrors and glass that is not modelled, from sums over texels.
pub fn not_modelled(modelled: &[Rgb], specular: f64) -> f64 {
    let modelled: f64 = modelled.iter().map(|value| value.mean()).sum();
    if specular > 0.0 {
        (1.0 - modelled / specular).max(0.0)
    } else {
        specular
    }
}

/// The truth of a scene by beams, for an approximation of some of its light.
///
/// Two runs: one of chains no longer than that light's, to the error that is asked for, and one of all
/// chains, of which only the sum of the other light is wanted, to ten times that error.
///
/// # Errors
///
/// As [`Method::run`].
pub fn truth_by_beams(
    scene: &Scene,
    sensor: &Sensor,
    light: Light,
    budget: &Budget,
    context: &Context,
) -> Result<Truth, Error> {
    /// The part that is not modelled is a figure of one or two digits.
    const ROUGHLY: f64 = 10.0;
    /// Signatures with a layer of their own: the modelled one is hardly ever the seventeenth brightest.
    const LAYERS: &str = "16";
    let beams =
        |key: &str, value: String| Method::new("beams", &BTreeMap::from([(key.to_owned(), value)]));
    let depth = light.max_depth().map(|depth| depth.to_string());
    let short = match depth {
        Some(depth) => beams("max-depth", depth)?,
        None => Method::new("beams", &BTreeMap::new())?,
    };
    let estimate = short.run(scene, sensor, budget, context)?.estimate;
    let rough = Budget {
        relative_error: budget.relative_error.map(|error| ROUGHLY * error),
        ..*budget
    };
    let long = beams("layers", LAYERS.to_owned())?;
    let all = long.run(scene, sensor, &rough, context)?.estimate;
    let is_modelled = |name: LayerName| match (light, name) {
        (Light::Specular { .. }, LayerName::Other) => true,
        (light, LayerName::Path(signature)) => light.includes(signature),
        _ => false,
    };
    let direct = LayerName::Path(Signature::DIRECT);
    let is_good_enough = match (budget.relative_error, estimate.relative_error) {
        (Some(asked), Some(error)) => error <= asked,
        _ => true,
    };
    let modelled = sum_of(&estimate, is_modelled);
    let sum = |values: &[Rgb]| values.iter().map(|value| value.mean()).sum::<f64>();
    // Of chains of any length, those beyond the modelled depth are among `other` or have a layer.
    let rest = sum_of(&all, |name| name != direct && !is_modelled(name));
    Ok(Truth {
        not_modelled: not_modelled(&modelled, sum(&modelled) + sum(&rest)),
        modelled,
        relative_error: estimate.relative_error,
        is_resolved: is_good_enough && !estimate.incomplete,
    })
}

/// Some layers of an estimate, added up, texel by texel; NaN if the estimate knows nothing.
fn sum_of(estimate: &Estimate, is_chosen: impl Fn(LayerName) -> bool) -> Vec<Rgb> {
    let start = if estimate.total.is_unknown() {
        Rgb::grey(f64::NAN)
    } else {
        Rgb::BLACK
    };
    let mut sum = vec![start; estimate.width * estimate.height];
    for layer in estimate.layers.iter().filter(|layer| is_chosen(layer.name)) {
        for (sum, value) in sum.iter_mut().zip(&layer.values) {
            *sum += *value;
        }
    }
    sum
}
