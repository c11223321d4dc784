//! Photons binned into receiver texels: unbiased, on any scene, with a standard error.
//!
//! Photons start all over [light space](crate::transport::domain), are followed along
//! [chains](crate::transport::chain), and add their flux to the texel they end in: a box over
//! the texel, which is the very quantity wanted, so there is no bias. The sample points are
//! Owen-scrambled Sobol' points or plain random ones; the whole estimate is repeated with
//! independent randomisations ("replicates"), and their scatter gives each texel's standard
//! error, for both kinds of points alike. [`bounds`] hold where few photons arrived, or none.
//!
//! One file a step: [`mod@run`] spends the budget in rounds, [`replicate`] traces one randomisation,
//! [`pilot`] says beforehand what light there is, [`layers`] gives path signatures their layers, [`sums`]
//! keeps exact sums of a round, [`weights`] the largest contributions, [`finish`] turns them into an
//! [`Estimate`](crate::run::Estimate).

pub mod bounds;
pub mod finish;
pub mod layers;
pub mod pilot;
pub mod replicate;
pub mod run;
pub mod settings;
pub mod sums;
pub mod weights;

pub use run::run;
pub use settings::{DEFAULT_PHOTONS, PhotonSettings};
