//! Generators of the meshes of the bundled scenes, at any fineness, and of whole scenes in a folder.
//!
//! Pure functions of their arguments: the same bytes on every run. Every `.ply` file in `scenes/` is
//! reproduced byte for byte by [`generate`] with [`GenerateOptions::default`].
//!
//! (Floor 2: this room imports from `geometry`, and `film` for whole files.)

pub(crate) mod ball;
mod block;
mod bundled;
mod cuts;
mod facets;
mod fence;
mod height_field;
mod ply;
mod revolution;
mod tube;

#[cfg(test)]
mod checks;

pub use ball::{bumpy_ball, geodesic_sphere};
pub use block::bumpy_block;
pub use bundled::{
    BundledFile, BundledScene, GenerateError, GenerateOptions, HILLS, POOL, SCENES, WATER,
    generate, scene_names,
};
pub use facets::{BrilliantCut, equilateral_prism, round_brilliant, subdivided_facets};
pub use fence::{Picket, picket_fence};
pub use height_field::{Wave, height_field, terrain};
pub use ply::write_ply;
pub use revolution::{paraboloid, plano_convex_lens};
pub use tube::{band, ring, trefoil_knot};
