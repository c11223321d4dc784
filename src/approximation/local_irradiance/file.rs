//! Tables, and the borders of a form's shells, as the content of [chunks](super::chunk).
//!
//! A table's content is: what became of photons; numbers that were cut off; the table's kind, and trees if it
//! has them (eight bytes for 64 cells: a bit for each at which a leaf starts); the kind of numbers, the
//! size of a step, their count, and the numbers. All is little-endian. Lengths are checked against what the
//! settings ask for before anything is allocated.

use half::f16;

use super::cells::Cells;
use super::chunk::{AROUND, Key, Reader, is_fitted, opened, put_f64, put_u64, sealed};
use super::directions::Samples;
use super::layout::Layout;
use super::settings::Settings;
use super::shoot::Tally;
use super::storage::{Stored, bytes_each};
use super::table::{Form, Table};
use super::tree::{Trees, blocks};
use super::variants::{Normal, Space, Storage};

/// Bytes of a tally and of the count of numbers that were cut off.
const TALLY: u64 = 8 + 15 * 8 + 8;
/// Bytes that say the kind of a table; the form of trees; and kind, step and count of numbers.
const KIND: u64 = 1;
const TREES: u64 = 4 + 4 + 8 + 8;
const NUMBERS: u64 = 1 + 8 + 8;

/// The kinds of tables that outlive a frame.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Kind {
    Cells,
    Trees,
    Shells,
    Harmonics,
    Vectors,
}

impl Kind {
    const ALL: [Self; 5] = [
        Self::Cells,
        Self::Trees,
        Self::Shells,
        Self::Harmonics,
        Self::Vectors,
    ];
}

/// The kinds of numbers, in the order of their codes.
const STORAGES: [Storage; 5] = [
    Storage::U8,
    Storage::F16,
    Storage::F32,
    Storage::Exact,
    Storage::Rgb9e5,
];

/// A table that settings ask for: its kind, and how many numbers it has.
#[derive(Clone, Copy, Debug)]
pub struct Expected {
    kind: Kind,
    storage: Storage,
    step: f64,
    /// Numbers; of trees at most.
    most: u64,
    /// Children and levels of trees, and roots.
    trees: Option<([u32; 2], usize)>,
    /// Photons of all samples, of which harmonics of the light's direction are made.
    photons: u64,
}

impl Expected {
    /// The table of a sample in a layout, or of harmonics of the light's direction in its cells.
    pub fn new(settings: &Settings, layout: &Layout) -> Self {
        let cells = layout.count() as u64;
        let coefficients = u64::from(settings.order).pow(2);
        let mut trees = None;
        let (kind, most) = match (settings.space, &layout.cells) {
            (Space::MultiResolution, Some(_)) => {
                trees = layout.trees();
                (Kind::Trees, trees.map_or(0, most_leaves))
            }
            (Space::ShellHarmonics, Some(Cells::Shells(shells))) => {
                (Kind::Shells, shells.layers() as u64 * coefficients)
            }
            _ if is_fitted(settings) => (Kind::Harmonics, cells * coefficients),
            _ if settings.normal == Normal::Vector => (Kind::Vectors, 3 * cells),
            _ => (Kind::Cells, cells),
        };
        Self {
            kind,
            storage: settings.storage,
            step: if settings.storage == Storage::U8 {
                settings.range / 255.0
            } else {
                0.0
            },
            most,
            trees,
            photons: settings
                .photons
                .saturating_mul(u64::from(Samples::count(settings))),
        }
    }

    /// The most bytes of a file.
    pub fn most_bytes(&self) -> u64 {
        let trees = self
            .trees
            .map_or(0, |(form, roots)| TREES + 8 * blocks(form, roots) as u64);
        let numbers = self.most.saturating_mul(bytes_each(self.storage));
        AROUND + TALLY + KIND + trees + NUMBERS + numbers
    }
}

/// Leaves of trees that merge nothing.
fn most_leaves(([branches, levels], roots): ([u32; 2], usize)) -> u64 {
    u64::from(branches).pow(levels).saturating_mul(roots as u64)
}

