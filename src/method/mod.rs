//! Methods: one door to every way of filling a sensor.
//!
//! A [`Method`] is a name with settings. Its settings are rows of one table, which serves flags, `--set`,
//! `study.toml`, help, documents and errors. It says whether it [supports](Method::supports) a scene, what a
//! run [costs](Method::cost), and [runs](Method::run) within a [`Budget`].
//!
//! | file | content |
//! |---|---|
//! | [`mod@choose`] | the method that a scene allows best |
//! | [`table`] | all methods with their settings, for help and flags |
//! | `references/` | beams, photons, ...: one file each, of `reference.rs`' interface |
//! | [`inspection`] | what can be said of a scene before a run |
//! | [`wanted`] | the sensor and the method that suit what is asked for |
//! | [`sensors`] | the sensor of an id, or the first |
//! | `sequence.rs` | frames of an animation, one after the other |
//! | `tables.rs` | tables of a technique that outlive a frame, all of them |
//! | `technique.rs` | any technique of [`approximation`](crate::approximation) |
//! | `rows.rs` | rows that several tables share |
//! | `memory.rs` | bytes of films |
//! | `warnings.rs` | the one place for warnings |
//!
//! A new reference is a file in `references/` and a line in its list; a new technique is registered in
//! [`TECHNIQUES`](crate::approximation::TECHNIQUES) and needs nothing here.

pub mod choose;
mod entry;
pub mod inspection;
mod memory;
mod reference;
mod references;
mod rows;
pub mod sensors;
mod sequence;
pub mod shards;
pub mod table;
#[cfg(feature = "cli")]
pub mod tables;
mod technique;
pub mod wanted;
mod warnings;

use std::collections::BTreeMap;
use std::fmt;

use crate::approximation::Twins;
use crate::run::{Budget, Context, Cost, Error, Refusal, Rendering};
use crate::scene::{Scene, Sensor};
use crate::setting::{SettingError, Values};

pub use choose::Choice;
use entry::Entry;
pub use sequence::Sequence;

/// A method with its settings.
///
/// # Example: measure a scene by the method that suits it
///
/// ```
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// use nephroid::{Budget, Context, Method};
///
/// let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "16")])?;
/// let sensor = &scene.sensors()[0];
/// let choice = Method::choose(&scene, sensor)?;
/// assert_eq!(choice.method.name(), "beams");
/// let rendering = choice.method.run(&scene, sensor, &Budget::error(0.1), &Context::default())?;
/// assert!(rendering.estimate.total.range().mean > 0.0);
/// # Ok(())
/// # }
/// ```
#[derive(Clone)]
pub struct Method {
    entry: Entry,
    values: Values,
}

impl PartialEq for Method {
    fn eq(&self, other: &Self) -> bool {
        self.name() == other.name() && self.values == other.values
    }
}

impl fmt::Debug for Method {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{} {:?}", self.name(), self.values.given())
    }
}

/// A stage of a technique, as a method's settings have it.
///
/// # Example: the stages that approximate
///
/// ```
/// let map = nephroid::Method::new("caustic-map", &Default::default())?;
/// for stage in map.stages().iter().filter(|stage| !stage.is_exact()) {
///     println!("{}: {} instead of {}", stage.name, stage.variant, stage.exact);
/// }
/// assert_eq!(map.stages()[0].name, "view");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Eq, serde::Serialize)]
pub struct StageSetting {
    /// The name, which is the key of the setting that chooses its variant.
    pub name: &'static str,
    /// The variant that runs.
    pub variant: String,
    /// The variant without the stage's error.
    pub exact: &'static str,
}

impl StageSetting {
    /// True if the variant that runs has no error of its own.
    ///
    /// # Example: a stage without error
    ///
    /// ```
    /// let map = nephroid::Method::new("caustic-map", &Default::default())?.with_exact("splat")?;
    /// let splat = map.stages().into_iter().find(|stage| stage.name == "splat");
    /// assert!(splat.is_some_and(|stage| stage.is_exact()));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn is_exact(&self) -> bool {
        self.variant == self.exact
    }
}

impl Method {
    /// The method of a name, with settings as text; settings that are not given have their defaults.
    ///
    /// # Errors
    ///
    /// For a name that does not exist, a setting that the method does not have, and a value that it cannot
    /// have.
    ///
    /// # Example: a million photons
    ///
    /// ```
    /// let settings = [("photons".to_owned(), "1048576".to_owned())].into();
    /// let method = nephroid::Method::new("photons", &settings)?;
    /// assert_eq!(method.budget().work, Some(1 << 20));
    /// # Ok::<(), nephroid::SettingError>(())
    /// ```
    pub fn new(name: &str, settings: &BTreeMap<String, String>) -> Result<Self, SettingError> {
        let entry = Entry::of(name)?;
        let values = Values::new(entry.name(), entry.table(), settings)
            .map_err(|error| error.of_others(table::owners))?;
        let method = Self { entry, values };
        method.check_bar(&method.budget())?;
        Ok(method)
    }

