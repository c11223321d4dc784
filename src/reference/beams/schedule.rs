//! Tolerances of the next pass.
//!
//! Each layer s has an error e and took work W at its tolerance τ. A tolerance of x τ is likely to make them
//! e xᵃ and W x⁻ᵇ. The least work ΣW x⁻ᵇ for a given error √(Σe² x²ᵃ) is where all quotients of the
//! derivatives are the same: b W x⁻ᵇ = λ 2a e² x²ᵃ. So
//!
//! ```text
//! x = min(1, (b W / (2a λ e²))^(1 / (2a + b)))
//! ```
//!
//! with λ such that the error is the one asked for.
//!
//! Before the first pass neither e nor W is known. At one tolerance W is about the same for all: a fainter
//! layer has as many patches. Its error is smaller. So its first tolerance is larger.

use crate::numeric::math;

/// Power a of the tolerance that errors follow, about. Misplaced flux falls like the fourth power of a cell's
/// size in smooth light, and cells at borders are fewer than their texels.
const ERROR_ORDER: f64 = 0.7;

/// Power b of the tolerance that work grows with: 1/2 in smooth light, faster at borders.
const WORK_ORDER: f64 = 0.55;

/// Tolerance at which errors are about 1 in the mean over the bundled scenes (`examples/beam-figures`):
/// extrapolated with [`ERROR_ORDER`] from 0.1 % to 10 %.
const TOLERANCE_AT_ONE: f64 = 0.2;

/// Errors of all light that the first pass is for. With larger cells of it there is nothing smooth to derive
/// bounds from. With smaller ones, one pass would take long if the scene is harder than most.
const FIRST: std::ops::RangeInclusive<f64> = 1e-3..=COARSE_ERROR;

/// The error that the first pass is for if time or rays are limited.
pub const COARSE_ERROR: f64 = 3e-2;

/// Power of a layer's part of all light that its error goes with, about, at one tolerance: 0.1 to 1.3 in
/// `lens`, `turntable-ring` and `turntable-terrain`.
const ERROR_OF_PART: f64 = 0.5;

/// Largest tolerance, relative to a signature's own flux, at which its cells tell what they misplace. On 512
/// x 512 texels a glass ball's faint layers have 2,000 to 20,000 cells then.
const FINE: f64 = 1.0 / 32.0;

/// Largest tolerance of a signature, relative to its own flux, if its bounds do not rest on its cells: some
/// dozens of them.
const COARSE: f64 = 1.0 / 8.0;

/// The largest tolerance of a signature with a `part` of all flux at which its cells tell what they misplace.
pub fn fine(part: f64) -> f64 {
    FINE * part
}

/// The largest tolerance that makes sense for it if its bounds do not rest on its cells.
pub fn coarse(part: f64) -> f64 {
    COARSE * part
}

/// Part of the error asked for that a pass aims at, so that one step is enough.
const AIM: f64 = 0.8;

/// Factors of the tolerance that one pass may take.
const STEP: std::ops::RangeInclusive<f64> = 1e-3..=0.25;

/// Smallest tolerance: below it, cells hold so little that sums are rounding.
const LEAST_TOLERANCE: f64 = 1e-14;

/// A layer as the last pass left it.
#[derive(Clone, Copy, Debug)]
pub struct Known {
    /// Tolerance: the root mean square over all texels of the flux that a cell may misplace, relative to
    /// the mean flux of texels.
    pub tolerance: f64,
    /// Its error, relative to all light.
    pub error: f64,
    /// The work that it took, in any unit.
    pub work: f64,
    /// True if a smaller tolerance would not help.
    pub is_stuck: bool,
}

/// The tolerance to begin with, on the way to an error of `target`; as coarse as makes sense if time or rays
/// are `limited`.
pub fn first(target: Option<f64>, limited: bool) -> f64 {
    let error = match target {
        Some(target) if !limited => target.clamp(*FIRST.start(), *FIRST.end()),
        _ => COARSE_ERROR,
    };
    TOLERANCE_AT_ONE * math::powf(error, 1.0 / ERROR_ORDER)
}

