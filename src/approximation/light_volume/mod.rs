//! Hierarchical light volumes: beams below the triangles of water, drawn one after the other.
//!
//! Barczak and Olano, *Interactive Shadowed Caustics Using Hierarchical Light Volumes* (University of
//! Maryland Baltimore County), whose sections and tables are cited as such.
//!
//! Each triangle of the water is a beam: it is carried along the rays refracted at its vertices, and cut by
//! parallel planes. A visible point gathers E = Σ I cos θ over the beams that hold it.
//!
//! | stage | file | variants | exact |
//! |---|---|---|---|
//! | `surface` | [`water`], [`refract`], [`volume`] | `triangles` | quartered, on the scene's own surface |
//! | `flux` | [`volume`] | `literal` | irradiance by cosine by area |
//! | `fresnel` | [`volume`], [`shade`] | `vertex`, `schlick`, `none` | Fresnel's equations at the point |
//! | `shadow` | [`shadow`] | `vertex`, `none` | a ray to the point of the water |
//! | `shadow-cull` | [`shadow`] | `hierarchy`, `dark` | no beam is culled |
//! | `clamp` | [`quadtree`], [`hull`], [`cull`] | `hierarchy`, `beams` | all beams between all planes |
//! | `density` | [`beam`], [`shade`] | `slices`, `perpendicular` | area across the light at the point |
//! | `inside` | [`stencil`] | `stencil` | [`gather`], [`search`]: the point in the cross-section |
//! | `occlusion` | [`shade`] | `none` | a ray from the water to the point |
//! | `cosine` | [`shade`] | `flat`, `vector` | each beam's own |
//! | `accumulate` | [`sums`] | `u8`, `f16`, `f32` | as computed |
//! | `lookup` | [`gather`] | `center` | [`deal`]: by area |
//!
//! Stages are factors of one value: the exact irradiance of a beam at a point, by Π (approximate / exact). So
//! each can be exact by itself. [`slicing`] has the planes, [`adaptive`] joins cells of the water's [`grid`],
//! [`faint`] culls by contribution, `ledger` accounts for flux, and `darkness` says why an image has no
//! light.
//!
//! The light that it models is `LTD`, through one open water surface.

pub mod adaptive;
pub mod beam;
pub mod cull;
mod darkness;
pub mod deal;
mod demands;
pub mod faint;
pub mod gather;
pub mod grid;
pub mod hull;
mod ledger;
pub mod quadtree;
pub mod refract;
mod run;
pub mod search;
pub mod settings;
pub mod shade;
pub mod shadow;
pub mod slicing;
pub mod stencil;
pub mod sums;
mod technique;
pub mod variants;
pub mod volume;
pub mod water;
pub mod work;

pub use settings::Settings;
pub use technique::LightVolume;
