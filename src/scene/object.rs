//! Names, places and materials of shapes.

use super::{Boundary, MaterialId, SourcePosition};
use crate::geometry::Transform;

/// The index of a shape in [`Scene::objects`](super::Scene::objects) and in the
/// [`World`](crate::geometry::World).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
pub struct ShapeId(pub u32);

/// A shape's entry in a scene, beside its form.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// The file's `id`, or one made from the plugin and a number.
    pub id: String,
    /// The name of Mitsuba's plugin.
    pub plugin: &'static str,
    /// The place where the file declares it.
    pub declared_at: SourcePosition,
    /// Its material.
    pub material: MaterialId,
    /// The media that it bounds, if any.
    pub boundary: Option<Boundary>,
    /// Its own space to the world's, as the file says; its form is in the world's already.
    pub to_world: Transform,
}
