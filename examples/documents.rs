//! Writes the tables of settings into docs/methods.md, from the program's own. `tests/documents.rs` compares them.
//!
//! ```sh
//! cargo run --example documents
//! ```
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of an example, no results"
)]

use std::fs;
use std::path::Path;

use nephroid::Method;
use nephroid::internals::method::table::markdown;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/methods.md");
    let mut text = fs::read_to_string(&path)?;
    for name in Method::names() {
        let begin = format!("<!-- settings: {name} -->\n");
        let start = text.find(&begin).ok_or(format!("no line {begin}"))? + begin.len();
        let length = text[start..].find("<!-- end -->").ok_or("no end")?;
        text.replace_range(start..start + length, &format!("\n{}\n", markdown(name)));
    }
    fs::write(&path, text)?;
    Ok(())
}
