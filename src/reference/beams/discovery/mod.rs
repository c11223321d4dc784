//! Discovery of the path signatures that bring light to the sensor.

mod aim;
mod discover;
mod faces;
mod found;
mod inputs;
mod look;
mod places;
mod rare;

pub use discover::discover;
pub use found::{Discovery, Landing, Looked, SignatureLight};
pub use inputs::DiscoveryInputs;
