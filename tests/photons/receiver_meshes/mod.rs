//! Receivers that are meshes: texels over the file's (u, v) measure what the surface receives.
//!
//! Two independent truths: the same surface as an analytic rectangle, and, for the light of a point
//! without shadows, I times the solid angle of the surface in a texel.

mod areas;
mod mapping;
mod refusals;
mod scenes;
