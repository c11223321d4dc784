//! The way from a scene's material to a [`Bsdf`] at a point.

use glam::DVec3;

use super::at_point::Bsdf;
use super::layer::BsdfLayer;
use super::lobe::Lobe;
use super::plastic::{Base, Plastic, RoughPlastic};
use super::principled::{PrincipledLobe, alphas};
use super::rough::{RoughInterface, RoughMetal};
use super::smooth::{Interface, SmoothMetal};
use super::turned::{TurnedNormal, raised};
use crate::geometry::{Frame, Hit, SurfacePoint};
use crate::optics::{FacetDistribution, Microfacets};
use crate::radiometry::Rgb;
use crate::scene::{
    Coat, Color, Material, NormalTurn, Principled, Roughness, Scalar, Scene, TexturePoint,
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
        let mut material = scene.material_of(hit.shape);
        let mut opacity = 1.0;
        while let Material::Mask {
            opacity: own,
            nested,
        } = material
        {
            opacity *= here.scalar(*own).clamp(0.0, 1.0);
            material = scene.material(*nested);
        }
        if *material == Material::Null {
            opacity = 0.0;
        }
        let (first, second) = match material {
            Material::TwoSided { front, back } => {
                (scene.material(*front), Some(scene.material(*back)))
            }
            _ => (material, None),
        };
        let uses_tangents = uses_tangents(scene, first)
            || second.is_some_and(|material| uses_tangents(scene, material));
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
            front: here.layer(&frame, first),
            back: second.map(|material| here.layer(&frame, material)),
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
        _ => material
            .nested()
            .any(|id| uses_tangents(scene, scene.material(id))),
    }
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

    fn layer(&self, frame: &Frame, material: &'a Material) -> BsdfLayer<'a> {
        let Material::Turned {
            by,
            flip_invalid_normals,
            use_shadowing_function,
            nested,
        } = material
        else {
            return BsdfLayer {
                lobe: self.lobe(material),
                turned: None,
            };
        };
        let normal = self.turned_normal(frame, by);
        BsdfLayer {
            lobe: self.lobe(self.scene.material(*nested)),
            turned: Some(TurnedNormal::new(
                normal,
                *flip_invalid_normals,
                *use_shadowing_function,
            )),
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
            Material::Null
            | Material::Mask { .. }
            | Material::TwoSided { .. }
            | Material::Turned { .. } => Lobe::Black,
        }
    }
}
