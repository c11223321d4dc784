//! How faithfully an image reproduces the truth's light: how much of it, where, and at which scale.
//!
//! T is the truth and A the other image. Sums go over all texels of a layer, lit or not, and over channels;
//! a texel counts by its area, where areas differ. L1 and L2 of a black image are 1, at all scales.
//!
//! | figure | formula | of a black image |
//! |---|---|---|
//! | energy | Σ A / Σ T | 0 |
//! | L1 | Σ \|A − T\| / Σ T | 1 |
//! | misplaced | ½ Σ \|A / ΣA − T / ΣT\| | - |
//! | displaced | W₁(A / ΣA, T / ΣT), the mean distance that light must be moved | - |
//! | L2 | √(Σ (A − T)² / Σ T²) | 1 |
//! | L2 at s texels | the same of means over squares of s x s texels | 1 |
//! | resolution | the smallest s from which on L2 is below 10 % | - |
//!
//! A root mean square over the mean of the lit texels, which [`Difference`](super::difference::Difference)
//! has, is no fair headline: it grows with the lit area and with resolution. L1 and L2 do not depend on how
//! much of the receiver is dark.
//!
//! Each figure has an interval: the values that it could have with any truth within the truth's bars.
//! `bars.rs` has the derivations.

mod bars;
mod bounded;
mod displacement;
mod knothe;
mod measure;
mod scales;
mod sliced;

use serde::Serialize;

use super::pair::{LayerPair, Pairing};
use super::settings::ImageSide;
use super::sums::sums;
use super::{CompareError, CompareImage};
use bars::TruthBars;
pub use bounded::Bounded;
pub use displacement::Displacement;
use measure::Measure;
pub use scales::{Resolution, ScaleError};

/// Figures of a layer: how much light, where, and at which scale.
///
/// # Example: light that is all there, one texel beside its place
///
/// ```
/// use nephroid::{CompareImage, CompareSettings, Image, compare};
///
/// let spot = |column: usize| {
///     let mut image = Image::new(8, 8);
///     let mut values = [[0.0; 3]; 64];
///     values[8 * 4 + column] = [1.0; 3];
///     image.add_rgb("E", &values);
///     CompareImage::new("spot", image)
/// };
/// let comparison = compare(&spot(3), &spot(4), &CompareSettings::default())?;
/// let fidelity = &comparison.layers[0].fidelity;
/// assert_eq!(fidelity.energy.unwrap().value, 1.0);
/// assert_eq!(fidelity.misplaced.unwrap().value, 1.0);
/// let displaced = fidelity.displaced.as_ref().unwrap();
/// assert!((displaced.texels.value - 1.0).abs() < 1e-9);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Fidelity {
    /// Σ A / Σ T: flux of the image over flux of the truth, on the sensor. `None` if the truth is dark.
    pub energy: Option<Bounded>,
    /// Σ |A − T| / Σ T.
    pub l1: Option<Bounded>,
    /// The part of the light that is in a wrong texel if both have the same flux: 0 to 1. `None` if either
    /// is dark.
    pub misplaced: Option<Bounded>,
    /// How far light is from its place, on average. `None` if either is dark, or if `not_displaced` says
    /// why.
    pub displaced: Option<Displacement>,
    /// √(Σ (A − T)² / Σ T²).
    pub l2: Option<Bounded>,
    /// L2 of means over squares of 1, 2, 4, ... texels; the largest hold the whole image.
    pub scales: Vec<ScaleError>,
    /// The scale from which on L2 is below 10 %; `None` if that is at no scale.
    pub resolution: Option<Resolution>,
    /// The reason why no displacement is told, if there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub not_displaced: Option<String>,
}

/// The figures of all light of two images, and no others.
///
/// # Errors
///
/// As [`Pairing::new`].
pub fn of(truth: &CompareImage, other: &CompareImage) -> Result<Fidelity, CompareError> {
    let pairing = Pairing::new(truth, other, ImageSide::A, &[])?;
    Ok(Fidelity::of(&pairing.pairs[0]))
}

impl Fidelity {
    /// The figures of a layer.
    pub(crate) fn of(pair: &LayerPair) -> Self {
        let texels = pair.texels();
        let [truth, other, absolute] = sums(texels, |i| {
            let weight = pair.grid.weight(i);
            let mut terms = [0.0; 3];
            for one in &pair.channels {
                let (t, a) = (f64::from(one.reference[i]), f64::from(one.other[i]));
                for (sum, term) in terms.iter_mut().zip([t, a, (a - t).abs()]) {
                    *sum += weight * term;
                }
            }
            terms
        });
        let mut found = Self {
            energy: None,
            l1: None,
            misplaced: None,
            displaced: None,
            l2: None,
            scales: Vec::new(),
            resolution: None,
            not_displaced: pair.grid.not_a_plane.clone(),
        };
        if truth <= 0.0 {
            return found;
        }
        let bars = TruthBars::of(pair);
        found.energy = Some(bars.of_ratio(other / truth));
        found.l1 = Some(bars.of_l1(absolute / truth));
        found.scales = scales::scales(pair, &bars);
        found.l2 = found.scales.first().map(|finest| finest.l2);
        found.resolution = scales::resolution(&found.scales, pair.grid.spacing);
        if other <= 0.0 {
            return found;
        }
        let [apart] = sums(texels, |i| {
            let shares = pair.channels.iter().map(|one| {
                let (t, a) = (f64::from(one.reference[i]), f64::from(one.other[i]));
                (a / other - t / truth).abs()
            });
            [pair.grid.weight(i) * shares.sum::<f64>()]
        });
        found.misplaced = Some(bars.of_misplaced(0.5 * apart));
        if found.not_displaced.is_none() {
            let size = [pair.width, pair.height];
            let mean = |values: fn(&super::pair::ChannelPair, usize) -> f32| {
                Measure::new(size, |i| {
                    let channels = pair.channels.iter();
                    channels.map(|one| f64::from(values(one, i))).sum()
                })
            };
            let measures = [mean(|one, i| one.reference[i]), mean(|one, i| one.other[i])];
            if let [Some(truth), Some(other)] = &measures {
                found.displaced = Some(Displacement::of(truth, other, pair.grid.spacing, &bars));
            }
        }
        found
    }
}
