//! An entry of the table of methods: a reference or a technique.

use super::reference::{Job, Reference};
use super::references::REFERENCES;
use super::technique;
use crate::approximation::{Prepared, Stage, TECHNIQUES, Technique};
use crate::run::{Cost, Error, Refusal, Rendering};
use crate::scene::{Scene, Sensor};
use crate::setting::{Setting, SettingError, Values};

/// A reference or a technique.
#[derive(Clone, Copy)]
pub(super) enum Entry {
    Reference(&'static dyn Reference),
    Technique(&'static dyn Technique),
}

impl Entry {
    /// All entries, references first.
    pub fn all() -> impl Iterator<Item = Self> {
        let references = Self::references().map(Self::Reference);
        references.chain(TECHNIQUES.iter().map(|one| Self::Technique(*one)))
    }

    /// All references.
    pub fn references() -> impl Iterator<Item = &'static dyn Reference> {
        REFERENCES.iter().copied()
    }

    /// The entry of a name.
    pub fn of(name: &str) -> Result<Self, SettingError> {
        let names = || Self::all().map(Self::name);
        Self::all()
            .find(|entry| entry.name() == name)
            .ok_or_else(|| SettingError::unknown("method", name, names()))
    }

    pub fn name(self) -> &'static str {
        match self {
            Self::Reference(one) => one.about().name,
            Self::Technique(one) => one.name(),
        }
    }

    pub fn meaning(self) -> &'static str {
        match self {
            Self::Reference(one) => one.about().meaning,
            Self::Technique(one) => one.meaning(),
        }
    }

    /// Limits and settings.
    pub fn table(self) -> Vec<&'static Setting> {
        match self {
            Self::Reference(one) => {
                let about = one.about();
                about.limits.iter().chain(about.settings).collect()
            }
            Self::Technique(one) => one.settings().iter().collect(),
        }
    }

    pub fn work_key(self) -> Option<&'static str> {
        match self {
            Self::Reference(one) => one.about().work_key,
            Self::Technique(_) => None,
        }
    }

    pub fn stages(self) -> &'static [Stage] {
        match self {
            Self::Reference(_) => &[],
            Self::Technique(one) => one.stages(),
        }
    }

    pub fn supports(self, scene: &Scene, sensor: &Sensor, values: &Values) -> Result<(), Refusal> {
        self.check_dispersion(scene)?;
        match self {
            Self::Reference(one) => one.supports(scene, sensor, values),
            Self::Technique(one) => one.supports(scene, sensor, values),
        }
    }

    /// Refuses scenes with dispersion, if it takes every index for one number.
    pub fn check_dispersion(self, scene: &Scene) -> Result<(), Refusal> {
        let follows = match self {
            Self::Reference(one) => one.follows_dispersion(),
            Self::Technique(_) => false,
        };
        match scene.dispersion().first() {
            Some(one) if !follows => Err(Refusal::new(format!(
                "\"{}\" has dispersion ({}), and the method {} knows one index for all wavelengths: use --method photons, \
                 or leave --dispersion out",
                one.id,
                one.glass.name(),
                self.name()
            ))),
            _ => Ok(()),
        }
    }

    pub fn cost(self, scene: &Scene, sensor: &Sensor, values: &Values) -> Cost {
        match self {
            Self::Reference(one) => one.cost(scene, sensor, values),
            Self::Technique(one) => one.cost(scene, sensor, values),
        }
    }

    /// Memory \[bytes\] of a run with the light that a pilot finds.
    pub fn pilot_bytes(
        self,
        scene: &Scene,
        sensor: &Sensor,
        values: &Values,
    ) -> Result<u64, Error> {
        match self {
            Self::Reference(one) => one.pilot(scene, sensor, values),
            Self::Technique(one) => one.pilot(scene, sensor, values),
        }
    }

    /// Why a run does not fit into `available` bytes, if the method knows more of it than its film.
    pub fn too_large(
        self,
        scene: &Scene,
        sensor: &Sensor,
        values: &Values,
        available: u64,
    ) -> Option<String> {
        match self {
            Self::Reference(_) => None,
            Self::Technique(one) => one.too_large(scene, sensor, values, available),
        }
    }

    /// What a pilot says of the settings; references have none.
    pub fn advice(self, scene: &Scene, values: &Values) -> Result<Vec<String>, Error> {
        match self {
            Self::Reference(_) => Ok(Vec::new()),
            Self::Technique(one) => one.advice(scene, values),
        }
    }

    /// Fills a sensor. Techniques may use what is left of the frames before, and leave that of this one.
    pub fn run(self, job: &Job, left: &mut Option<Box<dyn Prepared>>) -> Result<Rendering, Error> {
        self.check_dispersion(job.scene)?;
        match self {
            Self::Reference(one) => one.run(job),
            Self::Technique(one) => technique::run(one, job, left),
        }
    }
}
