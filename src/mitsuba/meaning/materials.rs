//! The meaning of `<bsdf>`, which becomes a [`Material`].

use std::collections::HashMap;
use std::sync::Arc;

use super::plugin::Plugin;
use super::spectra::{self, Role};
use super::textures::Textures;
use super::{ior, metals};
use crate::mitsuba::error::LoadError;
use crate::mitsuba::files::Files;
use crate::mitsuba::syntax::{ObjectIndex, ObjectKind, Tree, Value, shortened};
use crate::optics::{FacetDistribution, RoughTransmittance};
use crate::radiometry::Rgb;
use crate::scene::{
    Coat, Color, Material, MaterialId, NormalTurn, Principled, PrincipledThin, Roughness, Scalar,
};
use crate::setting::did_you_mean;

/// Every plugin that becomes a material.
const MODELLED: [&str; 16] = [
    "blendbsdf",
    "bumpmap",
    "conductor",
    "dielectric",
    "diffuse",
    "mask",
    "normalmap",
    "null",
    "plastic",
    "principled",
    "principledthin",
    "roughconductor",
    "roughdielectric",
    "roughplastic",
    "thindielectric",
    "twosided",
];

/// The reflectance of `diffuse` if the file gives none, and of a shape without a bsdf.
const DEFAULT_REFLECTANCE: f64 = 0.5;

/// Most plain materials in a blend and the blends in it: each is evaluated by itself, and blends may share
/// them.
const MAX_BLENDED: usize = 64;

/// Mitsuba's roughness if the file gives none.
const DEFAULT_ALPHA: f64 = 0.1;

/// The materials so far; each bsdf of the file is read once.
#[derive(Default)]
pub struct Materials {
    pub list: Vec<Material>,
    /// The ids of those that have one.
    pub ids: Vec<(String, MaterialId)>,
    pub textures: Textures,
    known: HashMap<ObjectIndex, MaterialId>,
    defaults: [Option<MaterialId>; 2],
}

impl Materials {
    /// True if a shape uses the bsdf.
    pub fn is_used(&self, bsdf: ObjectIndex) -> bool {
        self.known.contains_key(&bsdf)
    }

