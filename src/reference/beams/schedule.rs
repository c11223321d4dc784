//! Fineness of the next pass.

/// The fineness of a pass's division of light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fineness {
    /// Misplaced flux that a cell may have, relative to all flux.
    pub tolerance: f64,
    /// Places on each area light, in each replicate.
    pub points: u64,
}

/// Relative errors over lit texels, root mean square.
#[derive(Clone, Copy, Debug)]
pub struct Errors {
    /// The error of the division into cells.
    pub deterministic: f64,
    /// The error of places on area lights drawn at random.
    pub random: f64,
}

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

/// Most places that an area light is divided into, in each replicate.
const MOST_POINTS: u64 = 1 << 24;

/// Smallest tolerance: below it, cells hold so little that sums are rounding.
const LEAST_TOLERANCE: f64 = 1e-14;

/// Power of the number n of places with which the random error falls. It is between n^-½ (of independent
/// places) and n^-1½ (of nets and smooth integrands). Folds and shadows that sweep over texels leave about
/// n^-¾, as for nets and functions with jumps.
const POINTS_ORDER: f64 = 0.75;

impl Errors {
    /// Both errors together, which are independent.
    pub fn both(self) -> f64 {
        self.deterministic.hypot(self.random)
    }
}

impl Fineness {
    /// The fineness to begin with, on the way to an error of `target`; as coarse as makes sense if time or
    /// rays are `limited`.
    pub fn first(target: Option<f64>, limited: bool) -> Self {
        let error = match target {
            Some(target) if !limited => target.clamp(FINEST_FIRST, COARSEST),
            _ => COARSEST,
        };
        Self {
            tolerance: TOLERANCE_AT_ONE * error.powf(1.0 / ERROR_ORDER),
            points: 1,
        }
    }

    /// The next pass, to get errors of this one down to `target`, or further down if there is no target.
    /// `None` if they are down, or nothing is to be gained. `hope` is the part of the estimated deterministic
    /// error that is expected to be real. `is_random` is true if there are area lights.
    pub fn next(
        self,
        errors: Errors,
        hope: f64,
        target: Option<f64>,
        is_random: bool,
    ) -> Option<Self> {
        if errors.both() == 0.0 || target.is_some_and(|target| errors.both() <= target) {
            return None;
        }
        let Self { tolerance, points } = self;
        let next = match target {
            // A little more than needed, so that one step is enough. A step must be neither too large, nor
            // too small to tell from it how good this pass was.
            Some(target) if !is_random => {
                let wanted = (0.8 * target / (hope * errors.both())).powf(1.0 / ERROR_ORDER);
                let least = if errors.both() < NEARLY_THERE * target {
                    0.25
                } else {
                    1.0 / DIVIDED_AGAIN
                };
                Self {
                    tolerance: tolerance * wanted.clamp(1e-3, least),
                    points,
                }
            }
            // Half of the squared error to each part. If the cells are finer than needed, coarser ones leave
            // work for more places.
            Some(target) => {
                let share = 0.8 * target * std::f64::consts::FRAC_1_SQRT_2;
                let factor = (share / errors.deterministic).powf(1.0 / ERROR_ORDER);
                let doublings = (errors.random / share).log2() / POINTS_ORDER;
                Self {
                    tolerance: tolerance * factor.clamp(0.02, 4.0),
                    points: points << doublings.ceil().clamp(0.0, 3.0) as u32,
                }
            }
            None if errors.random > errors.deterministic => Self {
                tolerance,
                points: 2 * points,
            },
            None => Self {
                tolerance: tolerance / 8.0,
                points,
            },
        };
        next.is_possible().then_some(next)
    }

    /// The next pass if this one was so coarse that it lit no texel; `None` if none can be finer. `is_random`
    /// is true if there are area lights.
    pub fn finer(self, is_random: bool) -> Option<Self> {
        let next = Self {
            tolerance: self.tolerance * UNLIT,
            points: self.points << if is_random { 3 } else { 0 },
        };
        next.is_possible().then_some(next)
    }

    /// Likely work of the pass `next`, in units of the work of this pass.
    pub fn growth_to(self, next: Self) -> f64 {
        (self.tolerance / next.tolerance).powf(WORK_ORDER)
            * (next.points as f64 / self.points as f64)
    }

    /// The pass `next`, or a coarser one if `next` is likely to take more than `affordable` times the work of
    /// this pass. `None` if the coarser one would hardly be finer than this.
    pub fn towards(self, next: Self, affordable: f64) -> Option<Self> {
        if self.growth_to(next) <= affordable {
            return Some(next);
        }
        let ratio = affordable.powf(1.0 / WORK_ORDER);
        let less = Self {
            tolerance: self.tolerance / ratio,
            ..next
        };
        (next.points == self.points && ratio >= 4.0).then_some(less)
    }

    fn is_possible(self) -> bool {
        self.tolerance >= LEAST_TOLERANCE && self.points <= MOST_POINTS
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ERRORS: Errors = Errors {
        deterministic: 0.01,
        random: 0.0,
    };

    #[test]
    fn a_pass_that_is_good_enough_is_the_last() {
        let first = Fineness::first(Some(0.05), false);
        assert_eq!(first.next(ERRORS, 1.0, Some(0.02), false), None);
        assert!(first.next(ERRORS, 0.6, Some(0.009), false).is_some());
    }

    #[test]
    fn what_cannot_be_afforded_is_made_as_fine_as_can() {
        let first = Fineness::first(None, true);
        let next = first.next(ERRORS, 1.0, Some(1e-6), false).unwrap();
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
        assert!(Fineness::first(tiny, true).tolerance > Fineness::first(tiny, false).tolerance);
    }
}
