//! Shared parts of the tests of techniques: a technique with some settings, and what it makes of a meter.

use nephroid::internals::method::Method;
use nephroid::internals::run::{Budget, Context, Rendering};
use nephroid::internals::scene::Scene;

use super::scenes::meter;

/// A technique with some settings.
pub fn technique(name: &str, settings: &[(&str, &str)]) -> Method {
    let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
    Method::new(name, &settings.iter().map(owned).collect()).unwrap()
}

/// What a method makes of a scene's first meter.
pub fn rendered(method: &Method, scene: &Scene) -> Rendering {
    let context = Context::default();
    method
        .run(scene, meter(scene), &Budget::default(), &context)
        .unwrap()
}

/// What each texel has of that, the mean of its channels.
pub fn texels(method: &Method, scene: &Scene) -> Vec<f64> {
    let values = rendered(method, scene).estimate.total.values;
    values.iter().map(|value| value.mean()).collect()
}
