//! The scene that all methods render: immutable, and checked as a whole.

use std::path::{Path, PathBuf};

use super::{
    Dispersive, Emitter, Ignored, Integrator, Material, MaterialId, Medium, Object, SceneError,
    SceneParts, Sensor, Texture, TextureId, Warning, coincidence, validate,
};
use crate::geometry::World;

/// An immutable, validated scene.
///
/// # Example: the sensors of a file
///
/// ```
/// let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// for sensor in scene.sensors() {
///     println!("{}: {} of {:?}", sensor.id, sensor.plugin(), sensor.size());
/// }
/// assert_eq!(scene.sensors()[0].id, "floor");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Scene {
    path: PathBuf,
    pub(super) content_hash: String,
    world: World,
    pub(super) objects: Vec<Object>,
    pub(super) materials: Vec<Material>,
    pub(super) material_ids: Vec<(String, MaterialId)>,
    pub(super) dispersion: Vec<Dispersive>,
    media: Vec<Medium>,
    textures: Vec<Texture>,
    emitters: Vec<Emitter>,
    immersed: Vec<usize>,
    sensors: Vec<Sensor>,
    integrator: Option<Integrator>,
    warnings: Vec<Warning>,
    ignored: Vec<Ignored>,
}

impl Scene {
    /// Checks the parts as a whole, looks for defects of meshes and builds the search tree.
    ///
    /// Oddities of a mesh become warnings: an open refractor still bends light, only not as a solid would. An
    /// interface at the same place as another surface becomes a warning, too.
    ///
    /// # Errors
    ///
    /// If a number is outside its physical range or an index refers to nothing.
    #[doc(hidden)]
    pub fn new(parts: SceneParts) -> Result<Self, SceneError> {
        validate::check(&parts)?;
        let of_meshes = validate::mesh_warnings(&parts);
        let mut warnings = parts.warnings;
        warnings.extend(of_meshes);
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
            material_ids: parts.material_ids,
            dispersion: Vec::new(),
            media: parts.media,
            textures: parts.textures,
            emitters: parts.emitters,
            immersed: parts.immersed,
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

    /// A hash over everything the scene was read from, and over the glasses of
    /// [`with_dispersion`](Self::with_dispersion).
    ///
    /// # Example: a name for results that can be kept
    ///
    /// ```
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// let other = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "16")])?;
    /// assert_ne!(scene.content_hash(), other.content_hash());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn content_hash(&self) -> &str {
        &self.content_hash
    }

    /// The surfaces.
    #[doc(hidden)]
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The entry of each shape, beside its form.
    #[doc(hidden)]
    pub fn objects(&self) -> &[Object] {
        &self.objects
    }

    /// All materials.
    #[doc(hidden)]
    pub fn materials(&self) -> &[Material] {
        &self.materials
    }

    /// The material of a shape.
    #[inline]
    #[doc(hidden)]
    pub fn material_of(&self, shape: u32) -> &Material {
        self.material(self.objects[shape as usize].material)
    }

    /// The material with this id.
    #[inline]
    #[doc(hidden)]
    pub fn material(&self, id: MaterialId) -> &Material {
        &self.materials[id.0 as usize]
    }

    /// The interfaces whose index depends on the wavelength; none unless they were asked for.
    #[inline]
    #[doc(hidden)]
    pub fn dispersion(&self) -> &[Dispersive] {
        &self.dispersion
    }

    /// True if no medium absorbs.
    #[inline]
    #[doc(hidden)]
    pub fn is_clear(&self) -> bool {
        self.media.is_empty()
    }

    /// The media that absorb light; none unless the file has one.
    #[inline]
    #[doc(hidden)]
    pub fn media(&self) -> &[Medium] {
        &self.media
    }

    /// All textures.
    #[doc(hidden)]
    pub fn textures(&self) -> &[Texture] {
        &self.textures
    }

    /// The texture with this id.
    #[inline]
    #[doc(hidden)]
    pub fn texture(&self, id: TextureId) -> &Texture {
        &self.textures[id.0 as usize]
    }

    /// All emitters, in the file's order.
    #[doc(hidden)]
    pub fn emitters(&self) -> &[Emitter] {
        &self.emitters
    }

    /// The emitters that the file says are in a medium that absorbs, as indices of
    /// [`emitters`](Self::emitters).
    #[doc(hidden)]
    pub fn immersed(&self) -> &[usize] {
        &self.immersed
    }

    /// All sensors, in the file's order.
    ///
    /// # Example: the camera
    ///
    /// ```
    /// let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[])?;
    /// let camera = scene.sensors().iter().find(|sensor| sensor.plugin() == "perspective");
    /// assert_eq!(camera.map(|camera| camera.id.as_str()), Some("camera"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn sensors(&self) -> &[Sensor] {
        &self.sensors
    }

    /// The limits that the file's integrator sets on paths, if it is one that follows paths.
    #[doc(hidden)]
    pub fn integrator(&self) -> Option<&Integrator> {
        self.integrator.as_ref()
    }

    /// Oddities that are no errors.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Contents of the file that make no difference here.
    #[doc(hidden)]
    pub fn ignored(&self) -> &[Ignored] {
        &self.ignored
    }
}
