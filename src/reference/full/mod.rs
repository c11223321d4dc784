//! All light that a camera sees, each class of paths by the method that finds it best.
//!
//! | class | paths | by |
//! |---|---|---|
//! | `emitted`, `direct`, `indirect` | L S\* E, L D S\* E, L D … D S\* E | [paths](super::path) |
//! | `caustic` | L (S\|G)+ D E | [beams](super::beams), or [photons](super::photons) to the camera |
//! | `caustic-sds` | L (S\|G)+ D S+ E | [photon maps](super::photon_map) |
//! | `caustic-indirect` | L S+ D … D S\* E | paths, where lights have some size |
//!
//! S is smooth, G a rough interface. Beams follow no G: where there is any, photons take their place, or maps
//! where light of smooth interfaces may be seen on rough ones. What of a G's light is seen on another G is
//! for paths.
//!
//! Beams fill plain pixels of diffuse surfaces with one colour. On films with other filters and on textures
//! photons take their place, through a lens photon maps. Photons are spread by the film's filter, and maps
//! choose their places by it ([`PixelFilter`](crate::film::PixelFilter)), so that all parts measure what
//! paths do: the average of a pixel's surroundings by the filter.
//!
//! Classes are those of [`path_class`](crate::transport::path_class), a partition of all paths: each is
//! measured once, as one layer, and the image is their sum ([`Estimate::and`](crate::run::Estimate::and)).
//! [`plan`] says which method measures which class of a scene, and why; [`mod@run`] spends a budget on them.
//!
//! **What is missing is said.** Paths from the camera find `caustic-indirect` by running into an emitter: of
//! lights that are a point or a direction never, and no other method here looks for it.
//!
//! **Bounds.** Beams and photon maps have bounds, so that all layers get some: of random ones their standard
//! error times Student's t for [`CONFIDENCE`]. The total's are the sums of the methods', which is cautious.
//!
//! **Depth.** A path of `max_depth` legs has `max_depth` − 2 surfaces beside the one that scatters: that many
//! specular events chains may have. Photon maps bound them on either side of that surface, not their sum.

pub mod plan;
pub mod run;
pub mod settings;
mod shares;

pub use super::photon_map::finish::CONFIDENCE;
pub use plan::{Finder, Plan};
pub use run::{FullReport, PartDetail, PartReport, run};
pub use settings::FullSettings;
