//! The coordinates of a tree.

use glam::DVec3;

use crate::geometry::Bounds;
use crate::numeric::math;

/// Coordinates in which a tree's boxes lie within the cube [-1, 1]³.
///
/// Its scale is a power of two, so that it rounds nothing and worlds of any size look the same.
#[derive(Clone, Copy, Debug)]
pub(in crate::geometry) struct TreeFrame {
    pub center: DVec3,
    /// Number of local units in a world unit.
    pub scale: f64,
}

impl TreeFrame {
    /// World space itself.
    pub(super) const WORLD: Self = Self {
        center: DVec3::ZERO,
        scale: 1.0,
    };

    pub(super) fn around(bounds: &Bounds) -> Self {
        let center = bounds.center();
        // The reach is measured from the rounded center, both ways.
        let reach = (bounds.max - center).max(center - bounds.min).max_element();
        let scale = if reach > 0.0 {
            math::exp2(-math::log2(reach).ceil())
        } else {
            1.0
        };
        Self { center, scale }
    }

    pub(in crate::geometry) fn to_local(self, point: DVec3) -> DVec3 {
        (point - self.center) * self.scale
    }
}
