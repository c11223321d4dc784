//! Is the truth good enough to judge by?
//!
//! A row's error is known only as far as the truth is: the truth's own error must be a tenth of it at most. Else the report
//! says "not resolved" in that row, and no order is fitted to it.

use super::facts::Facts;
use crate::film::Image;
use crate::metric::LayerComparison;

/// The truth's error may be so large a part of an error that it judges. By then it changes it by 10 % where both have one sign
/// everywhere, and by √(1 + 0.01), half a percent, where they are independent.
pub const LARGEST_SHARE: f64 = 0.1;

/// The truth's error in the terms of a row: relative, over the truth's lit texels.
///
/// With σ the root mean square over all N texels of what is known of the truth's error, r̄ the mean over the n lit ones,
///
/// ```text
/// e = σ √(N / n) / r̄
/// ```
///
/// which is to [`relative_rmse`](crate::metric::difference::Difference::relative_rmse) as σ is to the root mean square difference.
/// Direct light that is the same in both films to the last bit (references share a quadrature) has no part in their
/// difference, and none in σ. `None` where the truth does not know its error, or is dark.
pub fn error(truth: &Facts, is_direct_shared: bool, comparison: &LayerComparison) -> Option<f64> {
    let direct = if is_direct_shared {
        0.0
    } else {
        truth.spread.direct
    };
    let sigma = truth.spread.specular?.hypot(direct);
    let difference = &comparison.difference;
    let texels = (comparison.size[0] * comparison.size[1]) as f64;
    let lit = difference.lit as f64;
    (lit > 0.0).then(|| sigma * (texels / lit).sqrt() / difference.mean_lit)
}

/// Whether an error is resolved by a truth that errs so much.
pub fn resolves(truth: Option<f64>, error: Option<f64>) -> bool {
    matches!((truth, error), (Some(truth), Some(error)) if truth <= LARGEST_SHARE * error && error > 0.0)
}

/// Whether two films have the same direct light, bit by bit.
pub fn shares_direct(one: &Image, other: &Image) -> bool {
    ["LD.R", "LD.G", "LD.B"].iter().all(|name| {
        matches!((one.channel(name), other.channel(name)), (Some(a), Some(b)) if a.samples == b.samples)
    })
}
