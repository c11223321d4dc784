//! Images rendered elsewhere: checked, and copied beside the films that they are shown with.

use super::super::StudyError;
use super::super::plan::SensorPlan;
use super::super::report::JudgedFilm;
use super::super::session::Session;
use super::super::store::file_name;
use crate::film::atomic;
use crate::film::exr::{self, ExrReadError};
use crate::metric::{self, CompareImage};

/// Copies the candidates of a sensor into the store.
///
/// # Errors
///
/// If one cannot be read, is not of the sensor's size, or cannot be compared with anything.
pub fn copy<'a>(
    session: &Session,
    plan: &'a SensorPlan,
) -> Result<Vec<JudgedFilm<'a>>, StudyError> {
    let film = &session.sensor(plan)?.film;
    let expected = [film.crop.width as usize, film.crop.height as usize];
    let mut judged = Vec::new();
    for (i, candidate) in plan.candidates.iter().enumerate() {
        // Once: what is judged is what is copied, even if the file changes or vanishes now.
        let bytes = std::fs::read(&candidate.file).map_err(|error| ExrReadError {
            path: candidate.file.clone(),
            message: error.to_string(),
        })?;
        let image = exr::parse(&candidate.file, &bytes)?;
        let size = [image.width, image.height];
        if size != expected {
            let is_turned = size == [expected[1], expected[0]];
            return Err(StudyError::Size {
                file: candidate.file.display().to_string(),
                size,
                sensor: plan.sensor.clone(),
                expected,
                hint: if is_turned {
                    ": are rows and columns exchanged?"
                } else {
                    ""
                }
                .to_owned(),
            });
        }
        // With itself: what cannot be compared at all is better known now, too.
        let source = CompareImage::new(candidate.file.display().to_string(), image);
        let quick = metric::CompareSettings {
            pixels_per_degree: None,
            ..metric::CompareSettings::default()
        };
        metric::compare(&source, &source, &quick)?;
        // By its content: the report of an earlier run keeps the image that it judged.
        let content = blake3::hash(&bytes).to_hex();
        let name = format!(
            "{}-{}.exr",
            file_name(&format!(
                "{}-candidate-{}-{}",
                plan.sensor,
                i + 1,
                candidate.name
            )),
            &content[..8]
        );
        atomic::write(&session.store.path(&name), |file| {
            std::io::Write::write_all(file, &bytes)
        })?;
        judged.push(JudgedFilm::Candidate(candidate, name));
    }
    Ok(judged)
}
