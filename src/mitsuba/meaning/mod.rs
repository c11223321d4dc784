//! The second step: the meaning of the plugins in the files.
//!
//! There is one file for each kind of object. Each plugin asks for the properties it knows, with their units
//! and limits; a property that nobody asked for is an error, as in Mitsuba. Defaults and meanings are those
//! of Mitsuba 3.9.1, `scalar_rgb`.

mod cie;
mod emitters;
mod field_of_view;
mod film;
mod forms;
mod ignored;
mod integrator;
mod ior;
mod materials;
mod media;
mod metals;
mod plugin;
mod scene;
mod sensors;
mod spectra;
mod sunsky;
mod textures;

pub use scene::{Meaning, read};
