//! Parts of a run, computed apart and put together exactly.
//!
//! A shard traces every n-th replicate. Its file holds the integer sums, so merging the shards of a run gives
//! the very bits of the run in one piece.
//!
//! A file has the line `nephroid shard 3`, one line of JSON (`Header`), then the accumulators, and the BLAKE3
//! hash of all that.

use std::io::{self, BufRead, Read, Write};

use serde::{Deserialize, Serialize};

use super::hashed::Hashed;
use super::run::Setup;
use super::settings::{DEFAULT_PHOTONS, Shard};
use super::sums::{LedgerSums, RoundSums};
use super::weights::Weights;
use crate::film::{Accumulator, AccumulatorError};
use crate::geometry::TraversalCounters;
use crate::reference::Target;
use crate::run::{Budget, Error, Estimate, Refusal, SOURCE_HASH};

/// The first line of a shard file, version included.
const MAGIC: &str = "nephroid shard 3";

/// The first line of shards of any version, up to its number.
const ANY_MAGIC: &str = "nephroid shard ";

/// Longest header line that is read, in bytes. A thousand layers need a tenth of it.
const MAX_HEADER: u64 = 1 << 22;

/// Identity of the run, and its small sums.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Header {
    /// Everything that must be the same in all shards of a run.
    run: RunIdentity,
    shard: Shard,
    counters: TraversalCounters,
    /// Integers as decimal text, since JSON's numbers are too short.
    ledger: Vec<String>,
    weights: Weights,
}

/// Everything that must be the same in all shards of a run.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub(super) struct RunIdentity {
    version: String,
    scene: String,
    sensor: String,
    settings: String,
    texels: usize,
    layers: Vec<String>,
    replicates: u32,
    photons_each: u64,
    /// The round, of a run that has several.
    #[serde(default)]
    round: u64,
}

/// A round of a run: all replicates, each with as many photons.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Round {
    /// Its number, from 0.
    pub number: u64,
    /// Number of replicates.
    pub replicates: u32,
    /// Photons of each of them.
    pub photons_each: u64,
}

/// One shard's sums.
#[derive(Debug)]
pub struct Part {
    pub(super) run: RunIdentity,
    pub(super) shard: Shard,
    pub(super) sums: RoundSums,
}

