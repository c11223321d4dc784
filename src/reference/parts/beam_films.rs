//! Films of beams in a file: numbers of 64 bits, little-endian, batch by batch.

use std::io::{BufRead, Read, Write};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::identity::{RunIdentity, ShardError};
use crate::geometry::TraversalCounters;
use crate::numeric::FixedPoint;
use crate::reference::beams::film::BeamFilm;
use crate::reference::beams::refine::Balance;
use crate::reference::beams::traced::{BatchSums, ChannelSums, SignatureDone, TaskDone};
use crate::transport::flux::Flux;

/// The small sums of beams: what is in the rest of the file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SmallBeams {
    batches: Vec<SmallBatch>,
}

/// The extent of a batch's sums.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
enum SmallBatch {
    Grey(Extent),
    Colours(Extent),
    Beyond { work: u64 },
}

/// Number of films and of tasks, and what their numbers mean.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Extent {
    films: usize,
    tasks: usize,
    /// The exponent of 2 of the films' quantum.
    exponent: i32,
    work: u64,
}

/// Bytes of a number.
const WORD: usize = size_of::<u64>();

impl SmallBeams {
    /// Those of some batches.
    pub fn of(batches: &[BatchSums]) -> Self {
        let small = |batch: &BatchSums| match batch {
            BatchSums::Grey(sums) => SmallBatch::Grey(Extent::of(sums)),
            BatchSums::Colours(sums) => SmallBatch::Colours(Extent::of(sums)),
            BatchSums::Beyond { work } => SmallBatch::Beyond { work: *work },
        };
        let batches = batches.iter().map(small).collect();
        Self { batches }
    }
}

impl Extent {
    fn of<const N: usize>(sums: &ChannelSums<N>) -> Self {
        let scale = sums.films.first().map(|film| film.scale());
        Self {
            films: sums.films.len(),
            tasks: sums.done.len(),
            exponent: scale.unwrap_or(FixedPoint::OF_ONE).exponent(),
            work: sums.work,
        }
    }
}

/// Adds the sums of other tasks of the same batches.
///
/// # Errors
///
/// If they are of others, or a sum overflows.
pub fn merge(batches: &mut [BatchSums], others: Vec<BatchSums>) -> Result<(), ShardError> {
    if batches.len() != others.len() {
        return malformed("it has another number of batches");
    }
    for (sums, others) in batches.iter_mut().zip(others) {
        if sums.merge(others).is_err() {
            return malformed("its films are of another kind, or their sums overflow");
        }
    }
    Ok(())
}

/// Writes the films of each batch, then what its tasks did.
///
/// # Errors
///
/// As the writer's.
pub fn write(batches: &[BatchSums], mut writer: impl Write) -> Result<(), ShardError> {
    for batch in batches {
        match batch {
            BatchSums::Grey(sums) => write_batch(sums, &mut writer)?,
            BatchSums::Colours(sums) => write_batch(sums, &mut writer)?,
            BatchSums::Beyond { .. } => {}
        }
    }
    Ok(())
}

fn write_batch<const N: usize>(
    sums: &ChannelSums<N>,
    mut writer: impl Write,
) -> Result<(), ShardError> {
    for film in &sums.films {
        for quanta in film.quanta() {
            writer.write_all(&quanta.to_le_bytes())?;
        }
    }
    for task in &sums.done {
        for number in [task.number, task.signatures.len()] {
            writer.write_all(&(number as u64).to_le_bytes())?;
        }
        for done in &task.signatures {
            write_done(done, &mut writer)?;
        }
    }
    Ok(())
}

fn write_done<const N: usize>(
    done: &SignatureDone<N>,
    mut writer: impl Write,
) -> Result<(), ShardError> {
    let (balance, counters) = (&done.balance, &done.counters);
    let numbers = [
        done.signature as u64,
        balance.cells,
        balance.cut_cells,
        balance.unresolved_cells,
        counters.rays,
        counters.node_visits,
        counters.primitive_tests,
    ];
    let light = [balance.emitted].into_iter();
    let light = light.chain(balance.received.0).chain(balance.uncertain.0);
    for number in numbers.into_iter().chain(light.map(f64::to_bits)) {
        writer.write_all(&number.to_le_bytes())?;
    }
    Ok(())
}

