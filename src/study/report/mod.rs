//! The report of a study: the figures of `report.json`, and the files that show them.
//!
//! | file | what |
//! |---|---|
//! | `report.json` | all figures; the same bytes on any machine, with any threads, in one go or resumed |
//! | `timings.json` | seconds, threads, machines, the source's hash: all that is never the same twice |
//! | `report.csv`, `summary.md` | a line a run, for spreadsheets and for pull requests |
//! | `index.html` | all of it to look at, in one file |
//! | `poses.json`, `poses.md` | figures over all poses of a study, each in a folder of its own |
//!
//! Figures are those of [`metric::compare`](crate::metric::compare) on the stored films: `nephroid compare`
//! prints the same digits.
//! Methods of all light by mirrors and glass are the exception: that layer of the truth is made here
//! (`study/layers.rs`).

mod answers;
mod build;
mod figures;
mod files;
mod page;
mod picture;
mod planes;
mod poses;
mod text;
mod trade;

pub use build::{JudgedFilm, RowProgress, SensorFilms, build};
pub use figures::{
    Answer, Curve, Gate, GateVerdict, OrderOf, ReportRow, RunTiming, SensorFigures, SensorTimings,
    StageErrors, StudyFigures, StudyReport, Timings, TruthFigures,
};
pub use files::write;
pub use poses::{Pose, PosesReport, parameters};
pub use text::{field, markdown};
