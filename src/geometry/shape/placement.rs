//! Checks of the transform that places a shape.

use glam::{DMat4, DVec3};

use crate::geometry::Transform;

/// Reason why a shape cannot be made.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ShapeError {
    /// The transform stretches unevenly or shears.
    #[error(
        "to_world must keep a {plugin} round: only rotation, translation and uniform scale are allowed"
    )]
    NotRound {
        /// Mitsuba's name of the shape.
        plugin: &'static str,
    },
    /// The transform makes the shape so small or large that `f64` cannot hold its squared size.
    #[error(
        "to_world gives the {plugin} a size of {size:e}; allowed is {SMALLEST_SIZE:e} to {LARGEST_SIZE:e}"
    )]
    Size {
        /// Mitsuba's name of the shape.
        plugin: &'static str,
        /// The offending length.
        size: f64,
    },
}

/// Below this the square of a length, multiplied by u², is no longer a normal `f64`.
const SMALLEST_SIZE: f64 = 1e-120;
/// Above this the fourth power of a length overflows.
const LARGEST_SIZE: f64 = 1e70;

/// The largest difference of the squared stretch of a "round" transform between axes, as a fraction.
///
/// Mitsuba 3 warns if an element of the polar factor S is off by more than 1e-6. This compares `SᵀS`, in
/// which such a difference counts twice. Matrices written with seven digits pass.
const ROUNDNESS_TOLERANCE: f64 = 2e-6;

/// The images of the three unit vectors.
pub(super) fn columns(to_world: &Transform) -> [DVec3; 3] {
    let matrix: DMat4 = to_world.matrix();
    [
        matrix.x_axis.truncate(),
        matrix.y_axis.truncate(),
        matrix.z_axis.truncate(),
    ]
}

/// True if two images of unit vectors are equally long.
pub(super) fn equally_long(a: DVec3, b: DVec3) -> bool {
    let (a, b) = (a.length_squared(), b.length_squared());
    (a - b).abs() <= ROUNDNESS_TOLERANCE * a.max(b)
}

/// True if two images of unit vectors are at a right angle.
pub(super) fn perpendicular(a: DVec3, b: DVec3) -> bool {
    a.dot(b).abs() <= ROUNDNESS_TOLERANCE * a.length() * b.length()
}

/// Refuses lengths whose squares would leave the range of `f64`.
pub(super) fn check_size(plugin: &'static str, size: f64) -> Result<(), ShapeError> {
    if (SMALLEST_SIZE..=LARGEST_SIZE).contains(&size) {
        Ok(())
    } else {
        Err(ShapeError::Size { plugin, size })
    }
}
