//! Tolerance of the next pass.

/// Misplaced flux that a cell of a pass may have, relative to all flux.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tolerance(pub f64);

/// Power of the tolerance that errors follow, about. Misplaced flux falls like the fourth power of a cell's
/// size in smooth light, and cells at borders are fewer than their texels.
const ERROR_ORDER: f64 = 2.0 / 3.0;

/// Tolerance at which errors are about 1 in the mean over the bundled scenes (`examples/beam-figures`):
/// extrapolated with [`ERROR_ORDER`] from 0.1 % to 10 %.
const TOLERANCE_AT_ONE: f64 = 0.38;

/// Largest error that the first pass is for: with larger cells there is nothing smooth to derive bounds from.
const COARSEST: f64 = 3e-3;

/// Smallest error that the first pass is for. If the scene is harder than most, one pass must end before
/// another can be planned by it.
const FINEST_FIRST: f64 = 1e-3;

/// Power of the tolerance that work grows with: −1/2 in smooth light, faster at borders.
const WORK_ORDER: f64 = 0.55;

/// Ratio of tolerances after which every cell has been divided once more: misplaced flux falls like the
/// fourth power of a cell's size. Such passes can be compared.
pub const DIVIDED_AGAIN: f64 = 16.0;

/// Factor of the tolerance after a pass whose cells were too large to light any texel.
const UNLIT: f64 = 1.0 / 256.0;

/// Ratio to the error asked for below which a small step is likely to do.
const NEARLY_THERE: f64 = 1.6;

/// Smallest tolerance: below it, cells hold so little that sums are rounding.
const LEAST_TOLERANCE: f64 = 1e-14;

impl Tolerance {
    /// The tolerance to begin with, on the way to an error of `target`; as coarse as makes sense if time or
    /// rays are `limited`.
    pub fn first(target: Option<f64>, limited: bool) -> Self {
        let error = match target {
            Some(target) if !limited => target.clamp(FINEST_FIRST, COARSEST),
            _ => COARSEST,
        };
        Self(TOLERANCE_AT_ONE * error.powf(1.0 / ERROR_ORDER))
    }

    /// The next pass, to get the error of this one down to `target`, or further down if there is no target.
    /// `None` if it is down, or nothing is to be gained. `hope` is the part of the estimated error that is
    /// expected to be real.
    pub fn next(self, error: f64, hope: f64, target: Option<f64>) -> Option<Self> {
        if error == 0.0 || target.is_some_and(|target| error <= target) {
            return None;
        }
        let next = match target {
            // A little more than needed, so that one step is enough. A step must be neither too large, nor
            // too small to tell from it how good this pass was.
            Some(target) => {
                let wanted = (0.8 * target / (hope * error)).powf(1.0 / ERROR_ORDER);
                let least = if error < NEARLY_THERE * target {
                    0.25
                } else {
                    1.0 / DIVIDED_AGAIN
                };
                Self(self.0 * wanted.clamp(1e-3, least))
            }
            None => Self(self.0 / 8.0),
        };
        next.is_possible().then_some(next)
    }

    /// The next pass if this one was so coarse that it lit no texel; `None` if none can be finer.
    pub fn finer(self) -> Option<Self> {
        let next = Self(self.0 * UNLIT);
        next.is_possible().then_some(next)
    }

    /// Likely work of the pass `next`, in units of the work of this pass.
    pub fn growth_to(self, next: Self) -> f64 {
        (self.0 / next.0).powf(WORK_ORDER)
    }

    /// The pass `next`, or a coarser one if `next` is likely to take more than `affordable` times the work of
    /// this pass. `None` if the coarser one would hardly be finer than this.
    pub fn towards(self, next: Self, affordable: f64) -> Option<Self> {
        if self.growth_to(next) <= affordable {
            return Some(next);
        }
        let ratio = affordable.powf(1.0 / WORK_ORDER);
        (ratio >= 4.0).then_some(Self(self.0 / ratio))
    }

    fn is_possible(self) -> bool {
        self.0 >= LEAST_TOLERANCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ERROR: f64 = 0.01;

    #[test]
    fn a_pass_that_is_good_enough_is_the_last() {
        let first = Tolerance::first(Some(0.05), false);
        assert_eq!(first.next(ERROR, 1.0, Some(0.02)), None);
        assert!(first.next(ERROR, 0.6, Some(0.009)).is_some());
    }

    #[test]
    fn what_cannot_be_afforded_is_made_as_fine_as_can() {
        let first = Tolerance::first(None, true);
        let next = first.next(ERROR, 1.0, Some(1e-6)).unwrap();
        let growth = first.growth_to(next);
        assert_eq!(first.towards(next, growth * 1.01), Some(next));
        let less = first.towards(next, 5.0).unwrap();
        // Rounding of powers.
        assert!((first.growth_to(less) - 5.0).abs() < 1e-9);
        assert_eq!(first.towards(next, 1.5), None);
    }

    #[test]
    fn a_limit_begins_coarse() {
        let tiny = Some(1e-9);
        assert!(Tolerance::first(tiny, true).0 > Tolerance::first(tiny, false).0);
    }
}
