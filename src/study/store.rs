//! Films kept in files, found again by the ingredients that they were made from.
//!
//! A run's key is a hash of the scene (its file, all files it names, its parameters), the sensor, the method,
//! all settings and the program's source. Three files hold a run. `STEM.exr` is the film. `STEM.json` holds
//! all facts of it, and is written last, so that it stands for a whole run. `STEM.time.json` holds its time,
//! which is apart since it is never the same twice.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};

use super::facts::{Facts, Product};
use super::machine::Machine;
use super::plan::StudyRun;
use crate::film::atomic::{self, WriteError};
use crate::film::exr::{self, ExrWriteError};
use crate::run::{SOURCE_HASH, texels};
use crate::scene::{Scene, Sensor};

/// A folder of runs.
#[derive(Clone, Debug)]
pub struct Store {
    folder: PathBuf,
}

/// A run in the store's files.
#[derive(Clone, Debug, PartialEq)]
pub struct StoredRun {
    /// The file's name in the store.
    pub exr: String,
    /// A hash of all its channels: films with the same one are the same to the last bit.
    pub texels: String,
    /// All facts of the film.
    pub facts: Facts,
    /// Its time.
    pub time: Time,
}

/// The time of a run, and the machine on which it was taken.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Time {
    /// From set-up to the film, once for each repeat \[s\].
    pub seconds: Vec<f64>,
    /// Threads used.
    pub threads: usize,
    /// The machine.
    pub machine: Machine,
}

impl Time {
    /// The time of one run on this machine, with as many threads as are in use.
    pub fn of_this_machine(seconds: f64) -> Self {
        Self {
            seconds: vec![seconds],
            threads: rayon::current_num_threads(),
            machine: Machine::this(),
        }
    }

    /// Adds a repeat. Seconds of another machine or another number of threads do not compare with it: it
    /// replaces them.
    pub fn repeat(&mut self, again: Self) {
        if self.machine == again.machine && self.threads == again.threads {
            self.seconds.extend(again.seconds);
        } else {
            *self = again;
        }
    }
}

/// The content of `STEM.json`.
#[derive(Serialize, Deserialize)]
struct StoreRecord {
    /// The run's key.
    key: String,
    /// A hash of the EXR.
    exr: String,
    /// A hash of all channels.
    texels: String,
    facts: Facts,
}

/// A value that is computed from a run and its truth, and kept as JSON.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Value {
    /// The text by which it is found again.
    pub key: String,
    name: String,
}

impl Value {
    /// A value with a name, from a run, its truth, and what else is named.
    pub fn new(
        name: String,
        scene: &Scene,
        sensor: &Sensor,
        [run, truth]: [&StudyRun; 2],
        else_named: &str,
    ) -> Self {
        let mut hasher = blake3::Hasher::new();
        for run in [run, truth] {
            hasher.update(key(SOURCE_HASH, scene, sensor, run).as_bytes());
        }
        hasher.update(else_named.as_bytes());
        let key = hasher.finalize().to_hex().to_string();
        Self { key, name }
    }

    /// Its file.
    pub fn file(&self) -> String {
        format!("{}-{}.json", file_name(&self.name), &self.key[..10])
    }
}

/// Errors of keeping a run.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// The image cannot be written.
    #[error(transparent)]
    Image(#[from] ExrWriteError),
    /// Another file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
    /// A file or folder cannot be used.
    #[error("cannot use {}: {cause}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The system's error.
        cause: io::Error,
    },
}

impl Store {
    /// The store in a folder, which is made if it is missing.
    ///
    /// # Errors
    ///
    /// If the folder cannot be made.
    pub fn open(folder: &Path) -> Result<Self, StoreError> {
        std::fs::create_dir_all(folder).map_err(|cause| io_error(folder, cause))?;
        Ok(Self {
            folder: folder.to_owned(),
        })
    }

    /// The path of a file of the store.
    pub fn path(&self, name: &str) -> PathBuf {
        self.folder.join(name)
    }

