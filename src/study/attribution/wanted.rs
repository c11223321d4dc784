//! An attribution as it is asked for: one place for the program and for Python.

use std::time::Duration;

use super::{Attribution, AttributionError, ReducedSensor, RunProgress, SIDE, Truth, truth_by};
use crate::method::Method;
use crate::method::sensors::choose_sensor;
use crate::run::{Budget, Context, Error};
use crate::scene::{Scene, Sensor};
use crate::setting::{Given, Kind, Preset, Setting, SettingError, Values};

/// The references that make the truth.
pub const TRUTHS: [&str; 2] = ["beams", "photons"];

/// The likely error at which the truth is good enough, if none is asked for.
const ERROR: f64 = 0.003;

/// Limits as text.
const TABLE: [Setting; 4] = [
    Setting {
        key: "truth",
        kind: Kind::Choice(truths),
        default: Preset::Rule("beams"),
        unit: "",
        meaning: "The reference that makes the truth",
    },
    Setting {
        key: "error",
        kind: Kind::Fraction,
        default: Preset::Rule("0.3%"),
        unit: "",
        meaning: "The likely error at which the truth is good enough",
    },
    Setting {
        key: "time",
        kind: Kind::Time,
        default: Preset::Rule("none"),
        unit: "",
        meaning: "The longest that the truth may take",
    },
    Setting {
        key: "side",
        kind: Kind::Whole(1, u16::MAX as u64),
        default: Preset::Rule("128"),
        unit: "texels",
        meaning: "Texels that the longer side of the sensor has at least",
    },
];

fn truths() -> Vec<(&'static str, &'static str)> {
    TRUTHS.iter().map(|name| (*name, "")).collect()
}

/// The truth of an attribution, and the sensor it is made on.
#[derive(Clone, Debug, PartialEq)]
pub struct Limits {
    /// The reference that makes the truth, of [`TRUTHS`].
    pub truth: String,
    /// The likely error at which it is good enough.
    pub error: f64,
    /// The longest that it may take.
    pub time: Option<Duration>,
    /// Texels that the longer side of the sensor has at least.
    pub side: usize,
}

impl Limits {
    /// From text, by the keys of `nephroid attribute`'s flags.
    ///
    /// # Errors
    ///
    /// For a key or a value that does not exist.
    pub fn of(given: &Given) -> Result<Self, SettingError> {
        let values = Values::new("attribute", TABLE.iter().collect(), given)?;
        Ok(Self {
            truth: values.text("truth").unwrap_or(TRUTHS[0]).to_owned(),
            error: values.fraction("error").unwrap_or(ERROR),
            time: values.time("time"),
            side: values.whole("side").unwrap_or(SIDE),
        })
    }
}

/// An attribution, ready to be made.
#[derive(Debug)]
pub struct Wanted {
    technique: Method,
    reference: Method,
    sensor: Sensor,
    budget: Budget,
}

/// Something that computes a truth.
pub type TruthMaker<'a> = &'a (dyn Fn() -> Result<Truth, Error> + Sync);

impl Wanted {
    /// An attribution of the method with this name and these settings, else of the first technique, on the
    /// sensor with this id, else on the first irradiance meter.
    ///
    /// # Errors
    ///
    /// For a method, a setting or a sensor that does not exist.
    pub fn new(
        scene: &Scene,
        sensor: Option<&str>,
        (method, given): (Option<&str>, &Given),
        limits: &Limits,
    ) -> Result<Self, Error> {
        let technique = technique(method, given)?;
        let reference = Method::new(&limits.truth, &Given::new())?;
        let sensor = choose_sensor(scene, sensor)?;
        Ok(Self {
            technique,
            reference,
            sensor: ReducedSensor::new(scene, sensor, limits.side).sensor,
            budget: Budget {
                relative_error: Some(limits.error),
                time: limits.time,
                work: None,
            },
        })
    }

    /// Makes it. `watch` has the truth computed, and may watch it meanwhile. `None` if it was stopped.
    ///
    /// # Errors
    ///
    /// As [`attribute`](super::attribute).
    pub fn attribute(
        &self,
        scene: &Scene,
        context: &Context,
        progressing: RunProgress,
        watch: impl FnOnce(TruthMaker) -> Result<Truth, Error>,
    ) -> Result<Option<Attribution>, AttributionError> {
        let (technique, sensor) = (&self.technique, &self.sensor);
        super::attribute(technique, scene, sensor, context, progressing, |light| {
            watch(&|| truth_by(&self.reference, scene, sensor, light, &self.budget, context))
        })
    }
}

/// The technique asked for, or the first that there is.
fn technique(name: Option<&str>, given: &Given) -> Result<Method, SettingError> {
    let mut techniques = Method::names()
        .into_iter()
        .filter(|name| Method::new(name, &Given::new()).is_ok_and(|method| method.is_technique()));
    let name = name.or_else(|| techniques.next());
    Method::new(name.unwrap_or_default(), given)
}
