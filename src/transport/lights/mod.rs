//! Emitters as a point of the scene sees them, for paths that start at a camera.
//!
//! A path has three questions, which multiple importance sampling (Veach 1997, chapter 9) puts together:
//!
//! | question | answered by |
//! |---|---|
//! | in which direction may light come from? | [`sample`](Lights::sample) |
//! | what does the light shine that this ray met? | [`emitted`](Lights::emitted) |
//! | how likely would `sample` have chosen this ray? | [`emitted_and_pdf`](Lights::emitted_and_pdf) |
//!
//! `sample` first chooses an emitter, all with the same probability as Mitsuba's `path` does, then a
//! direction towards it. The sample does not tell if anything is in the way: see
//! [`visibility`](super::visibility) and [`LightSample::reach`]. Let q be the density of any other sampling
//! of directions. Let w and w' be the weights of that sampling and this one (w + w' = 1). Then
//!
//! ```text
//! ∫ L f cos θ dω = E[ w'  radiance_over_pdf · visible · f cos θ ]  +  E_q[ w · emitted · f cos θ / q ]
//! ```
//!
//! A surface shines on its front only, the side to which its *true* normal points. Mitsuba uses the shading
//! normal of a mesh. Photons use the true one, and so must every method that they are compared with.

mod area;
mod delta;
mod environment;
mod sample;
mod scene_lights;
mod sphere;

pub(super) use environment::Environment;
pub use sample::LightSample;
pub use scene_lights::Lights;