    /// A hash of the program's source.
    pub fn program(&self) -> &'static str {
        SOURCE_HASH
    }

    /// The text by which a run is found again.
    pub fn key(&self, scene: &Scene, sensor: &Sensor, run: &StudyRun) -> String {
        key(SOURCE_HASH, scene, sensor, run)
    }

    /// The files of a run, that of its facts last.
    pub fn files(&self, scene: &Scene, sensor: &Sensor, run: &StudyRun) -> Vec<String> {
        let stem = stem(sensor, run, &self.key(scene, sensor, run));
        let ends = [".exr", ".time.json", ".json"];
        ends.map(|end| format!("{stem}{end}")).to_vec()
    }

    /// A run that is whole and unchanged since it was kept; anything else does not count.
    ///
    /// Its numbers are the kept ones to the last bit: `serde_json` reads them so by its feature
    /// `float_roundtrip` only.
    pub fn find(&self, scene: &Scene, sensor: &Sensor, run: &StudyRun) -> Option<StoredRun> {
        let key = key(SOURCE_HASH, scene, sensor, run);
        let stem = stem(sensor, run, &key);
        let read = |end: &str| std::fs::read(self.path(&format!("{stem}{end}"))).ok();
        let record: StoreRecord = serde_json::from_slice(&read(".json")?).ok()?;
        let time = serde_json::from_slice(&read(".time.json")?).ok()?;
        let is_whole = record.key == key && record.exr == blake3::hash(&read(".exr")?).to_string();
        is_whole.then(|| StoredRun {
            exr: format!("{stem}.exr"),
            texels: record.texels,
            facts: record.facts,
            time,
        })
    }

    /// Keeps a run.
    ///
    /// # Errors
    ///
    /// If a file cannot be written; the files that are left do not count as a run.
    pub fn keep(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        run: &StudyRun,
        product: Product,
        time: Time,
    ) -> Result<StoredRun, StoreError> {
        let key = key(SOURCE_HASH, scene, sensor, run);
        let stem = stem(sensor, run, &key);
        let exr = format!("{stem}.exr");
        let path = self.path(&exr);
        exr::write(&path, &described(scene, sensor, run, &product))?;
        let bytes = std::fs::read(&path).map_err(|cause| io_error(&path, cause))?;
        self.keep_time(&exr, &time)?;
        let record = StoreRecord {
            key,
            exr: blake3::hash(&bytes).to_string(),
            texels: texels_hash(&product.image),
            facts: product.facts,
        };
        write_json(&self.path(&format!("{stem}.json")), &record)?;
        Ok(StoredRun {
            exr,
            texels: record.texels,
            facts: record.facts,
            time,
        })
    }

    /// A value that was kept; `None` if it is not there, or was computed from other runs.
    pub fn value<T: DeserializeOwned>(&self, value: &Value) -> Option<T> {
        let bytes = std::fs::read(self.path(&value.file())).ok()?;
        let record: ValueRecord<T> = serde_json::from_slice(&bytes).ok()?;
        (record.key == value.key).then_some(record.value)
    }

    /// True if a value is kept.
    pub fn has(&self, value: &Value) -> bool {
        self.value::<serde::de::IgnoredAny>(value).is_some()
    }

    /// Keeps a value.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    pub fn keep_value<T: Serialize>(&self, value: &Value, content: &T) -> Result<(), StoreError> {
        let record = ValueRecord {
            key: value.key.clone(),
            value: content,
        };
        write_json(&self.path(&value.file()), &record)
    }

    /// Removes a value that is not needed any more. One that stays does no harm.
    pub fn forget(&self, value: &Value) {
        let _ = std::fs::remove_file(self.path(&value.file()));
    }

    /// Keeps a run's time.
    ///
    /// # Errors
    ///
    /// If the file cannot be written.
    pub fn keep_time(&self, exr: &str, time: &Time) -> Result<(), StoreError> {
        let stem = exr.strip_suffix(".exr").unwrap_or(exr);
        write_json(&self.path(&format!("{stem}.time.json")), time)
    }
}

/// A hash of the names and samples of all channels.
fn texels_hash(image: &crate::film::Image) -> String {
    let mut hasher = blake3::Hasher::new();
    for channel in &image.channels {
        hasher.update(channel.name.as_bytes());
        for sample in &channel.samples {
            hasher.update(&sample.to_bits().to_le_bytes());
        }
    }
    hasher.finalize().to_hex().to_string()
}

/// A value that was computed from runs, and their key.
#[derive(Serialize, Deserialize)]
struct ValueRecord<T> {
    key: String,
    value: T,
}

/// The text by which a run is found again, from all that its film is made from.
fn key(program: &str, scene: &Scene, sensor: &Sensor, run: &StudyRun) -> String {
    let parts = [
        program,
        scene.content_hash(),
        &sensor.id,
        run.method.name(),
        &run.method.settings().to_string(),
    ];
    let mut hasher = blake3::Hasher::new();
    for part in parts {
        // With its length: no two lists of parts are the same text.
        hasher.update(&(part.len() as u64).to_le_bytes());
        hasher.update(part.as_bytes());
    }
    hasher.finalize().to_hex().to_string()
}

