//! Checksummed chunks, one a file: what is kept of a form, with all that says whether it is what was asked
//! for.
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `nephtab`, and a line's end |
//! | 4 | version of this format |
//! | 32 | hash of the program's source: another source may make other tables |
//! | 32 | hash of the form: the object with all settings that tables depend on |
//! | 8 | number of the sample; of harmonics and of shells the two largest numbers |
//! | 8 | bytes of the content |
//! | | content |
//! | 32 | BLAKE3 hash of all before |
//!
//! All is little-endian. Lengths are checked before anything is allocated.

use std::fs::File;
use std::io::Read as _;
use std::path::Path;
use std::sync::Arc;

use super::directions::Samples;
use super::settings::Settings;
use super::variants::{Directions, Space};

const MAGIC: [u8; 8] = *b"nephtab\n";
const VERSION: u32 = 2;
/// Bytes before the content.
const HEADER: usize = 8 + 4 + 32 + 32 + 8 + 8;
const HASH: usize = 32;
/// Bytes of a chunk beside its content.
pub const AROUND: u64 = (HEADER + HASH) as u64;

/// What is kept of a form.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Content {
    /// The table of a light sample.
    Sample(usize),
    /// The table of harmonics of the light's direction.
    Harmonics,
    /// The borders of shells.
    Shells,
}

impl Content {
    /// All tables that settings ask for.
    pub fn tables(settings: &Settings, samples: &Samples) -> Vec<Self> {
        if is_fitted(settings) {
            vec![Self::Harmonics]
        } else {
            (0..samples.all().len()).map(Self::Sample).collect()
        }
    }

    /// Its name: a sample has its number.
    pub fn name(self) -> String {
        match self {
            Self::Sample(sample) => sample.to_string(),
            Self::Harmonics => "harmonics".to_owned(),
            Self::Shells => "shells".to_owned(),
        }
    }

    fn number(self) -> u64 {
        match self {
            Self::Sample(sample) => sample as u64,
            Self::Harmonics => u64::MAX,
            Self::Shells => u64::MAX - 1,
        }
    }
}

/// True if an object has one table for all light directions: harmonics of these in each cell.
pub fn is_fitted(settings: &Settings) -> bool {
    let is_cellwise = matches!(settings.space, Space::Grid | Space::Shells);
    settings.directions == Directions::Harmonics && is_cellwise
}

/// A form, and what is kept of it.
#[derive(Clone, Debug, PartialEq, Eq, Hash)]
pub struct Key {
    /// The form's hash in hex.
    pub form: Arc<str>,
    /// What is kept of it.
    pub content: Content,
}

impl Key {
    /// A form's content.
    pub fn new(form: &Arc<str>, content: Content) -> Self {
        Self {
            form: Arc::clone(form),
            content,
        }
    }
}

/// The bytes of a file, if there is one.
///
/// # Errors
///
/// If it has more bytes than `most`, or cannot be read.
pub(super) fn bytes_of(path: &Path, most: u64) -> Result<Option<Vec<u8>>, String> {
    let file = match File::open(path) {
        Ok(file) => file,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(None),
        Err(error) => return Err(error.to_string()),
    };
    let length = file.metadata().map_err(|error| error.to_string())?.len();
    if length > most {
        return Err(format!(
            "it has {length} bytes, and a table of these settings at most {most}"
        ));
    }
    let mut bytes = Vec::with_capacity(length as usize);
    file.take(most)
        .read_to_end(&mut bytes)
        .map_err(|error| error.to_string())?;
    Ok(Some(bytes))
}

/// Adds a number.
pub(super) fn put_u64(into: &mut Vec<u8>, x: u64) {
    into.extend(x.to_le_bytes());
}

/// Adds a number.
pub(super) fn put_f64(into: &mut Vec<u8>, x: f64) {
    into.extend(x.to_le_bytes());
}

/// The hash of the program's source, as a file has it.
fn source() -> [u8; 32] {
    *blake3::hash(env!("NEPHROID_SOURCE_HASH").as_bytes()).as_bytes()
}

/// The hash of a form, as a file has it.
fn form_bytes(form: &str) -> [u8; 32] {
    *blake3::hash(form.as_bytes()).as_bytes()
}

/// Content with its header and its checksum.
pub fn sealed(key: &Key, content: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER + content.len() + HASH);
    bytes.extend(MAGIC);
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(source());
    bytes.extend(form_bytes(&key.form));
    put_u64(&mut bytes, key.content.number());
    put_u64(&mut bytes, content.len() as u64);
    bytes.extend(content);
    let hash = blake3::hash(&bytes);
    bytes.extend(hash.as_bytes());
    bytes
}

/// The content of a file's bytes, after its header and checksum were checked.
pub(super) fn opened<'a>(bytes: &'a [u8], key: &Key) -> Result<&'a [u8], String> {
    let mut reader = Reader(bytes);
    if reader.take(8)? != MAGIC {
        return Err("it is no table".to_owned());
    }
    let version = reader.u32()?;
    if version != VERSION {
        return Err(format!(
            "its format is version {version}, and this program's {VERSION}"
        ));
    }
    if reader.take(32)? != source() {
        return Err("another version of the program made it".to_owned());
    }
    if reader.take(32)? != form_bytes(&key.form) {
        return Err("it belongs to another object or other settings".to_owned());
    }
    let number = reader.u64()?;
    if number != key.content.number() {
        return Err(format!(
            "it has sample {number}, not {}",
            key.content.name()
        ));
    }
    let length = reader.u64()?;
    let there = reader.0.len() as u64;
    if length.checked_add(HASH as u64) != Some(there) {
        return Err(format!(
            "it is cut off or too long: {length} bytes and a checksum should follow its header, and {there} \
             bytes do"
        ));
    }
    let (all, hash) = bytes.split_at(bytes.len() - HASH);
    if blake3::hash(all).as_bytes() != hash {
        return Err("its checksum is not that of its bytes".to_owned());
    }
    Ok(&all[HEADER..])
}

/// Bytes that are still to be read.
pub(super) struct Reader<'a>(pub(super) &'a [u8]);

impl<'a> Reader<'a> {
    /// The next bytes.
    ///
    /// # Errors
    ///
    /// If there are fewer; this goes for all that reads.
    pub(super) fn take(&mut self, count: usize) -> Result<&'a [u8], String> {
        let Some((taken, rest)) = self.0.split_at_checked(count) else {
            return Err("it is cut off".to_owned());
        };
        self.0 = rest;
        Ok(taken)
    }

    fn array<const N: usize>(&mut self) -> Result<[u8; N], String> {
        let mut array = [0; N];
        array.copy_from_slice(self.take(N)?);
        Ok(array)
    }

    /// The next byte.
    pub(super) fn u8(&mut self) -> Result<u8, String> {
        Ok(self.array::<1>()?[0])
    }

    /// The next number.
    pub(super) fn u32(&mut self) -> Result<u32, String> {
        Ok(u32::from_le_bytes(self.array()?))
    }

    /// The next number.
    pub(super) fn u64(&mut self) -> Result<u64, String> {
        Ok(u64::from_le_bytes(self.array()?))
    }

    /// The next number.
    pub(super) fn f64(&mut self) -> Result<f64, String> {
        Ok(f64::from_le_bytes(self.array()?))
    }

    /// Refuses bytes that are left over.
    ///
    /// # Errors
    ///
    /// If there are some.
    pub(super) fn end(&self) -> Result<(), String> {
        if self.0.is_empty() {
            Ok(())
        } else {
            Err(format!("it has {} bytes too many", self.0.len()))
        }
    }
}
