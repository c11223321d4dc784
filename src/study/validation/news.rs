//! What a study tells of its course.

use std::path::Path;
use std::time::Duration;

use super::super::plan::StudyPlan;
use super::super::report::StudyReport;
use crate::run::Progress;
use crate::setting::Given;

/// Whoever hears of a study's course.
pub trait Watcher {
    /// Hears of it.
    fn hear(&mut self, news: News);

    /// Makes a run, and may show meanwhile how far it is.
    fn watch<T: Send>(&mut self, _progress: &Progress, run: impl FnOnce() -> T + Send) -> T {
        run()
    }
}

/// What a study tells of its course.
#[derive(Clone, Copy, Debug)]
pub enum News<'a> {
    /// A pose begins: its number from 1 of so many, and its parameters.
    Pose(usize, usize, &'a Given),
    /// So many of all poses are not begun, since the study's time is over.
    PosesLeft(usize, usize),
    /// So many of all runs of a shard are not made, since the study's time is over.
    RunsLeft(usize, usize),
    /// The runs are planned, and nothing is made yet; the report goes into the folder.
    Planned(&'a StudyPlan, &'a Path),
    /// A run begins.
    Begins(&'a Task),
    /// An attribution has made so many of its runs.
    Counts(usize, usize),
    /// A run is done; what is left of the time, if it is known.
    Done(&'a Task, Done<'a>, Option<Left>),
    /// A row is judged: its number from 1 of so many, and its label.
    Judges(usize, usize, &'a str),
    /// The report is written.
    Judged(&'a StudyReport),
    /// It was stopped; so many of all runs are kept.
    Stopped(usize, usize),
}

/// A run of a study under way.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Task {
    /// Its number, from 1.
    pub number: usize,
    /// The number of all runs.
    pub all: usize,
    /// What is made.
    pub name: String,
}

/// How a run was done.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Done<'a> {
    /// It was kept from before.
    Kept,
    /// It was made, in so long.
    Made(Duration),
    /// An error was attributed to stages, by so many runs in so long.
    Attributed(usize, Duration),
    /// An error was not attributed, for a reason.
    NotAttributed(&'a str),
}

/// The time of a study, by the mean of the runs made so far, the truths apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Left {
    /// Since it began.
    pub so_far: Duration,
    /// Until it ends.
    pub left: Duration,
}
