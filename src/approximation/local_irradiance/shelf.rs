//! The folder of tables that outlive a run, and what is odd about it.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::chunk::{self, Content, Key};
use super::demands::are_kept;
use super::file::{self, Expected};
use super::settings::Settings;
use super::table::Table;
use crate::film::atomic;
use crate::run::Context;

/// The most files that are named one by one.
const NAMED: usize = 8;

/// A folder of tables: one folder a form, one file a light sample. Without a folder nothing is kept.
#[derive(Debug, Default)]
pub struct Shelf {
    folder: Option<PathBuf>,
    /// Files that cannot be used, each with the reason.
    spoiled: Vec<String>,
    /// The first file that could not be written, with the reason; and how many there were.
    unwritten: Option<(String, u64)>,
}

impl Shelf {
    /// The folder that a context has for tables; none if tables are of one frame.
    pub fn new(settings: &Settings, context: &Context) -> Self {
        let cache = context.cache.as_ref().filter(|_| are_kept(settings));
        Self {
            folder: cache.map(|cache| cache.join("local-irradiance")),
            ..Self::default()
        }
    }

    /// The table of a sample, if it has a file.
    pub fn table(&mut self, key: &Key, expected: &Expected) -> Option<Table> {
        self.read(key, expected.most_bytes(), |bytes| {
            file::table_of(bytes, key, expected)
        })
    }

    /// Writes the table of a sample.
    pub fn keep(&mut self, key: &Key, table: &Table) {
        self.write(key, || file::table_bytes(key, table));
    }

    /// The borders \[m\] of a form's shells up to that of the region, if they have a file.
    pub fn radii(&mut self, form: &Arc<str>, shells: u32, region: f64) -> Option<Vec<f64>> {
        let key = Key::new(form, Content::Shells);
        let most = file::most_radii_bytes(shells);
        self.read(&key, most, |bytes| {
            file::radii_of(bytes, &key, shells, region)
        })
    }

    /// Writes the borders \[m\] of a form's shells.
    pub fn keep_radii(&mut self, form: &Arc<str>, radii: &[f64]) {
        let key = Key::new(form, Content::Shells);
        self.write(&key, || file::radii_bytes(&key, radii));
    }

    /// Files that could not be written since the last warnings.
    pub fn unwritten(&self) -> u64 {
        self.unwritten.as_ref().map_or(0, |(_, count)| *count)
    }

    /// Oddities since the last call.
    pub fn warnings(&mut self) -> Vec<String> {
        let mut warnings = std::mem::take(&mut self.spoiled);
        let more = warnings.len().saturating_sub(NAMED);
        if more > 0 {
            warnings.truncate(NAMED);
            warnings.push(format!("{more} more table files were made anew"));
        }
        if let Some((why, count)) = self.unwritten.take() {
            let files = if count == 1 { "file is" } else { "files are" };
            warnings.push(format!(
                "{why}: {count} table {files} not written, and the run goes on in memory"
            ));
        }
        warnings
    }

    fn path(folder: &Path, key: &Key) -> PathBuf {
        folder
            .join(&*key.form)
            .join(format!("{}.table", key.content.name()))
    }

    fn read<T>(
        &mut self,
        key: &Key,
        most: u64,
        content: impl FnOnce(&[u8]) -> Result<T, String>,
    ) -> Option<T> {
        let path = Self::path(self.folder.as_ref()?, key);
        let found = match chunk::bytes_of(&path, most) {
            Ok(None) => return None,
            Ok(Some(bytes)) => content(&bytes),
            Err(why) => Err(why),
        };
        let spoiled = |why| {
            self.spoiled
                .push(format!("{}: {why}; it is made anew", path.display()));
        };
        found.map_err(spoiled).ok()
    }

    fn write(&mut self, key: &Key, bytes: impl FnOnce() -> Vec<u8>) {
        let Some(folder) = &self.folder else {
            return;
        };
        let path = Self::path(folder, key);
        let made = path.parent().map_or(Ok(()), fs::create_dir_all);
        let written = match made {
            Err(error) => Err(format!(
                "cannot make the folder of {}: {error}",
                path.display()
            )),
            Ok(()) => atomic::write(&path, |file| std::io::Write::write_all(file, &bytes()))
                .map_err(|error| error.to_string()),
        };
        if let Err(why) = written {
            self.unwritten.get_or_insert((why, 0)).1 += 1;
        }
    }
}
