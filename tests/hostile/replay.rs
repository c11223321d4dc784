//! Inputs that fuzzing found, and changes of them: none makes a reader panic or abort.
//!
//! `corpus/TARGET` has the inputs of a target of `fuzz/` in one file, minimised: they reach all that any
//! input reached. Each is preceded by its length in 32 bits, little-endian. `corpus/crashes/` has inputs that
//! brought a reader down once, under names that begin with their target's.

use std::path::{Path, PathBuf};

use super::watch::{alone, watched};
use crate::entries::{TARGETS, enter};

/// Changed inputs of each target: some seconds of all.
const CHANGED: u64 = 2000;

/// The most heap \[bytes\] that any reader may take for a byte of its file: pictures, whose decoders may take
/// 4096 bytes, a texel each, of which reading makes 24 more (12 of the texel in `f32`, twice).
const MOST_A_BYTE: usize = 25 * 4096;

/// Heap \[bytes\] beside that: readers' own buffers, and what is made once.
const LEAST: usize = 16_000_000;

pub fn corpora() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/hostile/corpus")
}

/// The inputs of a target, with their names: in the order of the file, then crashes in that of their names.
pub fn inputs(target: &str) -> Vec<(String, Vec<u8>)> {
    let path = corpora().join(target);
    let packed = std::fs::read(&path).unwrap_or_else(|error| panic!("{}: {error}", path.display()));
    let mut rest = &packed[..];
    let mut inputs = Vec::new();
    while let Some((length, more)) = rest.split_first_chunk() {
        let (input, more) = more.split_at(u32::from_le_bytes(*length) as usize);
        inputs.push((format!("input {}", inputs.len()), input.to_vec()));
        rest = more;
    }
    assert!(rest.is_empty(), "{} is cut off", path.display());
    let mut crashes: Vec<(String, Vec<u8>)> = std::fs::read_dir(corpora().join("crashes"))
        .unwrap()
        .map(|entry| {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            (name, std::fs::read(&path).unwrap())
        })
        .filter(|(name, _)| name.starts_with(&format!("{target}-")))
        .collect();
    crashes.sort();
    inputs.extend(crashes);
    inputs
}

/// Packs inputs as `corpus/TARGET` has them.
pub fn packed(mut inputs: Vec<Vec<u8>>) -> Vec<u8> {
    inputs.sort_by_key(|input| (input.len(), input.clone()));
    let mut packed = Vec::new();
    for input in inputs {
        packed.extend((input.len() as u32).to_le_bytes());
        packed.extend(input);
    }
    packed
}

/// Reads an input under a watch; returns the heap that it took for each byte.
fn read(target: &'static str, name: &str, input: &[u8]) -> usize {
    let bytes = input.to_vec();
    let outcome = watched(&format!("{target}, {name}"), move || {
        enter(target, &bytes);
        Ok(())
    });
    let most = LEAST + MOST_A_BYTE * input.len();
    assert!(
        outcome.peak <= most,
        "{target}, {name}: {} bytes of heap for {} bytes, {most} are allowed",
        outcome.peak,
        input.len()
    );
    outcome.peak
}

#[test]
fn kept_inputs_are_refused_or_read() {
    let _alone = alone();
    for target in TARGETS {
        let inputs = inputs(target);
        assert!(inputs.len() >= 2, "{target} has {} inputs", inputs.len());
        let bytes: usize = inputs.iter().map(|(_, input)| input.len()).sum();
        let peaks = inputs.iter().map(|(name, input)| read(target, name, input));
        let peak = peaks.max().unwrap_or(0);
        println!(
            "{target}: {} inputs of {bytes} bytes; {peak} bytes of heap at most",
            inputs.len()
        );
    }
}

/// The same changes on every machine: a failure names the target and the number of the input.
#[test]
fn changed_inputs_are_refused_or_read() {
    let _alone = alone();
    for target in TARGETS {
        let inputs = inputs(target);
        let mut most = 0;
        for number in 0..CHANGED {
            let mut changes = Changes(number.wrapping_mul(0x9e37_79b9_7f4a_7c15));
            let (name, input) = &inputs[changes.below(inputs.len())];
            let (_, other) = &inputs[changes.below(inputs.len())];
            let changed = changes.of(input, other);
            most = most.max(read(
                target,
                &format!("change {number} of {name}"),
                &changed,
            ));
        }
        println!("{target}: {CHANGED} changed inputs; {most} bytes of heap at most");
    }
}

/// A source of changes (SplitMix64, Steele et al. 2014).
struct Changes(u64);

/// Numbers that readers stumble over: ends of ranges, and a size in between.
const NUMBERS: [u64; 10] = [
    0,
    1,
    0x7f,
    0xff,
    0x7fff,
    0xffff,
    0x10_0000,
    0x7fff_ffff,
    0xffff_ffff,
    u64::MAX,
];

impl Changes {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut x = self.0;
        x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        x ^ (x >> 31)
    }

    fn below(&mut self, end: usize) -> usize {
        (self.next() % end.max(1) as u64) as usize
    }

    /// One to four changes of an input; some bring a piece of another one.
    fn of(&mut self, input: &[u8], other: &[u8]) -> Vec<u8> {
        let mut bytes = input.to_vec();
        for _ in 0..=self.below(4) {
            // Every second one near the beginning, where headers are.
            let end = if self.below(2) == 0 {
                bytes.len().min(64)
            } else {
                bytes.len()
            };
            let at = self.below(end);
            match self.below(8) {
                0 if at < bytes.len() => bytes[at] ^= 1 << self.below(8),
                1 if at < bytes.len() => bytes[at] = self.next() as u8,
                2 => {
                    let number = NUMBERS[self.below(NUMBERS.len())].to_le_bytes();
                    let mut number = number[..1 << self.below(4)].to_vec();
                    if self.below(2) == 0 {
                        number.reverse();
                    }
                    for (byte, new) in bytes.iter_mut().skip(at).zip(number) {
                        *byte = new;
                    }
                }
                3 => {
                    let number = NUMBERS[self.below(NUMBERS.len())].to_string();
                    bytes.splice(at..at, number.into_bytes());
                }
                4 => bytes.truncate(at),
                5 => {
                    let end = bytes.len().min(at + self.below(16));
                    bytes.drain(at..end);
                }
                6 => {
                    let from = self.below(other.len());
                    let end = other.len().min(from + self.below(64));
                    bytes.splice(at..at, other[from..end].iter().copied());
                }
                _ => {
                    let end = bytes.len().min(at + self.below(32));
                    let again = bytes[at..end].to_vec();
                    bytes.splice(at..at, again);
                }
            }
        }
        bytes
    }
}
