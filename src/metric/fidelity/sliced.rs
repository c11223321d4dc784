//! A lower bound of the Wasserstein distance, by maps to lines.
//!
//! A map f to a line that moves no two points further apart than they are gives W₁(f A, f T) <= W₁(A, T). On
//! the line W₁ = ∫ |F − G| of the two cumulative distributions (Vallender 1974). Two kinds of maps are used:
//!
//! - **Projections** p·e(θ). A plan that moves light by v costs at least ∫ |v·e(θ)| in direction θ, and the
//!   mean of |cos| over the K directions θₖ = (k + ½) π / K is 1 / (K sin(π / 2K)) at most. So
//!   sin(π / 2K) Σₖ W₁(θₖ) is a lower bound. It is the distance itself for all light moved by one vector
//!   along rows or columns; for other directions it is short of it by at most 1 − cos(π / 2K). It is the
//!   distance, too, for light that is scaled about a point (Bonneel et al. 2015 have the sliced distance).
//! - **Distances** from the truth's centre of light, which know what is moved in or out.

use glam::DVec2;

use super::measure::Measure;
use crate::numeric::math;
use crate::numeric::rotation;

/// Directions K: 1 − cos(π / 2K) = 3e-4.
const DIRECTIONS: usize = 64;

/// Bins of a line for the shorter side of a texel.
///
/// A share between two bins is dealt to both, linearly. Functions on the line that are linear between the
/// bins and move no two points further apart see no difference; so the bound stays one.
const BINS: f64 = 2.0;

/// The lower bound, in the unit of `spacing`.
pub(super) fn lower_bound(truth: &Measure, other: &Measure, spacing: [f64; 2]) -> f64 {
    use rayon::prelude::*;
    let directions: Vec<f64> = (0..DIRECTIONS)
        .into_par_iter()
        .map(|k| {
            let angle = (k as f64 + 0.5) * std::f64::consts::PI / DIRECTIONS as f64;
            let direction = rotation::direction(angle);
            on_line(truth, other, spacing, |place| place.dot(direction))
        })
        .collect();
    let share = math::sin(0.5 * std::f64::consts::PI / DIRECTIONS as f64);
    let sliced = share * directions.iter().sum::<f64>();
    let centre = truth.centre(spacing);
    let radial = on_line(truth, other, spacing, |place| place.distance(centre));
    sliced.max(radial)
}

/// The distance of two distributions that are mapped to a line.
fn on_line(truth: &Measure, other: &Measure, spacing: [f64; 2], map: impl Fn(DVec2) -> f64) -> f64 {
    let [width, height] = truth.size;
    let step = spacing[0].min(spacing[1]) / BINS;
    // All places are within the diagonal of the origin.
    let reach = math::hypot(spacing[0] * width as f64, spacing[1] * height as f64);
    let count = (2.0 * reach / step).ceil() as usize + 2;
    let mut bins = vec![0.0; count];
    for (texel, (t, a)) in truth.shares.iter().zip(&other.shares).enumerate() {
        let difference = a - t;
        if difference == 0.0 {
            continue;
        }
        let along = (map(truth.place(texel, spacing)) + reach) / step;
        let bin = (along.floor().max(0.0) as usize).min(count - 2);
        let beyond = (along - bin as f64).clamp(0.0, 1.0);
        bins[bin] += (1.0 - beyond) * difference;
        bins[bin + 1] += beyond * difference;
    }
    let (mut cumulative, mut sum) = (0.0f64, 0.0);
    for difference in bins {
        cumulative += difference;
        sum += cumulative.abs();
    }
    step * sum
}
