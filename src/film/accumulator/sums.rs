//! Sums of deposits over replicates, and their means.

use std::io;
use std::sync::atomic::{AtomicBool, AtomicI64, AtomicU64, Ordering};

use rayon::prelude::*;

use crate::numeric::FixedPoint;
use crate::numeric::wide::{Wide, quotient};

/// Sums of deposits on the texels of one layer, and the sums that their error bars need.
///
/// A *replicate* is one independent estimate of the whole layer. Its deposits are integers (quanta of a
/// [`FixedPoint`] scale) that all threads add with [`Accumulator::deposit`]; [`Accumulator::flush`] ends it.
/// Integer sums commute, and nothing is rounded before [`Accumulator::estimate`]. So the same deposits give
/// the same bits in any order, on any number of threads, and in any number of shards joined by
/// [`Accumulator::merge`].
///
/// With S the sum of one replicate at one texel, Σ runs over replicates; ΣS and ΣS² are kept.
///
/// **Range.** A scale from [`FixedPoint::for_total`] of the emitted flux keeps |S| ≤ 2⁶⁰ (all light on one
/// texel), so that S² ≤ 2¹²⁰ and 255 such replicates fit the 128 bits of ΣS². If a texel gets up to 2⁶² (four
/// times the total), 15 do. Beyond, `flush` and `merge` return [`AccumulatorError::Overflow`]; nothing wraps
/// silently.
///
/// **Memory.** 40 bytes a texel and channel (8 for S, 16 for ΣS, 16 for ΣS²), and 8 a texel for counts.
#[derive(Debug)]
pub struct Accumulator {
    pub(super) texels: usize,
    pub(super) channels: usize,
    pub(super) scale: FixedPoint,
    pub(super) replicates: u32,
    /// S of the replicate under way; texel by texel, its channels side by side.
    pub(super) current: Vec<AtomicI64>,
    /// True if any S left `i64` in the replicate under way.
    pub(super) current_overflowed: AtomicBool,
    pub(super) sums: Vec<i128>,
    pub(super) sums_of_squares: Vec<u128>,
    /// Deposits a texel, if wanted.
    pub(super) counts: Option<Vec<AtomicU64>>,
}

/// A mean over replicates and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReplicateMean {
    /// ΣS/R in the unit of the deposits, correctly rounded; NaN before the first replicate.
    pub mean: f64,
    /// The standard error of the mean, same unit; `None` for fewer than two replicates.
    pub standard_error: Option<f64>,
}