    /// Refuses a limit on the error of a single replicate, which would never know it.
    fn check_bar(&self, budget: &Budget) -> Result<(), SettingError> {
        let is_alone = self.values.whole::<u32>("replicates") == Some(1);
        if is_alone && budget.relative_error.is_some() {
            let allowed =
                "2 and more with a limit on the error: its bar takes at least 2 replicates";
            return Err(SettingError::value("replicates", "1", allowed));
        }
        Ok(())
    }

    /// The names of all methods.
    ///
    /// # Example: a list for a menu
    ///
    /// ```
    /// let names = nephroid::Method::names();
    /// assert!(names.contains(&"beams") && names.contains(&"photons"));
    /// ```
    pub fn names() -> Vec<&'static str> {
        Entry::all().map(Entry::name).collect()
    }

    /// The name.
    ///
    /// # Example: the name beside a result
    ///
    /// ```
    /// let method = nephroid::Method::new("beams", &Default::default())?;
    /// assert_eq!(method.name(), "beams");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn name(&self) -> &'static str {
        self.entry.name()
    }

    /// One line: the light that the method measures, and how.
    ///
    /// # Example: help for all methods
    ///
    /// ```
    /// for name in nephroid::Method::names() {
    ///     let method = nephroid::Method::new(name, &Default::default())?;
    ///     println!("{name:>12}  {}", method.meaning());
    ///     assert!(!method.meaning().is_empty());
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn meaning(&self) -> &'static str {
        self.entry.meaning()
    }

    /// The settings that were given, as text.
    ///
    /// # Example: only the settings that differ from the defaults
    ///
    /// ```
    /// let method = nephroid::Method::new("photons", &Default::default())?.with("seed", "7")?;
    /// assert_eq!(method.given()["seed"], "7");
    /// assert_eq!(method.given().len(), 1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn given(&self) -> &BTreeMap<String, String> {
        self.values.given()
    }

    /// All settings with a value, those not given included, as JSON: runs with the same settings have the
    /// same bits.
    ///
    /// # Example: a default value
    ///
    /// ```
    /// let method = nephroid::Method::new("photons", &Default::default())?;
    /// assert_eq!(method.settings()["replicates"], 32);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn settings(&self) -> serde_json::Value {
        self.values.json()
    }

    /// The limits among the settings.
    ///
    /// # Example: a limit on the error as a setting
    ///
    /// ```
    /// let method = nephroid::Method::new("photons", &Default::default())?.with("error", "1%")?;
    /// assert_eq!(method.budget(), nephroid::Budget::error(0.01));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn budget(&self) -> Budget {
        Budget {
            relative_error: self.values.fraction("error"),
            time: self.values.time("time"),
            work: self.entry.work_key().and_then(|key| self.values.whole(key)),
        }
    }

    /// The same method with another value of one setting.
    ///
    /// # Errors
    ///
    /// As [`Method::new`].
    ///
    /// # Example: the same photons from another seed
    ///
    /// ```
    /// let method = nephroid::Method::new("photons", &Default::default())?;
    /// let other = method.with("seed", "7")?;
    /// assert_ne!(method, other);
    /// assert!(method.with("seed", "seven").is_err());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with(&self, key: &str, value: &str) -> Result<Self, SettingError> {
        let mut given = self.given().clone();
        given.insert(key.to_owned(), value.to_owned());
        Self::new(self.name(), &given)
    }

    /// The stages of a technique, in the order in which they run; empty for references.
    ///
    /// # Example: the order of the stages
    ///
    /// ```
    /// let map = nephroid::Method::new("caustic-map", &Default::default())?;
    /// let names: Vec<_> = map.stages().iter().map(|stage| stage.name).collect();
    /// assert_eq!(names.first(), Some(&"view"));
    /// assert_eq!(names.last(), Some(&"lookup"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn stages(&self) -> Vec<StageSetting> {
        let stages = self.entry.stages().iter().map(|stage| StageSetting {
            name: stage.name,
            variant: self.values.text(stage.name).unwrap_or_default().to_owned(),
            exact: stage.exact,
        });
        stages.collect()
    }

    /// The same technique with one stage exact.
    ///
    /// # Errors
    ///
    /// For a name that is none of its stages.
    ///
    /// # Example: the technique without the error of its refraction
    ///
    /// ```
    /// let map = nephroid::Method::new("caustic-map", &Default::default())?;
    /// let better = map.with_exact("refraction")?;
    /// assert_eq!(better.given()["refraction"], "exact");
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn with_exact(&self, stage: &str) -> Result<Self, SettingError> {
        let stages = self.entry.stages();
        let found = stages.iter().find(|one| one.name == stage);
        let found = found.ok_or_else(|| {
            SettingError::unknown("stage", stage, stages.iter().map(|one| one.name))
        })?;
        self.with(found.name, found.exact)
    }

    /// The setting that says how well exact twins are known, and its value; `None` if they are but for
    /// rounding.
    pub(crate) fn twins(&self) -> Option<(Twins, f64)> {
        let Entry::Technique(technique) = self.entry else {
            return None;
        };
        let twins = technique.twins()?;
        Some((twins, self.values.number(twins.key())?))
    }

    /// True for approximations: real-time techniques, whose stages have errors.
    ///
    /// # Example: truth or approximation
    ///
    /// ```
    /// let is_technique = |name| Ok::<_, nephroid::SettingError>(
    ///     nephroid::Method::new(name, &Default::default())?.is_technique(),
    /// );
    /// assert!(is_technique("caustic-map")? && !is_technique("beams")?);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn is_technique(&self) -> bool {
        matches!(self.entry, Entry::Technique(_))
    }

    /// The settings of a default study: a key, and its values from coarse to fine; `None` for references.
    #[doc(hidden)]
    pub fn sweep(&self) -> Option<(&'static str, &'static [&'static str])> {
        match self.entry {
            Entry::Reference(_) => None,
            Entry::Technique(technique) => Some(technique.sweep()),
        }
    }

    /// The key of the limit on work, in the method's own unit.
    pub(crate) fn work_key(&self) -> Option<&'static str> {
        self.entry.work_key()
    }

    /// True if it fills cameras only.
    #[doc(hidden)]
    pub fn is_of_cameras(&self) -> bool {
        matches!(self.entry, Entry::Reference(one) if one.about().is_of_cameras)
    }

    /// Refuses scenes and sensors that the method cannot work on, without running it.
    ///
    /// # Errors
    ///
    /// Names what the scene or the sensor has that the method cannot take, and what is allowed.
    ///
    /// # Example: the methods that a scene allows
    ///
    /// ```
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// for name in nephroid::Method::names() {
    ///     let method = nephroid::Method::new(name, &Default::default())?;
    ///     match method.supports(&scene, sensor) {
    ///         Ok(()) => println!("{name}"),
    ///         Err(refusal) => println!("not {name}: {refusal}"),
    ///     }
    ///     assert!(name != "photons" || method.supports(&scene, sensor).is_ok());
    /// }
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn supports(&self, scene: &Scene, sensor: &Sensor) -> Result<(), Refusal> {
        self.entry.supports(scene, sensor, &self.values)
    }

    /// The cost of a run before anything is traced: a bound on its memory, and the work that its settings
    /// fix.
    ///
    /// # Example: memory before a run
    ///
    /// ```
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// let cost = nephroid::Method::new("photons", &Default::default())?.cost(&scene, sensor);
    /// assert!(cost.bytes < 100_000_000);
    /// assert_eq!((cost.work[0].name.as_str(), cost.work[0].count), ("photons", 1 << 24));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn cost(&self, scene: &Scene, sensor: &Sensor) -> Cost {
        self.entry.cost(scene, sensor, &self.values)
    }

    /// Memory \[bytes\] of a run with the light that a pilot finds, beside the scene and the program: at most
    /// that of the [`cost`](Self::cost).
    ///
    /// # Errors
    ///
    /// If the method cannot work on the scene or the sensor.
    #[doc(hidden)]
    pub fn pilot_bytes(&self, scene: &Scene, sensor: &Sensor) -> Result<u64, Error> {
        self.supports(scene, sensor)?;
        self.entry.pilot_bytes(scene, sensor, &self.values)
    }

    /// What a pilot of a few photons says of the settings in a scene, a line each; empty for methods without
    /// one.
    ///
    /// # Errors
    ///
    /// If the method cannot work on the scene or the sensor.
    ///
    /// # Example: the light that two surfaces a slab lose
    ///
    /// ```
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// let volume = nephroid::Method::new("caustics-volume", &Default::default())?;
    /// let advice = volume.advice(&scene, sensor)?;
    /// assert!(advice[0].contains("photons"), "{advice:?}");
    /// assert!(nephroid::Method::new("photons", &Default::default())?.advice(&scene, sensor)?.is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn advice(&self, scene: &Scene, sensor: &Sensor) -> Result<Vec<String>, Error> {
        self.supports(scene, sensor)?;
        self.entry.advice(scene, &self.values)
    }

    /// Refuses films that no file or not the free memory can hold.
    ///
    /// # Errors
    ///
    /// With the size, the memory that it takes, and the memory that there is.
    pub(crate) fn check_memory(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        context: &Context,
    ) -> Result<(), Refusal> {
        let film = &sensor.film;
        let most = crate::film::Image::MAX_SIZE;
        if film.width.max(film.height) as usize > most {
            return Err(Refusal::new(format!(
                "sensor \"{}\": a film of {} x {} texels; 1 to {most} each way are allowed",
                sensor.id, film.width, film.height
            )));
        }
        let needed = self.cost(scene, sensor).bytes;
        let free = context.available_bytes();
        let Some(available) = free.filter(|available| needed > *available) else {
            return Ok(());
        };
        let why = self.entry.too_large(scene, sensor, &self.values, available);
        Err(Refusal::new(why.unwrap_or_else(|| {
            format!(
                "sensor \"{}\": {} x {} texels by {} take about {:.1} GB of memory, and {:.1} GB are free; a \
                 smaller film, a crop or fewer layers take less",
                sensor.id,
                film.crop.width,
                film.crop.height,
                self.name(),
                needed as f64 / 1e9,
                available as f64 / 1e9
            )
        })))
    }

    /// Fills a sensor, within `budget` and the limits among the settings.
    ///
    /// # Errors
    ///
    /// If the method cannot work on the scene or the sensor, the film does not fit into memory, or numbers
    /// cannot be summed.
    ///
    /// # Example: four thousand photons
    ///
    /// ```
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// use nephroid::{Budget, Context, Method};
    ///
    /// let method = Method::new("photons", &Default::default())?;
    /// let rendering = method.run(&scene, sensor, &Budget::work(4096), &Context::default())?;
    /// assert_eq!(rendering.estimate.paths, 4096);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn run(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        budget: &Budget,
        context: &Context,
    ) -> Result<Rendering, Error> {
        self.frames().frame(scene, sensor, budget, context)
    }

    /// A rendering whose files say by what method, with which settings and on what sensor they were made.
    fn described(&self, mut rendering: Rendering, sensor: &Sensor) -> Rendering {
        let report = &mut rendering.report;
        report.insert("method".to_owned(), self.name().into());
        report.insert("sensor".to_owned(), sensor.id.as_str().into());
        if !report.contains_key("settings") {
            report.insert("settings".to_owned(), self.settings());
        }
        rendering
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_name_makes_the_method_of_that_name() {
        for name in Method::names() {
            let method = Method::new(name, &BTreeMap::new()).unwrap();
            assert_eq!(method.name(), name);
        }
    }

    #[test]
    fn an_unknown_method_is_refused_and_the_nearest_one_suggested() {
        let error = Method::new("beam", &BTreeMap::new()).unwrap_err();
        let error = error.to_string();
        assert!(error.contains("did you mean \"beams\"?"), "{error}");
    }

    #[test]
    fn a_film_is_refused_one_byte_below_its_cost() {
        let scene = crate::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")]).unwrap();
        let sensor = &scene.sensors()[0];
        for name in ["beams", "photons", "closed-form", "caustic-map"] {
            let method = Method::new(name, &BTreeMap::new()).unwrap();
            let bytes = method.cost(&scene, sensor).bytes;
            let check = |bytes| {
                let context = Context {
                    memory_limit: Some(bytes),
                    ..Context::default()
                };
                method.check_memory(&scene, sensor, &context)
            };
            assert!(check(bytes).is_ok(), "{name}");
            assert!(check(bytes - 1).is_err(), "{name}");
        }
    }

    #[test]
    fn an_error_to_stop_at_needs_two_replicates() {
        let given = |pairs: &[(&str, &str)]| {
            let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
            pairs.iter().map(owned).collect()
        };
        let alone = given(&[("replicates", "1"), ("error", "1%")]);
        assert!(Method::new("photons", &alone).is_err());
        let single = Method::new("photons", &given(&[("replicates", "1")])).unwrap();
        assert!(single.with("error", "1%").is_err());
        assert!(single.check_bar(&Budget::error(0.01)).is_err());
        assert!(single.check_bar(&Budget::work(1)).is_ok());
    }
}
