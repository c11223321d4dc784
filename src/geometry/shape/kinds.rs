//! A surface of any kind.

use glam::{DVec2, DVec3};

use crate::geometry::{Bounds, Mesh, Ray, SurfacePoint};

use super::{Cylinder, Disk, Rectangle, Sphere};

/// A surface.
#[derive(Clone, Debug, PartialEq)]
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
    /// The smallest axis-aligned box around it, rounded outward so that it holds every hit point.
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

    /// The intersection of a ray with that plane, also beyond the shape's border: the distance, > 0, and the
    /// surface parameters, which continue there as they are within. `None` if there is none, and for other
    /// shapes.
    #[inline]
    pub fn meet_beyond(&self, ray: &Ray) -> Option<(f64, DVec2)> {
        match self {
            Self::Rectangle(rectangle) => rectangle.meet_beyond(ray),
            Self::Disk(disk) => disk.meet_beyond(ray),
            Self::Sphere(_) | Self::Cylinder(_) | Self::Mesh(_) => None,
        }
    }
}
