//! The sums of a part of a step, of each method that can be divided, and their form in a file.
//!
//! Small sums are in the file's header, and behind it those of the film: accumulators, for paths moments, and
//! for beams integers and what each task did, in numbers of 64 bits, little-endian.

use std::io::{BufRead, Write};

use serde::{Deserialize, Serialize};

use super::beam_films::{self, SmallBeams};
use super::films::{self, SmallPhotons};
use super::identity::{RunIdentity, ShardError};
use super::moments::{self, SmallPath};
use crate::geometry::TraversalCounters;
use crate::reference::beams::traced::BatchSums;
use crate::reference::path::sums::RoundSums as PathSums;
use crate::reference::photon_map::sums::RoundSums as PhotonMapSums;
use crate::reference::photons::sums::RoundSums as PhotonSums;
use crate::reference::shard::Shard;

/// What a part of a round has found.
#[derive(Debug)]
pub enum Sums {
    /// Some replicates of photons.
    Photons(PhotonSums),
    /// Some replicates of photon maps.
    PhotonMap(PhotonMapSums),
    /// Paths of the rows of some parts, each in one piece.
    Path(Vec<(Shard, PathSums)>),
    /// Some tasks of each batch of a piece of beams.
    Beams(Vec<BatchSums>),
}

/// The small sums, by method.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub(super) enum SmallSums {
    Photons(SmallPhotons),
    PhotonMap { counters: TraversalCounters },
    Path(SmallPath),
    Beams(SmallBeams),
}

impl Sums {
    /// Adds those of another part of the same round.
    ///
    /// # Errors
    ///
    /// If the two are not of the same round, or a sum overflows.
    pub fn merge(&mut self, other: Self) -> Result<(), ShardError> {
        match (self, other) {
            (Self::Photons(sums), Self::Photons(others)) => sums.merge(&others)?,
            (Self::PhotonMap(sums), Self::PhotonMap(others)) => sums.merge(&others)?,
            (Self::Path(parts), Self::Path(others)) => parts.extend(others),
            (Self::Beams(sums), Self::Beams(others)) => beam_films::merge(sums, others)?,
            _ => return Err(of_another_method()),
        }
        Ok(())
    }

    /// The small sums.
    pub(super) fn small(&self) -> SmallSums {
        match self {
            Self::Photons(sums) => SmallSums::Photons(SmallPhotons::of(sums)),
            Self::PhotonMap(sums) => SmallSums::PhotonMap {
                counters: sums.counters,
            },
            Self::Path(parts) => SmallSums::Path(SmallPath::of(parts)),
            Self::Beams(sums) => SmallSums::Beams(SmallBeams::of(sums)),
        }
    }

    /// Writes those of the film.
    pub(super) fn write_film(&self, mut writer: impl Write) -> Result<(), ShardError> {
        match self {
            Self::Photons(sums) => {
                for film in [&sums.total].into_iter().chain(&sums.layers) {
                    film.write_to(&mut writer)?;
                }
            }
            Self::PhotonMap(sums) => {
                for film in sums.all() {
                    film.write_to(&mut writer)?;
                }
            }
            Self::Path(parts) => {
                for (_, sums) in parts {
                    moments::write(sums, &mut writer)?;
                }
            }
            Self::Beams(sums) => beam_films::write(sums, writer)?,
        }
        Ok(())
    }

    /// Reads those of the film.
    ///
    /// # Errors
    ///
    /// If they are not of the run and the shard that they are said to be of: whoever merges them takes them
    /// at the header's word.
    pub(super) fn read_film(
        run: &RunIdentity,
        shard: Shard,
        small: SmallSums,
        reader: impl BufRead,
    ) -> Result<Self, ShardError> {
        match (small, run.method.as_str()) {
            (SmallSums::Photons(small), "photons") => {
                films::read_photons(run, shard, small, reader).map(Self::Photons)
            }
            (SmallSums::PhotonMap { counters }, "photon-map") => {
                films::read_photon_map(run, shard, counters, reader).map(Self::PhotonMap)
            }
            (SmallSums::Path(small), "path") => {
                let sums = moments::read(run, shard, &small, reader)?;
                Ok(Self::Path(vec![(shard, sums)]))
            }
            (SmallSums::Beams(small), "beams") => {
                beam_films::read(run, &small, reader).map(Self::Beams)
            }
            _ => Err(of_another_method()),
        }
    }
}

fn of_another_method() -> ShardError {
    ShardError::Malformed("its sums are not of its method".to_owned())
}
