//! The tables of `docs/light-volume.md`:
//!
//! ```text
//! cargo run --release --example volume-figures [SECTION ...]
//! ```
//!
//! Without sections, all tables and `docs/light-volume.png` are made: some minutes on two cores.
#![allow(missing_docs, reason = "an example is no library")]

#[path = "../../tests/support/mod.rs"]
mod support;

mod counted;
mod drawn;
mod errors;
mod judge;
mod picture;
mod stages;

use std::time::Instant;

use judge::Judge;

/// Makes the tables of a section.
type Section = fn(&mut Judge) -> Vec<String>;

/// The sections, in the order of the document.
const SECTIONS: [(&str, Section); 17] = [
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
    let named: Vec<String> = std::env::args().skip(1).collect();
    if let Some(unknown) = named
        .iter()
        .find(|name| SECTIONS.iter().all(|(known, _)| known != name))
    {
        let known: Vec<&str> = SECTIONS.iter().map(|(name, _)| *name).collect();
        eprintln!("no section {unknown}: there are {}", known.join(", "));
        std::process::exit(2);
    }
    let mut judge = Judge::default();
    for (name, tables) in SECTIONS {
        if named.is_empty() || named.iter().any(|it| it == name) {
            let start = Instant::now();
            println!("## {name}\n");
            for table in tables(&mut judge) {
                println!("{table}\n");
            }
            eprintln!("{name}: {:.1} s", start.elapsed().as_secs_f64());
        }
    }
}
