//! Thin beams: a ray of a delta emitter together with the light right beside it.
//!
//! A [`ThinBeam`] has a ray, its exact derivatives by the two coordinates of the light (see
//! [`RayDerivative`](crate::optics::RayDerivative)), and its share of the emitted flux. At its end, the
//! derivatives of the point are the columns of the Jacobian from light to receiver. The determinant is the
//! area that light of one unit of light-space measure spreads over; the columns span the parallelogram (the
//! "footprint") that it lights.
//!
//! A [`Follower`] follows beams in three ways. [`Follower::every_path`] goes along every branch of the
//! Fresnel tree, [`Follower::retrace`] along a given chain as the scene has it. [`Follower::along`] goes
//! along a given chain whatever is in the way, and extends flat surfaces: a smooth map, for root finders.

mod beam;
mod follow;

pub use beam::{ChainStep, Landing, ThinBeam, signature};
pub use follow::Follower;
