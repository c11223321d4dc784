//! What the caller of a study asks for beside its file.

use std::path::{Path, PathBuf};

use super::super::limit::StudyLimit;
use super::error::FileError;
use super::study_file::{StudyCandidate, StudyFile};

/// What the caller of a study asks for beside its file. It goes before what the file says.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyWishes {
    /// Parameters of the scene file.
    pub define: Vec<(String, String)>,
    /// The sensors' ids; the study's if there are none.
    pub sensors: Vec<String>,
    /// Images rendered elsewhere, beside the study's.
    pub candidates: Vec<StudyCandidate>,
    /// Limits on figures of methods and candidates.
    pub max_error: Vec<StudyLimit>,
    /// The difference that matters, relative to the truth's mean.
    pub margin: Option<f64>,
    /// Number of times that each run is made.
    pub repeats: Option<u32>,
}

impl StudyFile {
    /// What is asked for: the study of a file in TOML, or the default one of a scene, with some wishes.
    ///
    /// # Errors
    ///
    /// As [`StudyFile::read`].
    pub fn wanted(path: &Path, wishes: &StudyWishes) -> Result<Self, FileError> {
        let file = if Self::is_study(path) {
            Self::read(path)?
        } else {
            Self::of_scene(path)
        };
        Ok(file.with(wishes))
    }

    /// True of a study's file, by its name; others are scenes.
    pub fn is_study(path: &Path) -> bool {
        path.extension()
            .is_some_and(|extension| extension == "toml")
    }

    /// The same study with some wishes.
    #[must_use]
    pub fn with(mut self, wishes: &StudyWishes) -> Self {
        let file = &mut self;
        for (key, value) in &wishes.define {
            file.define.retain(|(name, _)| name != key);
            file.define.push((key.clone(), value.clone()));
        }
        if !wishes.sensors.is_empty() {
            file.sensors.clone_from(&wishes.sensors);
        }
        file.margin = wishes.margin.or(file.margin);
        file.repeats = wishes.repeats.unwrap_or(file.repeats);
        file.candidates.extend_from_slice(&wishes.candidates);
        for limit in &wishes.max_error {
            // What is said last goes before the rest.
            file.max_error.retain(|other| {
                let is_same = other.place() == limit.place();
                !is_same || other.limit.figure != limit.limit.figure
            });
            file.max_error.push(limit.clone());
        }
        self
    }
}

impl StudyCandidate {
    /// An image with a name, `NAME` or `NAME@SENSOR`; `None` if that is none.
    pub fn named(name: &str, file: impl Into<PathBuf>) -> Option<Self> {
        let (name, sensor) = match name.rsplit_once('@') {
            None => (name, None),
            Some((_, "")) => return None,
            Some((name, sensor)) => (name, Some(sensor.to_owned())),
        };
        (!name.is_empty()).then(|| Self {
            name: name.to_owned(),
            sensor,
            file: file.into(),
            seconds: None,
        })
    }
}

/// The folder of a study's report if none is named: `out/NAME.report`.
pub fn report_folder(study: &Path) -> PathBuf {
    let mut name = study.file_stem().unwrap_or_default().to_owned();
    name.push(".report");
    Path::new("out").join(name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn candidates_have_names_and_may_have_a_sensor() {
        let named = |name: &str| {
            let found = StudyCandidate::named(name, "b.exr")?;
            Some((found.name, found.sensor))
        };
        assert_eq!(named("a"), Some(("a".to_owned(), None)));
        assert_eq!(
            named("a@floor"),
            Some(("a".to_owned(), Some("floor".to_owned())))
        );
        for wrong in ["", "@floor", "a@"] {
            assert_eq!(named(wrong), None, "{wrong}");
        }
    }

    #[test]
    fn wishes_go_before_the_file() {
        let limit = |name: &str, value: &str| StudyLimit::parse(name, value).unwrap();
        let wishes = StudyWishes {
            define: vec![("a".into(), "1".into()), ("a".into(), "2".into())],
            sensors: vec!["floor".to_owned()],
            max_error: vec![limit("x", "5%"), limit("x:energy", "1%"), limit("x", "3%")],
            margin: Some(0.02),
            ..StudyWishes::default()
        };
        let file = StudyFile::wanted("scene.xml".as_ref(), &wishes).unwrap();
        assert_eq!(file.define, [("a".to_owned(), "2".to_owned())]);
        assert_eq!(file.max_error, [limit("x:energy", "1%"), limit("x", "3%")]);
        assert_eq!((file.margin, file.repeats), (Some(0.02), 1));
        assert_eq!(file.sensors, wishes.sensors);
        assert!(file.is_default);
    }
}
