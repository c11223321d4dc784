//! Division of cells until their light is placed well enough.

mod balance;
mod border;
mod density;
mod limits;
mod nodes;
mod refiner;
mod sound;

pub use balance::Balance;
pub use limits::{Asked, Limits};
pub(super) use refiner::misplaced;
pub use refiner::{LeftLight, MOST_LEFT, Refiner, Scratch, scratch_bytes};
pub use sound::Sounding;
