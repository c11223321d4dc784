//! The contents of a `study.toml`, key by key.

use std::collections::BTreeMap;
use std::fs::File;
use std::io::{self, Read as _};
use std::path::{Path, PathBuf};
use std::time::Duration;

use toml::de::DeTable;

use super::error::FileError;
use super::study_method::StudyMethod;
use super::sweep;
use super::table::{Text, TomlNode, TomlTable};
use crate::setting::{Given, parse_fraction};
use crate::study::limit::{self, StudyLimit};

/// The wishes for a study, as its file has them. Gaps are left to the [plan](crate::study::plan).
#[derive(Clone, Debug, Default, PartialEq)]
pub struct StudyFile {
    /// True if the scene's default methods are run beside the named ones.
    pub is_default: bool,
    /// The scene file; relative paths are relative to the study's file.
    pub scene: PathBuf,
    /// The sensors' ids; if there are none the plan chooses one.
    pub sensors: Vec<String>,
    /// Parameters of the scene file.
    pub define: Vec<(String, String)>,
    /// Parameters that change from pose to pose: each pose is a study with a truth of its own.
    pub poses: Vec<Given>,
    /// Seed of all random choices except the truth's.
    pub seed: u64,
    /// Number of times that each run is made, for the median of its seconds.
    pub repeats: u32,
    /// The difference that matters, relative to the truth's mean.
    pub margin: Option<f64>,
    /// Time after which no run begins.
    pub time: Option<Duration>,
    /// The truth's method, with one value for each setting: by sensor, or for all sensors that have none of
    /// their own.
    pub truths: BTreeMap<Option<String>, StudyMethod>,
    /// Methods and their settings.
    pub methods: Vec<StudyMethod>,
    /// Images rendered elsewhere.
    pub candidates: Vec<StudyCandidate>,
    /// Limits on figures of methods and candidates.
    pub max_error: Vec<StudyLimit>,
}

/// An image rendered elsewhere.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyCandidate {
    /// Its name.
    pub name: String,
    /// The sensor that it shows; may be left out if a study has one.
    pub sensor: Option<String>,
    /// The EXR.
    pub file: PathBuf,
    /// Its time, if that is known \[s\].
    pub seconds: Option<f64>,
}

impl StudyFile {
    /// The study of one of its poses.
    #[must_use]
    pub fn of_pose(&self, pose: &Given) -> Self {
        let mut study = self.clone();
        study.poses.clear();
        study.define.retain(|(key, _)| !pose.contains_key(key));
        let own = pose.iter().map(|(key, value)| (key.clone(), value.clone()));
        study.define.extend(own);
        study
    }

    /// A study of a scene without further wishes.
    pub fn of_scene(scene: impl Into<PathBuf>) -> Self {
        Self {
            scene: scene.into(),
            repeats: 1,
            is_default: true,
            ..Self::default()
        }
    }

    /// Reads a study's file.
    ///
    /// # Errors
    ///
    /// If it is missing, longer than a MiB, no TOML, or has a key or a value that it cannot have.
    pub fn read(path: &Path) -> Result<Self, FileError> {
        Self::parse(path, &Self::text(path)?)
    }

    /// The contents of a study's file, unread.
    ///
    /// # Errors
    ///
    /// If it is missing, longer than a MiB or no text.
    pub fn text(path: &Path) -> Result<String, FileError> {
        contents(path).map_err(|cause| FileError::Read {
            path: path.to_owned(),
            cause,
        })
    }

    /// Reads the contents of a study's file. The path is for messages, and relative paths start at its
    /// folder.
    ///
    /// # Errors
    ///
    /// As [`StudyFile::read`].
    pub fn parse(path: &Path, contents: &str) -> Result<Self, FileError> {
        let text = Text { path, contents };
        let document = DeTable::parse(contents).map_err(|error| {
            let at = error.span().unwrap_or(0..0);
            text.error(&at, error.message())
        })?;
        let mut table = TomlTable::new(text, "the study", 0..0, document.get_ref());
        let folder = path.parent().unwrap_or(Path::new(""));
        let study = Self {
            is_default: false,
            scene: folder.join(table.need("scene")?.scalar()?),
            sensors: sensors(&mut table)?,
            define: define(&mut table)?,
            poses: poses(&mut table)?,
            seed: whole(&mut table, "seed")?.unwrap_or(0),
            repeats: repeats(&mut table)?,
            margin: positive(&mut table, "margin")?,
            time: time(&mut table)?,
            truths: truths(&mut table)?,
            methods: methods(&mut table)?,
            candidates: candidates(&mut table, folder)?,
            max_error: max_error(&mut table)?,
        };
        table.finish()?;
        Ok(study)
    }
}

/// Most bytes of a study's file. Errors name their places, so it is read whole.
const LONGEST: u64 = 1 << 20;

/// Most runs of all methods of a study: nobody means more, and a line of text can ask for a thousand.
const MOST_RUNS: usize = 10_000;

fn contents(path: &Path) -> io::Result<String> {
    let mut contents = String::new();
    let mut file = File::open(path)?.take(LONGEST + 1);
    if file.read_to_string(&mut contents)? as u64 > LONGEST {
        let message = format!("it has more than {LONGEST} bytes, which no study needs");
        return Err(io::Error::other(message));
    }
    Ok(contents)
}

