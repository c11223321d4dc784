//! The truth that an attribution is held against.

use crate::method::Method;
use crate::radiometry::Rgb;
use crate::run::{Budget, Context, Error, Estimate, LayerName, Light};
use crate::scene::{Scene, Sensor};
use crate::setting::Given;
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

/// The truth of a scene by a reference, beams or photons, for an approximation of some of its light.
///
/// Two runs: one of chains no longer than that light's, to the error that is asked for, and one of all
/// chains, of which only the sum of the other light is wanted, to a hundredth or to that error if it is more.
/// One is enough if these are the same chains.
///
/// # Errors
///
/// As [`Method::run`]; and if the reference has no setting `max-depth` or `layers`.
pub fn truth_by(
    reference: &Method,
    scene: &Scene,
    sensor: &Sensor,
    light: Light,
    budget: &Budget,
    context: &Context,
) -> Result<Truth, Error> {
    /// The error of all light at which the part that is not modelled is known well enough.
    const ROUGHLY: f64 = 0.01;
    /// Signatures with a layer of their own: the modelled one is hardly ever the seventeenth brightest.
    const LAYERS: &str = "16";
    let all = reference.with("layers", LAYERS)?;
    let short = match light.max_depth() {
        Some(depth) => all.with("max-depth", &depth.to_string())?,
        None => all.clone(),
    };
    let estimate = short.run(scene, sensor, budget, context)?.estimate;
    let longer = if short.settings() == all.settings() {
        None
    } else {
        let rough = Budget {
            relative_error: budget.relative_error.map(|error| error.max(ROUGHLY)),
            ..*budget
        };
        Some(all.run(scene, sensor, &rough, context)?.estimate)
    };
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
    let rest = sum_of(longer.as_ref().unwrap_or(&estimate), |name| {
        name != direct && !is_modelled(name)
    });
    Ok(Truth {
        not_modelled: not_modelled(&modelled, sum(&modelled) + sum(&rest)),
        modelled,
        relative_error: estimate.relative_error,
        is_resolved: is_good_enough && !estimate.incomplete,
    })
}

/// [`truth_by`] beams, which is the sooner one of all scenes but meshes of many bent faces.
///
/// # Errors
///
/// As [`truth_by`].
pub fn truth_by_beams(
    scene: &Scene,
    sensor: &Sensor,
    light: Light,
    budget: &Budget,
    context: &Context,
) -> Result<Truth, Error> {
    let beams = Method::new("beams", &Given::new())?;
    truth_by(&beams, scene, sensor, light, budget, context)
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
