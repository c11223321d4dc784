//! Honest files of every kind, and the heap that reading them takes.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use flate2::Compression;
use nephroid::internals::film::{Channel, Image, exr};
use tempfile::TempDir;

use super::watch::{Outcome, folder_with, load, watched};
use crate::support;
use crate::support::geometry::icosphere;
use crate::support::mutation::{PACKINGS, film, obj, ply, serialized, serialized_contents};

/// A kind of file that holds a mesh or an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    Obj,
    AsciiPly,
    BinaryPly,
    Serialized,
    /// As a scene's texture.
    Exr,
    /// As a film, with its channels and metadata: what `compare` and studies read.
    Film,
}

pub const KINDS: [Kind; 6] = [
    Kind::Obj,
    Kind::AsciiPly,
    Kind::BinaryPly,
    Kind::Serialized,
    Kind::Exr,
    Kind::Film,
];

impl Kind {
    /// A well-formed file: a ball of `20 · 4^size` faces, or an image of as many texels.
    pub fn honest(self, size: u32) -> Vec<u8> {
        let ball = || icosphere(size);
        match self {
            Self::Obj => obj(&ball()),
            Self::AsciiPly => ply(&ball(), "ascii"),
            Self::BinaryPly => ply(&ball(), "binary_little_endian"),
            Self::Serialized => serialized(&serialized_contents(&ball()), Compression::none()),
            Self::Exr | Self::Film => noise(20 << size, 1 << size),
        }
    }

    /// Elements of a scene that names the file `it`.
    ///
    /// # Panics
    ///
    /// For films, which scenes do not name.
    pub fn elements(self) -> &'static str {
        match self {
            Self::Film => unreachable!("no scene names a film"),
            Self::Obj => r#"<shape type="obj"><string name="filename" value="it"/></shape>"#,
            Self::AsciiPly | Self::BinaryPly => {
                r#"<shape type="ply"><string name="filename" value="it"/></shape>"#
            }
            Self::Serialized => {
                r#"<shape type="serialized"><string name="filename" value="it"/></shape>"#
            }
            Self::Exr => {
                r#"<shape type="sphere"><bsdf type="diffuse"><texture type="bitmap" name="reflectance"><string name="filename" value="it"/></texture></bsdf></shape>"#
            }
        }
    }

    pub fn load(self, bytes: &[u8]) -> Outcome<()> {
        if self == Self::Film {
            let folder = TempDir::new().unwrap();
            let file = folder.path().join("it");
            std::fs::write(&file, bytes).unwrap();
            return watched("a film", move || {
                exr::read(&file)
                    .map(drop)
                    .map_err(|error| error.to_string())
            });
        }
        let (folder, file) = folder_with(self.elements());
        std::fs::write(folder.path().join("it"), bytes).unwrap();
        let outcome = load(&file);
        Outcome {
            result: outcome.result.map(drop),
            seconds: outcome.seconds,
            peak: outcome.peak,
        }
    }

    /// Heap that an honest file of the length of this one, and packed as it is, may take.
    pub fn need(self, file: &[u8]) -> Need {
        /// By kind and packing.
        static MEASURED: Mutex<BTreeMap<(usize, usize), Need>> = Mutex::new(BTreeMap::new());
        let is_image = matches!(self, Self::Exr | Self::Film);
        let packing = if is_image { packing_of(file) } else { 0 };
        let mut measured = MEASURED.lock().unwrap_or_else(PoisonError::into_inner);
        let need = measured.entry((self as usize, packing)).or_insert_with(|| {
            let mut pairs = vec![[self.honest(0), self.honest(3)]];
            let mut black_pairs = Vec::new();
            if is_image {
                let packing = PACKINGS[packing];
                let sizes = [(20, 1), (160, 8)];
                pairs.push(sizes.map(|(width, height)| film(width, height, packing, false)));
                // The longer the lines, the less of a file is headers of blocks.
                let sizes = [(20, 1), (20_000, 32)];
                black_pairs.push(sizes.map(|(width, height)| film(width, height, packing, true)));
            }
            let mut least = 0.0_f64;
            let mut a_byte = |pairs: &[[Vec<u8>; 2]]| {
                let slopes = pairs.iter().map(|files| {
                    let peaks = files.each_ref().map(|file| {
                        honest_peak(|| {
                            let outcome = self.load(file);
                            let why = outcome.result.err();
                            assert!(why.is_none(), "{self:?}: {why:?}");
                            outcome.peak
                        })
                    });
                    least = least.max(peaks[0]);
                    (peaks[1] - peaks[0]) / (files[1].len() - files[0].len()) as f64
                });
                slopes.fold(0.0, f64::max)
            };
            let (a_byte, a_black_byte) = (a_byte(&pairs), a_byte(&black_pairs));
            let name = if is_image {
                format!("{self:?} by {:?}", PACKINGS[packing])
            } else {
                format!("{self:?}")
            };
            println!(
                "{name}: {least} bytes of heap, and {a_byte:.1} for a byte; {a_black_byte:.0} where all is black"
            );
            Need {
                least,
                a_byte,
                a_black_byte,
            }
        });
        *need
    }
}

/// The heap \[bytes\] that reading something honest takes at most, of three times: what other threads (the
/// pool's) give back late is taken off what one of them seems to take. A first one, which pays for what is
/// made once, does not count.
pub fn honest_peak(read: impl Fn() -> usize) -> f64 {
    read();
    (0..3).map(|_| read()).max().unwrap_or(0) as f64
}

/// The heap \[bytes\] that an honest file takes.
#[derive(Clone, Copy, Debug)]
pub struct Need {
    /// The smallest file.
    least: f64,
    /// Heap for each byte more.
    a_byte: f64,
    /// The same of an image that is all black, which packs best; 0 for what is no image.
    a_black_byte: f64,
}

impl Need {
    /// Most heap of a file of this length.
    pub fn peak(self, length: usize) -> f64 {
        self.least + self.a_byte * length as f64
    }

    /// The same whatever is in it: as little in so much room as can be packed so.
    pub fn peak_of_any(self, length: usize) -> f64 {
        self.least + self.a_byte.max(self.a_black_byte) * length as f64
    }
}

/// Packing of an image, by its place in [`PACKINGS`], which is its number in the file. 0 where it cannot
/// be read.
fn packing_of(bytes: &[u8]) -> usize {
    let at = after(bytes, b"compression\0compression\0").map(|at| at + 4);
    let number = at.and_then(|at| bytes.get(at)).copied();
    number
        .map(usize::from)
        .filter(|&number| number < PACKINGS.len())
        .unwrap_or(0)
}

/// Place where some text of a file ends.
pub fn after(bytes: &[u8], text: &[u8]) -> Option<usize> {
    let start = bytes
        .windows(text.len())
        .position(|window| window == text)?;
    Some(start + text.len())
}

/// An image that does not compress.
pub fn noise(width: usize, height: usize) -> Vec<u8> {
    let mut random = support::geometry::Random(3);
    let mut image = Image::new(width, height);
    for name in ["R", "G", "B"] {
        let samples = (0..width * height).map(|_| random.unit() as f32).collect();
        image.channels.push(Channel {
            name: name.to_owned(),
            samples,
        });
    }
    written(&image)
}

pub fn written(image: &Image) -> Vec<u8> {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("it.exr");
    exr::write(&file, image).unwrap();
    std::fs::read(&file).unwrap()
}
