//! What came of a study.

use super::super::report::{PosesReport, StudyReport, Timings};

/// What came of a study.
#[derive(Clone, Debug)]
pub struct Validated {
    /// False if it was stopped, or its time was over before its end.
    pub is_complete: bool,
    /// False if a figure is above its limit, or the truth cannot tell.
    pub is_kept: bool,
    /// Its figures; `None` if it was stopped.
    pub report: Option<Report>,
}

/// The figures of a study, as they are written into its folder.
#[derive(Clone, Debug)]
pub enum Report {
    /// Of a study of one pose.
    One(Box<(StudyReport, Timings)>),
    /// Over all poses.
    Poses(PosesReport),
}