/// The bytes of a table's file.
pub fn table_bytes(key: &Key, table: &Table) -> Vec<u8> {
    let mut content = Vec::with_capacity(table.bytes() as usize + 1024);
    let tally = &table.tally;
    put_u64(&mut content, tally.photons);
    for sum in [
        tally.set_out,
        tally.missed,
        tally.absorbed,
        tally.cut_off,
        tally.left,
    ] {
        for x in sum {
            put_f64(&mut content, x);
        }
    }
    put_u64(&mut content, table.saturated);
    match &table.form {
        Form::Cells(stored) => put_numbers(&mut content, Kind::Cells, stored),
        Form::Vectors(stored) => put_numbers(&mut content, Kind::Vectors, stored),
        Form::Shells(stored) => put_numbers(&mut content, Kind::Shells, stored),
        Form::Harmonics(stored) => put_numbers(&mut content, Kind::Harmonics, stored),
        Form::Trees { trees, leaves } => {
            content.push(Kind::Trees as u8);
            content.extend(trees.form().iter().flat_map(|number| number.to_le_bytes()));
            put_u64(&mut content, trees.roots() as u64);
            put_u64(&mut content, trees.starts().len() as u64);
            content.extend(trees.starts().flatten().flat_map(u32::to_le_bytes));
            put_stored(&mut content, leaves);
        }
        // Tables of a frame alone have no files.
        Form::Reads(..) | Form::ReadShells(_) => {}
    }
    sealed(key, &content)
}

fn put_numbers(into: &mut Vec<u8>, kind: Kind, stored: &Stored) {
    into.push(kind as u8);
    put_stored(into, stored);
}

fn put_stored(into: &mut Vec<u8>, stored: &Stored) {
    let (code, step) = match stored {
        Stored::U8 { step, .. } => (0, *step),
        Stored::F16(_) => (1, 0.0),
        Stored::F32(_) => (2, 0.0),
        Stored::F64(_) => (3, 0.0),
        Stored::Rgb9e5(_) => (4, 0.0),
    };
    into.push(code);
    put_f64(into, step);
    put_u64(into, stored.count() as u64);
    raw_numbers(stored, into);
}

/// The numbers as they are kept, little-endian, without anything before them.
pub fn raw_numbers(stored: &Stored, into: &mut Vec<u8>) {
    match stored {
        Stored::U8 { steps, .. } => into.extend(steps.as_flattened()),
        Stored::Rgb9e5(words) => into.extend(words.iter().flat_map(|word| word.to_le_bytes())),
        Stored::F16(all) => into.extend(all.as_flattened().iter().flat_map(|x| x.to_le_bytes())),
        Stored::F32(all) => into.extend(all.as_flattened().iter().flat_map(|x| x.to_le_bytes())),
        Stored::F64(all) => into.extend(all.as_flattened().iter().flat_map(|x| x.to_le_bytes())),
    }
}

/// The table in a file's bytes.
///
/// # Errors
///
/// The reason for which they are not those of the table that was asked for.
pub fn table_of(bytes: &[u8], key: &Key, expected: &Expected) -> Result<Table, String> {
    let mut reader = Reader(opened(bytes, key)?);
    let table = reader.table(expected)?;
    reader.end()?;
    Ok(table)
}

/// The bytes of the file of shells' borders \[m\].
pub fn radii_bytes(key: &Key, radii: &[f64]) -> Vec<u8> {
    let mut content = Vec::new();
    put_u64(&mut content, radii.len() as u64);
    for x in radii {
        put_f64(&mut content, *x);
    }
    sealed(key, &content)
}

/// The most bytes of the file of so many shells' borders.
pub fn most_radii_bytes(shells: u32) -> u64 {
    AROUND + 8 + 8 * (u64::from(shells) + 1)
}

/// The borders of shells \[m\] in a file's bytes, up to that of a region.
///
/// # Errors
///
/// The reason for which they are not those that were asked for.
pub fn radii_of(bytes: &[u8], key: &Key, shells: u32, region: f64) -> Result<Vec<f64>, String> {
    let mut reader = Reader(opened(bytes, key)?);
    let count = reader.u64()?;
    if count != u64::from(shells) + 1 {
        return Err(format!("it has {count} borders of {shells} shells"));
    }
    let radii = (0..count)
        .map(|_| reader.f64())
        .collect::<Result<Vec<f64>, _>>()?;
    reader.end()?;
    let grow = radii.windows(2).all(|pair| pair[0] < pair[1]);
    if !grow || radii[0] != 0.0 || radii[radii.len() - 1] != region {
        return Err("its borders do not grow from 0 to the region's radius".to_owned());
    }
    Ok(radii)
}

