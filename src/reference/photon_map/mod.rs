//! Progressive photon mapping: caustics that a camera sees by way of mirrors and glass.
//!
//! Light that meets a mirror or glass on both sides of a matt surface (L S+ D S+ E, "SDS") can neither be
//! connected to a pinhole camera nor, from a camera, to a small lamp. Photon maps join the two ends at the
//! matt surface, approximately: photons that fell *near* the point that is seen stand for those that fell on
//! it.
//!
//! Photons are those of the [photon loop](super::photons::replicate), kept where they meet surfaces that
//! scatter ([`map`]). From every pixel a ray goes along specular chains to the points it sees ([`view`]),
//! where the photons within a radius are looked up (`gather.rs`). Many such passes with ever smaller radii
//! are averaged (Hachisuka, Ogaki and Jensen, *Progressive Photon Mapping*, ACM TOG 27(5), 2008; Hachisuka
//! and Jensen, *Stochastic Progressive Photon Mapping*, ACM TOG 28(5), 2009), by the schedule of independent
//! passes of Knaus and Zwicker ([`settings`]): the variance and the bias of the mean both vanish.
//!
//! **The bias is stated.** Every lookup is made with r and with √2 r. Their difference says what the blur
//! adds, as a Laplacian would (Hachisuka, Jarosz and Jensen, *A Progressive Error Estimation Framework for
//! Photon Density Estimation*, ACM TOG 29(6), 2010), at borders too ([`finish`]). Independent replicates give
//! the standard errors of the value and of the bias. An estimate's `interval` holds both.
//!
//! Photons of another shape than the one seen do not count. Beyond a surface's border and across its bends a
//! disc is not all surface: that is part of the bias.

pub mod finish;
pub(super) mod gather;
pub mod map;
mod pilot;
pub mod run;
pub mod settings;
pub mod setup;
pub(super) mod sums;
pub mod view;

pub use finish::PhotonMapReport;
pub use map::PHOTON_BYTES;
pub use run::run;
pub use settings::{PhotonMapSettings, Seen};
