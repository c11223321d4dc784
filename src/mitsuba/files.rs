//! The files of a scene: finding, reading once, hashing.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// The folders that are searched for relative names, the files read, and the hash over all of them.
pub struct Files {
    /// Searched from the last to the first.
    folders: Vec<PathBuf>,
    /// Files that are in memory rather than on the disk.
    held: HashMap<PathBuf, Arc<[u8]>>,
    read: HashMap<PathBuf, Arc<[u8]>>,
    hasher: blake3::Hasher,
}

impl Files {
    /// No file read yet; `parameters` are part of the hash.
    pub fn new(parameters: &[(String, String)]) -> Self {
        let mut files = Self {
            folders: Vec::new(),
            held: HashMap::new(),
            read: HashMap::new(),
            hasher: blake3::Hasher::new(),
        };
        files.hash_block(&(parameters.len() as u64).to_le_bytes());
        for (name, value) in parameters {
            files.hash_block(name.as_bytes());
            files.hash_block(value.as_bytes());
        }
        files
    }

    /// The length goes in first, so that moving a border between two blocks changes the hash.
    fn hash_block(&mut self, bytes: &[u8]) {
        self.hasher.update(&(bytes.len() as u64).to_le_bytes());
        self.hasher.update(bytes);
    }

    /// Gives a path contents that win over what the disk has there. They are hashed like any file's.
    pub fn hold(&mut self, path: PathBuf, contents: &[u8]) {
        self.held.insert(path, contents.into());
    }

    /// True of a plain file, in memory or on the disk.
    pub fn is_file(&self, path: &Path) -> bool {
        self.held.contains_key(path) || path.is_file()
    }

    /// Makes `folder` the first to be searched.
    pub fn search_first(&mut self, folder: PathBuf) {
        self.folders.push(folder);
    }

    /// Number of folders searched, to return to with [`Self::forget_folders`].
    pub fn folder_count(&self) -> usize {
        self.folders.len()
    }

    /// Forgets all folders but the first `count` given.
    pub fn forget_folders(&mut self, count: usize) {
        self.folders.truncate(count);
    }

    /// The path of the file that `name` means: the first that exists in the folders searched.
    ///
    /// If none exists, it is the name in the folder searched first, for the error message.
    pub fn resolve(&self, name: &str) -> PathBuf {
        let name = Path::new(name);
        let mut candidates = self.folders.iter().rev().map(|folder| folder.join(name));
        let nearest = self
            .folders
            .last()
            .map_or_else(|| name.to_owned(), |folder| folder.join(name));
        candidates
            .find(|path| self.held.contains_key(path) || path.exists())
            .unwrap_or(nearest)
    }

    /// The contents of the file at `path`; read and hashed at the first call.
    ///
    /// Files named in the first file must be plain files: others (devices, pipes) may never end. The first,
    /// which the caller names, may be a pipe.
    ///
    /// # Errors
    ///
    /// If it cannot be read: a phrase that says why, without the path.
    pub fn read(&mut self, path: &Path) -> Result<Arc<[u8]>, String> {
        if let Some(bytes) = self.read.get(path) {
            return Ok(Arc::clone(bytes));
        }
        if let Some(bytes) = self.held.get(path).map(Arc::clone) {
            self.hash_block(&bytes);
            self.read.insert(path.to_owned(), Arc::clone(&bytes));
            return Ok(bytes);
        }
        let is_special = std::fs::metadata(path).is_ok_and(|it| !it.is_file() && !it.is_dir());
        if is_special && !self.read.is_empty() {
            return Err("cannot be read: it is a device or a pipe, not a file".to_owned());
        }
        let bytes: Arc<[u8]> = std::fs::read(path)
            .map_err(|error| format!("cannot be read: {error}"))?
            .into();
        self.hash_block(&bytes);
        self.read.insert(path.to_owned(), Arc::clone(&bytes));
        Ok(bytes)
    }

    /// As [`Self::read`], for a file that an element names: the error names the path.
    ///
    /// # Errors
    ///
    /// As [`Self::read`].
    pub fn read_named(&mut self, path: &Path) -> Result<Arc<[u8]>, String> {
        self.read(path)
            .map_err(|why| format!("{} {why}", path.display()))
    }

    /// The paths of all files read.
    pub fn paths(&self) -> Vec<PathBuf> {
        let mut paths: Vec<PathBuf> = self.read.keys().cloned().collect();
        paths.sort();
        paths
    }

    /// BLAKE3 hash, in hex digits, over the parameters and the contents of all files read, in order of first
    /// use.
    pub fn content_hash(&self) -> String {
        self.hasher.finalize().to_hex().to_string()
    }
}

/// Number of lines that end in a piece of text.
#[allow(clippy::naive_bytecount)] // The pieces are short, or read once for a message.
pub fn line_ends(text: &[u8]) -> usize {
    text.iter().filter(|byte| **byte == b'\n').count()
}
