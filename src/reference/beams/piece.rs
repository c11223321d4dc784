//! Some batches of a pass, whose tasks may be done on several machines.

use std::time::Instant;

use serde::{Deserialize, Serialize};

use super::inputs::BeamInputs;
use super::limit::Limit;
use super::refine::{Asked, Limits};
use super::traced::BatchSums;
use crate::reference::shard::Shard;
use crate::run::{Budget, Error, Progress, Refusal};

/// Some batches of a pass. All that their tasks need to know is here and in the scene: no discovery is made
/// again.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Piece {
    /// Its number in the run, from 0.
    pub number: u64,
    /// Flux \[W\], about, that a film must have room for.
    room: f64,
    /// Work \[rays\] after which a forecast was wrong, and the pass ends; `None` if it has no limit.
    most_work: Option<u64>,
    batches: Vec<Vec<AskedByName>>,
}

/// A signature to be followed.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct AskedByName {
    signature: String,
    limits: Limits,
}

impl Piece {
    /// The piece of these batches.
    pub fn new(number: u64, room: f64, most_work: Option<u64>, batches: &[Vec<Asked>]) -> Self {
        let named = |(signature, limits): &Asked| AskedByName {
            signature: signature.to_string(),
            limits: *limits,
        };
        let batch = |batch: &Vec<Asked>| batch.iter().map(named).collect();
        Self {
            number,
            room,
            most_work,
            batches: batches.iter().map(batch).collect(),
        }
    }

    /// Number of its batches.
    pub fn len(&self) -> usize {
        self.batches.len()
    }

    /// True if it has no batch.
    pub fn is_empty(&self) -> bool {
        self.batches.is_empty()
    }

    /// The signatures of each batch.
    ///
    /// # Errors
    ///
    /// If one has a name that is none.
    pub fn asked(&self) -> Result<Vec<Vec<Asked>>, Refusal> {
        let asked = |one: &AskedByName| {
            let signature = one.signature.parse();
            let signature = signature.map_err(|error| {
                Refusal::new(format!("\"{}\" is no signature: {error}", one.signature))
            });
            Ok((signature?, one.limits))
        };
        let batches = self.batches.iter();
        batches
            .map(|batch| batch.iter().map(asked).collect())
            .collect()
    }

    /// Does a part of the tasks of each batch. `None` if work was stopped before its end.
    ///
    /// # Errors
    ///
    /// If a texel's flux is not representable, or a signature is none.
    pub fn trace(
        &self,
        inputs: &BeamInputs,
        shard: Shard,
        progress: &Progress,
    ) -> Result<Option<Vec<BatchSums>>, Error> {
        let limit =
            Limit::new(&Budget::default(), progress, Instant::now()).guarded(self.most_work);
        let passes = inputs.passes(self.room, &limit, progress);
        let mut done = Vec::with_capacity(self.len());
        for asked in self.asked()? {
            if limit.is_beyond_rays() {
                done.push(BatchSums::Beyond { work: 0 });
                continue;
            }
            let Some(sums) = passes.trace(&inputs.lights, &asked, shard)? else {
                return Ok(None);
            };
            done.push(sums);
        }
        Ok(Some(done))
    }
}
