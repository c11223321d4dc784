//! The files of a report.

use std::io::Write as _;
use std::path::Path;

use super::super::StudyError;
use super::super::store::write_json;
use super::figures::{StudyReport, Timings};
use super::{page, text};
use crate::film::atomic;

/// Writes all files of a report into a folder that exists, each whole or not at all. Returns their names.
///
/// # Errors
///
/// If a film cannot be read, or a file not written.
pub fn write(
    folder: &Path,
    report: &StudyReport,
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