/// The tolerance to begin a layer with that has a `part` of all light, if that for all light is `first`.
pub fn first_of_layer(first: f64, part: f64) -> f64 {
    let power = 2.0 * ERROR_OF_PART / (2.0 * ERROR_ORDER + WORK_ORDER);
    first * math::powf(part.min(1.0), -power)
}

/// The work to an error of `target`, by that of the first pass.
pub fn after_first(target: Option<f64>) -> f64 {
    let steps = target.unwrap_or(*FIRST.start()) / FIRST.start();
    if steps < 1.0 {
        1.0 + growth(steps)
    } else {
        1.0
    }
}

/// The work to so small a part of an error, by that to the error.
pub fn growth(part: f64) -> f64 {
    math::powf(part, -WORK_ORDER / ERROR_ORDER)
}

/// The error of all layers together: they are independent.
pub fn error(layers: &[Known]) -> f64 {
    let squares: f64 = layers.iter().map(|one| one.error * one.error).sum();
    squares.sqrt()
}

/// The tolerances of the layers that are to be made anew for an error of `target`; `None` for those that
/// stay. All stay if the error is reached, or if no tolerance may be smaller.
pub fn next(layers: &[Known], target: f64) -> Vec<Option<f64>> {
    if error(layers) <= target {
        return vec![None; layers.len()];
    }
    // Layers that are stuck keep their error: what is left is for the others.
    let stuck = layers.iter().filter(|one| one.is_stuck);
    let stuck: f64 = stuck.map(|one| one.error * one.error).sum();
    let goal = [AIM * target, target]
        .into_iter()
        .map(|error| error * error - stuck)
        .find(|squared| *squared > 0.0);
    let Some(goal) = goal.map(f64::sqrt) else {
        return vec![None; layers.len()];
    };
    let power = 1.0 / (2.0 * ERROR_ORDER + WORK_ORDER);
    let factor = |one: &Known, lambda: f64| {
        let squared = one.error * one.error;
        if squared == 0.0 || one.is_stuck {
            return 1.0;
        }
        let quotient = WORK_ORDER * one.work / (2.0 * ERROR_ORDER * lambda * squared);
        math::powf(quotient, power).min(1.0)
    };
    let reached = |lambda: f64| {
        let after =
            |one: &Known| math::powi(one.error * math::powf(factor(one, lambda), ERROR_ORDER), 2);
        let free = layers.iter().filter(|one| !one.is_stuck);
        free.map(after).sum::<f64>().sqrt()
    };
    // The error falls as λ grows. Its logarithm is halved until it is known to a part of 2⁻⁴⁰.
    let scale = layers.iter().map(|one| one.work).sum::<f64>() / math::powi(error(layers), 2);
    let (mut low, mut high) = (math::ln(scale * 1e-12), math::ln(scale * 1e24));
    for _ in 0..48 {
        let middle = 0.5 * (low + high);
        if reached(math::exp(middle)) > goal {
            low = middle;
        } else {
            high = middle;
        }
    }
    let factors: Vec<f64> = layers
        .iter()
        .map(|one| factor(one, math::exp(high)))
        .collect();
    // If no layer is to become much finer, all that are to become finer at all do.
    let least = factors.iter().fold(1.0_f64, |least, one| least.min(*one));
    let stays = f64::max(*STEP.end(), least);
    let finer = |(one, factor): (&Known, &f64)| {
        let tolerance = one.tolerance * factor.clamp(*STEP.start(), *STEP.end());
        (*factor <= stays && !one.is_stuck && one.error > 0.0 && tolerance >= LEAST_TOLERANCE)
            .then_some(tolerance)
    };
    layers.iter().zip(&factors).map(finer).collect()
}

