//! Files that are written whole or not at all.

use std::ffi::{OsStr, OsString};
use std::fs::File;
use std::io::{self, BufWriter, Write};
use std::path::{Path, PathBuf};

/// Reason why a file was not written. The former content of the path is still there.
#[derive(Debug, thiserror::Error)]
pub enum WriteError {
    /// The folder does not exist.
    #[error("cannot write {}: folder {} does not exist", path.display(), folder.display())]
    NoFolder {
        /// The file that was to be written.
        path: PathBuf,
        /// The folder for it.
        folder: PathBuf,
    },
    /// The path names a folder, or nothing.
    #[error("cannot write {}: the path does not name a file", path.display())]
    NotAFile {
        /// The path given.
        path: PathBuf,
    },
    /// The system refused.
    #[error("cannot write {}: {cause}", path.display())]
    Io {
        /// The file that was to be written.
        path: PathBuf,
        /// The system's error. Not a `source`: callers that also print those would say it twice.
        cause: io::Error,
    },
}

/// Checks that [`write()`] could write a file of this path, by beginning to: for runs that take an hour, and
/// would have no place for their result. No file stays, and the former content of the path is kept.
///
/// # Errors
///
/// If the folder is missing or takes no file, or `path` is a folder.
pub fn check(path: &Path) -> Result<(), WriteError> {
    let (folder, name) = place(path)?;
    let found = temporary(folder, name).and_then(tempfile::NamedTempFile::close);
    found.map_err(|cause| WriteError::Io {
        path: path.to_owned(),
        cause,
    })
}

/// Writes a file by `fill`, so that `path` holds either all of it or its former content.
///
/// `fill` writes to a temporary file in the same folder (a rename does not cross file systems), which is
/// synced to disk and then renamed. If anything fails, the temporary file is removed. Missing folders are not
/// made: a mistyped path should not look like success.
///
/// # Errors
///
/// If the folder is missing, `path` is a folder, or `fill` or the system fails.
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

/// An ordinary file that is removed when it is dropped.
fn temporary(folder: &Path, name: &OsStr) -> io::Result<tempfile::NamedTempFile> {
    let mut prefix = OsString::from(".");
    prefix.push(name);
    let mut builder = tempfile::Builder::new();
    builder.prefix(&prefix).suffix(".partial");
    // Temporary files are for their owner only; this one is to be an ordinary file.
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
    // The rename itself is recorded in the folder. Not all systems can sync a folder, and the file is
    // complete by now: no reason to call it failed.
    let _ = File::open(folder).and_then(|folder| folder.sync_all());
    Ok(())
}
