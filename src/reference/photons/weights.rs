//! The largest contributions of photons, which bound what one more photon would have brought.

use serde::{Deserialize, Serialize};

use crate::numeric::FixedPoint;
use crate::radiometry::Rgb;

/// The largest contributions of a round, in quanta, and their numbers. Largest of integers: any order and any
/// division of the work gives the same bits.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Weights {
    /// The largest flux of a photon at its start, channel by channel.
    pub emitted: [i64; 3],
    /// One a layer.
    pub layers: Vec<LayerWeights>,
}

/// The largest contribution of a layer in each channel, and the number of contributions.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct LayerWeights {
    /// In quanta.
    pub largest: [i64; 3],
    /// Of all texels.
    pub contributions: u64,
}

/// The largest contribution in the unit of a film's sums.
#[derive(Clone, Copy, Debug)]
pub struct Largest {
    /// Of a texel.
    pub flux: Rgb,
    /// Of a photon at its start.
    pub emitted: Rgb,
    /// The number of contributions.
    pub contributions: u64,
}

impl Largest {
    /// None at all.
    pub const NONE: Self = Self {
        flux: Rgb::BLACK,
        emitted: Rgb::BLACK,
        contributions: 0,
    };

    /// Those of both.
    pub fn with(&mut self, other: &Self) {
        let larger = |a: Rgb, b: Rgb| Rgb(std::array::from_fn(|c| a.0[c].max(b.0[c])));
        self.flux = larger(self.flux, other.flux);
        self.emitted = larger(self.emitted, other.emitted);
        self.contributions = self.contributions.saturating_add(other.contributions);
    }
}

impl Weights {
    /// None so far, of so many layers.
    pub fn new(layers: usize) -> Self {
        Self {
            emitted: [0; 3],
            layers: vec![LayerWeights::default(); layers],
        }
    }

    /// Counts a contribution; one channel stands for three.
    #[inline]
    pub fn count<const N: usize>(&mut self, layer: usize, quanta: [i64; N]) {
        let layer = &mut self.layers[layer];
        raise(&mut layer.largest, quanta);
        layer.contributions += 1;
    }

    /// Counts a photon that starts.
    #[inline]
    pub fn start<const N: usize>(&mut self, quanta: [i64; N]) {
        raise(&mut self.emitted, quanta);
    }

    /// Adds those of other photons.
    pub fn merge(&mut self, other: &Self) {
        raise(&mut self.emitted, other.emitted);
        for (layer, others) in self.layers.iter_mut().zip(&other.layers) {
            raise(&mut layer.largest, others.largest);
            layer.contributions = layer.contributions.saturating_add(others.contributions);
        }
    }

    /// The largest of each layer, quanta times `weight`.
    pub fn largest(&self, scale: FixedPoint, weight: f64) -> Vec<Largest> {
        let rgb = |quanta: [i64; 3]| Rgb(quanta.map(|it| scale.value_i64(it) * weight));
        let layers = self.layers.iter();
        layers
            .map(|layer| Largest {
                flux: rgb(layer.largest),
                emitted: rgb(self.emitted),
                contributions: layer.contributions,
            })
            .collect()
    }
}

#[inline]
fn raise<const N: usize>(largest: &mut [i64; 3], quanta: [i64; N]) {
    for (c, largest) in largest.iter_mut().enumerate() {
        *largest = (*largest).max(quanta[c.min(N - 1)]);
    }
}
