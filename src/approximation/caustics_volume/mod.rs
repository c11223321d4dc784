//! Caustics volumes: photons marched through pictures of slabs, one after the other.
//!
//! De Barro, Bugeja, Spina, Magro and Napoli, *A Lightweight Photon Tracing Method for Visualising Caustics*
//! (University of Malta), whose sections, figures and tables are cited as such. The paper has no equations;
//! what it leaves open is a setting here.
//!
//! An oriented [`cuboid`] about what mirrors and refracts is cut into slabs, parallel to its entry face.
//! Photons enter by that face, cross the slabs in order, leave by exit faces and are projected onto what is
//! around: S + 1 passes.
//!
//! | stage | file | variants | exact |
//! |---|---|---|---|
//! | `emission` | [`emission`] | `parallel`, `towards` | all faces, own directions and flux, shadows |
//! | `buffers` | [`buffers`], [`raster`] | `f16`, `f32` | axis rays at each photon's own place |
//! | `march` | [`march`] | `texels`, `steps` | the very crossing with what pictures hold |
//! | `layers` | [`slab`] | `near-far`, `peel` | the slab's surfaces by rays, any number of events |
//! | `interface` | [`meeting`] | `refract`, `mirror-total`, `schlick`, `fresnel` | all ways |
//! | `sweep` | [`sweep`] | `once` | any order and face |
//! | `projector` | [`projector`] | `cube`, `orthographic` | a ray to the next surface |
//! | `splat` | [`splat`], [`ellipse`], [`draw`] | `quads`, `ellipses` | [`beams`], dealt out by area |
//! | `smooth` | [`smooth`] | `gaussian` | none |
//!
//! [`lod`], [`update`] and [`frames`] are the optimisations of sections 3.5 and 4. [`advice`] says how many
//! slabs a scene needs. `warnings` knows what settings and shapes do not do, `ledger` accounts for flux, and
//! `darkness` says why an image has no light.
//!
//! The light that it is judged by is all of L S+ D.

pub mod advice;
pub mod beams;
pub mod buffers;
pub mod cuboid;
mod darkness;
pub mod demands;
pub mod draw;
pub mod ellipse;
pub mod emission;
pub mod frames;
pub mod ledger;
pub mod lod;
pub mod march;
pub mod meeting;
pub mod photon;
pub mod projector;
pub mod raster;
mod run;
pub mod settings;
pub mod slab;
pub mod smooth;
pub mod splat;
pub mod sweep;
mod technique;
pub mod update;
pub mod variants;
mod warnings;
pub mod work;

pub use settings::Settings;
pub use technique::CausticsVolume;
