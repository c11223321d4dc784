//! Every specular path from lights without size to one receiver point, by root finding.
//!
//! Light of a delta emitter is a two-dimensional family of rays; each chain of specular surfaces maps it to the
//! receiver. At a point, the irradiance is a sum over the preimages x of the point under all these maps,
//!
//! ```text
//! E = Σ w(x) / |det J(x)|
//! ```
//!
//! with w the flux per unit of light-space measure (intensity per solid angle, or irradiance across parallel light) times
//! Fresnel's shares and tints, and det J the receiver area per unit of that measure (Mitchell and Hanrahan, *Illumination from
//! curved reflectors*, SIGGRAPH 1992). Nothing is sampled at random and nothing averaged: this is the *pointwise* irradiance,
//! infinite on a fold, where every other method measures averages over texels. It shares with those the
//! intersections and Fresnel's formulas, but neither cells, nor densities, nor deposits: an independent check.
//!
//! # How preimages are found
//!
//! The cells of [light space](crate::transport::domain) are looked at on 3 x 3 nodes: `search` traces the full Fresnel tree
//! with [derivatives](crate::transport::differentials) at each, and divides a patch until each chain in it
//! is either away from the point, by a margin from its second differences, or so nearly linear that it meets the point once at
//! most. There `newton` finds the root; `path` traces it through the scene as it is.
//!
//! # What it does not promise
//!
//! A feature that none of the nodes' rays meets is not known: nodes stand about 1/100 of the specular geometry's width apart at first
//! ([`ProbeSettings::first_level`] halves that at each step, and outlines seen from the emitter are divided four times in any case). So small
//! facets and far occluders' outlines can be missed: tests hold it to a diamond's polygons of light down to 1/30 of its width; one of 1/150 was missed. Margins come from samples; they are no interval proof. Patches that
//! stay unclear to the last level, as they must where the point lies *on* a fold or a focus, are counted in
//! [`Probed::unresolved`]. On a focus each level may have twice the patches of the one before: there
//! [`ProbeSettings::max_rays`] ends the search, and [`Probed::end`] says so.

mod direct;
mod error;
mod found;
mod map;
mod newton;
mod path;
mod run;
mod search;
mod settings;
mod sheet;
mod target;

pub use error::ProbeError;
pub use found::{Probed, SearchEnd, SpecularPath, Vertex};
pub use run::{probe, probe_until};
pub use search::MAX_LEVEL;
pub use settings::ProbeSettings;
