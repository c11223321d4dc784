//! The way from a scene's material to a [`Bsdf`] at a point.

use glam::DVec3;

use super::at_point::Bsdf;
use super::disney::alphas;
use super::layer::{BsdfLayer, LayerList};
use super::lobe::Lobe;
use super::plastic::{Base, Plastic, RoughPlastic};
use super::principled::PrincipledLobe;
use super::principled_thin::PrincipledThinLobe;
use super::rough::{RoughInterface, RoughMetal};
use super::smooth::{Interface, SmoothMetal};
use super::turned::{TurnedNormal, raised};
use crate::geometry::{Frame, Hit, SurfacePoint};
use crate::optics::{FacetDistribution, Microfacets};
use crate::radiometry::Rgb;
use crate::scene::{
    Coat, Color, Material, NormalTurn, Principled, PrincipledThin, Roughness, Scalar, Scene,
    TexturePoint,
};

impl<'a> Bsdf<'a> {
    /// The material that a ray met at `hit`. Unknown colours are black: see
    /// [`check_colors`](super::check_colors).
    ///
    /// `point` must be [`World::surface_point`] of it, for its `uv`.
    ///
    /// [`World::surface_point`]: crate::geometry::World::surface_point
    ///
    /// Looks through masks, on both sides and below turned normals, and looks up all textures.
    pub fn at(scene: &'a Scene, hit: &Hit, point: &SurfacePoint) -> Self {
        let here = Here {
            scene,
            hit,
            point,
            texture: TexturePoint::new(scene, hit, point),
        };
        let (opacity, material) = scene
            .material_of(hit.shape)
            .below_masks(scene.materials(), |opacity| here.scalar(opacity));
        let uses_tangents = uses_tangents(scene, material);
        let frame = if uses_tangents {
            let [dp_du, _] = scene.world().tangents(hit, point);
            Frame::along(point.shading_normal, dp_du)
        } else {
            Frame::around(point.shading_normal)
        };
        Self {
            geometric_normal: point.geometric_normal,
            frame,
            passed: 1.0 - opacity,
            front: here.layers(&frame, material, false),
            back: has_two_sides(scene, material).then(|| here.layers(&frame, material, true)),
        }
    }
}

/// True if the direction in which u grows matters.
fn uses_tangents(scene: &Scene, material: &Material) -> bool {
    match material {
        Material::Turned { .. } => true,
        Material::RoughConductor { roughness, .. }
        | Material::RoughDielectric { roughness, .. } => roughness.alpha_u != roughness.alpha_v,
        Material::Principled(principled) => principled.anisotropic.may_exceed_zero(),
        Material::PrincipledThin(sheet) => sheet.anisotropic.may_exceed_zero(),
        _ => material
            .nested()
            .any(|id| uses_tangents(scene, scene.material(id))),
    }
}

/// True if its back has a material of its own, or part of it has.
fn has_two_sides(scene: &Scene, material: &Material) -> bool {
    match material {
        Material::TwoSided { .. } => true,
        Material::Blend { nested, .. } => nested
            .iter()
            .any(|id| has_two_sides(scene, scene.material(*id))),
        _ => false,
    }
}

/// The wrappers that are taken off a material on the way to a layer.
#[derive(Clone, Copy)]
struct Unwrapped {
    on_back: bool,
    is_mirrored: bool,
    turned: Option<TurnedNormal>,
    weight: f64,
}

/// The point at which textures are looked up.
struct Here<'a, 'p> {
    scene: &'a Scene,
    hit: &'p Hit,
    point: &'p SurfacePoint,
    texture: TexturePoint<'a>,
}

