//! Sums of estimates of disjoint light.
//!
//! No method finds all light well. Light paths are divided by the surfaces they meet (L light, S mirror or
//! glass, D any other surface, E camera), and each part is left to one method:
//!
//! | paths | found by |
//! |---|---|
//! | L S+ D E | photons or beams, connected to the camera |
//! | L S+ D S+ E | photon maps, without light that is seen directly |
//! | the rest | paths from the camera |
//!
//! Parts must have no light in common: a layer that both have is refused.

use super::{Estimate, Interval, Layer, LayerName, Quantity};
use crate::numeric::distributions::critical_value;
use crate::transport::ledger::Ledger;

/// The reason for which estimates cannot be added.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum CombineError {
    /// They differ in quantity or size.
    #[error("estimates of {left:?} and of {right:?} cannot be added")]
    Kind {
        /// Quantity, columns and rows of the one.
        left: (Quantity, usize, usize),
        /// Those of the other.
        right: (Quantity, usize, usize),
    },
    /// The sum would have bounds of a part of its light.
    #[error("one estimate has bounds and the other has not")]
    Bounds,
    /// Light would count twice.
    #[error("both estimates have a layer {layer}: its light would count twice")]
    Twice {
        /// The layer.
        layer: String,
    },
}

impl Estimate {
    /// This light and `other` light: layers side by side, and the sum of both as the total. Layers of what
    /// has no name of its own (`other`) are added to one.
    ///
    /// Standard errors add by squares, as those of independent runs; bounds add up, and both must have them
    /// or neither ([`Estimate::with_bounds`] makes some). The ledger is that of neither: both may have
    /// followed the same light.
    ///
    /// # Errors
    ///
    /// Where the two are of different quantity or size, have a layer in common, or one alone has bounds.
    #[doc(hidden)]
    pub fn and(mut self, other: Self) -> Result<Self, CombineError> {
        let kind = |it: &Self| (it.quantity, it.width, it.height);
        if kind(&self) != kind(&other) {
            return Err(CombineError::Kind {
                left: kind(&self),
                right: kind(&other),
            });
        }
        let named = |it: &&Layer| it.name != LayerName::Other;
        let is_in = |layer: &Layer| other.layers.iter().any(|it| it.name == layer.name);
        if let Some(twice) = self.layers.iter().filter(named).find(|it| is_in(it)) {
            return Err(CombineError::Twice {
                layer: twice.name.of(self.quantity),
            });
        }
        if self.total.interval.is_some() != other.total.interval.is_some() {
            return Err(CombineError::Bounds);
        }
        self.total.add(&other.total);
        for layer in other.layers {
            match self.layers.iter_mut().find(|it| it.name == layer.name) {
                Some(rest) => rest.add(&layer),
                None => self.layers.push(layer),
            }
        }
        // The rest comes last.
        self.layers
            .sort_by_key(|layer| layer.name == LayerName::Other);
        for (sum, count) in self.counts.iter_mut().zip(other.counts) {
            *sum += count;
        }
        self.ledger = Ledger::default();
        self.paths += other.paths;
        self.counters += other.counters;
        self.relative_error = Layer {
            interval: None,
            ..self.total.clone()
        }
        .relative_error();
        self.incomplete |= other.incomplete;
        Ok(self)
    }

    /// The same with bounds of a random method's layers: `replicates` - 1 degrees of freedom, each holding
    /// with the probability `confidence`. Layers that have bounds keep them. No bound is below `least`, the
    /// least light that there can be ([`ReconstructionFilter::least_light`]).
    ///
    /// [`ReconstructionFilter::least_light`]: crate::scene::ReconstructionFilter::least_light
    #[must_use]
    #[doc(hidden)]
    pub fn with_bounds(mut self, confidence: f64, replicates: u32, least: f64) -> Self {
        let widths = critical_value(confidence, f64::from(replicates) - 1.0);
        for layer in self.layers.iter_mut().chain([&mut self.total]) {
            let bound = |sign: f64| {
                let values = layer.values.iter().zip(&layer.standard_error);
                let bounds = values.map(|(value, error)| *value + *error * (sign * widths));
                // What is unknown stays so.
                bounds
                    .map(|it| it.map(|bound| if bound < least { least } else { bound }))
                    .collect()
            };
            // Those that hold for few samples know more than the scatter does, if they know anything.
            let is_known = |it: &Interval| it.high.iter().all(|high| high.is_finite());
            let of_sampling = layer.sampling.take().filter(is_known);
            if layer.interval.is_none() {
                layer.interval = Some(of_sampling.unwrap_or_else(|| Interval {
                    low: bound(-1.0),
                    high: bound(1.0),
                }));
            }
        }
        self
    }
}
