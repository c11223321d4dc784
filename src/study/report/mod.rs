//! What a study found: the figures of `report.json`, and the files that show them.
//!
//! | file | what |
//! |---|---|
//! | `report.json` | all figures; the same bytes from any machine, any number of threads, in one go or resumed |
//! | `timings.json` | seconds, threads, the program's hash: what is never the same twice |
//! | `report.csv`, `summary.md` | a line a run, for spreadsheets and for pull requests |
//! | `index.html` | all of it to look at, in one file |
//!
//! Figures are those of [`metric::compare`](crate::metric::compare) on the films as they are stored: `nephroid compare` prints the same digits.

mod answers;
mod build;
mod figures;
mod page;
mod planes;
mod stages;
mod text;
mod trade;

use std::path::Path;

pub use build::{Judged, Progressing, SensorFilms, build};
pub use figures::{
    Answer, Check, Curve, Gate, GateVerdict, OrderOf, Report, Row, SensorFigures, SensorTimings,
    StageError, StageErrors, StudyFigures, Timing, Timings, TruthFigures,
};
pub use stages::StageFilms;
pub use text::markdown;

use super::StudyError;
use super::store::write_json;
use crate::film::atomic;
use std::io::Write as _;

/// Writes all files of a report into a folder that exists, each whole or not at all. Returns their names.
///
/// # Errors
///
/// Where a film cannot be read, or a file not written.
pub fn write(
    folder: &Path,
    report: &Report,
    timings: &Timings,
) -> Result<[&'static str; 5], StudyError> {
    let page = page::page(folder, report, timings)?;
    let put = |name: &str, text: &str| {
        atomic::write(&folder.join(name), |file| file.write_all(text.as_bytes()))
    };
    write_json(&folder.join("report.json"), report)?;
    write_json(&folder.join("timings.json"), timings)?;
    put("report.csv", &text::csv(report, timings))?;
    put("summary.md", &text::markdown(report, timings))?;
    put("index.html", &page)?;
    Ok([
        "index.html",
        "report.json",
        "report.csv",
        "summary.md",
        "timings.json",
    ])
}
