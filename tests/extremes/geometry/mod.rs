//! Meshes at their worst, from the single ray to the whole run: what holds, and what is reported where it
//! cannot.
//!
//! `tests/geometry/` tests the parts (hits, spawned rays, diagnostics); here a mesh file goes in and a map
//! with its ledger comes out.

mod bodies;
mod faces;
mod leaks;
mod runs;
mod sizes;
mod vertices;
