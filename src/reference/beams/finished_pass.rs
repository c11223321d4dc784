//! Results of one pass, for the next one and for the estimate.

use super::pass::SignatureReport;
use super::schedule::Tolerance;
use super::sums::Sums;
use crate::transport::signature::Signature;

/// A finished pass.
pub(super) struct FinishedPass {
    /// One entry a signature with a layer of its own, brightest first, then one of all others, if any.
    pub layers: Vec<(Option<Signature>, Sums)>,
    /// Their sum.
    pub total: Sums,
    /// One entry a signature followed.
    pub reports: Vec<SignatureReport>,
    /// Relative error over lit texels, root mean square; `None` if no texel is lit.
    pub error: Option<f64>,
    pub tolerance: Tolerance,
}
