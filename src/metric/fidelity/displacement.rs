//! How far light is from its place: the Wasserstein distance of order one.

use serde::Serialize;

use super::bars::TruthBars;
use super::bounded::Bounded;
use super::knothe::upper_bound;
use super::measure::Measure;
use super::sliced::lower_bound;

/// How far light must be moved, on average, to be where the truth has it, if both have the same flux.
///
/// This is W₁, the least cost of any plan that moves the one to the other. `value` is a lower bound: the
/// distance that light is moved as a whole. It is W₁ itself for light that is shifted or scaled, and below
/// it for noise, whose single texels it hardly sees. `low` and `high` hold W₁: `high` has the cost of the
/// best plan found, and both have what the truth's bars allow.
///
/// # Example: three texels to the right
///
/// ```
/// use nephroid::{CompareImage, CompareSettings, Image, compare};
///
/// let spot = |column: usize| {
///     let mut image = Image::new(8, 8);
///     let mut values = [[0.0; 3]; 64];
///     values[8 * 4 + column] = [1.0; 3];
///     image.add_rgb("E", &values);
///     image.add_metadata("texel-size", "[0.01,0.01]");
///     CompareImage::new("spot", image)
/// };
/// let comparison = compare(&spot(1), &spot(4), &CompareSettings::default())?;
/// let displaced = comparison.layers[0].fidelity.displaced.clone().unwrap();
/// assert!((displaced.texels.value - 3.0).abs() < 1e-9);
/// assert!((displaced.metres.unwrap().value - 0.03).abs() < 1e-11);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Displacement {
    /// In texels.
    pub texels: Bounded,
    /// In metres, if the images know the size of their texels.
    pub metres: Option<Bounded>,
}

impl Displacement {
    pub(super) fn of(
        truth: &Measure,
        other: &Measure,
        spacing: Option<[f64; 2]>,
        bars: &TruthBars,
    ) -> Self {
        let texels = bounded(truth, other, [1.0; 2], bars);
        let metres = spacing.map(|spacing| {
            if spacing[0] == spacing[1] {
                texels.times(spacing[0])
            } else {
                bounded(truth, other, spacing, bars)
            }
        });
        Self { texels, metres }
    }
}

fn bounded(truth: &Measure, other: &Measure, spacing: [f64; 2], bars: &TruthBars) -> Bounded {
    let lower = lower_bound(truth, other, spacing);
    // Sums of rounded numbers: the two may cross in the last digits.
    let upper = upper_bound(truth, other, spacing).max(lower);
    bars.of_displacement(truth, spacing, lower, upper)
}
