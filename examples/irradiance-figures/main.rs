//! The tables of `docs/local-irradiance.md`:
//!
//! ```text
//! cargo run --release --example irradiance-figures [SECTION ...]
//! ```
//!
//! Without sections, all tables and `docs/local-irradiance.png` are made: an hour or so on two busy cores.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of an example, no results"
)]
#![allow(missing_docs, reason = "an example is no library")]

#[path = "../../tests/support/mod.rs"]
mod support;

mod bytes;
mod cells;
mod directions;
mod frames;
mod harmonics;
mod judge;
mod limits;
mod picture;
mod stages;

use support::figures::{Section, print_sections};

/// The sections, in the order of the document.
const SECTIONS: [(&str, Section<()>); 14] = [
    ("picture", |()| picture::picture()),
    ("exact", |()| stages::exact()),
    ("bytes", |()| bytes::bytes()),
    ("directions", |()| directions::directions()),
    ("cells", |()| cells::cells()),
    ("frame", |()| frames::frame()),
    ("samples", |()| frames::samples()),
    ("harmonics", |()| harmonics::harmonics()),
    ("storage", |()| cells::storage()),
    ("reach", |()| limits::reach()),
    ("lamp", |()| limits::lamp()),
    ("shooting", |()| frames::shooting()),
    ("stages", |()| stages::stages()),
    ("sets", |()| stages::sets()),
];

fn main() {
    print_sections(&SECTIONS);
}
