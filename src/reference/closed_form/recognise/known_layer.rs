//! Light by one path, before it is a layer of an estimate.

use super::plane::ReceiverPlane;
use crate::radiometry::Rgb;
use crate::reference::closed_form::KnownPath;
use crate::run::Refusal;
use crate::run::{Interval, Layer, LayerName};
use crate::transport::signature::{Event, Signature};

/// Light of one path on all texels, of an emitter of strength 1.
pub(super) struct KnownLayer {
    /// The path.
    pub(super) path: KnownPath,
    /// Irradiance of each texel of the film [W/m²] for a strength of 1.
    pub(super) values: Vec<f64>,
    /// Largest error of each value [W/m²].
    pub(super) accuracy: Vec<f64>,
    /// Strength of the emitter times the colours of the surfaces that the light met.
    pub(super) factor: Rgb,
}

/// A configuration that a closed form solves.
pub(super) trait KnownLight {
    /// Hands over the light of all paths of up to `max_depth` specular events, direct light first, until
    /// `take` returns false.
    ///
    /// # Errors
    ///
    /// If the configuration is too large for so many events.
    fn layers(
        &self,
        plane: &ReceiverPlane,
        max_depth: u32,
        take: &mut dyn FnMut(KnownLayer) -> bool,
    ) -> Result<(), Refusal>;
}

impl KnownLayer {
    /// True if no texel has light.
    pub(super) fn is_dark(&self) -> bool {
        self.values.iter().all(|value| *value <= 0.0)
    }

    /// The layer of an estimate: value and bounds of each texel.
    ///
    /// The factor's three roundings are below the accuracy of every formula.
    pub(super) fn into_layer(self) -> Layer {
        let scaled = |value: f64| self.factor * value.max(0.0);
        let pairs = || self.values.iter().zip(&self.accuracy);
        let texels = self.values.len();
        Layer {
            values: self.values.iter().map(|value| scaled(*value)).collect(),
            interval: Some(Interval {
                low: pairs()
                    .map(|(value, error)| scaled(value - error))
                    .collect(),
                high: pairs()
                    .map(|(value, error)| scaled(value + error))
                    .collect(),
            }),
            ..Layer::dark(LayerName::Path(signature(self.path)), texels)
        }
    }
}

fn signature(path: KnownPath) -> Signature {
    let times =
        |from: Signature, count: u32| (0..count).fold(from, |path, _| path.then(Event::Reflection));
    let direct = Signature::DIRECT;
    match path {
        KnownPath::Direct => direct,
        KnownPath::Reflected(count) => times(direct, count),
        KnownPath::Through(count) => {
            times(direct.then(Event::Transmission), count).then(Event::Transmission)
        }
    }
}