/// The tolerance that is likely to lower an error to `asked`; `None` if it would be too small.
pub fn finer(tolerance: f64, error: f64, asked: f64) -> Option<f64> {
    let factor = math::powf(AIM * asked / error, 1.0 / ERROR_ORDER);
    let tolerance = tolerance * factor.clamp(*STEP.start(), *STEP.end());
    (tolerance >= LEAST_TOLERANCE).then_some(tolerance)
}

/// Likely work of a pass.
pub fn work(layers: &[Known], next: &[Option<f64>]) -> f64 {
    let of = |(one, next): (&Known, &Option<f64>)| {
        let growth = math::powf(one.tolerance / (*next)?, WORK_ORDER);
        Some(one.work * growth)
    };
    layers.iter().zip(next).filter_map(of).sum()
}

/// The [`next`] tolerances, or larger ones whose likely work is `affordable`; none if these would hardly
/// help.
pub fn affordable(layers: &[Known], target: f64, affordable: f64) -> Vec<Option<f64>> {
    let wanted = next(layers, target);
    if work(layers, &wanted) <= affordable {
        return wanted;
    }
    // The smallest error that can be afforded, by halving its logarithm.
    let (mut low, mut high) = (math::ln(target), math::ln(error(layers)));
    for _ in 0..16 {
        let middle = 0.5 * (low + high);
        if work(layers, &next(layers, math::exp(middle))) <= affordable {
            high = middle;
        } else {
            low = middle;
        }
    }
    next(layers, math::exp(high))
}

#[cfg(test)]
mod tests {
    use super::*;

    const BRIGHT: Known = Known {
        tolerance: 1e-4,
        error: 0.01,
        work: 1.0,
        is_stuck: false,
    };

    const DEAR: Known = Known {
        error: 1e-4,
        work: 100.0,
        ..BRIGHT
    };

    #[test]
    fn layers_that_are_good_enough_stay() {
        assert_eq!(next(&[BRIGHT, DEAR], 0.02), [None, None]);
    }

    #[test]
    fn a_stuck_layer_makes_no_work_for_the_others() {
        let stuck = Known {
            is_stuck: true,
            ..BRIGHT
        };
        // 0.01 is stuck: 0.008 cannot be reached, and for 0.02 the other layer is good enough.
        assert_eq!(next(&[stuck, DEAR], 0.008), [None, None]);
        let coarse = Known {
            error: 0.02,
            ..BRIGHT
        };
        let next = next(&[stuck, coarse], 0.015);
        assert!(next[0].is_none() && next[1].is_some_and(|one| one >= 0.01 * BRIGHT.tolerance));
    }

    #[test]
    fn faint_layers_begin_with_larger_tolerances() {
        assert_eq!(first_of_layer(1e-5, 1.0), 1e-5);
        // 100^(1 / 1.95) = 10.61.
        assert!((first_of_layer(1e-5, 1e-2) - 1.061e-4).abs() < 1e-7);
    }

    #[test]
    fn work_goes_where_it_lowers_the_error_most() {
        let next = next(&[BRIGHT, DEAR], 1e-3);
        assert!(next[0].unwrap() < BRIGHT.tolerance && next[1].is_none());
        // (1e-3 / 0.01)^(3/2) = 0.032, and a little less to be sure.
        let factor = next[0].unwrap() / BRIGHT.tolerance;
        assert!((0.02..0.032).contains(&factor), "{factor}");
    }

    #[test]
    fn layers_alike_share_the_work() {
        let next = next(&[BRIGHT, BRIGHT], 1e-3);
        assert_eq!(next[0], next[1]);
        assert!(next[0].is_some());
    }

    #[test]
    fn work_grows_with_the_fineness() {
        let next = [Some(1e-6), None];
        // 100^0.55 = 12.589.
        assert!((work(&[BRIGHT, DEAR], &next) - 12.589).abs() < 0.01);
    }
}
