//! Figures by name, each as an error: for limits, attributions and curves.

use super::LayerComparison;
use super::fidelity::{Bounded, Fidelity};
use crate::setting::words::words;

words! {
    /// A figure by which an image can be judged.
    Figure {
        /// flux of the image over flux of the truth, less one; too little light is negative
        Energy = "energy",
        /// Σ |A − T| / Σ T over all texels; 1 for a black image
        L1 = "l1",
        /// the part of the light that is in a wrong texel if both have the same flux
        Misplaced = "misplaced",
        /// how far light is from its place, on average, in texels
        Displaced = "displaced",
        /// √(Σ (A − T)² / Σ T²) over all texels; 1 for a black image
        L2 = "l2",
        /// the smallest scale from which on L2 is below 10 %, in texels
        Resolution = "resolution",
        /// root mean square difference over the truth's mean, both over lit texels
        Rmse = "rmse",
        /// mean HDR-FLIP
        Flip = "flip",
    }
}

impl Figure {
    /// The figures of light alone, of which attributions are made: each is a number for any image that is
    /// not black.
    pub const OF_LIGHT: [Self; 5] = [
        Self::L1,
        Self::Energy,
        Self::Misplaced,
        Self::Displaced,
        Self::L2,
    ];

    /// True for lengths in texels; all others are fractions.
    pub fn is_length(self) -> bool {
        matches!(self, Self::Displaced | Self::Resolution)
    }

    /// The figure of an image, zero where it is right; `None` if it is not defined.
    ///
    /// The energy's error has a sign. A resolution that no scale reaches is `None`, and so are figures that
    /// are not of light alone.
    pub fn of_light(self, fidelity: &Fidelity) -> Option<Bounded> {
        match self {
            Self::Energy => fidelity.energy.map(|energy| Bounded {
                value: energy.value - 1.0,
                low: energy.low.map(|low| low - 1.0),
                high: energy.high.map(|high| high - 1.0),
            }),
            Self::L1 => fidelity.l1,
            Self::Misplaced => fidelity.misplaced,
            Self::Displaced => fidelity.displaced.as_ref().map(|it| it.texels),
            Self::L2 => fidelity.l2,
            Self::Resolution => fidelity.resolution.map(|it| it.texels),
            Self::Rmse | Self::Flip => None,
        }
    }

    /// The size of the error in a layer, whichever its sign; `None` if it is not defined.
    pub fn error(self, layer: &LayerComparison) -> Option<Bounded> {
        let alone = |value: f64| Bounded {
            value,
            low: None,
            high: None,
        };
        match self {
            Self::Rmse => layer.difference.relative_rmse.map(alone),
            Self::Flip => layer.flip.map(|flip| alone(flip.mean)),
            Self::Energy => self.of_light(&layer.fidelity).map(size),
            _ => self.of_light(&layer.fidelity),
        }
    }
}

/// The size of a number of either sign.
fn size(signed: Bounded) -> Bounded {
    let ends = signed.low.zip(signed.high);
    Bounded {
        value: signed.value.abs(),
        low: signed.low.map(|low| match signed.high {
            Some(high) if low <= 0.0 && high >= 0.0 => 0.0,
            Some(high) => low.abs().min(high.abs()),
            None => low.max(0.0),
        }),
        high: ends.map(|(low, high)| low.abs().max(high.abs())),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setting::Words;

    #[test]
    fn the_size_of_an_energy_error_holds_zero_if_its_interval_does() {
        let signed = |low, value, high| {
            size(Bounded {
                value,
                low: Some(low),
                high: Some(high),
            })
        };
        let ends = |it: Bounded| (it.low.unwrap(), it.value, it.high.unwrap());
        assert_eq!(ends(signed(-0.3, -0.2, -0.1)), (0.1, 0.2, 0.3));
        assert_eq!(ends(signed(-0.1, 0.1, 0.2)), (0.0, 0.1, 0.2));
        assert_eq!(ends(signed(0.1, 0.2, 0.3)), (0.1, 0.2, 0.3));
    }

    #[test]
    fn every_word_names_its_figure() {
        for (word, figure, meaning) in Figure::WORDS {
            assert_eq!(Figure::of_word(word), Some(*figure));
            assert!(!meaning.trim().is_empty());
        }
    }
}
