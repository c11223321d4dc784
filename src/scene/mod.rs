//! What a scene holds: immutable and validated.

mod emitter;
mod material;
mod notice;
mod sensor;

use std::path::PathBuf;

use crate::geometry::{Shape, World};

pub use emitter::Emitter;
pub use material::{Material, MaterialId};
pub use notice::{Ignored, SourcePosition, Warning};
pub use sensor::{Crop, Film, Perspective, ReconstructionFilter, Sensor, SensorKind};

/// The index of a shape in [`Scene::objects`] and in the [`World`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord, serde::Serialize)]
pub struct ShapeId(pub u32);

/// What a scene says of one shape beside its form.
#[derive(Clone, Debug, PartialEq)]
pub struct Object {
    /// The file's `id`, or one made from the plugin and a number.
    pub id: String,
    /// The name of Mitsuba's plugin.
    pub plugin: &'static str,
    /// Where the file declares it.
    pub declared_at: SourcePosition,
    /// What happens to light on it.
    pub material: MaterialId,
}

/// What a reader found in its files, before it is checked as a whole.
#[derive(Debug, Default)]
pub struct SceneParts {
    /// The main file, as named by the caller.
    pub path: PathBuf,
    /// A hash (BLAKE3, hex) over the main file and all files it names, in order of first use,
    /// and over the parameters given.
    pub content_hash: String,
    /// The forms.
    pub shapes: Vec<Shape>,
    /// What else is known of each form; as long as `shapes`.
    pub objects: Vec<Object>,
    /// Referred to by [`MaterialId`].
    pub materials: Vec<Material>,
    /// In the file's order.
    pub emitters: Vec<Emitter>,
    /// In the file's order.
    pub sensors: Vec<Sensor>,
    /// What the reader found odd.
    pub warnings: Vec<Warning>,
    /// What the file holds that this program has no use for.
    pub ignored: Vec<Ignored>,
}

/// An immutable, validated scene.
#[derive(Debug)]
pub struct Scene {
    path: PathBuf,
    content_hash: String,
    world: World,
    objects: Vec<Object>,
    materials: Vec<Material>,
    emitters: Vec<Emitter>,
    sensors: Vec<Sensor>,
    warnings: Vec<Warning>,
    ignored: Vec<Ignored>,
}

/// Why parts do not make a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{at}: {message}")]
pub struct SceneError {
    /// Where the file declares what is wrong.
    pub at: SourcePosition,
    /// What is wrong, and what is allowed.
    pub message: String,
}

impl Scene {
    /// Checks the parts as a whole and builds the search tree.
    ///
    /// # Errors
    ///
    /// Where the parts contradict each other.
    pub fn new(_parts: SceneParts) -> Result<Self, SceneError> {
        todo!()
    }
}
