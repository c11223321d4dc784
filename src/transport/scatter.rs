//! What a surface makes of one ray: the branches light goes on along.

use glam::DVec3;

use super::signature::Event;
use crate::geometry::SurfacePoint;
use crate::optics::{
    conductor_reflectance, dielectric_reflectance, reflect, refract, thin_slab_reflectance,
};
use crate::radiometry::Rgb;
use crate::scene::{Material, Scene};

/// What interpolated normals do to the flux a ray carries.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum ShadingNormals {
    /// Flux changes by Fresnel's equations and absorption only: the ledger closes.
    #[default]
    Flux,
    /// Flux is also scaled by |ωi·ns ωo·ng| / |ωo·ns ωi·ng| at every specular event
    /// (Veach 1997, 5.3), as Mitsuba's `ptracer` does and any camera-side path tracer implies.
    Adjoint,
}

/// One way light goes on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Branch {
    /// The new direction of travel, a unit vector.
    pub direction: DVec3,
    /// What happened; `None` where light passed as if nothing were there.
    pub event: Option<Event>,
    /// The share of the arriving flux that takes this branch, before `tint`.
    pub share: f64,
    /// The factor that filters and metals put on it.
    pub tint: Rgb,
}

/// Hands every branch of light that travels along `direction` and meets `point` to `branch`:
/// passed, reflected, transmitted, in this order, each with a share above zero. What the shares
/// and tints do not carry on is absorbed; without any branch, all of it.
#[inline]
pub fn scatter(
    scene: &Scene,
    material: &Material,
    point: &SurfacePoint,
    direction: DVec3,
    shading_normals: ShadingNormals,
    branch: &mut impl FnMut(Branch),
) {
    let at = Meeting {
        point,
        direction,
        shading_normals,
    };
    at.scatter(scene, material, 1.0, branch);
}

/// A ray at a surface.
struct Meeting<'a> {
    point: &'a SurfacePoint,
    direction: DVec3,
    shading_normals: ShadingNormals,
}

