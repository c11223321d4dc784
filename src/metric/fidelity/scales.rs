//! The relative difference against the scale at which one looks.

use serde::Serialize;

use super::super::pair::LayerPair;
use super::super::sums::square_sums;
use super::bars::TruthBars;
use super::bounded::Bounded;
use crate::numeric::math;

/// L2 below which an image counts as right at a scale.
pub(crate) const RIGHT: f64 = 0.1;

/// L2 of means over squares of texels.
///
/// # Example: the coarsest scale has the flux alone
///
/// ```
/// # use nephroid::{CompareImage, CompareSettings, Image, compare};
/// # let grey = |value: f64| {
/// #     let mut image = Image::new(16, 16);
/// #     image.add_rgb("E", &[[value; 3]; 256]);
/// #     CompareImage::new(format!("{value}.exr"), image)
/// # };
/// let comparison = compare(&grey(1.0), &grey(1.02), &CompareSettings::default())?;
/// let scales = &comparison.layers[0].fidelity.scales;
/// let coarsest = scales.last().unwrap();
/// assert_eq!(coarsest.texels, 16);
/// assert!((coarsest.l2.value - 0.02).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct ScaleError {
    /// The side of the squares \[texels\].
    pub texels: usize,
    /// √(Σ n (Ā − T̄)² / Σ n T̄²) over squares of area n with means Ā and T̄.
    pub l2: Bounded,
}

/// The scale from which on an image is right.
///
/// # Example: right at every scale
///
/// ```
/// # use nephroid::{CompareImage, CompareSettings, Image, compare};
/// # let grey = |value: f64| {
/// #     let mut image = Image::new(16, 16);
/// #     image.add_rgb("E", &[[value; 3]; 256]);
/// #     CompareImage::new(format!("{value}.exr"), image)
/// # };
/// let comparison = compare(&grey(1.0), &grey(1.02), &CompareSettings::default())?;
/// assert_eq!(comparison.layers[0].fidelity.resolution.unwrap().texels.value, 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Resolution {
    /// In texels; 1 if the image is right as it is.
    pub texels: Bounded,
    /// In metres, if the images know the size of their texels and these are squares.
    pub metres: Option<f64>,
}

/// L2 at 1, 2, 4, ... texels, up to a square that holds the image.
pub(super) fn scales(pair: &LayerPair, bars: &TruthBars) -> Vec<ScaleError> {
    let size = [pair.width, pair.height];
    let largest = pair.width.max(pair.height).next_power_of_two();
    let mut scales = Vec::new();
    let mut side = 1;
    while side <= largest {
        scales.push(ScaleError {
            texels: side,
            l2: at_scale(pair, bars, size, side),
        });
        side *= 2;
    }
    scales
}

fn at_scale(pair: &LayerPair, bars: &TruthBars, size: [usize; 2], side: usize) -> Bounded {
    let (mut squares, mut truth_squares) = (0.0, 0.0);
    for one in &pair.channels {
        let sums = square_sums(size, side, |i| {
            let (t, a) = (f64::from(one.reference[i]), f64::from(one.other[i]));
            [1.0, t, a - t].map(|term| pair.grid.weight(i) * term)
        });
        for [n, t, d] in sums.into_iter().filter(|[n, ..]| *n > 0.0) {
            squares += d * d / n;
            truth_squares += t * t / n;
        }
    }
    if truth_squares <= 0.0 {
        // Sums that are zero although the image's is not: means of both signs, which no light has.
        return Bounded {
            value: 1.0,
            low: None,
            high: None,
        };
    }
    bars.of_l2_at((squares / truth_squares).sqrt(), side)
}

/// The smallest scale at which, and at all above it, L2 is below [`RIGHT`]; between two scales L2 is taken as
/// linear in the logarithm of the scale.
pub(super) fn resolution(scales: &[ScaleError], spacing: Option<[f64; 2]>) -> Option<Resolution> {
    let crossing = |l2: fn(&Bounded) -> Option<f64>| -> Option<f64> {
        let known: Option<Vec<(f64, f64)>> = scales
            .iter()
            .map(|one| Some((one.texels as f64, l2(&one.l2)?)))
            .collect();
        let known = known?;
        let right = known.iter().rev().take_while(|(_, l2)| *l2 < RIGHT);
        let first = known.len() - right.count();
        let (scale, below) = *known.get(first)?;
        let Some((before, above)) = first.checked_sub(1).map(|i| known[i]) else {
            return Some(scale);
        };
        let along = (above - RIGHT) / (above - below);
        Some(before * math::powf(scale / before, along.clamp(0.0, 1.0)))
    };
    let value = crossing(|l2| Some(l2.value))?;
    let metres = spacing.filter(|[width, height]| width == height);
    Some(Resolution {
        texels: Bounded {
            value,
            low: crossing(|l2| l2.low),
            high: crossing(|l2| l2.high),
        },
        metres: metres.map(|[side, _]| side * value),
    })
}