impl<'a> Here<'a, '_> {
    fn scalar(&self, scalar: Scalar) -> f64 {
        self.scene.scalar(scalar, &self.texture)
    }

    fn color(&self, color: Color) -> Rgb {
        self.scene.color(color, &self.texture)
    }

    /// What light meets on one side.
    fn layers(&self, frame: &Frame, material: &'a Material, on_back: bool) -> LayerList<'a> {
        let mut wrappers = Unwrapped {
            on_back,
            is_mirrored: false,
            turned: None,
            weight: 1.0,
        };
        let material = self.unwrap(frame, material, &mut wrappers);
        if matches!(material, Material::Blend { .. }) {
            let mut layers = Vec::new();
            self.add(frame, material, wrappers, &mut layers);
            LayerList::Blend(layers)
        } else {
            LayerList::One(self.layer(material, wrappers))
        }
    }

    /// Adds the layers of a material: those of a blend's second part first, as Mitsuba divides its numbers.
    fn add(
        &self,
        frame: &Frame,
        material: &'a Material,
        mut wrappers: Unwrapped,
        layers: &mut Vec<BsdfLayer<'a>>,
    ) {
        let material = self.unwrap(frame, material, &mut wrappers);
        let Material::Blend { weight, nested } = material else {
            return layers.push(self.layer(material, wrappers));
        };
        let weight = match self.scalar(*weight) {
            number if number.is_nan() => 0.0,
            number => number.clamp(0.0, 1.0),
        };
        for (id, share) in [(nested[1], weight), (nested[0], 1.0 - weight)] {
            if share > 0.0 {
                let wrappers = Unwrapped {
                    weight: wrappers.weight * share,
                    ..wrappers
                };
                self.add(frame, self.scene.material(id), wrappers, layers);
            }
        }
    }

    /// Takes off wrappers, down to a plain material or a blend.
    fn unwrap(
        &self,
        frame: &Frame,
        mut material: &'a Material,
        wrappers: &mut Unwrapped,
    ) -> &'a Material {
        loop {
            match material {
                Material::TwoSided { front, back } => {
                    wrappers.is_mirrored = wrappers.on_back;
                    let side = if wrappers.on_back { back } else { front };
                    material = self.scene.material(*side);
                }
                Material::Turned {
                    by,
                    flip_invalid_normals,
                    use_shadowing_function,
                    nested,
                } => {
                    wrappers.turned = Some(TurnedNormal::new(
                        self.turned_normal(frame, by),
                        *flip_invalid_normals,
                        *use_shadowing_function,
                    ));
                    material = self.scene.material(*nested);
                }
                _ => return material,
            }
        }
    }

    fn layer(&self, material: &'a Material, wrappers: Unwrapped) -> BsdfLayer<'a> {
        BsdfLayer {
            lobe: self.lobe(material),
            turned: wrappers.turned,
            is_mirrored: wrappers.is_mirrored,
            weight: wrappers.weight,
        }
    }

    /// The turned normal, in the shading frame and of any length.
    fn turned_normal(&self, frame: &Frame, by: &NormalTurn) -> DVec3 {
        match *by {
            NormalTurn::Height { texture, scale } => {
                let slope = self.scene.texture_gradient(texture, &self.texture) * scale;
                let tangents = self.scene.world().tangents(self.hit, self.point);
                raised(frame, self.point.geometric_normal, tangents, slope)
            }
            NormalTurn::Normal { color } => DVec3::from_array(self.color(color).0) * 2.0 - 1.0,
        }
    }

    fn facets(&self, roughness: &Roughness) -> Microfacets {
        let alpha = [roughness.alpha_u, roughness.alpha_v].map(|alpha| self.scalar(alpha));
        Microfacets::new(roughness.distribution, alpha)
    }

    fn base(&self, coat: &Coat) -> Base {
        Base {
            eta: coat.interior_ior / coat.exterior_ior,
            diffuse_reflectance: self.color(coat.diffuse_reflectance),
            specular_reflectance: self.color(coat.specular_reflectance),
            nonlinear: coat.nonlinear,
        }
    }

    fn principled(&self, material: &Principled) -> PrincipledLobe {
        let share = |scalar| self.scalar(scalar).clamp(0.0, 1.0);
        let roughness = share(material.roughness);
        let alphas = alphas(roughness, share(material.anisotropic));
        PrincipledLobe {
            base_color: self.color(material.base_color),
            roughness,
            facets: Microfacets::new(FacetDistribution::Ggx, alphas),
            metallic: share(material.metallic),
            spec_trans: share(material.spec_trans),
            eta: material.eta,
            spec_tint: share(material.spec_tint),
            sheen: share(material.sheen),
            sheen_tint: share(material.sheen_tint),
            flatness: share(material.flatness),
            clearcoat: share(material.clearcoat),
            clearcoat_gloss: share(material.clearcoat_gloss),
        }
    }

    fn principled_thin(&self, sheet: &PrincipledThin) -> PrincipledThinLobe {
        let share = |scalar| self.scalar(scalar).clamp(0.0, 1.0);
        PrincipledThinLobe {
            base_color: self.color(sheet.base_color),
            roughness: share(sheet.roughness),
            anisotropic: share(sheet.anisotropic),
            spec_trans: share(sheet.spec_trans),
            eta: sheet.eta,
            spec_tint: share(sheet.spec_tint),
            sheen: share(sheet.sheen),
            sheen_tint: share(sheet.sheen_tint),
            flatness: share(sheet.flatness),
            crossing: (0.5 * self.scalar(sheet.diff_trans)).clamp(0.0, 1.0),
        }
    }

    /// The lobe of a plain material at this point.
    fn lobe(&self, material: &'a Material) -> Lobe<'a> {
        match material {
            Material::Diffuse { reflectance } => Lobe::Diffuse(self.color(*reflectance)),
            Material::Dielectric {
                interior_ior,
                exterior_ior,
                specular_reflectance,
                specular_transmittance,
            }
            | Material::ThinDielectric {
                interior_ior,
                exterior_ior,
                specular_reflectance,
                specular_transmittance,
            } => {
                let interface = Interface {
                    eta: interior_ior / exterior_ior,
                    specular_reflectance: self.color(*specular_reflectance),
                    specular_transmittance: self.color(*specular_transmittance),
                };
                if matches!(material, Material::Dielectric { .. }) {
                    Lobe::Dielectric(interface)
                } else {
                    Lobe::Pane(interface)
                }
            }
            Material::Conductor {
                eta,
                k,
                specular_reflectance,
            } => Lobe::Conductor(SmoothMetal {
                eta: *eta,
                k: *k,
                specular_reflectance: self.color(*specular_reflectance),
            }),
            Material::RoughDielectric {
                interior_ior,
                exterior_ior,
                specular_reflectance,
                specular_transmittance,
                roughness,
            } => Lobe::RoughDielectric(RoughInterface {
                interface: Interface {
                    eta: interior_ior / exterior_ior,
                    specular_reflectance: self.color(*specular_reflectance),
                    specular_transmittance: self.color(*specular_transmittance),
                },
                facets: self.facets(roughness),
            }),
            Material::RoughConductor {
                eta,
                k,
                specular_reflectance,
                roughness,
            } => Lobe::RoughConductor(RoughMetal {
                metal: SmoothMetal {
                    eta: *eta,
                    k: *k,
                    specular_reflectance: self.color(*specular_reflectance),
                },
                facets: self.facets(roughness),
            }),
            Material::Plastic(coat) => Lobe::Plastic(Plastic {
                base: self.base(coat),
            }),
            Material::RoughPlastic {
                coat,
                distribution,
                alpha,
                transmittance,
            } => Lobe::RoughPlastic(RoughPlastic {
                base: self.base(coat),
                facets: Microfacets::new(*distribution, [*alpha; 2]),
                transmittance,
            }),
            Material::Principled(principled) => {
                Lobe::Principled(Box::new(self.principled(principled)))
            }
            Material::PrincipledThin(sheet) => {
                Lobe::PrincipledThin(Box::new(self.principled_thin(sheet)))
            }
            Material::Null
            | Material::Mask { .. }
            | Material::TwoSided { .. }
            | Material::Blend { .. }
            | Material::Turned { .. } => Lobe::Black,
        }
    }
}
