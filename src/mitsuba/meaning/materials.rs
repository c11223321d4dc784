//! `<bsdf>` becomes [`Material`].

use std::collections::HashMap;

use super::ignored::IgnoredList;
use super::plugin::Plugin;
use super::spectra::{self, Role};
use super::textures;
use super::{ior, metals};
use crate::mitsuba::error::{LoadError, did_you_mean};
use crate::mitsuba::files::Files;
use crate::mitsuba::syntax::{Kind, ObjectIndex, Tree, Value, shortened};
use crate::radiometry::Rgb;
use crate::scene::{Material, MaterialId, Warning};

/// Every plugin that becomes a material.
const MODELLED: [&str; 7] = [
    "conductor",
    "dielectric",
    "diffuse",
    "mask",
    "null",
    "thindielectric",
    "twosided",
];

/// The reflectance of `diffuse` where the file gives none, and of a shape without a bsdf.
const DEFAULT_REFLECTANCE: f64 = 0.5;

/// Materials found so far; each bsdf of the file is read once.
#[derive(Default)]
pub struct Materials {
    pub list: Vec<Material>,
    known: HashMap<ObjectIndex, MaterialId>,
    default: Option<MaterialId>,
    pub warnings: Vec<Warning>,
}

impl Materials {
    /// Whether a shape uses the bsdf.
    pub fn is_used(&self, bsdf: ObjectIndex) -> bool {
        self.known.contains_key(&bsdf)
    }

    /// What a shape without a bsdf gets, as in Mitsuba: `diffuse` with reflectance 0.5.
    pub fn default_material(&mut self) -> MaterialId {
        if let Some(id) = self.default {
            return id;
        }
        let id = self.add(Material::Diffuse {
            reflectance: Some(Rgb::grey(DEFAULT_REFLECTANCE)),
        });
        self.default = Some(id);
        id
    }

    fn add(&mut self, material: Material) -> MaterialId {
        self.list.push(material);
        MaterialId(self.list.len() as u32 - 1)
    }

    /// The material of a bsdf.
    pub fn read(
        &mut self,
        tree: &Tree,
        bsdf: ObjectIndex,
        files: &Files,
        ignored: &mut IgnoredList,
    ) -> Result<MaterialId, LoadError> {
        if let Some(id) = self.known.get(&bsdf) {
            return Ok(*id);
        }
        let plugin = Plugin::new(tree, bsdf);
        let material = match plugin.name() {
            "diffuse" => self.diffuse(tree, &plugin, files, ignored)?,
            "dielectric" | "thindielectric" => dielectric(tree, &plugin)?,
            "conductor" => conductor(tree, &plugin)?,
            "null" => Material::Null,
            "mask" => {
                let opacity = opacity(tree, &plugin)?;
                let nested = plugin
                    .child(Kind::Bsdf)?
                    .ok_or_else(|| plugin.error("needs a nested bsdf"))?;
                Material::Mask {
                    opacity,
                    nested: self.read(tree, nested, files, ignored)?,
                }
            }
            "twosided" => self.two_sided(tree, &plugin, files, ignored)?,
            name => {
                let hint = did_you_mean(name, MODELLED);
                let message = format!(
                    "is not modelled{hint}; modelled bsdfs are: {}",
                    MODELLED.join(", ")
                );
                return Err(plugin.error(message));
            }
        };
        plugin.finish()?;
        let id = self.add(material);
        self.known.insert(bsdf, id);
        Ok(id)
    }

    /// A texture is checked and let be: no irradiance depends on it, and cameras refuse it.
    fn diffuse(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &Files,
        ignored: &mut IgnoredList,
    ) -> Result<Material, LoadError> {
        let reflectance = match plugin.find("reflectance").map(|found| found.value) {
            Some(Value::Object(texture)) if textures::is_texture(tree, *texture) => {
                self.warnings
                    .extend(textures::check(tree, *texture, files)?);
                ignored.add_texture(tree, *texture);
                None
            }
            Some(Value::Spectrum(crate::mitsuba::syntax::Spectrum::File(_))) => None,
            _ => Some(spectra::read_or(
                tree,
                plugin,
                "reflectance",
                Role::Fraction,
                DEFAULT_REFLECTANCE,
            )?),
        };
        Ok(Material::Diffuse { reflectance })
    }

