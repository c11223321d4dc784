//! Films of exact integers in a file: of photons, and of photon maps.

use std::io::BufRead;

use serde::{Deserialize, Serialize};

use super::identity::{RunIdentity, ShardError};
use crate::film::Accumulator;
use crate::geometry::TraversalCounters;
use crate::reference::photon_map::gather::Films;
use crate::reference::photon_map::settings::MOST_MAPS;
use crate::reference::photon_map::sums::RoundSums as PhotonMapSums;
use crate::reference::photons::sums::{LedgerSums, RoundSums as PhotonSums};
use crate::reference::photons::weights::Weights;
use crate::reference::shard::Shard;

/// The small sums of photons.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct SmallPhotons {
    counters: TraversalCounters,
    /// Integers as decimal text, since JSON's numbers are too short.
    ledger: Vec<String>,
    weights: Weights,
}

impl SmallPhotons {
    /// Those of sums.
    pub fn of(sums: &PhotonSums) -> Self {
        Self {
            counters: sums.counters,
            ledger: sums.ledger.numbers().map(|n| n.to_string()).collect(),
            weights: sums.weights.clone(),
        }
    }
}

/// Reads sums of photons: all light, then one film a layer.
///
/// # Errors
///
/// If they contradict the run or the shard.
pub fn read_photons(
    run: &RunIdentity,
    shard: Shard,
    small: SmallPhotons,
    reader: impl BufRead,
) -> Result<PhotonSums, ShardError> {
    // The layers that are named, and that of all others.
    let count = run.layers.len() + 1;
    let mut layers = read_films(run, shard, count + 1, reader)?.into_iter();
    let Some(total) = layers.next() else {
        return malformed("it has no sums");
    };
    let layers: Vec<Accumulator> = layers.collect();
    let round = run.round;
    let photons = round.each.checked_mul(round.replicates.into());
    if photons.is_none() {
        return malformed(format!(
            "it claims {} replicates of {} photons: allowed are up to 2^64 in all",
            round.replicates, round.each
        ));
    }
    if total.count(0).is_none() && total.texels() > 0 {
        return malformed("its sums of all light lack counts");
    }
    if small.weights.layers.len() != count {
        return malformed(format!(
            "it has the largest contributions of {} layers, and sums of {count}",
            small.weights.layers.len()
        ));
    }
    // Flux ends once, in 2⁶³ quanta a replicate at most, and there are up to 2³² replicates: an honest
    // sum stays below 2⁹⁵. Sums of 2²⁷ shards below 2¹⁰⁰ do not overflow.
    let possible = |number: &i128| number.unsigned_abs() < 1 << 100;
    let numbers = small.ledger.iter();
    let numbers = numbers.map_while(|text| text.parse().ok().filter(possible));
    let Some(ledger) = LedgerSums::from_numbers(total.scale(), count + 1, numbers) else {
        return malformed("its ledger is damaged");
    };
    Ok(PhotonSums {
        layers,
        total,
        ledger,
        weights: small.weights,
        counters: small.counters,
        photons: round.each,
    })
}

/// Reads sums of photon maps: values and differences by layer, then both of all layers.
///
/// # Errors
///
/// If they contradict the run or the shard.
pub fn read_photon_map(
    run: &RunIdentity,
    shard: Shard,
    counters: TraversalCounters,
    reader: impl BufRead,
) -> Result<PhotonMapSums, ShardError> {
    let maps = run.round.before.saturating_add(run.round.each);
    if maps > MOST_MAPS {
        return malformed(format!(
            "it is of {maps} maps a replicate: allowed are up to {MOST_MAPS}"
        ));
    }
    let layers = run.layers.len();
    let mut values = read_films(run, shard, 2 * layers + 2, reader)?;
    let (Some(total_difference), Some(total)) = (values.pop(), values.pop()) else {
        return malformed("it has no sums");
    };
    let differences = values.split_off(layers);
    let films = Films {
        values,
        differences,
    };
    let totals = [total, total_difference];
    Ok(PhotonMapSums::of_films(
        films,
        totals,
        counters,
        run.round.each,
    ))
}

/// Films that are alike, of the shard's replicates.
fn read_films(
    run: &RunIdentity,
    shard: Shard,
    count: usize,
    mut reader: impl BufRead,
) -> Result<Vec<Accumulator>, ShardError> {
    let texels = run.texels();
    let replicates = shard.replicates(run.round.replicates);
    let mut films: Vec<Accumulator> = Vec::new();
    for _ in 0..count {
        let film = Accumulator::read_from(&mut reader)?;
        if film.texels() != texels {
            return malformed(format!(
                "its sums have {} texels, and its header says {texels}",
                film.texels()
            ));
        }
        if film.replicates() != replicates {
            return malformed(format!(
                "its sums have {} replicates: of {} in {} parts, part {} has {replicates}",
                film.replicates(),
                run.round.replicates,
                shard.count,
                shard.index
            ));
        }
        if let Some(first) = films.first() {
            first.check_like(&film)?;
        }
        films.push(film);
    }
    Ok(films)
}

fn malformed<T>(message: impl Into<String>) -> Result<T, ShardError> {
    Err(ShardError::Malformed(message.into()))
}
