//! How a surface scatters light: what a path that starts at a camera needs of every material.
//!
//! A [`Bsdf`] is a material at one point of a surface: textures are looked up, masks are weighed, bump
//! and normal maps have turned the normal. All directions are unit vectors in world space and point
//! *away* from the surface. `wi` is the side a path comes from, `wo` the side it goes on to; which
//! of them light travels along is the meaning of [`Transport`].
//!
//! Light goes on in three ways, kept apart since an estimator can do different things with each:
//!
//! | part | what it is | how it is found |
//! |---|---|---|
//! | [`passed`](Bsdf::passed) | the share that goes straight on, as if nothing were there | [`sample`](Bsdf::sample), or by looking through |
//! | delta lobes | mirror reflection and refraction | [`sample`](Bsdf::sample) only |
//! | the rest | all that has a density over solid angle | [`eval`](Bsdf::eval), [`pdf_solid_angle`](Bsdf::pdf_solid_angle), [`sample`](Bsdf::sample) |
//!
//! The meaning of every parameter is that of Mitsuba 3.9.1, checked against it direction by direction
//! (`tests/scattering/mitsuba_oracle.rs`). In particular everything happens in the *shading* frame: which side a
//! direction is on is asked of the shading normal, as Mitsuba's `path` does. Where that and the true
//! normal disagree, [`Bsdf::is_consistent`] says so: Mitsuba's `ptracer` and this program's photons
//! leave such light out.
//!
//! # Light that travels along `wi`
//!
//! [`Transport::Flux`] is by definition the adjoint of [`Transport::Radiance`]. With n the true normal,
//!
//! ```text
//! eval_flux(wi, wo) = eval_radiance(wo, wi) |wo·n| / |wi·n|
//! ```
//!
//! for this makes what a camera's path and a photon's path count the same integral. The equation
//! holds two well-known rules: radiance that is refracted scales by (nᵢ/nₜ)² and flux does not, and
//! flux at a shading normal s scales by |wi·s wo·n| / |wi·n wo·s| (Veach 1997, 5.2 and 5.3).

mod at_point;
mod check;
mod layer;
mod lobe;
mod plastic;
mod resolve;
mod rough;
mod sample;
mod smooth;
mod turned;

pub use at_point::Bsdf;
pub use check::{UnknownColor, check_colors};
pub use sample::{BsdfSample, Scattering, Transport};