/// Reason why there are no sums.
#[derive(Debug, thiserror::Error)]
pub enum AccumulatorError {
    /// A sum left its integer.
    #[error(
        "a texel's sum overflows: {0}; use fewer replicates, or a fixed-point scale for a larger total"
    )]
    Overflow(&'static str),
    /// The sums belong to different layers.
    #[error("accumulators differ in {field}: {left} and {right}")]
    Mismatch {
        /// The field that differs.
        field: &'static str,
        /// Its value here.
        left: String,
        /// Its value in the other accumulator.
        right: String,
    },
    /// Deposits that no flush has ended.
    #[error("a replicate is under way: flush it first")]
    ReplicateUnderWay,
    /// Bytes that are not a written accumulator.
    #[error("not a valid accumulator: {0}")]
    Malformed(String),
    /// The system refused.
    #[error(transparent)]
    Io(#[from] io::Error),
}

impl Accumulator {
    /// Empty sums for `texels` texels of `channels` channels (1 for grey light, 3 for RGB) each.
    pub fn new(texels: usize, channels: usize, scale: FixedPoint) -> Self {
        let length = texels * channels;
        Self {
            texels,
            channels,
            scale,
            replicates: 0,
            current: zeros(length),
            current_overflowed: AtomicBool::new(false),
            sums: vec![0; length],
            sums_of_squares: vec![0; length],
            counts: None,
        }
    }

    /// Also counts the deposits of each texel.
    #[must_use]
    pub fn with_counts(mut self) -> Self {
        self.counts = Some(zeros(self.texels));
        self
    }

    /// Number of texels.
    pub const fn texels(&self) -> usize {
        self.texels
    }

    /// Number of channels a texel.
    pub const fn channels(&self) -> usize {
        self.channels
    }

    /// The scale of a deposit's integers.
    pub const fn scale(&self) -> FixedPoint {
        self.scale
    }

    /// Number of replicates in the sums: ended by [`Accumulator::flush`], here or in merged accumulators.
    pub const fn replicates(&self) -> u32 {
        self.replicates
    }

    /// Adds quanta to the channels of a texel, from any thread; returns true if it did.
    ///
    /// Nothing is added for a texel outside, or if `CHANNELS` is not the number of channels: light that would
    /// be lost, for the caller to account for.
    #[inline]
    #[must_use]
    pub fn deposit<const CHANNELS: usize>(&self, texel: usize, quanta: [i64; CHANNELS]) -> bool {
        if texel >= self.texels || CHANNELS != self.channels {
            return false;
        }
        let first = texel * CHANNELS;
        for (sum, addend) in self.current[first..first + CHANNELS].iter().zip(quanta) {
            // Relaxed: integer sums need no order, and the threads' join publishes them.
            let before = sum.fetch_add(addend, Ordering::Relaxed);
            if before.checked_add(addend).is_none() {
                self.current_overflowed.store(true, Ordering::Relaxed);
            }
        }
        self.count_deposit(texel);
        true
    }

    /// Counts a deposit on a texel if counts are wanted, without its quanta: for one that comes by
    /// [`Accumulator::deposit_all`]. Nothing is counted for a texel outside.
    #[inline]
    pub fn count_deposit(&self, texel: usize) {
        if let Some(count) = self.counts.as_ref().and_then(|counts| counts.get(texel)) {
            count.fetch_add(1, Ordering::Relaxed);
        }
    }

    /// Adds the whole replicate under way of `other` to this one's.
    ///
    /// # Errors
    ///
    /// If texels, channels or scale differ.
    pub fn deposit_all(&mut self, other: &Self) -> Result<(), AccumulatorError> {
        self.check_like(other)?;
        let overflowed = self
            .current
            .par_iter_mut()
            .zip(&other.current)
            .map(|(sum, addend)| {
                let sum = sum.get_mut();
                let addend = addend.load(Ordering::Relaxed);
                if addend == 0 {
                    return false;
                }
                let overflowed;
                (*sum, overflowed) = sum.overflowing_add(addend);
                overflowed
            })
            .reduce(|| false, |a, b| a | b);
        *self.current_overflowed.get_mut() |=
            overflowed || other.current_overflowed.load(Ordering::Relaxed);
        Ok(())
    }

    /// Drops the replicate under way; counts of its deposits stay.
    pub fn discard(&mut self) {
        self.current
            .par_iter_mut()
            .for_each(|sum| *sum.get_mut() = 0);
        *self.current_overflowed.get_mut() = false;
    }

    /// Ends a replicate: adds S to ΣS and S² to ΣS² everywhere, and clears S.
    ///
    /// # Errors
    ///
    /// [`AccumulatorError::Overflow`]; the sums are of no use then.
    pub fn flush(&mut self) -> Result<(), AccumulatorError> {
        if *self.current_overflowed.get_mut() {
            return Err(AccumulatorError::Overflow("one replicate exceeds 63 bits"));
        }
        self.replicates = self
            .replicates
            .checked_add(1)
            .ok_or(AccumulatorError::Overflow("too many replicates"))?;
        self.current
            .par_iter_mut()
            .zip(&mut self.sums)
            .zip(&mut self.sums_of_squares)
            .try_for_each(|((current, sum), sum_of_squares)| {
                let replicate = std::mem::take(current.get_mut());
                // Many layers are dark nearly everywhere.
                if replicate == 0 {
                    return Some(());
                }
                // 2^63 for each of at most 2^32 replicates: far below 2^127.
                *sum += i128::from(replicate);
                let square = u128::from(replicate.unsigned_abs()).pow(2);
                *sum_of_squares = sum_of_squares.checked_add(square)?;
                Some(())
            })
            .ok_or(AccumulatorError::Overflow(
                "squares of all replicates exceed 128 bits",
            ))
    }

    /// Adds the replicates of `other`, exactly: for shards of one run, by replicates.
    ///
    /// # Errors
    ///
    /// If texels, channels or scale differ, if a replicate is under way on either side, and on overflow (the
    /// sums are of no use then).
    pub fn merge(&mut self, other: &Self) -> Result<(), AccumulatorError> {
        self.check_like(other)?;
        if self.counts.is_some() != other.counts.is_some() {
            let counts = |a: &Self| {
                if a.counts.is_some() {
                    "with"
                } else {
                    "without"
                }
                .to_owned()
            };
            return Err(AccumulatorError::Mismatch {
                field: "counts",
                left: counts(self),
                right: counts(other),
            });
        }
        if self.is_under_way() || other.is_under_way() {
            return Err(AccumulatorError::ReplicateUnderWay);
        }
        self.replicates = self
            .replicates
            .checked_add(other.replicates)
            .ok_or(AccumulatorError::Overflow("too many replicates"))?;
        self.sums
            .par_iter_mut()
            .zip(&other.sums)
            .zip(
                self.sums_of_squares
                    .par_iter_mut()
                    .zip(&other.sums_of_squares),
            )
            .try_for_each(|((sum, addend), (squares, more_squares))| {
                *sum = sum.checked_add(*addend)?;
                *squares = squares.checked_add(*more_squares)?;
                Some(())
            })
            .ok_or(AccumulatorError::Overflow(
                "squares of all replicates exceed 128 bits",
            ))?;
        if let (Some(counts), Some(others)) = (&mut self.counts, &other.counts) {
            for (count, addend) in counts.iter_mut().zip(others) {
                let count = count.get_mut();
                *count = count
                    .checked_add(addend.load(Ordering::Relaxed))
                    .ok_or(AccumulatorError::Overflow("more than 2^64 deposits"))?;
            }
        }
        Ok(())
    }

    /// The mean over replicates of one texel's channel and its standard error; `None` outside.
    ///
    /// ```text
    /// mean = ΣS / R        standard error = √( (R ΣS² − (ΣS)²) / (R² (R − 1)) )
    /// ```
    ///
    /// The numerator is computed in integers of 256 bits: nothing cancels, and equal replicates give an error
    /// of exactly zero.
    pub fn estimate(&self, texel: usize, channel: usize) -> Option<ReplicateMean> {
        if channel >= self.channels {
            return None;
        }
        let index = texel * self.channels + channel;
        let (sum, sum_of_squares) = (*self.sums.get(index)?, self.sums_of_squares[index]);
        let quantum = self.scale.quantum();
        let replicates = f64::from(self.replicates);
        let standard_error = (self.replicates > 1).then(|| {
            let squared_sum = Wide::product(sum.unsigned_abs(), sum.unsigned_abs());
            let numerator = Wide::product(sum_of_squares, self.replicates.into())
                .checked_sub(squared_sum)
                // Cauchy and Schwarz forbid a negative one in sums that were made by `flush`.
                .map_or(f64::NAN, Wide::to_f64);
            (numerator / (replicates - 1.0)).sqrt() / replicates * quantum
        });
        Some(ReplicateMean {
            mean: quotient(sum, self.replicates.into()) * quantum,
            standard_error,
        })
    }

    /// ΣS of one texel's channel in quanta: exact, for ledgers. `None` outside.
    pub fn sum(&self, texel: usize, channel: usize) -> Option<i128> {
        if channel >= self.channels {
            return None;
        }
        self.sums.get(texel * self.channels + channel).copied()
    }

    /// Number of deposits that a texel got; `None` outside or without [`Accumulator::with_counts`].
    pub fn count(&self, texel: usize) -> Option<u64> {
        Some(self.counts.as_ref()?.get(texel)?.load(Ordering::Relaxed))
    }

    /// Refuses sums that do not have the same meaning as these.
    ///
    /// # Errors
    ///
    /// If texels, channels or scale differ.
    pub fn check_like(&self, other: &Self) -> Result<(), AccumulatorError> {
        let layout = |a: &Self| {
            [
                ("texels", a.texels.to_string()),
                ("channels", a.channels.to_string()),
                (
                    "the exponent of their quantum",
                    a.scale.exponent().to_string(),
                ),
            ]
        };
        for ((field, left), (_, right)) in layout(self).into_iter().zip(layout(other)) {
            if left != right {
                return Err(AccumulatorError::Mismatch { field, left, right });
            }
        }
        Ok(())
    }

    /// True if any deposit waits for its flush.
    pub(super) fn is_under_way(&self) -> bool {
        self.current_overflowed.load(Ordering::Relaxed)
            || self
                .current
                .par_iter()
                .any(|sum| sum.load(Ordering::Relaxed) != 0)
    }
}

/// Atomic zeros.
pub(super) fn zeros<T: Default>(length: usize) -> Vec<T> {
    std::iter::repeat_with(T::default).take(length).collect()
}
