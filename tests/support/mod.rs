//! Shared parts of tests, benches and examples: scenes and runs of them, closed forms, files to be broken,
//! and the statistics that tell if an estimate and a truth agree.
#![allow(dead_code, reason = "every program uses its own part of this")]

pub mod approximation;
pub mod beams;
pub mod bsdf;
pub mod caustic_scenes;
pub mod caustics_volume;
pub mod chains;
pub mod child;
pub mod comparison;
pub mod contest;
pub mod cpu;
pub mod extremes;
pub mod figures;
pub mod geometry;
pub mod images;
pub mod light_volume;
pub mod local_irradiance;
pub mod measured;
pub mod mutation;
pub mod oracles;
pub mod parity;
pub mod parts;
pub mod paths;
pub mod pool;
pub mod probes;
pub mod recognised;
pub mod scene_files;
pub mod scenes;
pub mod seen;
pub mod shared_meshes;
pub mod student;
pub mod technique;

#[allow(unused_imports, reason = "every program uses its own part of this")]
pub use comparison::{Agreement, Compared};
#[allow(unused_imports, reason = "every program uses its own part of this")]
pub use scenes::{Photons, bundled, bundled_file, loaded};
