//! Faces of a cube about a point: directions by coordinates on them.

use glam::{DVec2, DVec3};

use super::patch::ChartPatch;
use super::probe::Probe;
use crate::numeric::math;

/// The unit vector through a point of a cube-map face, and solid angle per unit of face area there: (1 + x² +
/// y²)^(−3/2).
#[inline]
pub(super) fn face_sample(axes: &[DVec3; 3], place: DVec2) -> (DVec3, f64) {
    let inverse_length = 1.0 / (1.0 + place.length_squared()).sqrt();
    let direction = (axes[0] * place.x + axes[1] * place.y + axes[2]) * inverse_length;
    (direction, inverse_length * inverse_length * inverse_length)
}

/// Solid angle \[sr\] of a patch of a cube-map face.
///
/// Ω = Σ ± atan(x y / √(1 + x² + y²)) over the corners, with plus if x and y are both a patch's high or both
/// its low coordinates.
pub(super) fn rectangle_solid_angle(patch: &ChartPatch) -> f64 {
    let corner = |x: f64, y: f64| math::atan2(x * y, (1.0 + x * x + y * y).sqrt());
    corner(patch.to.x, patch.to.y)
        - corner(patch.from.x, patch.to.y)
        - corner(patch.to.x, patch.from.y)
        + corner(patch.from.x, patch.from.y)
}

/// The pyramid of a patch of a face about `apex`.
pub(super) fn face_frustum(
    apex: DVec3,
    apex_radius: f64,
    axes: &[DVec3; 3],
    patch: &ChartPatch,
) -> Probe {
    let [x, y, z] = *axes;
    Probe::Frustum {
        apex,
        // Each plane holds the apex and one edge of the patch.
        inward: [
            (x - z * patch.from.x).normalize(),
            (z * patch.to.x - x).normalize(),
            (y - z * patch.from.y).normalize(),
            (z * patch.to.y - y).normalize(),
        ],
        apex_radius,
    }
}
