//! The parts of a scene before they are checked as a whole.

use std::path::PathBuf;

use super::{
    Emitter, Ignored, Integrator, Material, Object, Sensor, SourcePosition, Texture, Warning,
};
use crate::geometry::Shape;

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
    /// Referred to by [`MaterialId`](super::MaterialId).
    pub materials: Vec<Material>,
    /// Referred to by [`TextureId`](super::TextureId).
    pub textures: Vec<Texture>,
    /// In the file's order.
    pub emitters: Vec<Emitter>,
    /// In the file's order.
    pub sensors: Vec<Sensor>,
    /// How the file's integrator ends paths, where it is one that follows paths.
    pub integrator: Option<Integrator>,
    /// What the reader found odd.
    pub warnings: Vec<Warning>,
    /// What the file holds that this program has no use for.
    pub ignored: Vec<Ignored>,
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
