//! The tables of `docs/light-volume.md`:
//!
//! ```text
//! cargo run --release --example volume-figures [SECTION ...]
//! ```
//!
//! Without sections, all tables and `docs/light-volume.png` are made: some minutes on two cores.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of an example, no results"
)]
#![allow(missing_docs, reason = "an example is no library")]

#[path = "../../tests/support/mod.rs"]
mod support;

mod counted;
mod drawn;
mod errors;
mod judge;
mod picture;
mod stages;

use judge::Judge;
use support::figures::{Section, print_sections};

/// The sections, in the order of the document.
const SECTIONS: [(&str, Section<Judge>); 17] = [
    ("picture", |_| picture::picture()),
    ("culling", |_| counted::culling()),
    ("drawing", |_| counted::drawing()),
    ("shadow-culling", |_| counted::shadow_culling()),
    ("unshadowed", |_| counted::unshadowed()),
    ("objects", |_| counted::objects()),
    ("upkeep", |_| counted::upkeep()),
    ("hulls", |_| drawn::hulls()),
    ("clamping", |_| drawn::clamping()),
    ("stencil", |_| drawn::stencil()),
    ("cosines", errors::cosines),
    ("vectors", errors::vectors),
    ("tolerance", errors::tolerance),
    ("grid", errors::grid),
    ("slices", errors::slices),
    ("views", |_| drawn::views()),
    ("stages", stages::stages),
];

fn main() {
    print_sections(&SECTIONS);
}
