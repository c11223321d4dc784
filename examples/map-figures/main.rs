//! The tables of `docs/caustic-map.md`:
//!
//! ```text
//! cargo run --release --example map-figures [SECTION ...]
//! ```
//!
//! Without sections all tables are made. Section `stages` takes five minutes on two cores, and `claims` some
//! minutes for each mesh of the folder beside the crate; a mesh that is not there has no row.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of an example, no results"
)]
#![allow(missing_docs, reason = "an example is no library")]

#[path = "../../tests/support/mod.rs"]
mod support;

mod claims;
mod cost;
mod exits;
mod stages;

use support::figures::{Section, print_sections};

/// The sections, in the order of the document.
const SECTIONS: [(&str, Section<()>); 5] = [
    ("cost", |()| cost::cost()),
    ("stages", |()| stages::stages()),
    ("exits", |()| exits::exits()),
    ("normalisations", |()| exits::normalisations()),
    ("claims", |()| claims::claims()),
];

fn main() {
    print_sections(&SECTIONS);
}