/// Writes JSON for people, whole or not at all.
///
/// # Errors
///
/// If the file cannot be written.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<(), StoreError> {
    atomic::write(path, |file| {
        serde_json::to_writer_pretty(&mut *file, value)?;
        writeln!(file)
    })?;
    Ok(())
}

fn io_error(path: &Path, cause: io::Error) -> StoreError {
    StoreError::Io {
        path: path.to_owned(),
        cause,
    }
}

/// A file stem: a name that a person recognises, and the beginning of the key, which makes it unique.
fn stem(sensor: &Sensor, run: &StudyRun, key: &str) -> String {
    let label = run.label().replace('%', "pct");
    let name = file_name(&format!("{}-{label}", sensor.id));
    format!("{name}-{}", &key[..10])
}

/// A text as the name of a file: a hundred characters at most, of plain letters, numbers, hyphens and dots.
pub fn file_name(text: &str) -> String {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-.".contains(c);
    let plain = text.chars().map(|c| if allowed(c) { c } else { '-' });
    // Systems limit the length of names; the key does not need the rest.
    plain.take(100).collect()
}

/// The film with the metadata that describe it.
fn described(
    scene: &Scene,
    sensor: &Sensor,
    run: &StudyRun,
    product: &Product,
) -> crate::film::Image {
    let mut image = product.image.clone();
    let mut settings = run.method.settings();
    if let (Some(settings), Some(replicates)) = (settings.as_object_mut(), product.facts.replicates)
    {
        settings.insert("replicates".to_owned(), replicates.into());
    }
    let facts = &product.facts;
    image.add_metadata("scene", scene.path().display().to_string());
    image.add_metadata("scene-hash", scene.content_hash());
    image.add_metadata("sensor", sensor.id.as_str());
    image.add_metadata("method", run.method.name());
    image.add_metadata("settings", settings.to_string());
    image.add_metadata("version", env!("CARGO_PKG_VERSION"));
    image.add_metadata("complete", if facts.complete { "yes" } else { "no" });
    image.add_metadata("warnings", serde_json::json!(facts.warnings).to_string());
    image.add_metadata("quantity", product.quantity.name());
    image.add_metadata("unit", product.quantity.unit());
    texels::describe(&mut image, scene, sensor);
    image
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::method::Method;
    use crate::mitsuba;
    use crate::setting::Given;

    fn run(photons: &str) -> StudyRun {
        let given = Given::from([("photons".to_owned(), photons.to_owned())]);
        StudyRun {
            name: "photons".to_owned(),
            method: Method::new("photons", &given).unwrap(),
            given,
            is_default: false,
        }
    }

    #[test]
    fn a_run_is_known_by_its_source_and_settings_and_not_by_the_executable() {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/glass-ball.xml");
        let scene = mitsuba::load(&path, &[]).unwrap();
        let sensor = &scene.sensors()[0];
        let one = key("a hash", &scene, sensor, &run("64"));
        assert_eq!(one, key("a hash", &scene, sensor, &run("64")));
        assert_ne!(one, key("another hash", &scene, sensor, &run("64")));
        assert_ne!(one, key("a hash", &scene, sensor, &run("65")));
        // Runs are not kept under a hash of this test's executable.
        let executable = std::fs::read(std::env::current_exe().unwrap()).unwrap();
        assert_ne!(SOURCE_HASH, blake3::hash(&executable).to_string());
        let is_hash = SOURCE_HASH.len() == 64 && SOURCE_HASH.chars().all(|c| c.is_ascii_hexdigit());
        assert!(is_hash, "{SOURCE_HASH}");
    }

    #[test]
    fn repeats_elsewhere_do_not_join_the_seconds_of_another_machine() {
        let on = |host: &str, threads, seconds: &[f64]| Time {
            seconds: seconds.to_vec(),
            threads,
            machine: Machine {
                host: host.to_owned(),
                processor: "a processor".to_owned(),
            },
        };
        let mut time = on("here", 2, &[1.0]);
        time.repeat(on("here", 2, &[1.5]));
        assert_eq!(time, on("here", 2, &[1.0, 1.5]));
        time.repeat(on("there", 2, &[9.0]));
        assert_eq!(time, on("there", 2, &[9.0]));
        time.repeat(on("there", 1, &[18.0]));
        assert_eq!(time, on("there", 1, &[18.0]));
    }
}
