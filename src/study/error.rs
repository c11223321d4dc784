//! Why a study came to no report.

use std::io;
use std::path::PathBuf;

use super::attribution::AttributionError;
use super::file::FileError;
use super::plan::PlanError;
use super::store::StoreError;
use crate::film::atomic::WriteError;
use crate::film::exr::ExrReadError;
use crate::metric::CompareError;
use crate::mitsuba::LoadError;

/// Why a study came to no report. What was computed before is kept.
#[derive(Debug, thiserror::Error)]
pub enum StudyError {
    /// The study's file.
    #[error(transparent)]
    File(#[from] FileError),
    /// The scene.
    #[error(transparent)]
    Scene(#[from] LoadError),
    /// The plan.
    #[error(transparent)]
    Plan(#[from] PlanError),
    /// The sensor is gone.
    #[error("the scene has no sensor \"{0}\"")]
    NoSensor(String),
    /// A run is not of the study.
    #[error("the study has no such run: is this the same version of nephroid everywhere?")]
    NoUnit,
    /// A method cannot work on the scene.
    #[error("{run}: {cause}")]
    Method {
        /// The run.
        run: String,
        /// What the method says.
        cause: Box<crate::run::Error>,
    },
    /// An approximation's error cannot be attributed.
    #[error("{run}: {cause}")]
    Attribution {
        /// The run.
        run: String,
        /// The reason.
        cause: Box<AttributionError>,
    },
    /// Two runs with the same settings differ.
    #[error(
        "{0}: a repeat differs from the first run, which nothing may do; clear the folder of runs, and report this"
    )]
    NotRepeated(String),
    /// A film cannot be kept.
    #[error(transparent)]
    Store(#[from] StoreError),
    /// An image cannot be read.
    #[error(transparent)]
    Read(#[from] ExrReadError),
    /// Images that cannot be compared.
    #[error(transparent)]
    Compare(#[from] CompareError),
    /// An image that cannot be of this sensor.
    #[error("{file} has {} x {} texels, sensor \"{sensor}\" has {} x {}{hint}", size[0], size[1], expected[0], expected[1])]
    Size {
        /// The image.
        file: String,
        /// Its texels a row and rows.
        size: [usize; 2],
        /// The sensor's id.
        sensor: String,
        /// Its texels a row and rows.
        expected: [usize; 2],
        /// What it may be.
        hint: String,
    },
    /// A folder for the report.
    #[error("cannot make the folder {}: {cause}", folder.display())]
    Folder {
        /// The folder.
        folder: PathBuf,
        /// The system's error.
        cause: io::Error,
    },
    /// A candidate of a study of several poses.
    #[error(
        "candidate \"{0}\" and poses: an image shows one pose; allowed are candidates of studies without poses"
    )]
    CandidateOfPoses(String),
    /// A file of the report.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A report that is no JSON: a number that is none where one must be.
    #[error("cannot write the report: {0}")]
    Json(#[from] serde_json::Error),
}
