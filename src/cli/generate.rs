//! `nephroid generate`: the shipped scenes, with meshes as fine as wanted.

use super::args::GenerateArgs;
use super::outcome::Outcome;
use crate::generate::{self, GenerateOptions};

/// Runs the command.
///
/// # Errors
///
/// If a name is unknown or a file cannot be written.
pub fn generate(args: &GenerateArgs) -> anyhow::Result<Outcome> {
    let options = GenerateOptions {
        detail: args.detail,
    };
    let names: Vec<&str> = if args.names.is_empty() {
        generate::scene_names().collect()
    } else {
        args.names.iter().map(String::as_str).collect()
    };
    for name in names {
        for file in generate::generate(name, &args.output, options)? {
            say!("wrote {}", file.display());
        }
    }
    Ok(Outcome::Complete)
}
