//! The parts of a scene before they are checked as a whole.

use std::path::PathBuf;

use super::{
    Emitter, Ignored, Integrator, Material, MaterialId, Medium, Object, Sensor, SourcePosition,
    Texture, Warning,
};
use crate::geometry::Shape;

/// The contents of a scene's files, before they are checked as a whole.
#[derive(Debug, Default)]
pub struct SceneParts {
    /// The main file, as named by the caller.
    pub path: PathBuf,
    /// A hash (BLAKE3, hex) over the main file and all files it names, in order of first use, and over the
    /// parameters given.
    pub content_hash: String,
    /// The forms of shapes.
    pub shapes: Vec<Shape>,
    /// The entry of each form; as long as `shapes`.
    pub objects: Vec<Object>,
    /// All materials; [`MaterialId`] is an index here.
    pub materials: Vec<Material>,
    /// The ids of bsdfs that have one, and that a shape uses.
    pub material_ids: Vec<(String, MaterialId)>,
    /// The media that absorb light; [`MediumId`](super::MediumId) is an index here.
    pub media: Vec<Medium>,
    /// All textures; [`TextureId`](super::TextureId) is an index here.
    pub textures: Vec<Texture>,
    /// All emitters, in the file's order.
    pub emitters: Vec<Emitter>,
    /// The emitters that the file says are in a medium that absorbs, as indices of `emitters`.
    pub immersed: Vec<usize>,
    /// All sensors, in the file's order.
    pub sensors: Vec<Sensor>,
    /// The limits that the file's integrator sets on paths, if it is one that follows paths.
    pub integrator: Option<Integrator>,
    /// Oddities that the reader found.
    pub warnings: Vec<Warning>,
    /// Contents of the file that this program has no use for.
    pub ignored: Vec<Ignored>,
}

/// Reason why parts do not make a scene.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{at}: {message}")]
pub struct SceneError {
    /// The place where the file declares what is wrong.
    pub at: SourcePosition,
    /// The problem, and what is allowed.
    pub message: String,
}
