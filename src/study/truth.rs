//! The test that the truth is good enough to judge by.
//!
//! A row's error is known only as far as the truth is: the truth's own error must be a tenth of it at most.
//! Otherwise the report says "not resolved" in that row, and no order is fitted to it.

use super::facts::Facts;
use crate::film::Image;
use crate::metric::LayerComparison;

/// The largest ratio of the truth's error to an error that it judges. At this ratio it changes the error by
/// 10 % if both have one sign everywhere. If they are independent it changes it by √(1 + 0.01), half a
/// percent.
pub const LARGEST_SHARE: f64 = 0.1;

/// The truth's likely error in the terms of a row: of L1, as a part of the truth's light.
///
/// With σ the root mean square over all texels of the truth's known error and r̄ its mean over them,
///
/// ```text
/// e = σ / r̄
/// ```
///
/// which L1 does not exceed: a mean is no larger than the root of the mean square. References share a
/// quadrature: direct light can be the same in both films to the last bit. It then has no part in their
/// difference, and none in σ. `None` if the truth does not know its error, or is dark.
pub fn error(truth: &Facts, is_direct_shared: bool, comparison: &LayerComparison) -> Option<f64> {
    let direct = if is_direct_shared {
        0.0
    } else {
        truth.spread.direct
    };
    let sigma = truth.spread.specular?.hypot(direct);
    let mean = comparison.difference.mean_reference;
    (mean > 0.0).then(|| sigma / mean)
}

/// True if a truth with this error resolves an error.
pub fn resolves(truth: Option<f64>, error: Option<f64>) -> bool {
    matches!((truth, error), (Some(truth), Some(error)) if truth <= LARGEST_SHARE * error && error > 0.0)
}

/// True if two films have the same direct light, bit by bit.
pub fn shares_direct(one: &Image, other: &Image) -> bool {
    ["LD.R", "LD.G", "LD.B"].iter().all(|name| {
        matches!((one.channel(name), other.channel(name)), (Some(a), Some(b)) if a.samples == b.samples)
    })
}
