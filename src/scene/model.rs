//! The scene that all methods render: immutable, and checked as a whole.

use std::path::{Path, PathBuf};

use super::{
    Emitter, Ignored, Integrator, Material, MaterialId, Object, SceneError, SceneParts, Sensor,
    Texture, TextureId, Warning, coincidence, validate,
};
use crate::geometry::World;

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