/// Reads the films of each batch, and what its tasks did. Memory grows with the bytes read, not with what the
/// header claims.
///
/// # Errors
///
/// If they are fewer than the header says, or none that beams leave.
pub fn read(
    run: &RunIdentity,
    small: &SmallBeams,
    mut reader: impl BufRead,
) -> Result<Vec<BatchSums>, ShardError> {
    let batches = small.batches.iter();
    batches
        .map(|batch| match batch {
            SmallBatch::Grey(extent) => {
                read_batch(run.size, extent, &mut reader).map(BatchSums::Grey)
            }
            SmallBatch::Colours(extent) => {
                read_batch(run.size, extent, &mut reader).map(BatchSums::Colours)
            }
            SmallBatch::Beyond { work } => Ok(BatchSums::Beyond { work: *work }),
        })
        .collect()
}

fn read_batch<const N: usize>(
    size: [usize; 2],
    extent: &Extent,
    mut reader: impl BufRead,
) -> Result<ChannelSums<N>, ShardError> {
    let Ok(scale) = FixedPoint::new(extent.exponent) else {
        return malformed("its quantum is out of range");
    };
    let mut films = Vec::new();
    for _ in 0..extent.films {
        let numbers = read_words(BeamFilm::<N>::numbers(size), &mut reader)?;
        let mut film = BeamFilm::new(size, scale);
        for (quanta, number) in film.quanta_mut().zip(numbers) {
            *quanta = number.cast_signed();
        }
        films.push(Arc::new(film));
    }
    let mut done = Vec::new();
    for _ in 0..extent.tasks {
        let words = read_words(2, &mut reader)?;
        let mut signatures = Vec::new();
        for _ in 0..words[1] {
            signatures.push(read_done(&mut reader)?);
        }
        done.push(TaskDone {
            number: index(words[0]),
            signatures,
        });
    }
    Ok(ChannelSums {
        films,
        done,
        work: extent.work,
    })
}

fn read_done<const N: usize>(reader: impl BufRead) -> Result<SignatureDone<N>, ShardError> {
    let words = read_words(8 + 2 * N, reader)?;
    let (numbers, light) = words.split_at(7);
    let light = |index: usize| f64::from_bits(light[index]);
    Ok(SignatureDone {
        signature: index(numbers[0]),
        balance: Balance {
            emitted: light(0),
            received: Flux(std::array::from_fn(|channel| light(1 + channel))),
            uncertain: Flux(std::array::from_fn(|channel| light(1 + N + channel))),
            cells: numbers[1],
            cut_cells: numbers[2],
            unresolved_cells: numbers[3],
        },
        counters: TraversalCounters {
            rays: numbers[4],
            node_visits: numbers[5],
            primitive_tests: numbers[6],
        },
    })
}

/// A number that counts something: none is as large as the largest.
fn index(number: u64) -> usize {
    usize::try_from(number).unwrap_or(usize::MAX)
}

/// So many numbers, as many as there are bytes for.
fn read_words(count: usize, reader: impl BufRead) -> Result<Vec<u64>, ShardError> {
    let mut body = Vec::new();
    let bytes = count.saturating_mul(WORD);
    reader.take(bytes as u64).read_to_end(&mut body)?;
    if body.len() != bytes {
        return malformed("its sums are fewer than its header says");
    }
    let words = body.as_chunks().0.iter();
    Ok(words.map(|word| u64::from_le_bytes(*word)).collect())
}

fn malformed<T>(message: &str) -> Result<T, ShardError> {
    Err(ShardError::Malformed(message.to_owned()))
}