    fn two_sided(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &Files,
        ignored: &mut IgnoredList,
    ) -> Result<Material, LoadError> {
        let sides = plugin.children(Kind::Bsdf);
        let (front, back) = match sides[..] {
            [(both, _)] => (both, both),
            [(front, _), (back, _)] => (front, back),
            _ => {
                return Err(plugin.error(format!(
                    "needs one or two nested bsdfs, not {}",
                    sides.len()
                )));
            }
        };
        for (side, _) in sides {
            let nested = Plugin::new(tree, side);
            if matches!(
                nested.name(),
                "dielectric" | "thindielectric" | "null" | "mask" | "twosided"
            ) {
                let message = "cannot be inside twosided: only one-sided materials that let no light through can";
                return Err(nested.error(message));
            }
        }
        let front = self.read(tree, front, files, ignored)?;
        let back = self.read(tree, back, files, ignored)?;
        Ok(Material::TwoSided { front, back })
    }
}

fn dielectric(tree: &Tree, plugin: &Plugin) -> Result<Material, LoadError> {
    let interior_ior = ior::read(plugin, "int_ior", "bk7")?;
    let exterior_ior = ior::read(plugin, "ext_ior", "air")?;
    let factor = |name| spectra::read_or(tree, plugin, name, Role::Fraction, 1.0);
    let specular_reflectance = factor("specular_reflectance")?;
    let specular_transmittance = factor("specular_transmittance")?;
    Ok(if plugin.name() == "dielectric" {
        Material::Dielectric {
            interior_ior,
            exterior_ior,
            specular_reflectance,
            specular_transmittance,
        }
    } else {
        Material::ThinDielectric {
            interior_ior,
            exterior_ior,
            specular_reflectance,
            specular_transmittance,
        }
    })
}

/// `eta` and `k`, or `material`; the perfect mirror (eta 0, k 1) where the file gives neither.
///
/// Old files may give `extEta`, the index of what surrounds the metal: it divides eta and k, as
/// Mitsuba 0.6 documents. (Mitsuba 3 rejects it.)
fn conductor(tree: &Tree, plugin: &Plugin) -> Result<Material, LoadError> {
    let eta = spectra::read(tree, plugin, "eta", Role::Index)?;
    let k = spectra::read(tree, plugin, "k", Role::Index)?;
    let specular_reflectance =
        spectra::read_or(tree, plugin, "specular_reflectance", Role::Fraction, 1.0)?;
    let mut index = (
        eta.map_or(Rgb::BLACK, |(eta, _)| eta),
        k.map_or(Rgb::WHITE, |(k, _)| k),
    );
    if let Some(found) = plugin.find("material") {
        let name = plugin.string("material")?.unwrap_or_default();
        let at = found.property.at;
        if eta.is_some() || k.is_some() {
            return Err(plugin.parameter_error(
                at,
                "material",
                "and \"eta\" or \"k\" exclude each other",
            ));
        }
        index = match metals::named(name) {
            Some(metal) => (metal.eta, metal.k),
            None if name == "none" => (Rgb::BLACK, Rgb::WHITE),
            None => {
                let names = || metals::names().chain(["none"]);
                let message = format!(
                    "no material is called \"{}\"{}; known are {}",
                    shortened(name),
                    did_you_mean(name, names()),
                    names().collect::<Vec<_>>().join(", ")
                );
                return Err(plugin.parameter_error(at, "material", message));
            }
        };
    }
    if plugin.is_old() && plugin.find("ext_eta").is_some() {
        let outside = ior::read(plugin, "ext_eta", "air")?;
        index = (index.0 / outside, index.1 / outside);
    }
    Ok(Material::Conductor {
        eta: index.0,
        k: index.1,
        specular_reflectance,
    })
}

fn opacity(tree: &Tree, plugin: &Plugin) -> Result<f64, LoadError> {
    match spectra::read(tree, plugin, "opacity", Role::Fraction)? {
        None => Ok(0.5),
        Some((rgb, _)) if rgb.is_grey() => Ok(rgb.0[0]),
        Some((_, at)) => {
            Err(plugin.parameter_error(at, "opacity", "must be the same in all channels"))
        }
    }
}