fn define(table: &mut TomlTable) -> Result<Vec<(String, String)>, FileError> {
    let Some(node) = table.take("define") else {
        return Ok(Vec::new());
    };
    let table = node.need_table("[define]")?;
    let pairs = table
        .rest()
        .map(|node| Ok((node.key().to_owned(), node.scalar()?)));
    pairs.collect()
}

fn poses(table: &mut TomlTable) -> Result<Vec<Given>, FileError> {
    let node = table.take("poses");
    node.map_or(Ok(Vec::new()), |node| sweep::poses(&node))
}

fn whole(table: &mut TomlTable, key: &'static str) -> Result<Option<u64>, FileError> {
    let number = table.take(key);
    let number = number.map(|node| node.parsed(|text| text.parse().ok(), "whole numbers from 0"));
    number.transpose()
}

/// More runs of one kind than this do not make a median better known.
const MOST_REPEATS: u32 = 1000;

fn repeats(table: &mut TomlTable) -> Result<u32, FileError> {
    let Some(node) = table.take("repeats") else {
        return Ok(1);
    };
    let parse = |text: &str| text.parse().ok().filter(|n| (1..=MOST_REPEATS).contains(n));
    node.parsed(parse, &format!("whole numbers 1..={MOST_REPEATS}"))
}

fn positive(table: &mut TomlTable, key: &'static str) -> Result<Option<f64>, FileError> {
    let number = table.take(key);
    let allowed = "numbers > 0, as a fraction (0.01) or in percent (\"1%\")";
    number
        .map(|node| node.parsed(parse_fraction, allowed))
        .transpose()
}

fn time(table: &mut TomlTable) -> Result<Option<Duration>, FileError> {
    let seconds = |text: &str| {
        let (number, unit) = match text.strip_suffix('m') {
            Some(number) => (number, 60.0),
            None => (text.strip_suffix('s')?, 1.0),
        };
        let number: f64 = number.trim().parse().ok()?;
        Duration::try_from_secs_f64(number * unit).ok()
    };
    let node = table.take("time");
    node.map(|node| node.parsed(seconds, "times with a unit, \"30s\" or \"2m\""))
        .transpose()
}

/// `sensor = "floor"` or `sensors = ["floor", "camera"]`.
fn sensors(table: &mut TomlTable) -> Result<Vec<String>, FileError> {
    let one = table.take("sensor");
    let several = table.take("sensors");
    match (one, several) {
        (Some(_), Some(node)) => Err(node.error("give either sensor or sensors")),
        (Some(node), None) => Ok(vec![node.scalar()?]),
        (None, Some(node)) => match node.list()? {
            Some(list) => Ok(list),
            None => Err(node.error("sensors is a list, [\"floor\", \"camera\"]")),
        },
        (None, None) => Ok(Vec::new()),
    }
}

/// `[truth]` for all sensors, or `[truth.ID]` for each.
fn truths(table: &mut TomlTable) -> Result<BTreeMap<Option<String>, StudyMethod>, FileError> {
    let Some(node) = table.take("truth") else {
        return Ok(BTreeMap::new());
    };
    let truth = |node: &TomlNode, name| {
        let method = sweep::method(node.need_table(name)?)?;
        if method.settings.len() != 1 {
            return Err(node.error(format!("{name} is one run: no lists and no ranges")));
        }
        Ok(method)
    };
    let by_sensor: Vec<TomlNode> = node.need_table("[truth]")?.rest().collect();
    if by_sensor.is_empty() || !by_sensor.iter().all(TomlNode::is_table) {
        return Ok(BTreeMap::from([(None, truth(&node, "[truth]")?)]));
    }
    by_sensor
        .iter()
        .map(|one| Ok((Some(one.key().to_owned()), truth(one, "[truth.SENSOR]")?)))
        .collect()
}

fn methods(table: &mut TomlTable) -> Result<Vec<StudyMethod>, FileError> {
    let Some(node) = table.take("method") else {
        return Ok(Vec::new());
    };
    let mut methods: Vec<StudyMethod> = Vec::new();
    let mut runs = 0;
    for table in node.tables("[[method]]")? {
        let method = sweep::method(table)?;
        runs += method.settings.len();
        if runs > MOST_RUNS {
            return Err(node.error(format!("more than {MOST_RUNS} runs of all methods")));
        }
        methods.push(method);
    }
    Ok(methods)
}

fn candidates(table: &mut TomlTable, folder: &Path) -> Result<Vec<StudyCandidate>, FileError> {
    let Some(node) = table.take("candidate") else {
        return Ok(Vec::new());
    };
    let tables = node.tables("[[candidate]]")?;
    let candidates = tables.into_iter().map(|mut table| {
        let candidate = StudyCandidate {
            name: table.need("name")?.scalar()?,
            sensor: table.take("sensor").map(|node| node.scalar()).transpose()?,
            file: folder.join(table.need("file")?.scalar()?),
            seconds: positive(&mut table, "seconds")?,
        };
        table.finish()?;
        Ok(candidate)
    });
    candidates.collect()
}

fn max_error(table: &mut TomlTable) -> Result<Vec<StudyLimit>, FileError> {
    let Some(node) = table.take("max-error") else {
        return Ok(Vec::new());
    };
    let table = node.need_table("[max-error]")?;
    let limits = table.rest().map(|node| {
        let name = node.key().to_owned();
        node.parsed(|value| StudyLimit::parse(&name, value), limit::ALLOWED)
    });
    limits.collect()
}