/// Reason why shards cannot be read or merged.
#[derive(Debug, thiserror::Error)]
pub enum ShardError {
    /// The system reported an error, or the file ends early.
    #[error(transparent)]
    Io(#[from] io::Error),
    /// The file is not a shard.
    #[error("not a shard of this version of nephroid: {0}")]
    Malformed(String),
    /// The sums are damaged or do not fit.
    #[error(transparent)]
    Accumulator(#[from] AccumulatorError),
    /// A shard of another run.
    #[error("the shards are not of one run: {field} is {left} here and {right} there")]
    OtherRun {
        /// The field that differs.
        field: &'static str,
        /// Its value in the first shard, or in this run.
        left: String,
        /// Its value in the other.
        right: String,
    },
    /// Some are missing or doubled.
    #[error("a run of {count} shards needs each of them once; given were {given:?}")]
    Incomplete {
        /// The number that there must be.
        count: u32,
        /// The shards that were given, counted from 1.
        given: Vec<u32>,
    },
}

impl RunIdentity {
    /// The round that it is of.
    pub(super) fn round(&self) -> Round {
        Round {
            number: self.round,
            replicates: self.replicates,
            photons_each: self.photons_each,
        }
    }

    /// A hash of it and of the program's source: parts of the same key have the same sums.
    pub(super) fn key(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(SOURCE_HASH.as_bytes());
        hasher.update(format!("{self:?}").as_bytes());
        hasher.finalize().to_hex().to_string()
    }
}

impl Setup<'_> {
    pub(super) fn identity(&self, sensor: &str, round: Round) -> RunIdentity {
        let Round {
            number,
            replicates,
            photons_each,
        } = round;
        RunIdentity {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            scene: self.scene.content_hash().to_owned(),
            sensor: self.named(sensor),
            settings: serde_json::to_string(&self.settings).unwrap_or_default(),
            texels: self.target.texels(),
            layers: self
                .map
                .signatures()
                .iter()
                .map(ToString::to_string)
                .collect(),
            replicates,
            photons_each,
            round: number,
        }
    }

    /// The sensor's name, and its film's filter if pixels are no plain averages: a command may change it.
    fn named(&self, sensor: &str) -> String {
        match &self.target {
            Target::Camera {
                camera,
                filter: Some(_),
                ..
            } => format!("{sensor}, {:?}", camera.filter()),
            _ => sensor.to_owned(),
        }
    }

    /// Traces the shard's replicates. `None` if it was stopped before its end, since part of a shard is of no
    /// use.
    ///
    /// # Errors
    ///
    /// If the budget limits anything but photons, or contributions are not representable.
    pub fn run_shard(
        &self,
        sensor: &str,
        budget: &Budget,
        shard: Shard,
    ) -> Result<Option<Part>, Error> {
        check_budget(budget)?;
        let photons = budget.work.unwrap_or(DEFAULT_PHOTONS);
        let (replicates, photons_each) = self.division(photons);
        let round = Round {
            number: 0,
            replicates,
            photons_each,
        };
        self.run_part(sensor, round, shard)
    }

    /// Traces the shard's replicates of a round. `None` if it was stopped before its end.
    ///
    /// # Errors
    ///
    /// If contributions are not representable.
    pub fn run_part(
        &self,
        sensor: &str,
        round: Round,
        shard: Shard,
    ) -> Result<Option<Part>, Error> {
        let Round {
            number,
            replicates,
            photons_each,
        } = round;
        let mine = shard.replicates(replicates);
        self.expect(photons_each.saturating_mul(mine.into()));
        let sums = self.round(number, photons_each, replicates, shard, None)?;
        Ok((sums.replicates() == mine).then(|| Part {
            run: self.identity(sensor, round),
            shard,
            sums,
        }))
    }

    /// Puts the shards of a run together. The result is that of the run in one piece, bit for bit.
    ///
    /// # Errors
    ///
    /// If a shard is of another run, missing or doubled.
    pub fn merge(&self, sensor: &str, parts: Vec<Part>) -> Result<Estimate, ShardError> {
        let mut given: Vec<u32> = parts.iter().map(|part| part.shard.index + 1).collect();
        given.sort_unstable();
        let count = parts.first().map_or(1, |part| part.shard.count);
        if !given.iter().copied().eq(1..=count) {
            return Err(ShardError::Incomplete { count, given });
        }
        let mut rounds = self.rounds();
        let mut parts = parts.into_iter();
        if let Some(first) = parts.next() {
            let number = 0;
            let here = self.identity(
                sensor,
                Round {
                    number,
                    ..first.run.round()
                },
            );
            compare(&here, &first.run)?;
            let mut sums = first.sums;
            for part in parts {
                compare(&first.run, &part.run)?;
                if part.shard.count != count {
                    return Err(ShardError::OtherRun {
                        field: "the number of shards",
                        left: count.to_string(),
                        right: part.shard.count.to_string(),
                    });
                }
                sums.merge(&part.sums)?;
            }
            rounds.add(&sums, &self.map);
        }
        Ok(rounds.estimate(&self.target, &self.map, self.direct(None).as_ref(), false))
    }
}

/// Refuses budgets whose number of photons is not known beforehand.
///
/// # Errors
///
/// If time or error is limited.
pub fn check_budget(budget: &Budget) -> Result<(), Refusal> {
    if budget.is_work_only() {
        return Ok(());
    }
    let reason =
        "a shard needs a fixed number of photons: give --photons, and neither --time nor --error";
    Err(Refusal::new(reason))
}

/// Names the field in which two runs differ.
pub(super) fn compare(left: &RunIdentity, right: &RunIdentity) -> Result<(), ShardError> {
    let fields = [
        ("the version", &left.version, &right.version),
        ("the hash of the scene", &left.scene, &right.scene),
        ("the sensor", &left.sensor, &right.sensor),
        ("the list of settings", &left.settings, &right.settings),
    ];
    for (field, left, right) in fields {
        if left != right {
            return Err(ShardError::OtherRun {
                field,
                left: left.clone(),
                right: right.clone(),
            });
        }
    }
    if left == right {
        return Ok(());
    }
    Err(ShardError::OtherRun {
        field: "the round, or the number of photons, replicates, texels or layers",
        left: format!("{left:?}"),
        right: format!("{right:?}"),
    })
}

/// Refuses sums that are not those of the run and the shard that a header names: whoever merges them takes
/// them at the header's word.
fn check_sums(
    header: &Header,
    total: &Accumulator,
    layers: &[Accumulator],
) -> Result<(), ShardError> {
    let wrong = |message: String| Err(ShardError::Malformed(message));
    let Header { run, shard, .. } = header;
    if shard.index >= shard.count {
        return wrong(format!(
            "it is part {} of {}: allowed are 0 to {}",
            shard.index,
            shard.count,
            i64::from(shard.count) - 1
        ));
    }
    if total.texels() != run.texels {
        return wrong(format!(
            "its sums have {} texels, and its header says {}",
            total.texels(),
            run.texels
        ));
    }
    let replicates = shard.replicates(run.replicates);
    if total.replicates() != replicates {
        return wrong(format!(
            "its sums have {} replicates: of {} in {} parts, part {} has {replicates}",
            total.replicates(),
            run.replicates,
            shard.count,
            shard.index
        ));
    }
    if run
        .photons_each
        .checked_mul(u64::from(run.replicates))
        .is_none()
    {
        return wrong(format!(
            "it claims {} replicates of {} photons: allowed are up to 2^64 in all",
            run.replicates, run.photons_each
        ));
    }
    if total.count(0).is_none() && run.texels > 0 {
        return wrong("its sums of all light lack counts".to_owned());
    }
    if header.weights.layers.len() != layers.len() {
        return wrong(format!(
            "it has the largest contributions of {} layers, and sums of {}",
            header.weights.layers.len(),
            layers.len()
        ));
    }
    for layer in layers {
        total.check_like(layer)?;
        if layer.replicates() != replicates {
            return wrong(format!(
                "a layer has {} replicates, and all light {replicates}",
                layer.replicates()
            ));
        }
    }
    Ok(())
}

/// Refuses a file whose contents have not the hash at its end, or that goes on.
fn check_end(reader: Hashed<impl BufRead>) -> Result<(), ShardError> {
    let (mut reader, hash) = reader.into_parts();
    let mut said = [0; blake3::OUT_LEN];
    reader.read_exact(&mut said)?;
    // All of the file is hashed: the header says nothing of its own damage.
    if hash != said || !reader.fill_buf()?.is_empty() {
        let message = "its contents have not the hash at its end: it is damaged";
        return Err(ShardError::Malformed(message.to_owned()));
    }
    Ok(())
}

impl Part {
    /// Writes the shard.
    ///
    /// # Errors
    ///
    /// As the writer's.
    pub fn write_to(&self, writer: impl Write) -> Result<(), ShardError> {
        let mut writer = Hashed::new(writer);
        let header = Header {
            run: self.run.clone(),
            shard: self.shard,
            counters: self.sums.counters,
            ledger: self.sums.ledger.numbers().map(|n| n.to_string()).collect(),
            weights: self.sums.weights.clone(),
        };
        let header = serde_json::to_string(&header)
            .map_err(|error| ShardError::Malformed(error.to_string()))?;
        writeln!(writer, "{MAGIC}\n{header}")?;
        self.sums.total.write_to(&mut writer)?;
        for layer in &self.sums.layers {
            layer.write_to(&mut writer)?;
        }
        let (mut writer, hash) = writer.into_parts();
        Ok(writer.write_all(hash.as_bytes())?)
    }

