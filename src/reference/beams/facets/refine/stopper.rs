//! Things that end polygons before their goal.

use crate::reference::beams::facets::polygon::LegEnd;

/// A thing that ends a polygon.
#[derive(Clone, Copy, Debug)]
pub(super) enum Stopper {
    /// A facet that light does not go on from.
    Facet(u32),
    /// A shape that is not flat.
    Shape(u32),
}

impl From<Stopper> for LegEnd {
    fn from(stopper: Stopper) -> Self {
        match stopper {
            Stopper::Facet(facet) => Self::Facet(facet),
            Stopper::Shape(shape) => Self::Blocked(shape),
        }
    }
}
