//! Scenes whose light is known by formula: the truth that tests hold every other method to.
//!
//! Nothing here traces the scene. Each module derives its own map from the light to the receiver, in the
//! plane or by symmetry. It shares with the tracer only the Fresnel formulas. Every result is the
//! *texel-averaged* irradiance, as in all of this program, so that it is finite on caustics too.
//!
//! | module's type | scene | method |
//! |---|---|---|
//! | [`GlassBall`] | a ball on the axis of a point or parallel light | radial map, texel-exact |
//! | [`PlanoConvexLens`] | a lens on the axis of a point light | radial map |
//! | [`ParabolicMirror`] | a dish in parallel light | radial map |
//! | [`FlatSlab`] | a pane below a point light, or in parallel light | radial map; constant |
//! | [`MirrorCup`] | a cup that mirrors inside, in parallel or point light | chords cut by texels |
//! | [`SineWater`] | one wave on water, light straight down | map of one variable |
//! | [`FlatFacets`] | any convex solid with flat facets in parallel light | polygons cut by polygons |
//! | [`lambert_irradiance`] and others | light without anything in its way | formulas |
//!
//! [`solve`] recognises these configurations in a scene, and is the method `closed-form`. [`Bundled`] holds
//! the constants of the bundled scenes, for tests.
//!
//! Fluxes and irradiances are single numbers (one channel). Radial maps are computed to about 1e-10
//! of the texel's value: see [`RadialSheet`] for what bounds the error.

mod block;
mod blur;
mod branches;
mod bundled;
mod circle;
mod convex_solid;
mod direct;
mod flat_facets;
mod flat_slab;
mod glass_ball;
mod mirror_cup;
mod parabolic_mirror;
mod plano_convex_lens;
mod polygon;
mod quadrature;
mod radial;
mod recognise;
mod sine_water;
mod stretch;
mod texel;

pub use bundled::Bundled;
pub use convex_solid::FacetsError;
pub use direct::{
    AxialSpot, lambert_irradiance, parallel_irradiance, point_irradiance, spot_falloff,
};
pub use flat_facets::{FacetLedger, FlatFacets, FloorPolygon, ParallelLight};
pub use flat_slab::FlatSlab;
pub use glass_ball::{AxialLight, GlassBall};
pub use mirror_cup::{CupLight, MirrorCup};
pub use parabolic_mirror::ParabolicMirror;
pub use plano_convex_lens::PlanoConvexLens;
pub use radial::{RadialMap, RadialSheet};
pub use recognise::{ClosedFormSettings, solve, supports};
pub use sine_water::{SineWater, SineWave};
pub use texel::{KnownPath, TexelGrid, TexelRect};
