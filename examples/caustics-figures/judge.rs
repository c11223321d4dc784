//! The five objects in the box, and what caustics volumes make of them against the truth by beams.

use std::collections::BTreeMap;

use nephroid::internals::method::Method;
use nephroid::internals::metric::LayerComparison;
use nephroid::internals::metric::fidelity::Fidelity;
use nephroid::internals::mitsuba;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::{Budget, Context, LayerName, Rendering};
use nephroid::internals::scene::{Scene, Sensor};
use nephroid::internals::study::attribution::Truth;
use nephroid::internals::transport::signature::Signature;

use crate::support::caustics_volume::volume;
use crate::support::figures::{compared, figures};
use crate::support::light_volume::sensor;
use crate::support::scenes::bundled_file;

/// Texels a row of meters, and rows.
pub const SIDE: usize = 128;

/// An object of `cornell-caustics`, in the place of one of the paper's.
#[derive(Clone, Copy)]
pub struct Object {
    /// The paper's letter.
    pub letter: &'static str,
    pub name: &'static str,
    /// Most events of a path, of the truth and of the volume: beams do not end beyond it.
    pub depth: &'static str,
    /// Likely error that the truth is asked for.
    pub truth: f64,
}

/// The objects, as the paper's scenes A to E.
pub const OBJECTS: [Object; 5] = [
    object("A", "diamond", "4", 0.05),
    object("B", "ring", "16", 0.01),
    object("C", "ball", "16", 0.01),
    object("D", "knot", "6", 0.03),
    object("E", "blocks", "6", 0.03),
];

const fn object(
    letter: &'static str,
    name: &'static str,
    depth: &'static str,
    truth: f64,
) -> Object {
    Object {
        letter,
        name,
        depth,
        truth,
    }
}

impl Object {
    /// The name of a row.
    pub fn row(&self) -> String {
        format!("{} `{}`", self.letter, self.name)
    }

    /// The scene with `side` x `side` texels on meters and pixels of the camera.
    pub fn scene(&self, side: usize) -> Scene {
        let side = side.to_string();
        let parameters = [
            ("object", self.name),
            ("size", &side),
            ("width", &side),
            ("height", &side),
        ];
        let owned = |(key, value): &(&str, &str)| ((*key).into(), (*value).into());
        let parameters: Vec<_> = parameters.iter().map(owned).collect();
        mitsuba::load(&bundled_file("cornell-caustics"), &parameters).unwrap()
    }

    /// A caustics volume that follows as many events as the truth.
    pub fn volume(&self, settings: &[(&str, &str)]) -> Method {
        volume(&[&[("max-depth", self.depth)], settings].concat())
    }
}

/// Meters with their truths, made once.
#[derive(Default)]
pub struct Judge {
    known: BTreeMap<&'static str, Case>,
}

/// A floor and its truth.
pub struct Case {
    pub scene: Scene,
    pub truth: Truth,
    /// Light straight from the lamp.
    pub direct: Vec<Rgb>,
}

impl Judge {
    /// The floor under an object.
    pub fn floor(&mut self, object: &Object) -> &Case {
        self.known.entry(object.name).or_insert_with(|| {
            let scene = object.scene(SIDE);
            let (truth, direct) = truth(&scene, sensor(&scene, "floor"), object);
            Case {
                scene,
                truth,
                direct,
            }
        })
    }
}

/// The light by way of mirrors and glass, and straight from the lamp, by beams.
pub fn truth(scene: &Scene, sensor: &Sensor, object: &Object) -> (Truth, Vec<Rgb>) {
    let depth = BTreeMap::from([("max-depth".to_owned(), object.depth.to_owned())]);
    let beams = Method::new("beams", &depth).unwrap();
    let budget = Budget::error(object.truth);
    let rendering = beams.run(scene, sensor, &budget, &Context::default());
    let estimate = rendering.expect("beams of lights without size").estimate;
    let direct = LayerName::Path(Signature::DIRECT);
    let dark = vec![Rgb::BLACK; estimate.total.values.len()];
    let (mut specular, mut straight) = (dark.clone(), dark);
    for layer in &estimate.layers {
        let sum = if layer.name == direct {
            &mut straight
        } else {
            &mut specular
        };
        for (sum, value) in sum.iter_mut().zip(&layer.values) {
            *sum += *value;
        }
    }
    let truth = Truth {
        modelled: specular,
        not_modelled: f64::NAN,
        relative_error: estimate.relative_error,
        is_resolved: !estimate.incomplete,
    };
    (truth, straight)
}

/// A run on a sensor by its name.
pub fn rendered(method: &Method, scene: &Scene, id: &str) -> Rendering {
    let sensor = sensor(scene, id);
    let context = Context::default();
    let found = method.run(scene, sensor, &Budget::default(), &context);
    found.expect("a scene with mirrors or glass")
}

/// The light of a run, texel by texel.
pub fn values(method: &Method, scene: &Scene, id: &str) -> Vec<Rgb> {
    rendered(method, scene, id).estimate.total.values
}

/// The mean over texels and channels.
pub fn mean(values: &[Rgb]) -> f64 {
    values.iter().map(|value| value.mean()).sum::<f64>() / values.len() as f64
}

/// The L1 that an image's standard errors let expect, by its light: a normal error of deviation σ is √(2/π) σ in
/// the mean.
pub fn likely_l1(values: &[Rgb], errors: &[Rgb]) -> f64 {
    let of = |values: &[Rgb]| values.iter().map(|value| value.mean()).sum::<f64>();
    (2.0 * std::f64::consts::FRAC_1_PI).sqrt() * of(errors) / of(values)
}

/// Two images, added up.
pub fn sum(one: &[Rgb], other: &[Rgb]) -> Vec<Rgb> {
    one.iter().zip(other).map(|(a, b)| *a + *b).collect()
}

impl Case {
    pub fn sensor(&self) -> &Sensor {
        sensor(&self.scene, "floor")
    }

    /// What a method makes of it, and its figures.
    pub fn judged(&self, method: &Method) -> Fidelity {
        let found = values(method, &self.scene, "floor");
        figures(&self.scene, self.sensor(), &self.truth.modelled, &found)
    }

    /// SSIM and FLIP of the light by way of mirrors and glass alone.
    pub fn seen(&self, found: &[Rgb]) -> LayerComparison {
        compared(&self.scene, self.sensor(), &self.truth.modelled, found)
    }
}
