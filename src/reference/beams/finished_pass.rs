//! Results of one pass, for the next one and for the estimate.

use super::average::Average;
use super::pass::SignatureReport;
use super::schedule::{Errors, Fineness};
use crate::transport::signature::Signature;

/// A finished pass.
pub(super) struct FinishedPass {
    /// One entry a signature with a layer of its own, brightest first, then one of all others, if any.
    pub layers: Vec<(Option<Signature>, Average)>,
    /// Their sum.
    pub total: Average,
    /// One entry a signature followed.
    pub reports: Vec<(Signature, SignatureReport)>,
    pub errors: Option<Errors>,
    pub fineness: Fineness,
}
