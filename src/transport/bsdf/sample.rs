//! Sampled directions, of a whole material and of one lobe.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::numeric::math;
use crate::radiometry::Rgb;

/// The quantity that a path carries from `wi` to `wo`.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Transport {
    /// Radiance: the path starts at a camera. Light travels along it backwards, in through `wo` and out
    /// through `wi`, and its radiance scales by (nᵢ/nₜ)² if it is refracted.
    Radiance,
    /// Flux: the path starts at a light. Flux arrives from `wi` and leaves towards `wo`.
    Flux,
}

/// The kind of event that a sampled direction belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum Scattering {
    /// Straight on, as if nothing were there: no event.
    Passed,
    /// Reflected at an interface, smooth or rough.
    Reflected,
    /// Refracted or passed through an interface, smooth or rough.
    Transmitted,
    /// Scattered below the interface, or by a matt surface.
    Diffuse,
}

/// A direction that a path may go on along.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BsdfSample {
    /// A unit vector that points away from the surface.
    pub wo: DVec3,
    /// The factor on the quantity that the path carries: f |cos θ| / density. For delta lobes and passing
    /// light it is the share divided by its probability.
    pub weight: Rgb,
    /// The density [1/sr] of directions that have one: for radiance
    /// [`Bsdf::pdf_solid_angle`](super::Bsdf::pdf_solid_angle). For delta lobes and passing light it is the
    /// probability of the choice.
    pub pdf_solid_angle: f64,
    /// True if the direction was chosen from finitely many, which `eval` leaves out.
    pub is_delta: bool,
    /// `n_transmitted / n_incident` as the path goes, from wi's side to wo's; 1 if it stays on its side or
    /// nothing bends it. Russian roulette on radiance divides it out.
    pub eta: f64,
    /// The kind of event.
    pub scattering: Scattering,
}

/// A direction sampled from a lobe; as [`super::BsdfSample`], in the lobe's frame.
#[derive(Clone, Copy, Debug)]
pub(super) struct LobeSample {
    pub wo: DVec3,
    pub weight: Rgb,
    pub pdf: f64,
    pub is_delta: bool,
    pub eta: f64,
    pub scattering: Scattering,
}

/// A direction with density cos θ / π (Malley's method).
#[inline]
pub(in crate::transport) fn cosine_hemisphere(u: [f64; 2]) -> DVec3 {
    let radius = u[0].sqrt();
    let (sin, cos) = math::sin_cos(TAU * u[1]);
    DVec3::new(radius * cos, radius * sin, (1.0 - u[0]).sqrt())
}
