//! From an emitter, along specular chains, to a sensor.
//!
//! A [`domain`] says where light can leave an emitter and meet specular geometry; a
//! [`chain`] follows one ray of it through reflections and refractions; a [`receiver`]
//! says which texel the end of a chain falls in; [`direct`] measures the light that met
//! nothing specular. Every reference and every approximation is built from these.

pub mod chain;
pub mod direct;
pub mod domain;
pub mod facets;
pub mod first_surface;
pub mod flux;
pub mod ledger;
pub mod prescribed;
pub mod receiver;
pub mod scatter;
pub mod screen;
pub mod signature;
