//! Rays, surfaces, and where they meet. All of it in `f64`.

mod bounds;
mod mesh;
mod ray;
mod shape;
mod surface;
mod transform;
mod world;

pub use bounds::Bounds;
pub use mesh::{Mesh, MeshDiagnostics, MeshError, MeshParts};
pub use ray::Ray;
pub use shape::{Cylinder, Disk, Rectangle, Shape, ShapeError, Sphere};
pub use surface::{Hit, SurfacePoint};
pub use transform::{Transform, TransformError};
pub use world::{TraversalCounters, World};
