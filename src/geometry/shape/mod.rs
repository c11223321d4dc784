//! The forms that surfaces have.

mod cylinder;
mod disk;
mod rectangle;
mod sphere;

use glam::{DMat4, DVec2, DVec3};

use super::{Bounds, Mesh, Ray, SurfacePoint, Transform};

pub use cylinder::Cylinder;
pub use disk::Disk;
pub use rectangle::Rectangle;
pub use sphere::Sphere;

/// A surface.
#[derive(Clone, Debug)]
pub enum Shape {
    /// A sphere.
    Sphere(Sphere),
    /// A parallelogram.
    Rectangle(Rectangle),
    /// A flat disc.
    Disk(Disk),
    /// An open tube.
    Cylinder(Cylinder),
    /// Triangles.
    Mesh(Mesh),
}

impl Shape {
    /// The smallest axis-aligned box round it, rounded outward so that it holds every hit point.
    pub fn bounds(&self) -> Bounds {
        match self {
            Self::Sphere(sphere) => sphere.bounds(),
            Self::Rectangle(rectangle) => rectangle.bounds(),
            Self::Disk(disk) => disk.bounds(),
            Self::Cylinder(cylinder) => cylinder.bounds(),
            Self::Mesh(mesh) => mesh.bounds(),
        }
    }

    /// The surface's area in square scene units.
    pub fn area(&self) -> f64 {
        match self {
            Self::Sphere(sphere) => sphere.area(),
            Self::Rectangle(rectangle) => rectangle.area(),
            Self::Disk(disk) => disk.area(),
            Self::Cylinder(cylinder) => cylinder.area(),
            Self::Mesh(mesh) => mesh.area(),
        }
    }
}

impl Shape {
    /// The surface at Mitsuba's parameters `uv`, both in 0..=1; `None` for meshes.
    #[inline]
    pub fn at_uv(&self, uv: DVec2) -> Option<SurfacePoint> {
        match self {
            Self::Sphere(sphere) => Some(sphere.at_uv(uv)),
            Self::Rectangle(rectangle) => Some(rectangle.at_uv(uv)),
            Self::Disk(disk) => Some(disk.at_uv(uv)),
            Self::Cylinder(cylinder) => Some(cylinder.at_uv(uv)),
            Self::Mesh(_) => None,
        }
    }
}

impl Shape {
    /// A point of the plane that a rectangle or disc lies in, and its unit normal; `None` for other
    /// shapes.
    #[inline]
    pub fn plane(&self) -> Option<[DVec3; 2]> {
        match self {
            Self::Rectangle(rectangle) => Some([rectangle.center(), rectangle.normal()]),
            Self::Disk(disk) => Some([disk.center(), disk.normal()]),
            Self::Sphere(_) | Self::Cylinder(_) | Self::Mesh(_) => None,
        }
    }

    /// Where a ray meets that plane, beyond the shape's border too: the distance, > 0, and the surface
    /// parameters, which go on there as they do within. `None` where it does not, and for other shapes.
    #[inline]
    pub fn meet_beyond(&self, ray: &Ray) -> Option<(f64, DVec2)> {
        match self {
            Self::Rectangle(rectangle) => rectangle.meet_beyond(ray),
            Self::Disk(disk) => disk.meet_beyond(ray),
            Self::Sphere(_) | Self::Cylinder(_) | Self::Mesh(_) => None,
        }
    }
}

/// Why a shape cannot be made.
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

/// How far the squared stretch of a "round" transform may differ between axes, as a fraction.
///
/// Mitsuba 3 warns when an element of the polar factor S is off by more than 1e-6; this compares
/// `SᵀS`, where such a difference counts twice. Matrices written with seven digits pass.
const ROUNDNESS_TOLERANCE: f64 = 2e-6;

/// The images of the three unit vectors.
fn columns(to_world: &Transform) -> [DVec3; 3] {
    let matrix: DMat4 = to_world.matrix();
    [
        matrix.x_axis.truncate(),
        matrix.y_axis.truncate(),
        matrix.z_axis.truncate(),
    ]
}

/// Whether two images of unit vectors are equally long.
fn equally_long(a: DVec3, b: DVec3) -> bool {
    let (a, b) = (a.length_squared(), b.length_squared());
    (a - b).abs() <= ROUNDNESS_TOLERANCE * a.max(b)
}

/// Whether two images of unit vectors are at a right angle.
fn perpendicular(a: DVec3, b: DVec3) -> bool {
    a.dot(b).abs() <= ROUNDNESS_TOLERANCE * a.length() * b.length()
}

/// Refuses lengths whose squares would leave the range of `f64`.
fn check_size(plugin: &'static str, size: f64) -> Result<(), ShapeError> {
    if (SMALLEST_SIZE..=LARGEST_SIZE).contains(&size) {
        Ok(())
    } else {
        Err(ShapeError::Size { plugin, size })
    }
}

/// An angle as a fraction of a full turn, in `0..1`.
fn turn_fraction(y: f64, x: f64) -> f64 {
    let turns = y.atan2(x) * std::f64::consts::FRAC_1_PI * 0.5;
    // A negative angle of less than u rounds up to a full turn: that is angle 0.
    let wrapped = if turns < 0.0 { turns + 1.0 } else { turns };
    if wrapped < 1.0 { wrapped } else { 0.0 }
}

/// Where a ray meets a plane: (distance, hit − `center`), unless it runs along the plane or the
/// plane lies behind.
#[inline]
pub(in crate::geometry) fn meet_plane(
    ray: &Ray,
    center: DVec3,
    normal: DVec3,
) -> Option<(f64, DVec3)> {
    let from_center = ray.origin - center;
    let height = normal.dot(from_center);
    let approach = normal.dot(ray.direction);
    // Ahead only if height and approach have opposite signs; both branches reject NaN.
    if height * approach < 0.0 {
        let distance = -height / approach;
        Some((distance, from_center + ray.direction * distance))
    } else {
        None
    }
}
