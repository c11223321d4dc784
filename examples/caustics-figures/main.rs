//! The tables of `docs/caustics-volume.md`:
//!
//! ```text
//! cargo run --release --example caustics-figures [SECTION ...]
//! ```
//!
//! Without sections, all tables and `docs/caustics-volume.png` are made: some minutes on two cores.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of an example, no results"
)]
#![allow(missing_docs, reason = "an example is no library")]

#[path = "../../tests/support/mod.rs"]
mod support;

mod below;
mod beyond;
mod counted;
mod errors;
mod judge;
mod limits;
mod offline;
mod picture;
mod stages;
mod unseen;
mod views;
mod walls;

use judge::Judge;
use support::figures::{Section, print_sections};

/// The sections, in the order of the document.
const SECTIONS: [(&str, Section<Judge>); 22] = [
    ("picture", |_| picture::picture()),
    ("truths", errors::truths),
    ("residuals", errors::residuals),
    ("passes", |_| counted::passes()),
    ("totals", |_| counted::totals()),
    ("polygons", |_| counted::polygons()),
    ("quality", errors::quality),
    ("cures", errors::cures),
    ("below", |_| below::below()),
    ("offline", offline::offline),
    ("paths", |_| offline::paths()),
    ("walls", |_| walls::walls()),
    ("faces", |_| walls::faces()),
    ("limits", |_| limits::limits()),
    ("slabs", errors::slabs),
    ("advice", |_| beyond::advice()),
    ("splats", beyond::splats),
    ("unseen", |_| unseen::unseen()),
    ("exact", beyond::exact),
    ("views", |_| views::views()),
    ("stages", stages::objects),
    ("shipped", stages::shipped),
];

fn main() {
    print_sections(&SECTIONS);
}
