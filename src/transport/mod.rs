//! From an emitter, along specular chains, to a sensor.
//!
//! A [`domain`] says where light can leave an emitter and meet specular geometry; a
//! [`chain`] follows one ray of it through reflections and refractions ([`chain_limits`] says what that leaves out); a [`receiver`]
//! says which texel the end of a chain falls in, and a [`camera`] where on its film that is seen;
//! [`visibility`] says whether; [`bsdf`] says how any surface scatters, [`lights`] what may shine on it and [`path_class`] which
//! paths a method finds, for those that start at a camera; [`direct`] measures the light that met nothing specular. Beams name
//! rays by their [`first_surface`] and follow events of a [`fixed_signature`] to a [`screen`];
//! [`differentials`] follow the light right beside a ray. Every reference and every approximation
//! is built from these.

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
pub mod ledger;
pub mod lights;
pub mod path_class;
pub mod path_end;
pub mod receiver;
pub mod scatter;
pub mod screen;
pub mod signature;
pub mod visibility;
