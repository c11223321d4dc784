//! One interface, as light crosses it, and the share of it that does.

use glam::DVec3;

use crate::geometry::{Hit, SurfacePoint};
use crate::numeric::math;
use crate::optics::{RayDerivative, dielectric_reflectance, thin_slab_reflectance};
use crate::radiometry::Rgb;
use crate::scene::{Material, Scene};
use crate::setting::words::words;
use crate::transport::scatter::{Bending, Interaction, ShadingNormals, Way};

words! {
    /// The share of light that interfaces let through.
    Fresnel {
        /// All of it
        None = "none",
        /// Schlick's approximation
        Schlick = "schlick",
        /// Fresnel's equations
        Exact = "exact",
    }
}

/// A photon's way through one interface.
pub struct Crossing {
    /// Its unit direction from there on.
    pub direction: DVec3,
    /// The share of its flux that goes on, but for colours.
    pub share: f64,
    /// The factor that the surface's colour puts on it.
    pub tint: Rgb,
    /// The share of its flux that goes on.
    pub throughput: Rgb,
    /// The same by Fresnel's equations, whatever is modelled.
    pub by_fresnel: Rgb,
    /// What the interface does to rays beside it.
    pub bending: Bending,
}

/// Light that meets a surface, on one of the ways on; `None` where none goes there.
pub fn cross(
    scene: &Scene,
    shape: u32,
    point: &SurfacePoint,
    direction: DVec3,
    way: Way,
    fresnel: Fresnel,
) -> Option<Crossing> {
    let material = scene.material_of(shape);
    let interaction = Interaction::new(scene, material, point, direction, ShadingNormals::Flux);
    let share = interaction.share_of(way);
    if share <= 0.0 {
        return None;
    }
    let branch = interaction.branch::<3>(way)?;
    let front = direction.dot(point.geometric_normal) < 0.0;
    let cos = direction.dot(point.shading_normal).abs();
    let factor = match (fresnel, reflectance(material, front, cos, fresnel)) {
        // What is nested in masks and two-sided materials shares light out with them.
        (Fresnel::Exact, _) | (_, None) => share,
        (Fresnel::None, Some(_)) => 1.0,
        (Fresnel::Schlick, Some(reflected)) if way == Way::Reflected => reflected,
        (Fresnel::Schlick, Some(reflected)) => 1.0 - reflected,
    };
    Some(Crossing {
        direction: branch.direction,
        share: factor,
        tint: branch.tint.rgb(),
        throughput: branch.tint.rgb() * factor,
        by_fresnel: branch.tint.rgb() * share,
        bending: interaction.bending(way),
    })
}

/// The share of light that a plain dielectric or a thin pane reflects; `None` of other materials.
///
/// - `front`: whether light arrives from outside.
/// - `cos`: of the angle of incidence.
fn reflectance(material: &Material, front: bool, cos: f64, fresnel: Fresnel) -> Option<f64> {
    match (material, fresnel) {
        (Material::Dielectric { .. } | Material::ThinDielectric { .. }, Fresnel::None) => Some(0.0),
        (
            Material::Dielectric {
                interior_ior,
                exterior_ior,
                ..
            },
            _,
        ) => {
            let eta = interior_ior / exterior_ior;
            let eta = if front { eta } else { 1.0 / eta };
            Some(match fresnel {
                Fresnel::Schlick => schlick(cos, eta),
                Fresnel::None | Fresnel::Exact => dielectric_reflectance(cos, eta),
            })
        }
        (
            Material::ThinDielectric {
                interior_ior,
                exterior_ior,
                ..
            },
            _,
        ) => {
            let eta = interior_ior / exterior_ior;
            Some(match fresnel {
                Fresnel::Schlick => {
                    let one = schlick(cos, eta);
                    2.0 * one / (1.0 + one)
                }
                Fresnel::None | Fresnel::Exact => thin_slab_reflectance(cos, eta),
            })
        }
        _ => None,
    }
}

/// What is left of light that leaves an object from inside, by its index and colour.
///
/// - `cos`: of the angle of incidence at the inner side.
pub fn leaving(scene: &Scene, shape: u32, cos: f64, fresnel: Fresnel) -> Rgb {
    let material = scene.material_of(shape);
    let reflected = reflectance(material, false, cos, fresnel).unwrap_or(0.0);
    let tint = match material {
        Material::Dielectric {
            specular_transmittance,
            ..
        }
        | Material::ThinDielectric {
            specular_transmittance,
            ..
        } => specular_transmittance.even(),
        _ => Rgb::WHITE,
    };
    tint * (1.0 - reflected)
}

/// Reflectance by Schlick's approximation (1994), F₀ + (1 − F₀)(1 − cos)⁵, with the angle on the less dense
/// side.
///
/// - `cos_incident`: on the side light arrives from.
/// - `eta`: `n_transmitted / n_incident`. Below 1, beyond the critical angle, it is 1.
pub fn schlick(cos_incident: f64, eta: f64) -> f64 {
    let normal = dielectric_reflectance(1.0, eta);
    let sin_squared = (1.0 - cos_incident * cos_incident) / (eta * eta);
    let cos = if eta < 1.0 {
        (1.0 - sin_squared).max(0.0).sqrt()
    } else {
        cos_incident
    };
    normal + (1.0 - normal) * math::powi(1.0 - cos, 5)
}

/// How a beam that arrives at a surface leaves it, its normal turning by `turn`.
pub fn bent(
    arriving: [RayDerivative; 2],
    direction: DVec3,
    bending: Bending,
    turn: impl Fn(DVec3) -> DVec3,
) -> Option<[RayDerivative; 2]> {
    let [a, b] = arriving.map(|derivative| match bending {
        Bending::Straight => Some(derivative),
        Bending::Reflection { normal } => {
            Some(derivative.reflected(direction, normal, turn(derivative.position)))
        }
        Bending::Refraction { normal, eta } => {
            derivative.refracted(direction, normal, turn(derivative.position), eta)
        }
    });
    Some([a?, b?])
}

/// How the normal of a bending turns at a hit: the surface's own, or its opposite.
pub fn turning<'a>(
    scene: &'a Scene,
    hit: &'a Hit,
    point: &SurfacePoint,
    bending: Bending,
) -> impl Fn(DVec3) -> DVec3 + use<'a> {
    let sign = match bending {
        Bending::Straight => 0.0,
        Bending::Reflection { normal } | Bending::Refraction { normal, .. } => {
            normal.dot(point.shading_normal).signum()
        }
    };
    move |along| scene.world().normal_derivative(hit, along) * sign
}
