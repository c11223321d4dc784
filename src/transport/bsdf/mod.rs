//! Scattering of light by a surface, for paths that start at a camera.
//!
//! A [`Bsdf`] is a material at one point of a surface. Textures are looked up, masks are weighed, and bump
//! and normal maps have turned the normal. All directions are unit vectors in world space and point *away*
//! from the surface. `wi` is the side that a path comes from, `wo` the side that it goes on to. [`Transport`]
//! tells along which of them light travels.
//!
//! Light goes on in three ways, kept apart since an estimator can treat each in its own way:
//!
//! | part | content | found by |
//! |---|---|---|
//! | [`passed`] | the share that goes straight on | [`sample`], or looking through |
//! | delta lobes | mirror reflection and refraction | [`sample`] only |
//! | the rest | light with a density | [`eval`], [`pdf_solid_angle`], [`sample`] |
//!
//! [`passed`]: Bsdf::passed
//! [`sample`]: Bsdf::sample
//! [`eval`]: Bsdf::eval
//! [`pdf_solid_angle`]: Bsdf::pdf_solid_angle
//!
//! The meaning of every parameter is that of Mitsuba 3.9.1, checked against it direction by direction
//! (`tests/scattering/mitsuba_oracle.rs`). In particular everything happens in the *shading* frame: the
//! shading normal decides on which side a direction is, as in Mitsuba's `path`. [`Bsdf::is_consistent`] tells
//! if the true normal agrees. If it does not, Mitsuba's `ptracer` and this program's photons leave the light
//! out.
//!
//! # Light that travels along `wi`
//!
//! [`Transport::Flux`] is by definition the adjoint of [`Transport::Radiance`]. With n the true normal,
//!
//! ```text
//! eval_flux(wi, wo) = eval_radiance(wo, wi) |wo·n| / |wi·n|
//! ```
//!
//! With this equation a camera's path and a photon's path count the same integral. It holds two well-known
//! rules (Veach 1997, 5.2 and 5.3). Refracted radiance scales by (nᵢ/nₜ)² and flux does not. Flux at a
//! shading normal s scales by |wi·s wo·n| / |wi·n wo·s|.

mod at_point;
mod check;
mod disney;
mod layer;
mod lobe;
mod plastic;
mod principled;
mod principled_thin;
mod resolve;
mod rough;
mod sample;
mod smooth;
mod turned;

pub use at_point::Bsdf;
pub use check::{UnknownColor, check_colors};
pub(super) use sample::cosine_hemisphere;
pub use sample::{BsdfSample, Scattering, Transport};
