//! Dispersion: interfaces whose index depends on the wavelength.
//!
//! The scene language gives an interface one index. A glass beside it, by the id of the bsdf or of a shape,
//! takes the place of its `int_ior`; `ext_ior` stays what it is.

use std::collections::BTreeSet;

use super::dispersive::Dispersive;
use super::{Material, MaterialId, Scene};
use crate::setting::did_you_mean;
use crate::spectrum::{Glass, GlassError};

/// Reason why a scene cannot have the dispersion asked for.
///
/// # Example: an id that is not there
///
/// ```
/// let scene = nephroid::load("scenes/prism.xml".as_ref(), &[("size", "8")])?;
/// let error = scene.with_dispersion(&[("prysm", "bk7")]).unwrap_err();
/// assert!(error.to_string().contains("did you mean \"prism\"?"));
/// # Ok::<(), nephroid::LoadError>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum DispersionError {
    /// The text names no glass.
    #[error(transparent)]
    Glass(#[from] GlassError),
    /// Nothing has this id.
    #[error("no bsdf and no shape has the id \"{id}\"{hint}; {there}")]
    Unknown {
        /// The id.
        id: String,
        /// A suggestion, or nothing.
        hint: String,
        /// The ids of interfaces that there are.
        there: String,
    },
    /// The id is of something else.
    #[error(
        "\"{id}\" is of plugin {plugin}: dispersion is for smooth interfaces, dielectric and thindielectric; {there}"
    )]
    NoInterface {
        /// The id.
        id: String,
        /// Mitsuba's name of the material.
        plugin: &'static str,
        /// The ids of interfaces that there are.
        there: String,
    },
    /// The same interface twice.
    #[error("\"{0}\" has been given a glass already")]
    Twice(String),
}

impl Scene {
    /// The scene with interfaces whose index depends on the wavelength: pairs of an id (of a bsdf, or of a
    /// shape, which then has a material of its own) and a glass.
    ///
    /// A glass is a name (`bk7`, `f2`, `sf10`, `sf11`, `fused-silica`, `water`, `diamond`), or a formula:
    /// `cauchy:A,B,...`, n = A + B/λ² + ..., or `sellmeier:B1,...,C1,...`, n² = 1 + Σ B λ²/(λ² − C); λ in µm.
    ///
    /// Such a scene is for the method `photons` alone.
    ///
    /// # Errors
    ///
    /// For an id that no smooth interface has, and what is no glass.
    ///
    /// # Example: the prism's rainbow
    ///
    /// ```
    /// use nephroid::{Budget, Context, Method};
    ///
    /// let scene = nephroid::load("scenes/prism.xml".as_ref(), &[("size", "8")])?;
    /// let scene = scene.with_dispersion(&[("prism", "sf11")])?;
    /// let sensor = &scene.sensors()[0];
    /// let choice = Method::choose(&scene, sensor)?;
    /// assert_eq!(choice.method.name(), "photons");
    /// let rendering = choice.method.run(&scene, sensor, &Budget::work(4096), &Context::default())?;
    /// assert!(rendering.estimate.ledger.closure_error().is_some_and(|error| error < 1e-12));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_dispersion(mut self, glasses: &[(&str, &str)]) -> Result<Self, DispersionError> {
        // A bsdf's shapes may have glasses of their own, so bsdfs come first.
        let (of_bsdfs, of_shapes): (Vec<_>, Vec<_>) = glasses
            .iter()
            .partition(|(id, _)| self.material_named(id).is_some());
        for (id, text) in of_bsdfs.into_iter().chain(of_shapes) {
            let glass = Glass::parse(text)?;
            self.disperse(id, &glass)?;
        }
        if !glasses.is_empty() {
            self.content_hash = hash(&self.content_hash, &self.dispersion);
        }
        Ok(self)
    }

    fn disperse(&mut self, id: &str, glass: &Glass) -> Result<(), DispersionError> {
        if self.dispersion.iter().any(|known| known.id == id) {
            return Err(DispersionError::Twice(id.to_owned()));
        }
        let shape = self.objects.iter().position(|object| object.id == id);
        let root = match (self.material_named(id), shape) {
            (Some(material), _) => material,
            (None, Some(shape)) => self.objects[shape].material,
            (None, None) => {
                let ids = self.interface_ids();
                return Err(DispersionError::Unknown {
                    id: id.to_owned(),
                    hint: did_you_mean(id, ids.iter().map(String::as_str)),
                    there: listed(&ids),
                });
            }
        };
        if self.interfaces_of(root).is_empty() {
            return Err(DispersionError::NoInterface {
                id: id.to_owned(),
                plugin: self.material(root).plugin(),
                there: listed(&self.interface_ids()),
            });
        }
        let root = if let (None, Some(shape)) = (self.material_named(id), shape) {
            let own = self.copy(root);
            self.objects[shape].material = own;
            own
        } else {
            self.own_what_it_wraps(root);
            root
        };
        for material in self.interfaces_of(root) {
            let known = self.dispersion.iter();
            if let Some(known) = known.into_iter().find(|known| known.material == material) {
                return Err(DispersionError::Twice(known.id.clone()));
            }
            // Whoever looks at one index only sees that of the line by which glasses are named.
            set_interior(&mut self.materials[material.0 as usize], glass.ior_d());
            self.dispersion.push(Dispersive {
                material,
                id: id.to_owned(),
                glass: glass.clone(),
            });
        }
        Ok(())
    }

    /// The material of a bsdf's id.
    fn material_named(&self, id: &str) -> Option<MaterialId> {
        let named = self.material_ids.iter().find(|(name, _)| name == id);
        named.map(|(_, material)| *material)
    }

    /// A copy of a material and of all that it wraps.
    fn copy(&mut self, root: MaterialId) -> MaterialId {
        let copy = MaterialId(self.materials.len() as u32);
        self.materials.push(self.material(root).clone());
        self.own_what_it_wraps(copy);
        copy
    }

    /// Gives a material copies of all that it wraps: that may be others', too, and have a glass already.
    fn own_what_it_wraps(&mut self, root: MaterialId) {
        let mut material = self.material(root).clone();
        for nested in material.nested_mut() {
            *nested = self.copy(*nested);
        }
        self.materials[root.0 as usize] = material;
    }

    /// The smooth interfaces that a material is or wraps, each once.
    fn interfaces_of(&self, root: MaterialId) -> Vec<MaterialId> {
        let (mut found, mut open) = (Vec::new(), vec![root]);
        while let Some(id) = open.pop() {
            let material = self.material(id);
            if is_interface(material) && !found.contains(&id) {
                found.push(id);
            }
            // Chains end at normals that a texture turns.
            if !matches!(material, Material::Turned { .. }) {
                open.extend(material.nested());
            }
        }
        found
    }

    /// The ids of all bsdfs and shapes that are smooth interfaces.
    fn interface_ids(&self) -> Vec<String> {
        let bsdfs = self.material_ids.iter().map(|(id, root)| (id, *root));
        let shapes = self
            .objects
            .iter()
            .map(|object| (&object.id, object.material));
        bsdfs
            .chain(shapes)
            .filter(|(_, root)| !self.interfaces_of(*root).is_empty())
            .map(|(id, _)| id.clone())
            .collect()
    }
}

