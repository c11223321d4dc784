//! Emitters as a point of the scene sees them: what a path that starts at a camera asks of light.
//!
//! Three questions, which multiple importance sampling (Veach 1997, chapter 9) puts together:
//!
//! | question | answered by |
//! |---|---|
//! | in which direction may light come from? | [`sample`](Lights::sample) |
//! | what does the light shine that this ray met? | [`emitted`](Lights::emitted) |
//! | how likely would `sample` have chosen this ray? | [`pdf_solid_angle`](Lights::pdf_solid_angle) |
//!
//! `sample` first chooses an emitter, all with the same probability as Mitsuba's `path` does, then a
//! direction towards it. Nobody has looked yet whether anything is in the way: see
//! [`visibility`](super::visibility) and [`LightSample::reach`]. So with any other sampling of directions
//! that has a density q, and w the weights of that sampling and this one (w + w' = 1),
//!
//! ```text
//! ∫ L f cos θ dω = E[ w'  radiance_over_pdf · visible · f cos θ ]  +  E_q[ w · emitted · f cos θ / q ]
//! ```
//!
//! A surface shines on its front only, which is where its *true* normal points (Mitsuba asks the shading normal of a
//! mesh; photons ask the true one, and so must every method that they are compared with).

mod area;
mod delta;
mod environment;
mod sample;
mod scene_lights;
mod sphere;

pub use sample::LightSample;
pub use scene_lights::Lights;
