//! Shared parts of the tests of caustics volumes.

use nephroid::internals::method::Method;
use nephroid::internals::run::{Budget, Context, Light, Rendering};
use nephroid::internals::scene::Scene;
use nephroid::internals::study::attribution::truth_by_beams;

use super::approximation::relative_rmse;
use super::scenes::meter;
use super::technique::technique;
#[allow(unused_imports, reason = "every program uses its own part of this")]
pub use super::technique::{rendered, texels};

/// All stages exact.
pub const EXACT: [(&str, &str); 9] = [
    ("emission", "exact"),
    ("buffers", "exact"),
    ("march", "exact"),
    ("layers", "exact"),
    ("interface", "exact"),
    ("sweep", "exact"),
    ("projector", "exact"),
    ("splat", "exact"),
    ("smooth", "exact"),
];

/// A caustics volume with some settings.
pub fn volume(settings: &[(&str, &str)]) -> Method {
    technique("caustics-volume", settings)
}

/// A caustics volume with all stages exact but for some settings.
pub fn exact_but(settings: &[(&str, &str)]) -> Method {
    volume(&[&EXACT, settings].concat())
}

/// All light by way of mirrors and glass on the first meter, by beams.
pub fn truth(scene: &Scene, error: f64) -> Vec<nephroid::internals::radiometry::Rgb> {
    let budget = Budget {
        relative_error: Some(error),
        ..Budget::default()
    };
    let light = Light::Specular { max_depth: 16 };
    let context = Context::default();
    let truth = truth_by_beams(scene, meter(scene), light, &budget, &context).unwrap();
    assert!(truth.is_resolved);
    truth.modelled
}

/// Relative RMSE of a caustics volume's frame.
pub fn error(
    method: &Method,
    scene: &Scene,
    truth: &[nephroid::internals::radiometry::Rgb],
) -> f64 {
    relative_rmse(&rendered(method, scene).estimate.total.values, truth).unwrap()
}

/// A count of a stage, in all its passes.
pub fn count(rendering: &Rendering, stage: &str, counter: &str) -> u64 {
    let passes = rendering.stages.iter().filter(|one| one.name == stage);
    passes.map(|one| one.work.get(counter)).sum()
}