impl Meeting<'_> {
    #[inline]
    fn scatter(
        &self,
        scene: &Scene,
        material: &Material,
        weight: f64,
        into: &mut impl FnMut(Branch),
    ) {
        let front = self.direction.dot(self.point.geometric_normal) < 0.0;
        match *material {
            Material::Diffuse { .. } => {}
            Material::Null => self.pass(weight, into),
            Material::Mask { opacity, nested } => {
                self.pass(weight * (1.0 - opacity), into);
                self.scatter(scene, scene.material(nested), weight * opacity, into);
            }
            Material::TwoSided {
                front: material_front,
                back,
            } => {
                let side = if front { material_front } else { back };
                self.one_side(scene, scene.material(side), weight, into);
            }
            Material::Conductor { .. } if !front => {}
            Material::Conductor { .. } => self.mirror(material, weight, into),
            Material::Dielectric {
                interior_ior,
                exterior_ior,
                specular_reflectance,
                specular_transmittance,
            } => {
                let eta = if front {
                    interior_ior / exterior_ior
                } else {
                    exterior_ior / interior_ior
                };
                if eta == 1.0 {
                    // Matched media: no interface, though Mitsuba still tints and counts it.
                    push(
                        into,
                        Branch {
                            direction: self.direction,
                            event: Some(Event::Transmission),
                            share: weight,
                            tint: specular_transmittance,
                        },
                    );
                    return;
                }
                let Some(normal) = self.facing_normal() else {
                    return;
                };
                let cos_incident = -self.direction.dot(normal);
                let reflectance = dielectric_reflectance(cos_incident, eta);
                self.push_reflection(normal, weight * reflectance, specular_reflectance, into);
                if let Some(direction) = refract(self.direction, normal, eta) {
                    self.push_checked(
                        Branch {
                            direction,
                            event: Some(Event::Transmission),
                            share: weight * (1.0 - reflectance),
                            tint: specular_transmittance,
                        },
                        normal,
                        into,
                    );
                }
            }
            Material::ThinDielectric {
                interior_ior,
                exterior_ior,
                specular_reflectance,
                specular_transmittance,
            } => {
                let Some(normal) = self.facing_normal() else {
                    return;
                };
                let cos_incident = -self.direction.dot(normal);
                let reflectance = thin_slab_reflectance(cos_incident, interior_ior / exterior_ior);
                self.push_reflection(normal, weight * reflectance, specular_reflectance, into);
                push(
                    into,
                    Branch {
                        direction: self.direction,
                        event: Some(Event::Transmission),
                        share: weight * (1.0 - reflectance),
                        tint: specular_transmittance,
                    },
                );
            }
        }
    }

    /// A material that stands on the side light arrives from, whichever that is.
    fn one_side(
        &self,
        scene: &Scene,
        material: &Material,
        weight: f64,
        into: &mut impl FnMut(Branch),
    ) {
        if let Material::Conductor { .. } = material {
            self.mirror(material, weight, into);
        } else {
            self.scatter(scene, material, weight, into);
        }
    }

    fn pass(&self, share: f64, into: &mut impl FnMut(Branch)) {
        push(
            into,
            Branch {
                direction: self.direction,
                event: None,
                share,
                tint: Rgb::WHITE,
            },
        );
    }

    fn mirror(&self, material: &Material, weight: f64, into: &mut impl FnMut(Branch)) {
        let Material::Conductor {
            eta,
            k,
            specular_reflectance,
        } = *material
        else {
            return;
        };
        let Some(normal) = self.facing_normal() else {
            return;
        };
        let cos_incident = -self.direction.dot(normal);
        let reflectance = if eta.is_grey() && k.is_grey() {
            Rgb::grey(conductor_reflectance(cos_incident, eta.0[0], k.0[0]))
        } else {
            Rgb(std::array::from_fn(|c| {
                conductor_reflectance(cos_incident, eta.0[c], k.0[c])
            }))
        };
        self.push_reflection(normal, weight, specular_reflectance * reflectance, into);
    }

    /// The shading normal on the side light arrives from; `None` where the shading normal and
    /// the true one disagree about that side: such light is absorbed, as in Mitsuba's `ptracer`.
    #[inline]
    fn facing_normal(&self) -> Option<DVec3> {
        let shading = self.point.shading_normal;
        let along = self.direction.dot(shading);
        let true_along = self.direction.dot(self.point.geometric_normal);
        if along * true_along <= 0.0 {
            return None;
        }
        Some(if along < 0.0 { shading } else { -shading })
    }

    #[inline]
    fn push_reflection(&self, normal: DVec3, share: f64, tint: Rgb, into: &mut impl FnMut(Branch)) {
        self.push_checked(
            Branch {
                direction: reflect(self.direction, normal),
                event: Some(Event::Reflection),
                share,
                tint,
            },
            normal,
            into,
        );
    }

    /// Adds a branch unless the true surface is in its way.
    #[inline]
    fn push_checked(&self, mut branch: Branch, normal: DVec3, into: &mut impl FnMut(Branch)) {
        let geometric = self.point.geometric_normal;
        let arrived = self.direction.dot(geometric);
        let leaves = branch.direction.dot(geometric);
        let reflects = branch.event == Some(Event::Reflection);
        if (arrived * leaves < 0.0) != reflects || leaves == 0.0 {
            return;
        }
        if self.shading_normals == ShadingNormals::Adjoint && self.point.shading_normal != geometric
        {
            let factor = (self.direction.dot(normal) * leaves
                / (branch.direction.dot(normal) * arrived))
                .abs();
            branch.tint *= factor;
        }
        push(into, branch);
    }
}

/// Hands on a branch that carries anything.
#[inline]
fn push(into: &mut impl FnMut(Branch), branch: Branch) {
    if branch.share > 0.0 {
        into(branch);
    }
}
