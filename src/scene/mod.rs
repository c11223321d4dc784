//! What a scene holds: immutable and validated.

mod coincidence;
mod emitter;
mod environment;
mod integrator;
mod material;
mod material_check;
mod notice;
mod requirements;
mod sensor;
mod texture;
mod validate;

use std::path::{Path, PathBuf};

use crate::geometry::{Shape, World};

pub use crate::film::ReconstructionFilter;
pub use emitter::Emitter;
pub use environment::{Envmap, EnvmapCell, EnvmapError};
pub use integrator::Integrator;
pub use material::{Coat, Material, MaterialId, NormalTurn, Roughness};
pub use notice::{Ignored, SourcePosition, Warning};
pub use requirements::{Requirement, is_achromatic, requirements};
pub use sensor::{Crop, Film, Perspective, Sensor, SensorKind};
pub use texture::{
    BitmapTexture, Color, Scalar, Texture, TextureFilter, TextureId, TexturePoint, TextureWrap,
    luminance,
};

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
    /// Referred to by [`TextureId`].
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

/// An immutable, validated scene.
#[derive(Debug)]
pub struct Scene {
    path: PathBuf,
    content_hash: String,
    world: World,
    objects: Vec<Object>,
    materials: Vec<Material>,
    textures: Vec<Texture>,
    emitters: Vec<Emitter>,
    sensors: Vec<Sensor>,
    integrator: Option<Integrator>,
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
    /// Checks the parts as a whole, looks the meshes over and builds the search tree.
    ///
    /// What is odd about a mesh becomes a warning: an open refractor still bends light, only
    /// not as a solid would. So does an interface at the same place as another surface.
    ///
    /// # Errors
    ///
    /// Where a number is outside its physical range or an index refers to nothing.
    pub fn new(parts: SceneParts) -> Result<Self, SceneError> {
        validate::check(&parts)?;
        let mut warnings = parts.warnings;
        warnings.extend(validate::mesh_warnings(
            &parts.shapes,
            &parts.objects,
            &parts.materials,
        ));
        warnings.extend(coincidence::warnings(
            &parts.shapes,
            &parts.objects,
            &parts.materials,
        ));
        Ok(Self {
            path: parts.path,
            content_hash: parts.content_hash,
            world: World::new(parts.shapes),
            objects: parts.objects,
            materials: parts.materials,
            textures: parts.textures,
            emitters: parts.emitters,
            sensors: parts.sensors,
            integrator: parts.integrator,
            warnings,
            ignored: parts.ignored,
        })
    }

    /// The main file, as named by the caller.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// A hash over everything the scene was read from.
    pub fn content_hash(&self) -> &str {
        &self.content_hash
    }

    /// The surfaces.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// What is known of each shape beside its form.
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// All materials.
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The material of a shape.
    #[inline]
    pub fn material_of(&self, shape: u32) -> &Material {
        self.material(self.objects[shape as usize].material)
    }

    /// The material with this id.
    #[inline]
    pub fn material(&self, id: MaterialId) -> &Material {
        &self.materials[id.0 as usize]
    }

    /// All textures.
    pub fn textures(&self) -> &[Texture] {
        &self.textures
    }

    /// The texture with this id.
    #[inline]
    pub fn texture(&self, id: TextureId) -> &Texture {
        &self.textures[id.0 as usize]
    }

    /// In the file's order.
    pub fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    /// In the file's order.
    pub fn sensors(&self) -> &[Sensor] {
        &self.sensors
    }

    /// How the file's integrator ends paths, where it is one that follows paths.
    pub fn integrator(&self) -> Option<&Integrator> {
        self.integrator.as_ref()
    }

    /// What is odd, but no error.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// What the file holds that makes no difference here.
    pub fn ignored(&self) -> &[Ignored] {
        &self.ignored
    }
}
