//! Shapes of surfaces.

mod angle;
mod cylinder;
mod disk;
mod kinds;
mod moved;
mod placement;
mod plane;
mod rectangle;
mod sphere;

pub use cylinder::Cylinder;
pub use disk::Disk;
pub use kinds::Shape;
pub use placement::ShapeError;
pub(in crate::geometry) use plane::meet_plane;
pub use rectangle::Rectangle;
pub use sphere::Sphere;
