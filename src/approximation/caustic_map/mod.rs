//! Caustic mapping: photons traced in pictures from the light, drawn into a map that is projected back like a
//! shadow map.
//!
//! Wyman and Davis, *Interactive image-space techniques for approximating caustics* (I3D 2006); with splats
//! of variable size: Wyman and Dachsbacher, *Improving image-space caustics via variable-sized splatting*
//! (Technical Report UICS-06-02, 2006), whose sections and equations are cited as such.
//!
//! | stage | file | variants | exact |
//! |---|---|---|---|
//! | `view` | [`buffers`], of [`LightView`](super::LightView) | `f16` or `f32`; 24-bit depths | `f64` |
//! | `refraction` | [`refraction`], of [`interface`](super::interface) | `image-space` | the ray is traced |
//! | `hit` | [`hit`] | `depth-map`, `fixed-point` | the ray is traced |
//! | `flux` | [`trace`] | `density-ratio`, `uniform` | by solid angle |
//! | `fresnel` | [`interface`](super::interface) | `none`, `schlick` | Fresnel's equations |
//! | `splat` | [`splat`], [`resolve`], [`lens`] | Gaussians, fixed or variable | [`footprint`]: beams |
//! | `lookup` | [`lookup`] | `nearest`, `bilinear` | [`project`]: on the sensor's own texels |
//!
//! The light that it models is `LTTD`, `LTD` or `LRD`; third interfaces and whatever a photon meets on its
//! way after the specular object are not modelled. [`loss`] names the reasons for which photons come to
//! nothing, [`tally`] and `ledger` account for their flux, and `darkness` says why an image has no light.

pub mod buffers;
mod darkness;
mod demands;
pub mod footprint;
pub mod hit;
mod ledger;
pub mod lens;
pub mod lookup;
pub mod loss;
mod photons;
pub mod project;
pub mod refraction;
pub mod resolve;
mod run;
pub mod settings;
pub mod splat;
mod spread;
pub mod tally;
mod technique;
pub mod trace;
pub mod variants;
pub mod work;

pub use settings::Settings;
pub use technique::CausticMap;
