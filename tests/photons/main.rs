//! Light followed from emitters, the closed forms that it is held against, its balance, the same bits.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

mod absorption;
mod along_normals;
mod blends;
mod bounds;
mod closed_form_monte_carlo;
mod closed_form_scenes;
mod closed_forms;
mod coats;
mod determinism;
mod dispersion;
mod environments;
mod images;
mod ledger;
mod light_space;
mod light_tracing;
mod metered;
mod photon_map;
mod rainbow;
mod random;
mod receiver_meshes;
mod rough;
mod statistics;
mod textured_interfaces;
mod textured_lamps;

#[path = "../support/mod.rs"]
mod support;
