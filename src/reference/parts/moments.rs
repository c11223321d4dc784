//! Moments of some rows of an image in a file: numbers of 64 bits, little-endian, row by row.

use std::io::{BufRead, Read, Write};

use serde::{Deserialize, Serialize};

use super::identity::{RunIdentity, ShardError};
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::reference::path::bands::Bands;
use crate::reference::path::sums::{LAYERS, Moments, RoundSums};
use crate::reference::shard::Shard;

/// The small sums of paths.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SmallPath {
    counters: TraversalCounters,
    cut_off: u64,
    /// The layers that are not black, in their order.
    lit: Vec<usize>,
}

impl SmallPath {
    /// Those of a part, which is one piece when it is written.
    pub fn of(parts: &[(Shard, RoundSums)]) -> Self {
        let mut small = Self {
            counters: TraversalCounters::default(),
            cut_off: 0,
            lit: Vec::new(),
        };
        for (_, sums) in parts {
            small.counters += sums.counters;
            small.cut_off = small.cut_off.saturating_add(sums.cut_off);
            let lit = (0..LAYERS).filter(|&layer| !sums.layers[layer].is_empty());
            small.lit.extend(lit);
        }
        small
    }
}

/// Bytes of a number.
const WORD: usize = size_of::<f64>();

/// Numbers of a pixel's weights, and of its moments in a layer.
const WEIGHTS: usize = 2;
const MOMENTS: usize = 9;

/// Writes the weights of all rows, then the layers that are not black.
///
/// # Errors
///
/// As the writer's.
pub fn write(sums: &RoundSums, mut writer: impl Write) -> Result<(), ShardError> {
    let mut put = |number: f64| writer.write_all(&number.to_le_bytes());
    for number in sums.weights.iter().flatten() {
        put(*number)?;
    }
    for moments in sums.layers.iter().flatten() {
        let all = [moments.mean, moments.squares, moments.products];
        for number in all.iter().flat_map(|of| of.0) {
            put(number)?;
        }
    }
    Ok(())
}

/// Reads the moments of a shard's rows. Memory grows with the bytes read, not with the size that the header
/// claims.
///
/// # Errors
///
/// If they are more or fewer than the run and the shard have.
pub fn read(
    run: &RunIdentity,
    shard: Shard,
    small: &SmallPath,
    reader: impl BufRead,
) -> Result<RoundSums, ShardError> {
    let malformed = |message: &str| Err(ShardError::Malformed(message.to_owned()));
    let is_sorted = small.lit.is_sorted_by(|a, b| a < b);
    if !is_sorted || small.lit.iter().any(|layer| *layer >= LAYERS) {
        return malformed("its list of layers is damaged");
    }
    let [width, height] = run.size;
    let pixels = width * Bands::of(shard, height).row_count();
    let numbers = pixels * (WEIGHTS + MOMENTS * small.lit.len());
    let mut body = Vec::new();
    reader
        .take((numbers * WORD) as u64)
        .read_to_end(&mut body)?;
    let words: Vec<f64> = body
        .as_chunks()
        .0
        .iter()
        .map(|word| f64::from_le_bytes(*word))
        .collect();
    if words.len() != numbers {
        return malformed("its sums are fewer than its header says");
    }
    let (weights, mut rest) = words.split_at(WEIGHTS * pixels);
    let mut sums = RoundSums::new(0);
    sums.replicates = run.round.replicates;
    sums.weights = weights.as_chunks().0.to_vec();
    for layer in &small.lit {
        let moments;
        (moments, rest) = rest.split_at(MOMENTS * pixels);
        let moments: &[[[f64; 3]; 3]] = moments.as_chunks().0.as_chunks().0;
        let of = |[mean, squares, products]: &[[f64; 3]; 3]| Moments {
            mean: Rgb(*mean),
            squares: Rgb(*squares),
            products: Rgb(*products),
        };
        sums.layers[*layer] = moments.iter().map(of).collect();
    }
    sums.counters = small.counters;
    sums.cut_off = small.cut_off;
    Ok(sums)
}
