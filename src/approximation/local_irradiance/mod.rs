//! Local precomputed irradiance: caustics looked up in tables around the object that makes them.
//!
//! Wyman, Hansen and Shirley, *Interactive Caustics Using Local Precomputed Irradiance* (Pacific Graphics
//! 2004), whose sections, figures and tables are cited as such.
//!
//! An object with centre c is lit by parallel light from each of some directions L. Photons fill cells around
//! it with irradiance G(D, L) on surfaces at c + D that face c. A frame reads the samples of L around its
//! light at each diffuse point p with normal N,
//!
//! ```text
//! E(p, N) = E₀ G(p − c, L) (N · (c − p)/|c − p|)⁺
//! ```
//!
//! G is the flux density outward through spheres about c: what leaves the object crosses each of them.
//!
//! | stage | file | variants | exact |
//! |---|---|---|---|
//! | `light` | [`lamp`] | `directional` | the emitter |
//! | `scene` | [`object`], [`shoot`] | `alone` | chains in the whole scene |
//! | `directions` | [`directions`] | `aligned`, `barycentric`, `nearest`, `harmonics` | one sample, at L |
//! | `noise` | [`prepare`] | `photons` | as many as the sensor needs |
//! | `deposit` | [`deposit`] | `crossing` | mean over the cell, outside of glass |
//! | `space` | [`cells`], [`tree`] | `grid`, `shells`, `multi-resolution`, `shell-harmonics` | [`crossing`] |
//! | `region` | [`layout`] | `clamp`, `fade` | cells up to all that is seen |
//! | `normal` | [`deposit`], [`reads`] | `fixed`, `vector` | the sensor's |
//! | `storage` | [`storage`] | `u8`, `rgb9e5`, `f16`, `f32` | `f64` |
//!
//! Tables are in the object's own space, so they serve it wherever it is and however it is turned. `shelf`
//! keeps them in [files](file), and `export` writes them as raw volumes. `ledger` accounts for flux, and says
//! why an image has no light; `size` knows beforehand what tables take, and `bytes` chooses settings by that.
//!
//! The light that it is judged by is all of L S+ D.

mod bytes;
pub mod cells;
pub mod chunk;
pub mod crossing;
mod demands;
pub mod deposit;
pub mod directions;
mod export;
pub mod file;
pub mod grid;
pub mod lamp;
mod lasting;
pub mod layout;
mod ledger;
pub mod leg;
pub mod object;
mod once;
pub mod prepare;
pub mod reads;
mod run;
mod scenery;
pub mod settings;
mod shelf;
pub mod shells;
pub mod shoot;
mod size;
pub mod storage;
pub mod table;
mod technique;
pub mod tree;
pub mod variants;
pub mod work;

pub use settings::Settings;
pub use technique::LocalIrradiance;
