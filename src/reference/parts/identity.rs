//! The identity of a run: what all of its parts have in common.

use std::io;

use serde::{Deserialize, Serialize};

use crate::film::AccumulatorError;
use crate::reference::Target;
use crate::reference::shard::Round;
use crate::run::SOURCE_HASH;
use crate::scene::{ReconstructionFilter, Scene};

/// Everything that must be the same in all parts of a round.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct RunIdentity {
    version: String,
    pub(super) method: String,
    scene: String,
    sensor: String,
    settings: String,
    /// Columns and rows of the film.
    pub(super) size: [usize; 2],
    pub(super) layers: Vec<String>,
    pub(super) round: Round,
}

/// What a method says of a run.
pub(super) struct About<'a> {
    pub method: &'static str,
    pub scene: &'a Scene,
    pub sensor: &'a str,
    /// The film's filter, if pixels are no plain averages: a command may change it.
    pub filter: Option<ReconstructionFilter>,
    /// All settings, as JSON.
    pub settings: String,
    pub size: [usize; 2],
    pub layers: Vec<String>,
}

/// The filter of a target's film, if pixels are no plain averages.
pub(super) fn filter_of(target: &Target) -> Option<ReconstructionFilter> {
    match target {
        Target::Camera {
            camera,
            filter: Some(_),
            ..
        } => Some(camera.filter()),
        _ => None,
    }
}

impl RunIdentity {
    /// That of a round of a run.
    pub(super) fn new(about: About, round: Round) -> Self {
        let sensor = match about.filter {
            Some(filter) => format!("{}, {filter:?}", about.sensor),
            None => about.sensor.to_owned(),
        };
        Self {
            version: env!("CARGO_PKG_VERSION").to_owned(),
            method: about.method.to_owned(),
            scene: about.scene.content_hash().to_owned(),
            sensor,
            settings: about.settings,
            size: about.size,
            layers: about.layers,
            round,
        }
    }

    /// Texels of the film.
    pub(super) fn texels(&self) -> usize {
        self.size[0] * self.size[1]
    }

    /// A hash of it and of the program's source: parts of the same key have the same sums.
    pub(super) fn key(&self) -> String {
        let mut hasher = blake3::Hasher::new();
        hasher.update(SOURCE_HASH.as_bytes());
        hasher.update(format!("{self:?}").as_bytes());
        hasher.finalize().to_hex().to_string()
    }

    /// Names the field in which two runs differ.
    pub(super) fn compare(&self, other: &Self) -> Result<(), ShardError> {
        let fields = [
            ("the version", &self.version, &other.version),
            ("the method", &self.method, &other.method),
            ("the hash of the scene", &self.scene, &other.scene),
            ("the sensor", &self.sensor, &other.sensor),
            ("the list of settings", &self.settings, &other.settings),
        ];
        for (field, left, right) in fields {
            if left != right {
                return Err(ShardError::differs(field, left, right));
            }
        }
        if self == other {
            return Ok(());
        }
        Err(ShardError::OtherRun {
            field: "the round, or the number of photons, samples, replicates, texels or layers",
            left: format!("{self:?}"),
            right: format!("{other:?}"),
        })
    }
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
    /// No part of a round is there.
    #[error("the shards lack round {} of the run: they are cut short, or of several runs", .0 + 1)]
    NoRound(u64),
    /// Parts that the run does not need.
    #[error("it has more rounds than its run")]
    MoreRounds,
    /// An error of a file.
    #[error("{name}: {error}")]
    File {
        /// Its name.
        name: String,
        /// The error.
        error: Box<ShardError>,
    },
    /// A part of a run that is made round by round.
    #[error("a part of one round of a run is no shard: whoever asked for it puts it together")]
    OneRound,
}

impl ShardError {
    /// The error of a file.
    pub(super) fn of(self, name: &str) -> Self {
        let (name, error) = (name.to_owned(), Box::new(self));
        Self::File { name, error }
    }

    /// Two shards, or a shard and the run, that differ in a field.
    pub(super) fn differs(
        field: &'static str,
        left: &impl ToString,
        right: &impl ToString,
    ) -> Self {
        Self::OtherRun {
            field,
            left: left.to_string(),
            right: right.to_string(),
        }
    }
}
