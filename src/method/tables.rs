//! Tables that outlive a frame: all that a technique can use again, made beforehand.

use std::path::{Path, PathBuf};

use super::Method;
use super::entry::Entry;
use crate::approximation::{TECHNIQUES, TableChoices, TableReport, Technique};
use crate::film::atomic::WriteError;
use crate::run::{Context, Error, Refusal};
use crate::scene::{Scene, Sensor};

/// The setting that asks for tables, and its word for all of them.
const TABLES: (&str, &str) = ("tables", "all");

/// What became of tables.
#[derive(Debug)]
pub struct Tables {
    /// Counts and oddities.
    pub report: TableReport,
    /// Files written for other programs; none if the run was stopped.
    pub exported: Vec<PathBuf>,
}

/// Reason for which tables were not made, or not written for other programs.
#[derive(Debug, thiserror::Error)]
pub enum TablesError {
    /// They were not made.
    #[error(transparent)]
    Run(#[from] Error),
    /// A file for other programs was not written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

/// True if a technique makes tables that may outlive a frame.
fn has_tables(technique: &dyn Technique) -> bool {
    let mut settings = technique.settings().iter();
    settings.any(|setting| setting.key == TABLES.0)
}

impl Method {
    /// The names of methods that make tables which may outlive a frame.
    pub(crate) fn names_with_tables() -> Vec<&'static str> {
        let techniques = TECHNIQUES.iter().filter(|one| has_tables(**one));
        techniques.map(|one| one.name()).collect()
    }

    /// The method with all tables asked for.
    ///
    /// # Errors
    ///
    /// If it makes none, or with its settings none that outlive a frame.
    pub(crate) fn with_all_tables(&self) -> Result<Self, Error> {
        self.with_tables()?.keeps_tables(&self.values)?;
        Ok(self.with(TABLES.0, TABLES.1)?)
    }

    /// The technique, if it makes tables.
    fn with_tables(&self) -> Result<&'static dyn Technique, Refusal> {
        match self.entry {
            Entry::Technique(technique) if has_tables(technique) => Ok(technique),
            _ => Err(Refusal::new(format!(
                "method \"{}\" makes no tables that outlive a frame; those that do are: {}",
                self.name(),
                Self::names_with_tables().join(", ")
            ))),
        }
    }

    /// The method with the settings whose tables take up to `bytes` and are likely to err least, and all
    /// choices that it is one of.
    ///
    /// # Errors
    ///
    /// If it makes no tables, or none so small; and as [`Method::run`].
    pub(crate) fn within_bytes(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        bytes: u64,
        context: &Context,
    ) -> Result<(Self, TableChoices), Error> {
        let technique = self.with_tables()?;
        self.entry.check_dispersion(scene)?;
        let choices = context
            .install(|| technique.within_bytes(scene, sensor, &self.values, bytes, context))?;
        let mut method = self.clone();
        for (key, text) in &choices.front[choices.chosen].settings {
            method = method.with(key, text)?;
        }
        Ok((method, choices))
    }

    /// Makes the tables that its settings ask for. Writes them for other programs if there is a folder for
    /// that.
    ///
    /// # Errors
    ///
    /// As [`Method::run`], and if a file for other programs cannot be written.
    pub(crate) fn make_tables(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        context: &Context,
        export: Option<&Path>,
    ) -> Result<Tables, TablesError> {
        let technique = self.with_tables().map_err(Error::from)?;
        self.entry.check_dispersion(scene).map_err(Error::from)?;
        self.check_memory(scene, sensor, context)
            .map_err(Error::from)?;
        let prepared =
            context.install(|| technique.prepare(scene, sensor, &self.values, context))?;
        let exported = match export {
            Some(folder) if !context.progress.is_stopped() => prepared.export(scene, folder)?,
            _ => Vec::new(),
        };
        Ok(Tables {
            report: prepared.tables(),
            exported,
        })
    }
}
