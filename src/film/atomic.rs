//! Files that are written whole or not at all.

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Why a file was not written. What stood at the path before still does.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The folder is not there.
    #[error("cannot write {}: folder {} does not exist", path.display(), folder.display())]
    NoFolder {
        /// The file that was to be.
        path: PathBuf,
        /// The folder it was to be in.
        folder: PathBuf,
    },
    /// The path names a folder, or nothing.
    #[error("cannot write {}: the path does not name a file", path.display())]
    NotAFile {
        /// The path given.
        path: PathBuf,
    },
    /// The system said no.
    #[error("cannot write {}: {cause}", path.display())]
    Io {
        /// The file that was to be.
        path: PathBuf,
        /// What the system said. Not a `source`: who prints those, too, would say it twice.
        cause: io::Error,
    },
}

/// Finds out whether [`write()`] could write a file of this path, by beginning to: for runs that take
/// an hour, and would have nowhere to leave their result. Nothing stays, and what stood at the path still does.
///
/// # Errors
///
/// Where the folder is missing or takes no file, or `path` is a folder.
pub fn check(path: &Path) -> Result<(), WriteError> {
    let (folder, name) = place(path)?;
    let found = temporary(folder, name).and_then(tempfile::NamedTempFile::close);
    found.map_err(|cause| WriteError::Io {
        path: path.to_owned(),
        cause,
    })
}

/// Writes a file by `fill`, so that `path` holds either all of it or what it held before.
///
/// `fill` writes to a temporary in the same folder (a rename does not cross file systems), which
/// is brought to the disk and then renamed. Where anything fails, the temporary is removed.
/// Missing folders are not made: a mistyped path should not look like success.
///
/// # Errors
///
/// Where the folder is missing, `path` is a folder, or `fill` or the system fails.
pub fn write(
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> Result<(), WriteError> {
    let (folder, name) = place(path)?;
    write_in(folder, name, path, fill).map_err(|cause| WriteError::Io {
        path: path.to_owned(),
        cause,
    })
}

/// A path's folder and name.
fn place(path: &Path) -> Result<(&Path, &OsStr), WriteError> {
    let Some(name) = path.file_name().filter(|_| !path.is_dir()) else {
        return Err(WriteError::NotAFile {
            path: path.to_owned(),
        });
    };
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    if !folder.is_dir() {
        return Err(WriteError::NoFolder {
            path: path.to_owned(),
            folder: folder.to_owned(),
        });
    }
    Ok((folder, name))
}

/// An ordinary file that goes when it is dropped.
fn temporary(folder: &Path, name: &OsStr) -> io::Result<tempfile::NamedTempFile> {
    let mut prefix = OsString::from(".");
    prefix.push(name);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".partial");
    // Temporaries are for their owner only; this one is to be an ordinary file.
    #[cfg(unix)]
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder.tempfile_in(folder)
}

fn write_in(
    folder: &Path,
    name: &OsStr,
    path: &Path,
    fill: impl FnOnce(&mut BufWriter<&File>) -> io::Result<()>,
) -> io::Result<()> {
    let temporary = temporary(folder, name)?;
    let mut writer = BufWriter::new(temporary.as_file());
    fill(&mut writer)?;
    writer.flush()?;
    drop(writer);
    temporary.as_file().sync_all()?;
    temporary.persist(path).map_err(|error| error.error)?;
    // The rename itself lies in the folder. Not all systems can sync a folder, and the file
    // stands whole by now: no reason to call it failed.
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}
