//! Every specular path from lights without size to one receiver point, by root finding.
//!
//! Light of a delta emitter is a two-dimensional family of rays; each chain of specular surfaces maps it to
//! the receiver. At a point, the irradiance is a sum over the preimages x of the point under all these maps,
//!
//! ```text
//! E = Σ w(x) / |det J(x)|
//! ```
//!
//! (Mitchell and Hanrahan, *Illumination from curved reflectors*, SIGGRAPH 1992). Here w is the flux per unit
//! of light-space measure times Fresnel's shares and tints. The flux is intensity per solid angle, or
//! irradiance across parallel light; det J is the receiver area per unit of that measure. Nothing is sampled
//! at random and nothing is averaged. The result is the *pointwise* irradiance, infinite on a fold; every
//! other method measures averages over texels. With those it shares the intersections and Fresnel's formulas,
//! but neither cells, nor densities, nor deposits: it is an independent check.
//!
//! # How preimages are found
//!
//! `search` traces the cells of [light space](crate::transport::domain) at 3 x 3 nodes each: the full Fresnel
//! tree, with [derivatives](crate::transport::differentials). It divides a patch until each chain in it is
//! clear. Either the chain is away from the point, by a margin from its second differences. Or it is so
//! nearly linear that it meets the point once at most. Then `newton` finds the root, and `path` traces it
//! through the scene as it is.
//!
//! # What it does not promise
//!
//! A feature that none of the nodes' rays meets stays unknown. At first, nodes stand about 1/100 of the
//! specular geometry's width apart. [`ProbeSettings::first_level`] halves that at each step, and outlines
//! seen from the emitter are divided four times in any case. So small facets and far occluders' outlines can
//! be missed. Tests require a diamond's polygons of light down to 1/30 of its width; one of 1/150 was missed.
//! Margins come from samples; they are no interval proof.
//!
//! Some patches stay unclear to the last level, as they must if the point lies *on* a fold or a focus:
//! [`Probed::unresolved`] counts them. On a focus each level may have twice the patches of the one before.
//! There [`ProbeSettings::max_rays`] ends the search, and [`Probed::end`] says so.

mod direct;
mod error;
mod found;
mod map;
mod newton;
mod path;
mod report;
mod run;
mod search;
mod settings;
mod sheet;
mod target;

pub use error::ProbeError;
pub use found::{Probed, SearchEnd, SpecularPath, Vertex};
pub use report::{PathLine, ProbeReport, VertexLine};
pub use run::{probe, probe_until};
pub use search::MAX_LEVEL;
pub use settings::{MAX_RAYS, MAX_REFINE, ProbeSettings};
