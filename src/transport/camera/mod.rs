//! Cameras: the film point at which light on a surface is seen, and the brightness there.
//!
//! A pixel of a box-filtered film holds the average radiance over the pixel, L = 1/A ∫ L(x) dx. Seen from the
//! surface, the same is an integral over the pixel's footprint. In camera space, let q = (x, y, 1) be a film
//! point on the plane z = 1. Let M be the linear part of the camera's map to the world, and d the distance.
//! Then the footprint's area is
//!
//! ```text
//! dA cos θ / d² = dω = |det M| / |M q|³ dx dy
//! ```
//!
//! (for a rigid M: dx dy cos³ of the angle to the axis). Flux Φ that arrives at a point of a Lambertian
//! surface leaves it with radiance ρ/π Φ/dA. So a pixel of area A on the plane z = 1 gains
//!
//! ```text
//! L = Φ · ρ/π · cos θ |M q|³ / (d² |det M| A)
//! ```
//!
//! This is the measurement contribution of Veach 1997 (*Robust Monte Carlo methods for light transport
//! simulation*), chapter 8: the BRDF times the geometric term times the pixel's importance We. We is that of
//! Pharr, Jakob and Humphreys, *Physically Based Rendering*, 3rd edition, 16.1.1, for one pixel instead of
//! the film.
//!
//! For parallel projection along the unit vector a, areas across a take the place of solid angles. With X and
//! Y the first columns of M,
//!
//! ```text
//! dA cos θ = |a · (X × Y)| dx dy
//! ```
//!
//! Through a thin lens, a pixel's radiance is also the average over the lens. For each of its points the
//! equations are those of a pinhole there. The pinhole's film is shifted so that the plane in focus stays in
//! place.

mod connect;
mod diffuse;
mod error;
mod lens;
mod projection;

pub use connect::Connection;
pub(crate) use diffuse::reflectance;
pub use error::CameraError;
pub use projection::{Camera, CameraProjection, NearPlane, PixelRay};
