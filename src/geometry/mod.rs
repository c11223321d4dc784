//! Rays, surfaces, and their intersections. All of it in `f64`.

mod accel;
mod bounds;
mod counters;
mod face_tree;
mod frame;
mod geodesic;
mod geodesic_dual;
mod geodesic_lattice;
mod hull;
mod icosahedron;
mod local;
mod mesh;
mod nearest;
mod plane_pair;
mod ray;
mod rounding;
mod shape;
mod surface;
mod tangents;
mod transform;
mod triangle;
mod world;

pub use bounds::Bounds;
pub use counters::TraversalCounters;
pub use frame::Frame;
pub use geodesic::{Geodesic, GeodesicPlace};
pub use geodesic_dual::GeodesicDual;
pub use hull::{Hull, bulge, longest, range};
pub use icosahedron::{ICOSAHEDRON_FACES, icosahedron_corners};
pub use local::SurfaceElement;
pub use mesh::{
    AttributeOf, AttributeValues, Finding, Mesh, MeshAttribute, MeshBorder, MeshDiagnostics,
    MeshError, MeshParts, VertexFans,
};
pub use plane_pair::PlanePair;
pub use ray::{Ray, Segment};
pub use shape::{Cylinder, Disk, Rectangle, Shape, ShapeError, Sphere};
pub use surface::{Hit, SurfacePoint};
pub use transform::{Transform, TransformError};
pub use world::World;
