//! How fine the next pass is to be.

/// How finely light is divided in a pass.
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
    /// Of the division into cells.
    pub deterministic: f64,
    /// Of places on area lights drawn by lot.
    pub random: f64,
}

/// Errors follow tolerances about like this power of them: misplaced flux falls like the fourth power
/// of a cell's size where light is smooth, and cells at borders are fewer than their texels.
const ERROR_ORDER: f64 = 2.0 / 3.0;

/// The tolerance at which errors are about 1 in the mean over the bundled scenes
/// (`examples/beam-figures`): extrapolated with [`ERROR_ORDER`] from 0.1 % to 10 %.
const TOLERANCE_AT_ONE: f64 = 0.38;

/// The first pass is for an error of no more than this: with larger cells there is nothing smooth for
/// bounds to be made from.
const COARSEST: f64 = 3e-3;

/// ... and of no less: where the scene is harder than most, one pass must end for another to be
/// planned by it.
const FINEST_FIRST: f64 = 1e-3;

/// Work grows like the tolerance's power −1/2 where light is smooth, faster at borders.
const WORK_ORDER: f64 = 0.55;

/// Where tolerances are this far apart, every cell has been divided once more: misplaced flux falls like the
/// fourth power of a cell's size. Such passes can be compared.
pub const DIVIDED_AGAIN: f64 = 16.0;

/// Where cells were too large to light any texel, the next ones misplace at most this part.
const UNLIT: f64 = 1.0 / 256.0;

/// Where the error asked for is nearer than this, a small step is likely to do.
const NEARLY_THERE: f64 = 1.6;

/// A lamp is not divided into more places, in each replicate.
const MOST_POINTS: u64 = 1 << 24;

/// Below this, cells hold so little that sums are rounding.
const LEAST_TOLERANCE: f64 = 1e-14;

/// How the random error falls with the number n of places is between n^-½ (of independent ones)
/// and n^-1½ (of nets and smooth integrands); folds and shadows that sweep over texels leave about
/// n^-¾, as of nets and functions with jumps.
const POINTS_ORDER: f64 = 0.75;

impl Errors {
    /// Together: they know nothing of each other.
    pub fn both(self) -> f64 {
        self.deterministic.hypot(self.random)
    }
}

impl Fineness {
    /// What to begin with, on the way to an error of `target`; as coarse as makes sense where time or
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

    /// The next pass, to get errors of this one down to `target`, or without one further down; `None`
    /// where they are, or nothing is to be gained. The deterministic one is hoped to be this part of
    /// what it is said to be: `hope`. `by_lot` where there are area lights.
    pub fn next(
        self,
        errors: Errors,
        hope: f64,
        target: Option<f64>,
        by_lot: bool,
    ) -> Option<Self> {
        if errors.both() == 0.0 || target.is_some_and(|target| errors.both() <= target) {
            return None;
        }
        let Self { tolerance, points } = self;
        let next = match target {
            // A little more than needed, so that one step is enough; never too large a step, nor one
            // too small to tell from it how good this pass was.
            Some(target) if !by_lot => {
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
            // Half of the squared error to each part. Where the cells are finer than needed, coarser
            // ones will do for more places.
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

    /// The next pass where this one was so coarse that it lit no texel; `None` where none can be finer. `by_lot` where
    /// there are area lights.
    pub fn finer(self, by_lot: bool) -> Option<Self> {
        let next = Self {
            tolerance: self.tolerance * UNLIT,
            points: self.points << if by_lot { 3 } else { 0 },
        };
        next.is_possible().then_some(next)
    }

    /// How many times the work of this pass `next` is likely to be.
    pub fn growth_to(self, next: Self) -> f64 {
        (self.tolerance / next.tolerance).powf(WORK_ORDER)
            * (next.points as f64 / self.points as f64)
    }

    /// `next`, or where that is likely to be more than `affordable` times the work of this pass, what is
    /// not; `None` where that is no finer to speak of.
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
