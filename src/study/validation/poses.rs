//! Studies of poses, and the folders of studies.

use std::path::{Path, PathBuf};

use super::super::StudyError;
use super::super::file::StudyFile;
use super::super::store::Store;
use crate::film::atomic;

/// The films in a study's folder, which is made if it is missing.
///
/// # Errors
///
/// If the folder cannot be written to.
pub fn store(folder: &Path) -> Result<Store, StudyError> {
    std::fs::create_dir_all(folder).map_err(|cause| StudyError::Folder {
        folder: folder.to_owned(),
        cause,
    })?;
    atomic::check(&folder.join("index.html"))?;
    Ok(Store::open(&folder.join("runs"))?)
}

/// Refuses candidates of a study with poses: an image is of one.
///
/// # Errors
///
/// If it has both.
pub fn without_candidates(file: &StudyFile) -> Result<(), StudyError> {
    match file.candidates.first() {
        Some(candidate) => Err(StudyError::CandidateOfPoses(candidate.name.clone())),
        None => Ok(()),
    }
}

/// The folder of a pose, whose number is from 1.
pub fn pose_folder(number: usize) -> String {
    format!("pose-{number:03}")
}

/// The studies of a study's poses, with their numbers from 1 and their folders; the study itself if it has
/// none.
///
/// # Errors
///
/// If it has poses and candidates.
pub fn of_poses(
    file: &StudyFile,
    folder: &Path,
) -> Result<Vec<(Option<usize>, StudyFile, PathBuf)>, StudyError> {
    if file.poses.is_empty() {
        return Ok(vec![(None, file.clone(), folder.to_owned())]);
    }
    without_candidates(file)?;
    let poses = (1..).zip(&file.poses);
    let studies = poses.map(|(number, define)| {
        let own = folder.join(pose_folder(number));
        (Some(number), file.of_pose(define), own)
    });
    Ok(studies.collect())
}
