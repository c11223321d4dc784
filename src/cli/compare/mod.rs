//! `nephroid compare`: figures of the difference of two images.

mod args;
mod pictures;
mod table;

use std::path::Path;

use serde::Serialize;

use super::outcome::Outcome;
use crate::film::exr;
use crate::metric::{CompareImage, Comparison, Pairing, Verdict};
pub use args::{CompareArgs, SideArg};

/// The output of `--json`.
#[derive(Serialize)]
struct Output<'a> {
    #[serde(flatten)]
    report: &'a Comparison,
    unit: Option<&'a str>,
    /// The maps written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    files: Vec<String>,
}

/// Runs the command.
///
/// # Errors
///
/// If an image cannot be read, the two cannot be compared, or a map not written.
pub fn compare(args: &CompareArgs) -> anyhow::Result<Outcome> {
    // Side by side: large files take longer to read than to compare.
    let (a, b) = rayon::join(
        || source(args, &args.a, args.error_a.as_deref(), args.samples_a),
        || source(args, &args.b, args.error_b.as_deref(), args.samples_b),
    );
    let (a, b) = (a?, b?);
    let settings = args.settings();
    let pairing = Pairing::new(&a, &b, settings.reference, &settings.layers)?;
    let report = Comparison::of(&pairing, &a, &b, &settings);
    let unit = a.image.metadata("unit").or(b.image.metadata("unit"));
    let files = match &args.maps {
        Some(folder) => pictures::write(&pairing, unit.unwrap_or(""), folder)?,
        None => Vec::new(),
    };
    if args.json {
        let output = Output {
            report: &report,
            unit,
            files,
        };
        say!("{}", serde_json::to_string_pretty(&output)?);
    } else {
        say!("{}", table::TextTable::new(&report, unit, &files));
    }
    Ok(match report.verdict {
        Verdict::Equivalent => Outcome::Complete,
        Verdict::Undecided if !args.require_equivalence => Outcome::Complete,
        Verdict::Undecided | Verdict::Different => Outcome::Apart,
    })
}

/// An image with its separate errors, cropped.
fn source(
    args: &CompareArgs,
    path: &Path,
    errors: Option<&Path>,
    samples: Option<u64>,
) -> anyhow::Result<CompareImage> {
    let name = |path: &Path| path.display().to_string();
    let mut source = CompareImage::new(name(path), exr::read(path)?);
    if let Some(path) = errors {
        source.errors = Some((name(path), exr::read(path)?));
    }
    source.samples = samples.or(source.samples);
    Ok(match args.crop {
        Some(window) => source.cropped(window)?,
        None => source,
    })
}
