//! The signatures that polygons are followed for.

use crate::geometry::TraversalCounters;
use crate::reference::beams::refine::Refiner;
use crate::transport::signature::{Event, Signature};

/// A signature that polygons are followed for, with all that is its own.
///
/// Signatures that begin with the same events share the polygons that had these.
pub struct Followed<'f, const N: usize> {
    /// The signature.
    pub signature: Signature,
    /// Misplaced flux \[W\] that a polygon may have.
    pub tolerance: f64,
    /// Refiner of the cells that its polygons are given back to. It has the film and the balance, too.
    pub cells: Refiner<'f, 'f, N>,
}

impl<const N: usize> Followed<'_, N> {
    /// The work done for it, to be added to.
    pub(super) fn counters(&mut self) -> &mut TraversalCounters {
        self.cells.counters_mut()
    }
}

/// The order in which signatures are followed together: those that begin with the same events are side by
/// side, the shortest first.
pub fn by_events(a: Signature, b: Signature) -> std::cmp::Ordering {
    let is_transmission = |event| event == Event::Transmission;
    a.events()
        .map(is_transmission)
        .cmp(b.events().map(is_transmission))
}
