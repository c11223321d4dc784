//! One interface, as photons of both variants of stage `refraction` cross it; with stage `fresnel`, how much
//! of them does.

use glam::DVec3;

use crate::geometry::{Hit, SurfacePoint};
use crate::optics::{RayDerivative, dielectric_reflectance};
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
    /// The share of its flux that goes on.
    pub throughput: Rgb,
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
    let factor = match (fresnel, relative_index(material, point, direction)) {
        (Fresnel::Exact, _) | (_, None) => share,
        (Fresnel::None, Some(_)) => 1.0,
        (Fresnel::Schlick, Some(eta)) => {
            let reflected = schlick(direction.dot(point.shading_normal).abs(), eta);
            if way == Way::Reflected {
                reflected
            } else {
                1.0 - reflected
            }
        }
    };
    Some(Crossing {
        direction: branch.direction,
        throughput: branch.tint.rgb() * factor,
        bending: interaction.bending(way),
    })
}

/// `n_transmitted / n_incident` of a plain dielectric.
fn relative_index(material: &Material, point: &SurfacePoint, direction: DVec3) -> Option<f64> {
    let Material::Dielectric {
        interior_ior,
        exterior_ior,
        ..
    } = material
    else {
        return None;
    };
    let eta = interior_ior / exterior_ior;
    let front = direction.dot(point.geometric_normal) < 0.0;
    Some(if front { eta } else { 1.0 / eta })
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
    normal + (1.0 - normal) * (1.0 - cos).powi(5)
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

/// What an interface takes of transmitted light beside Fresnel's share.
pub fn tint(scene: &Scene, shape: u32) -> Rgb {
    match scene.material_of(shape) {
        Material::Dielectric {
            specular_transmittance,
            ..
        } => specular_transmittance.even(),
        _ => Rgb::WHITE,
    }
}
