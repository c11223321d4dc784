//! The nearest hit so far.

use super::Hit;

/// The nearest hit so far, and the distance beyond which hits are of no interest.
#[derive(Clone)]
pub(super) struct Nearest {
    limit: f64,
    hit: Option<Hit>,
}

impl Nearest {
    /// No hit so far, and none wanted at `limit` or beyond.
    #[inline]
    pub(super) fn before(limit: f64) -> Self {
        Self { limit, hit: None }
    }

    /// Hits beyond this distance are of no interest; those at it may be.
    #[inline]
    pub(super) fn limit(&self) -> f64 {
        self.limit
    }

    #[inline]
    pub(super) fn hit(self) -> Option<Hit> {
        self.hit
    }

    /// Takes the hit if it is nearer, or as near and first in (shape, face). This rule does not depend on the
    /// order in which hits are found.
    #[inline]
    pub(super) fn offer(&mut self, hit: Hit) {
        let nearer = hit.distance < self.limit
            || (hit.distance == self.limit
                && self
                    .hit
                    .is_some_and(|best| (hit.shape, hit.face) < (best.shape, best.face)));
        if nearer {
            self.limit = hit.distance;
            self.hit = Some(hit);
        }
    }
}
