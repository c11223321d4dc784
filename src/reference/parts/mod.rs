//! Runs in parts, traced apart and put together to the bits of the run in one piece.
//!
//! A part of a round has some replicates of it (photons, photon maps: exact integers, which may be added in
//! any order), or some rows of the image with all replicates (paths: each pixel's moments are made in one
//! place). A part of a pass of beams has some of its tasks (exact integers again, and what each task says of
//! its cells, in the tasks' order). So no division of the work can change a bit.
//!
//! One file a step: [`divided`] is what a method says of itself to be divided, and follows its schedule of
//! rounds; [`beams`] follows passes. [`identity`] tells runs apart, [`sums`] are what a part found
//! (`films.rs`, `moments.rs` and `beam_films.rs` read them), [`part`] is its file, [`gather`] puts parts
//! together as they come, and [`shards`] reads files of parts.

mod beam_films;
pub mod beams;
pub mod divided;
mod films;
pub mod gather;
mod hashed;
pub mod identity;
mod moments;
pub mod part;
mod path;
mod photon_map;
mod photons;
pub mod shards;
pub mod sums;

pub use divided::{Divided, GatherError, Next};
pub use gather::{Gathered, Step, Wanted};
pub use identity::ShardError;
pub use part::Part;
pub use shards::Shards;