/// Most ids that an error lists.
const LISTED: usize = 12;

fn listed(ids: &[String]) -> String {
    match ids.len() {
        0 => "the scene has no smooth interface (dielectric, thindielectric)".to_owned(),
        count if count > LISTED => format!(
            "smooth interfaces are {} and {} more",
            ids[..LISTED].join(", "),
            count - LISTED
        ),
        _ => format!("smooth interfaces are {}", ids.join(", ")),
    }
}

fn is_interface(material: &Material) -> bool {
    matches!(
        material,
        Material::Dielectric { .. } | Material::ThinDielectric { .. }
    )
}

fn set_interior(material: &mut Material, ior: f64) {
    if let Material::Dielectric { interior_ior, .. }
    | Material::ThinDielectric { interior_ior, .. } = material
    {
        *interior_ior = ior;
    }
}

/// The hash of a scene's files, and of what was asked for beside them.
fn hash(files: &str, dispersion: &[Dispersive]) -> String {
    let mut hasher = blake3::Hasher::new();
    hasher.update(files.as_bytes());
    let pairs = dispersion.iter().map(|one| [&*one.id, one.glass.name()]);
    // In any order, and once however many interfaces an id has.
    for text in pairs.collect::<BTreeSet<_>>().into_iter().flatten() {
        hasher.update(&(text.len() as u64).to_le_bytes());
        hasher.update(text.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

/// A scene's materials as light of one wavelength meets them.
#[derive(Clone, Debug)]
pub struct MaterialsAtWavelength {
    materials: Vec<Material>,
    dispersive: Vec<Dispersive>,
}

impl MaterialsAtWavelength {
    /// Those of a scene; `None` if its indices are the same at all wavelengths.
    pub fn new(scene: &Scene) -> Option<Self> {
        let dispersive = scene.dispersion().to_vec();
        (!dispersive.is_empty()).then(|| Self {
            materials: scene.materials().to_vec(),
            dispersive,
        })
    }

    /// All materials, by [`MaterialId`], at a wavelength \[nm\].
    pub fn at(&mut self, wavelength_nm: f64) -> &[Material] {
        for one in &self.dispersive {
            let material = &mut self.materials[one.material.0 as usize];
            set_interior(material, one.glass.ior(wavelength_nm));
        }
        &self.materials
    }
}
