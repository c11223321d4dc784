//! FLIP: the difference that a viewer sees who flips between two images, from 0 (none) to 1.
//!
//! - LDR-FLIP: Andersson, Nilsson, Akenine-Möller, Oskarsson, Åström, Fairchild, *FLIP: A Difference
//!   Evaluator for Alternating Images*, HPG 2020, with the separable kernels of the authors' later releases.
//! - HDR-FLIP: Andersson, Nilsson, Shirley, Akenine-Möller, *Visualizing Errors in Rendered High Dynamic
//!   Range Images*, Eurographics 2021: the largest LDR-FLIP over a range of exposures.
//!
//! `tests/compare/flip.rs` holds both against the authors' own package. The code is our own, since the only
//! crate (`nv-flip`) binds to their C++ and does LDR only.

mod colour;
mod display;
mod exposures;
mod filters;
mod images;
mod maps;
mod tile;

pub use exposures::Exposures;
pub use images::{Images, Planes};
pub use maps::{hdr, ldr};

/// Pixels a degree of vision at 0.7 m from a screen 0.7 m wide with 3840 pixels: the authors' default.
pub const PIXELS_PER_DEGREE: f32 = 0.7 * (3840.0 / 0.7) * (std::f32::consts::PI / 180.0);