    /// Reads a shard.
    ///
    /// # Errors
    ///
    /// If the file is no shard, is damaged, or cannot be read.
    pub fn read_from(reader: impl BufRead) -> Result<Self, ShardError> {
        let mut reader = Hashed::new(reader);
        let mut lines = reader.by_ref().take(MAX_HEADER);
        let mut line = String::new();
        let mut next = || -> Result<String, ShardError> {
            line.clear();
            lines
                .read_line(&mut line)
                .map_err(|error| match error.kind() {
                    io::ErrorKind::InvalidData => ShardError::Malformed("no text".to_owned()),
                    _ => error.into(),
                })?;
            Ok(line.trim_end().to_owned())
        };
        let magic = next()?;
        if magic != MAGIC {
            return Err(ShardError::Malformed(match magic.strip_prefix(ANY_MAGIC) {
                Some(_) => {
                    format!("it is a \"{magic}\", and this version has \"{MAGIC}\": make it again")
                }
                None => format!("its first line is not \"{MAGIC}\""),
            }));
        }
        let header: Header = serde_json::from_str(&next()?)
            .map_err(|error| ShardError::Malformed(error.to_string()))?;
        let total = Accumulator::read_from(&mut reader)?;
        let layers: Vec<Accumulator> = (0..=header.run.layers.len())
            .map(|_| Accumulator::read_from(&mut reader))
            .collect::<Result<_, _>>()?;
        check_end(reader)?;
        // Flux ends once, in 2⁶³ quanta a replicate at most, and there are up to 2³² replicates: an honest
        // sum stays below 2⁹⁵. Sums of 2²⁷ shards below 2¹⁰⁰ do not overflow.
        let possible = |number: &i128| number.unsigned_abs() < 1 << 100;
        let numbers = header
            .ledger
            .iter()
            .map_while(|text| text.parse().ok().filter(possible));
        let ledger = LedgerSums::from_numbers(total.scale(), layers.len() + 1, numbers)
            .ok_or_else(|| ShardError::Malformed("its ledger is damaged".to_owned()))?;
        check_sums(&header, &total, &layers)?;
        let photons = header.run.photons_each;
        Ok(Self {
            run: header.run,
            shard: header.shard,
            sums: RoundSums {
                layers,
                total,
                ledger,
                weights: header.weights,
                counters: header.counters,
                photons,
            },
        })
    }
}
