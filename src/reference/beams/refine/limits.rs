//! Limits of the division into cells.

use crate::transport::signature::Signature;

/// Flux, in tolerances, above which a cell needs a [clearance](crate::transport::clearance) to count as one
/// topology: nothing can be in its legs' way. A smaller cell hides no more than a part of this.
const UNCLEARED_TOLERANCES: f64 = 32.0;

/// Part of its signature's flux above which the same holds.
const LARGE_PART: f64 = 1.0 / 128.0;

/// Least part of the first limit that the second one may ask for: for a fainter signature it would take too
/// many cells.
const LEAST_UNCLEARED: f64 = 1.0 / 4096.0;

/// The largest part of a signature's light that a cell may misplace, however faint the signature is. Larger
/// cells hold nothing smooth from which bounds could be made.
const MOST_OF_SIGNATURE: f64 = 1.0 / 64.0;

/// The limits of the division of one signature's light.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
pub struct Limits {
    /// Misplaced flux \[W\] that a cell may have.
    pub tolerance: f64,
    /// Flux \[W\], about, that the signature brings in all. A cell that may hide a good part of it is not
    /// small, whatever the tolerance.
    pub flux: f64,
    /// Largest part of the light that sets out which a path of the signature delivers, as the discovery saw
    /// it. Dark nodes may hide at most twice that.
    pub peak: f64,
}

/// A signature to be followed, and the limits of its division.
pub type Asked = (Signature, Limits);

impl Limits {
    /// Largest part of the signature's light \[W\] that a cell may misplace.
    pub(super) fn most(&self) -> f64 {
        MOST_OF_SIGNATURE * self.flux
    }

    /// Flux \[W\] up to which a cell needs no clearance.
    pub(super) fn uncleared(&self) -> f64 {
        let most = self.tolerance.min(self.most()) * UNCLEARED_TOLERANCES;
        (self.flux * LARGE_PART).clamp(most * LEAST_UNCLEARED, most)
    }
}