impl Reader<'_> {
    fn triple(&mut self) -> Result<[f64; 3], String> {
        Ok([self.f64()?, self.f64()?, self.f64()?])
    }

    fn table(&mut self, expected: &Expected) -> Result<Table, String> {
        let tally = Tally {
            photons: self.u64()?,
            set_out: self.triple()?,
            missed: self.triple()?,
            absorbed: self.triple()?,
            cut_off: self.triple()?,
            left: self.triple()?,
        };
        let saturated = self.u64()?;
        if !tally.is_finite() || tally.photons > expected.photons || saturated > expected.most {
            return Err("its photons, or their flux, cannot be".to_owned());
        }
        let kind = Kind::ALL.get(usize::from(self.u8()?));
        if kind != Some(&expected.kind) {
            return Err("it is of another kind of table".to_owned());
        }
        let form = match expected.kind {
            Kind::Cells => Form::Cells(self.stored(expected, expected.most)?),
            Kind::Vectors => Form::Vectors(self.stored(expected, expected.most)?),
            Kind::Shells => Form::Shells(self.stored(expected, expected.most)?),
            Kind::Harmonics => Form::Harmonics(self.stored(expected, expected.most)?),
            Kind::Trees => {
                let (trees, leaves) = self.trees(expected)?;
                let leaves = self.stored(expected, leaves)?;
                Form::Trees { trees, leaves }
            }
        };
        Ok(Table {
            tally,
            saturated,
            form,
        })
    }

    /// Trees, and the number of their leaves.
    fn trees(&mut self, expected: &Expected) -> Result<(Trees, u64), String> {
        let form = [self.u32()?, self.u32()?];
        let (roots, count) = (self.u64()?, self.u64()?);
        let wanted = expected.trees.filter(|(wanted, number)| {
            *wanted == form && *number as u64 == roots && blocks(form, *number) as u64 == count
        });
        let Some((form, roots)) = wanted else {
            return Err(format!(
                "it has {roots} trees of {} levels and {count} blocks, which is not what its settings ask for",
                form[1]
            ));
        };
        // As many as the settings ask for: the number does not come from the file.
        let words = pairs_of_words(self.take(8 * blocks(form, roots))?);
        Trees::of_starts(form, roots, words)
            .ok_or_else(|| "its trees do not hang together".to_owned())
    }

    fn stored(&mut self, expected: &Expected, wanted: u64) -> Result<Stored, String> {
        let storage = STORAGES.get(usize::from(self.u8()?));
        let step = self.f64()?;
        if storage != Some(&expected.storage) || step.to_bits() != expected.step.to_bits() {
            return Err("its numbers are stored in another way".to_owned());
        }
        let count = self.u64()?;
        if count != wanted {
            return Err(format!("it has {count} numbers, and should have {wanted}"));
        }
        // `wanted` is that of the layout: it does not come from the file.
        let each = bytes_each(expected.storage) as usize;
        let bytes = self.take(count as usize * each)?;
        let stored = match expected.storage {
            Storage::U8 => Stored::U8 {
                steps: triples(bytes, |[x]| x),
                step,
            },
            Storage::Rgb9e5 => {
                let words = bytes.chunks_exact(4);
                Stored::Rgb9e5(
                    words
                        .map(|word| word.iter().rev().copied().fold(0, shifted))
                        .collect(),
                )
            }
            Storage::F16 => Stored::F16(triples(bytes, f16::from_le_bytes)),
            Storage::F32 => Stored::F32(triples(bytes, f32::from_le_bytes)),
            Storage::Exact => Stored::F64(triples(bytes, f64::from_le_bytes)),
        };
        if !stored.is_finite() {
            return Err("its numbers are not all finite".to_owned());
        }
        Ok(stored)
    }
}

/// A number with one more byte as its lowest.
fn shifted(number: u32, byte: u8) -> u32 {
    number << 8 | u32::from(byte)
}

/// Bytes as pairs of numbers.
fn pairs_of_words(bytes: &[u8]) -> impl ExactSizeIterator<Item = [u32; 2]> + '_ {
    bytes.chunks_exact(8).map(|pair| {
        let word = |bytes: &[u8]| bytes.iter().rev().copied().fold(0, shifted);
        [word(&pair[..4]), word(&pair[4..])]
    })
}

/// Bytes as triples of numbers of N bytes each.
fn triples<const N: usize, T>(bytes: &[u8], number: impl Fn([u8; N]) -> T) -> Vec<[T; 3]> {
    let at = |triple: &[u8], k: usize| {
        let mut array = [0; N];
        array.copy_from_slice(&triple[k * N..(k + 1) * N]);
        number(array)
    };
    bytes
        .chunks_exact(3 * N)
        .map(|triple| std::array::from_fn(|k| at(triple, k)))
        .collect()
}