    /// The material of a shape without a bsdf, as in Mitsuba: `diffuse` with reflectance 0.5.
    ///
    /// A shape that shines is black, as in Mitsuba: an area light does not reflect unless the file says so.
    pub fn default_material(&mut self, shines: bool) -> MaterialId {
        if let Some(id) = self.defaults[usize::from(shines)] {
            return id;
        }
        let reflectance = if shines { 0.0 } else { DEFAULT_REFLECTANCE };
        let id = self.add(Material::Diffuse {
            reflectance: Color::Constant(Rgb::grey(reflectance)),
        });
        self.defaults[usize::from(shines)] = Some(id);
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
        files: &mut Files,
    ) -> Result<MaterialId, LoadError> {
        if let Some(id) = self.known.get(&bsdf) {
            return Ok(*id);
        }
        let plugin = Plugin::new(tree, bsdf);
        let material = match plugin.name() {
            "diffuse" => Material::Diffuse {
                reflectance: self.textures.color(
                    tree,
                    &plugin,
                    "reflectance",
                    DEFAULT_REFLECTANCE,
                    files,
                )?,
            },
            "dielectric" | "thindielectric" => self.dielectric(tree, &plugin, files)?,
            "conductor" => {
                let (eta, k) = metal(tree, &plugin)?;
                Material::Conductor {
                    eta,
                    k,
                    specular_reflectance: self.textures.filter(
                        tree,
                        &plugin,
                        "specular_reflectance",
                        files,
                    )?,
                }
            }
            "roughconductor" => {
                let (eta, k) = metal(tree, &plugin)?;
                Material::RoughConductor {
                    eta,
                    k,
                    specular_reflectance: self.factor(
                        tree,
                        &plugin,
                        "specular_reflectance",
                        files,
                    )?,
                    roughness: self.roughness(tree, &plugin, files)?,
                }
            }
            "roughdielectric" => self.rough_dielectric(tree, &plugin, files)?,
            "plastic" => Material::Plastic(self.coat(tree, &plugin, files)?),
            "roughplastic" => self.rough_plastic(tree, &plugin, files)?,
            "principled" => self.principled(tree, &plugin, files)?,
            "principledthin" => self.principled_thin(tree, &plugin, files)?,
            "blendbsdf" => self.blend(tree, &plugin, files)?,
            "null" => Material::Null,
            "mask" => Material::Mask {
                opacity: self.textures.share(tree, &plugin, "opacity", 0.5, files)?,
                nested: self.nested(tree, &plugin, files)?,
            },
            "bumpmap" | "normalmap" => self.turned(tree, &plugin, files)?,
            "twosided" => self.two_sided(tree, &plugin, files)?,
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
        if let Some(name) = &tree.object(bsdf).id {
            self.ids.push((name.clone(), id));
        }
        Ok(id)
    }

    /// The one bsdf that a wrapper holds.
    fn nested(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &mut Files,
    ) -> Result<MaterialId, LoadError> {
        let nested = plugin
            .child(ObjectKind::Bsdf)?
            .ok_or_else(|| plugin.error("needs a nested bsdf"))?;
        self.read(tree, nested, files)
    }

    /// A factor on light, 1 in nature.
    fn factor(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        name: &str,
        files: &mut Files,
    ) -> Result<Color, LoadError> {
        self.textures.color(tree, plugin, name, 1.0, files)
    }

    /// The roughness: `distribution`, and `alpha` or both of `alpha_u` and `alpha_v`. `sample_visible`
    /// changes how Mitsuba samples, and no result.
    fn roughness(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &mut Files,
    ) -> Result<Roughness, LoadError> {
        let distribution = distribution(plugin)?;
        let separate = ["alpha_u", "alpha_v"].map(|name| plugin.find(name));
        let both = plugin.find("alpha");
        if let [None, None] = separate {
            let alpha = self
                .textures
                .scalar(tree, plugin, "alpha", DEFAULT_ALPHA, files)?;
            return Ok(Roughness {
                distribution,
                alpha_u: alpha,
                alpha_v: alpha,
            });
        }
        if let (Some(found), _) | (None, [Some(found), None] | [None, Some(found)]) =
            (both, separate)
        {
            let message = "and both \"alpha_u\" and \"alpha_v\" are the two ways to say how rough it is: give one";
            return Err(plugin.parameter_error(found.property.at, "alpha", message));
        }
        let mut of = |name| {
            self.textures
                .scalar(tree, plugin, name, DEFAULT_ALPHA, files)
        };
        Ok(Roughness {
            distribution,
            alpha_u: of("alpha_u")?,
            alpha_v: of("alpha_v")?,
        })
    }

    /// A principled material. The index is `eta`, or follows from `specular`, its reflectance at normal
    /// incidence by 0.08.
    fn principled(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &mut Files,
    ) -> Result<Material, LoadError> {
        let rates = [
            "diffuse_reflectance_sampling_rate",
            "main_specular_sampling_rate",
            "clearcoat_sampling_rate",
        ];
        let base_color = self.base_color(tree, plugin, &rates, files)?;
        let mut share = |name, default| self.textures.share(tree, plugin, name, default, files);
        let roughness = share("roughness", 0.5)?;
        let mut part = |name| share(name, 0.0);
        let spec_trans = part("spec_trans")?;
        let eta = principled_index(plugin, spec_trans.may_exceed_zero())?;
        Ok(Material::Principled(Box::new(Principled {
            base_color,
            roughness,
            anisotropic: part("anisotropic")?,
            metallic: part("metallic")?,
            spec_trans,
            eta,
            spec_tint: part("spec_tint")?,
            sheen: part("sheen")?,
            sheen_tint: part("sheen_tint")?,
            flatness: part("flatness")?,
            clearcoat: part("clearcoat")?,
            clearcoat_gloss: part("clearcoat_gloss")?,
        })))
    }

    /// The colour of a principled material. Sampling rates change how Mitsuba samples, and no result.
    fn base_color(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        rates: &[&str],
        files: &mut Files,
    ) -> Result<Color, LoadError> {
        for rate in rates {
            plugin.float_or(rate, 1.0)?;
        }
        self.textures.color(tree, plugin, "base_color", 0.5, files)
    }

    /// A thin sheet.
    fn principled_thin(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &mut Files,
    ) -> Result<Material, LoadError> {
        let rates = [
            "diffuse_reflectance_sampling_rate",
            "diffuse_transmittance_sampling_rate",
            "specular_reflectance_sampling_rate",
            "specular_transmittance_sampling_rate",
        ];
        let base_color = self.base_color(tree, plugin, &rates, files)?;
        let diff_trans = self
            .textures
            .scalar(tree, plugin, "diff_trans", 0.0, files)?;
        if let (Scalar::Constant(number), Some(found)) = (diff_trans, plugin.find("diff_trans"))
            && number > 2.0
        {
            let message = format!("must lie in 0..=2, but is {number}");
            return Err(plugin.parameter_error(found.property.at, "diff_trans", message));
        }
        let mut share = |name, default| self.textures.share(tree, plugin, name, default, files);
        let roughness = share("roughness", 0.5)?;
        let mut part = |name| share(name, 0.0);
        Ok(Material::PrincipledThin(Box::new(PrincipledThin {
            base_color,
            roughness,
            anisotropic: part("anisotropic")?,
            spec_trans: part("spec_trans")?,
            eta: plugin.positive_or("eta", 1.5)?,
            spec_tint: part("spec_tint")?,
            sheen: part("sheen")?,
            sheen_tint: part("sheen_tint")?,
            flatness: part("flatness")?,
            diff_trans,
        })))
    }

    /// Two bsdfs, in the file's order: a weight of 0 is the first, 1 the second.
    fn blend(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &mut Files,
    ) -> Result<Material, LoadError> {
        let weight = self.weight(tree, plugin, files)?;
        let parts = plugin.children(ObjectKind::Bsdf);
        let [(first, _), (second, _)] = parts[..] else {
            let message = format!("needs two nested bsdfs, not {}", parts.len());
            return Err(plugin.error(message));
        };
        let nested = [
            self.read(tree, first, files)?,
            self.read(tree, second, files)?,
        ];
        let [of_first, of_second] = nested.map(|id| &self.list[id.0 as usize]);
        match (weight, of_first, of_second) {
            // One of them alone: methods that take no blends take it.
            (Scalar::Constant(0.0), only, _) | (Scalar::Constant(1.0), _, only) => Ok(only.clone()),
            // A blend with nothing is a mask.
            (opacity, Material::Null, _) => Ok(Material::Mask {
                opacity,
                nested: nested[1],
            }),
            (Scalar::Constant(weight), _, Material::Null) => Ok(Material::Mask {
                opacity: Scalar::Constant(1.0 - weight),
                nested: nested[0],
            }),
            (Scalar::Texture(_), _, Material::Null) => Err(plugin.error(
                "cannot hold a null as its second bsdf if its weight is a texture: make it the first, with the \
                 texture's complement",
            )),
            (_, Material::Mask { .. }, _) | (_, _, Material::Mask { .. }) => Err(plugin.error(
                "cannot hold a mask: blend what the mask holds, and put the mask around the blendbsdf",
            )),
            _ => {
                let count: usize = nested.into_iter().map(|part| self.count(part)).sum();
                if count > MAX_BLENDED {
                    let message = format!(
                        "holds {count} materials, with those of blends in it; at most {MAX_BLENDED} are allowed"
                    );
                    return Err(plugin.error(message));
                }
                Ok(Material::Blend { weight, nested })
            }
        }
    }

    /// The number of plain materials in a material.
    fn count(&self, id: MaterialId) -> usize {
        let nested = self.list[id.0 as usize].nested();
        let count: usize = nested.map(|part| self.count(part)).sum();
        count.max(1)
    }

    /// The weight of a blend, which Mitsuba brings to 0..=1.
    fn weight(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &mut Files,
    ) -> Result<Scalar, LoadError> {
        match plugin.find("weight").map(|found| found.value) {
            None => Err(plugin.error("needs the parameter \"weight\"")),
            Some(Value::Float(_) | Value::Integer(_)) => {
                let weight = plugin.float_or("weight", 0.0)?;
                Ok(Scalar::Constant(weight.clamp(0.0, 1.0)))
            }
            Some(_) => self.textures.share(tree, plugin, "weight", 0.0, files),
        }
    }

    fn dielectric(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &mut Files,
    ) -> Result<Material, LoadError> {
        let interior_ior = ior::read(plugin, "int_ior", "bk7")?;
        let exterior_ior = ior::read(plugin, "ext_ior", "air")?;
        let mut factor = |name| self.textures.filter(tree, plugin, name, files);
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

    fn rough_dielectric(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &mut Files,
    ) -> Result<Material, LoadError> {
        let (interior_ior, exterior_ior) = differing_indices(plugin, "bk7")?;
        Ok(Material::RoughDielectric {
            interior_ior,
            exterior_ior,
            specular_reflectance: self.factor(tree, plugin, "specular_reflectance", files)?,
            specular_transmittance: self.factor(tree, plugin, "specular_transmittance", files)?,
            roughness: self.roughness(tree, plugin, files)?,
        })
    }

    fn coat(&mut self, tree: &Tree, plugin: &Plugin, files: &mut Files) -> Result<Coat, LoadError> {
        let base = "diffuse_reflectance";
        Ok(Coat {
            interior_ior: ior::read(plugin, "int_ior", "polypropylene")?,
            exterior_ior: ior::read(plugin, "ext_ior", "air")?,
            diffuse_reflectance: (self.textures).color(
                tree,
                plugin,
                base,
                DEFAULT_REFLECTANCE,
                files,
            )?,
            specular_reflectance: self.factor(tree, plugin, "specular_reflectance", files)?,
            nonlinear: plugin.boolean_or("nonlinear", false)?,
        })
    }

    fn rough_plastic(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &mut Files,
    ) -> Result<Material, LoadError> {
        let (interior_ior, exterior_ior) = differing_indices(plugin, "polypropylene")?;
        let coat = self.coat(tree, plugin, files)?;
        let distribution = distribution(plugin)?;
        let alpha = plugin.positive_or("alpha", DEFAULT_ALPHA)?;
        let eta = interior_ior / exterior_ior;
        // The table is the same for the same coat, and takes a while to make.
        let like = self.list.iter().find_map(|known| match known {
            Material::RoughPlastic {
                coat: other,
                distribution: other_distribution,
                alpha: other_alpha,
                transmittance,
            } if *other_distribution == distribution
                && *other_alpha == alpha
                && other.interior_ior / other.exterior_ior == eta =>
            {
                Some(Arc::clone(transmittance))
            }
            _ => None,
        });
        let transmittance =
            like.unwrap_or_else(|| Arc::new(RoughTransmittance::new(distribution, alpha, eta)));
        Ok(Material::RoughPlastic {
            coat,
            distribution,
            alpha,
            transmittance,
        })
    }

    /// A material with turned normals. `bumpmap` holds a texture of any name; `normalmap` holds one called
    /// `normalmap`.
    fn turned(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &mut Files,
    ) -> Result<Material, LoadError> {
        let by = if plugin.name() == "bumpmap" {
            let texture = plugin
                .child(ObjectKind::Texture)?
                .ok_or_else(|| plugin.error("needs a nested texture"))?;
            if matches!(
                tree.object(texture).plugin.as_str(),
                "checkerboard" | "mesh_attribute"
            ) {
                let message = "has no slope: only a bitmap can be a bump map";
                return Err(Plugin::new(tree, texture).error(message));
            }
            NormalTurn::Height {
                texture: self.textures.required(tree, texture, files)?,
                scale: plugin.float_or("scale", 1.0)?,
            }
        } else {
            NormalTurn::Normal {
                color: self.textures.vector(tree, plugin, "normalmap", files)?,
            }
        };
        let flip_invalid_normals = plugin.boolean_or("flip_invalid_normals", true)?;
        let use_shadowing_function = plugin.boolean_or("use_shadowing_function", true)?;
        let nested = self.nested(tree, plugin, files)?;
        if let Some(wrapper) = self.outer_wrapper(nested) {
            let name = plugin.name();
            let inside = &self.list[nested.0 as usize];
            let message = if matches!(inside, Material::Blend { .. }) {
                format!(
                    "cannot hold a blendbsdf that holds a {wrapper}: put a {name} into the {wrapper} instead"
                )
            } else {
                format!("cannot hold a {wrapper}: wrap it around the {name} instead")
            };
            return Err(plugin.error(message));
        }
        Ok(Material::Turned {
            by,
            flip_invalid_normals,
            use_shadowing_function,
            nested,
        })
    }

    /// The plugin of a material, or of the first one in a blend, that must be outside of turned normals.
    fn outer_wrapper(&self, id: MaterialId) -> Option<&'static str> {
        let material = &self.list[id.0 as usize];
        match material {
            Material::Blend { nested, .. } => {
                nested.iter().find_map(|part| self.outer_wrapper(*part))
            }
            Material::Null
            | Material::Mask { .. }
            | Material::TwoSided { .. }
            | Material::Turned { .. } => Some(material.plugin()),
            _ => None,
        }
    }

    fn two_sided(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &mut Files,
    ) -> Result<Material, LoadError> {
        let sides = plugin.children(ObjectKind::Bsdf);
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
        let [front, back] = [front, back].map(|side| {
            let id = self.read(tree, side, files)?;
            if self.is_one_sided(id) {
                Ok(id)
            } else {
                let message = "cannot be inside twosided: only one-sided materials that let no light through can";
                Err(Plugin::new(tree, side).error(message))
            }
        });
        Ok(Material::TwoSided {
            front: front?,
            back: back?,
        })
    }

    /// True if a material scatters on its front only and lets nothing through.
    fn is_one_sided(&self, id: MaterialId) -> bool {
        match &self.list[id.0 as usize] {
            Material::Diffuse { .. }
            | Material::Conductor { .. }
            | Material::RoughConductor { .. }
            | Material::Plastic(_)
            | Material::RoughPlastic { .. } => true,
            Material::Principled(principled) => !principled.spec_trans.may_exceed_zero(),
            Material::Turned { nested, .. } => self.is_one_sided(*nested),
            Material::Blend { nested, .. } => nested.iter().all(|part| self.is_one_sided(*part)),
            Material::Dielectric { .. }
            | Material::ThinDielectric { .. }
            | Material::RoughDielectric { .. }
            | Material::PrincipledThin(_)
            | Material::Null
            | Material::Mask { .. }
            | Material::TwoSided { .. } => false,
        }
    }
}

fn distribution(plugin: &Plugin) -> Result<FacetDistribution, LoadError> {
    plugin.boolean_or("sample_visible", true)?;
    let name = plugin.string("distribution")?.unwrap_or("beckmann");
    match name.to_ascii_lowercase().as_str() {
        "beckmann" => Ok(FacetDistribution::Beckmann),
        "ggx" => Ok(FacetDistribution::Ggx),
        // Asked for again, so that the error names the parameter's place.
        _ => plugin
            .choice_or("distribution", &["beckmann", "ggx"], "beckmann")
            .map(|_| FacetDistribution::Beckmann),
    }
}

/// The index of a principled material, inside by outside. Where light passes through, it is no interface at
/// 1: Mitsuba then takes 1.001, and a `specular` of 0.001.
fn principled_index(plugin: &Plugin, is_glass: bool) -> Result<f64, LoadError> {
    let is_given = plugin.find("specular").is_some();
    if let Some((eta, at)) = plugin.float_at("eta")? {
        if is_given {
            return Err(plugin.parameter_error(at, "eta", "and \"specular\" exclude each other"));
        }
        return Ok(if is_glass && eta == 1.0 { 1.001 } else { eta });
    }
    let specular = plugin.float_within("specular", 0.0..=1.0, 0.5)?;
    let reflectance = if is_glass && specular == 0.0 {
        1e-3
    } else {
        specular
    };
    Ok(2.0 / (1.0 - (0.08 * reflectance).sqrt()) - 1.0)
}

/// Absolute indices inside and outside, which a rough interface needs to differ.
fn differing_indices(plugin: &Plugin, inside: &str) -> Result<(f64, f64), LoadError> {
    let interior = ior::read(plugin, "int_ior", inside)?;
    let exterior = ior::read(plugin, "ext_ior", "air")?;
    if interior == exterior {
        let message = format!("needs indices of refraction that differ, but both are {interior}");
        return Err(plugin.error(message));
    }
    Ok((interior, exterior))
}

/// The complex index: `eta` and `k`, or `material`; the perfect mirror (eta 0, k 1) if the file gives
/// neither.
///
/// Old files may give `extEta`, the index of the medium around the metal: it divides eta and k, as Mitsuba
/// 0.6 documents. (Mitsuba 3 rejects it.)
fn metal(tree: &Tree, plugin: &Plugin) -> Result<(Rgb, Rgb), LoadError> {
    let eta = spectra::read(tree, plugin, "eta", Role::ComplexIndex)?;
    let k = spectra::read(tree, plugin, "k", Role::ComplexIndex)?;
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
    Ok(index)
}
