//! How finely cells are divided.

/// A cell with more tolerances of flux than this is taken for one topology only if nothing can be in
/// the way of any of its legs, as its [clearance](crate::transport::clearance) knows; a smaller one hides no
/// more than a part of this.
const UNCLEARED_TOLERANCES: f64 = 8.0;

/// ... and with no more than this part of its signature's flux, ...
const LARGE_PART: f64 = 1.0 / 128.0;

/// ... unless the signature is so faint that this would take too many cells.
const LEAST_UNCLEARED: f64 = 1.0 / 4096.0;

/// How finely one signature's cells are divided.
#[derive(Clone, Copy, Debug)]
pub struct Limits {
    /// Misplaced flux that a cell may have \[W\].
    pub tolerance: f64,
    /// About what the signature brings in all \[W\]: a cell that may hide a good part of it is no
    /// small one, whatever the tolerance.
    pub flux: f64,
    /// The most that a path of the signature delivers of what sets out, as a discovery saw it: what
    /// may be hidden between dark nodes is at most twice that.
    pub peak: f64,
}

impl Limits {
    /// Flux \[W\] up to which a cell need not be cleared.
    pub(super) fn uncleared(&self) -> f64 {
        let most = self.tolerance * UNCLEARED_TOLERANCES;
        (self.flux * LARGE_PART).clamp(most * LEAST_UNCLEARED, most)
    }
}
