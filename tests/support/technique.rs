//! Shared parts of the tests of techniques: a technique with some settings, and what it makes of a meter.

use nephroid::internals::approximation::Technique;
use nephroid::internals::method::Method;
use nephroid::internals::run::{Budget, Context, Rendering};
use nephroid::internals::scene::Scene;
use nephroid::internals::setting::{Given, Values};

use super::scenes::meter;

/// Settings as a user gives them.
pub fn given(settings: &[(&str, &str)]) -> Given {
    let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
    settings.iter().map(owned).collect()
}

/// A technique with some settings.
pub fn technique(name: &str, settings: &[(&str, &str)]) -> Method {
    Method::new(name, &given(settings)).unwrap()
}

/// All settings of a technique, some of them given.
pub fn values(technique: &dyn Technique, settings: &[(&str, &str)]) -> Values {
    let all = technique.settings().iter().collect();
    Values::new(technique.name(), all, &given(settings)).unwrap()
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
