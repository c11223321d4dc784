//! Ground truth for caustics: how much light reflection and refraction put on a
//! surface, with an error bar.
//!
//! # The map of the house
//!
//! A room imports only from its own folder or from lower floors; `tests/floors.rs`
//! enforces it.
//!
//! | floor | room | what happens there |
//! |---|---|---|
//! | 0 | [`numeric`], [`radiometry`], [`setting`] | exact sums, sample streams, quadrature; RGB quantities; what is wrong with a setting |
//! | 1 | [`geometry`], [`optics`], [`film`] | rays meet surfaces; interfaces bend light; grids of texels and their files |
//! | 2 | [`scene`] | immutable, validated: shapes, materials, emitters, sensors, and what they require modelled |
//! | 2 | [`generate`] | the meshes of the bundled scenes, made from formulas |
//! | 3 | [`mitsuba`] | Mitsuba 3 XML and mesh files become a scene |
//! | 4 | [`transport`] | light-space domains, specular chains, path signatures, deposits |
//! | 5 | [`mod@reference`] | ways to compute the truth |
//! | 5 | [`approximation`] | real-time techniques as pipelines of stages |
//! | 6 | [`metric`] | two images: differences, significance, equivalence |
//! | 7 | [`study`] | methods swept over settings, judged by a truth, reported; which stage makes an error |
//! | 8 | [`cli`] | one file a command |
//!
//! # Conventions
//!
//! - Lengths are scene units; fluxes W; irradiance W/m² (one scene unit is one metre);
//!   radiant intensity W/sr; radiance W/m²/sr. All of them linear RGB triples.
//! - Angles are radians; degrees only where a Mitsuba file has them.
//! - World space is right-handed, as in Mitsuba. Directions are unit vectors. A ray's
//!   direction is the direction of travel; `wi` and `wo` point away from the surface.
//! - `ior` is an absolute refractive index; `eta` is `n_transmitted / n_incident`.
//! - All results are computed in `f64`. Images are stored as `f32`.
#![warn(clippy::pedantic)]
#![allow(
    clippy::cast_possible_truncation,
    clippy::cast_precision_loss,
    clippy::cast_sign_loss,
    clippy::cast_lossless,
    clippy::many_single_char_names,
    clippy::similar_names,
    clippy::module_name_repetitions,
    clippy::must_use_candidate,
    clippy::float_cmp,
    clippy::suboptimal_flops,
    clippy::unreadable_literal
)]

pub mod approximation;
pub mod cli;
pub mod film;
pub mod generate;
pub mod geometry;
pub mod method;
pub mod metric;
pub mod mitsuba;
pub mod numeric;
pub mod optics;
pub mod radiometry;
pub mod reference;
pub mod run;
pub mod scene;
pub mod setting;
pub mod study;
pub mod transport;
