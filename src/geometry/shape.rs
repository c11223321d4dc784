//! Shapes with a closed form. (Contract; bodies being built.)

use super::{Bounds, Mesh, Transform};

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
    /// The smallest axis-aligned box round it, rounded outward.
    pub fn bounds(&self) -> Bounds {
        todo!()
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
}

/// Unit sphere mapped by `to_world`.
#[derive(Clone, Debug)]
pub struct Sphere;
/// [-1, 1]² in the xy plane with normal +z, mapped by `to_world`; uv = (xy + 1)/2.
#[derive(Clone, Debug)]
pub struct Rectangle;
/// Unit disc in the xy plane with normal +z, mapped by `to_world`; uv = (r, φ/2π).
#[derive(Clone, Debug)]
pub struct Disk;
/// Radius 1 about the z axis from z = 0 to z = 1, mapped by `to_world`; normal outward; uv = (φ/2π, z).
#[derive(Clone, Debug)]
pub struct Cylinder;

impl Sphere {
    /// `flip_normals` turns the normal inward (a mirroring `to_world` does not, as in Mitsuba).
    pub fn new(_to_world: &Transform, _flip_normals: bool) -> Result<Self, ShapeError> {
        todo!()
    }
}
impl Rectangle {
    /// Any affine map.
    pub fn new(_to_world: &Transform, _flip_normals: bool) -> Result<Self, ShapeError> {
        todo!()
    }
}
impl Disk {
    /// Mitsuba's restrictions apply.
    pub fn new(_to_world: &Transform, _flip_normals: bool) -> Result<Self, ShapeError> {
        todo!()
    }
}
impl Cylinder {
    /// Mitsuba's restrictions apply.
    pub fn new(_to_world: &Transform, _flip_normals: bool) -> Result<Self, ShapeError> {
        todo!()
    }
}
