//! Transport of light from an emitter, along specular chains, to a sensor.
//!
//! A [`domain`] holds the light that can leave an emitter and meet specular geometry. A [`chain`] follows one
//! ray of it through reflections and refractions. [`chain_limits`] lists the light that chains leave out.
//!
//! A [`receiver`] finds the texel in which a chain ends. A [`camera`] finds the film point at which this end
//! is seen, and [`visibility`] tells if anything hides it. A [`screen`] is either of the two.
//!
//! [`bsdf`], [`lights`] and [`path_class`] serve paths that start at a camera. The first describes the
//! scattering of any surface, the second the light that may arrive there. The third names the kinds of paths
//! that a method finds. [`direct`] measures the light that met nothing specular.
//!
//! Beams name rays by their [`first_surface`] and follow the events of a [`fixed_signature`]. [`media`]
//! absorb light between surfaces. [`differentials`] follow the light right beside a ray. Every reference and
//! every approximation is built from these.

pub mod bsdf;
pub mod camera;
pub mod chain;
pub mod chain_limits;
pub mod clearance;
pub mod differentials;
pub mod direct;
pub mod domain;
pub mod facets;
pub mod first_surface;
pub mod fixed_signature;
pub mod flux;
pub mod followed;
pub mod glossy;
pub mod ledger;
pub mod lights;
pub mod media;
pub mod path_class;
pub mod path_end;
pub mod receiver;
pub mod scatter;
pub mod screen;
pub mod signature;
pub mod visibility;
