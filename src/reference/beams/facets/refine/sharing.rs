//! What the signatures of a polygon share, and where they part.

use std::ops::Range;

use super::refiner::FacetRefiner;
use crate::reference::beams::facets::polygon::LightPolygon;
use crate::transport::signature::{Event, Signature};

/// The order in which signatures are followed together: those that begin with the same events are side by
/// side, the shortest first.
pub fn by_events(a: Signature, b: Signature) -> std::cmp::Ordering {
    let is_transmission = |event| event == Event::Transmission;
    a.events()
        .map(is_transmission)
        .cmp(b.events().map(is_transmission))
}

impl<const N: usize> FacetRefiner<'_, '_, '_, N> {
    /// True if a polygon had all events of its signature; then it has no other.
    pub(super) fn has_all_events(&self, polygon: &LightPolygon<N>) -> bool {
        self.cells[polygon.signatures.start].signature().len() == polygon.chain.events()
    }

    /// Misplaced flux \[W\] that a polygon may have for all of its signatures.
    pub(super) fn tolerance(&self, polygon: &LightPolygon<N>) -> f64 {
        let cells = self.cells[polygon.signatures.clone()].iter();
        cells
            .map(|one| one.limits().tolerance)
            .fold(f64::INFINITY, f64::min)
    }

    /// The ways on from a polygon on its next facet: an event, and the signatures that go on together after
    /// it. One that ends with the event goes alone.
    pub(super) fn ways_on(&self, polygon: &LightPolygon<N>) -> Vec<(Event, Range<usize>)> {
        let events = polygon.chain.events();
        let way = |index: usize| {
            let signature = self.cells[index].signature();
            let event = signature.events().nth(events)?;
            Some((event, signature.len() == events + 1))
        };
        let mut ways: Vec<(Event, Range<usize>)> = Vec::new();
        let mut last = None;
        for index in polygon.signatures.clone() {
            let this = way(index);
            let Some((event, _)) = this else {
                continue;
            };
            match ways.last_mut() {
                Some((_, range)) if this == last => range.end = index + 1,
                _ => ways.push((event, index..index + 1)),
            }
            last = this;
        }
        ways
    }
}
