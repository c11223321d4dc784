//! Exact sums over the replicates of one round of passes.

use super::gather::{Films, Pass};
use super::setup::Setup;
use crate::film::{Accumulator, AccumulatorError};
use crate::geometry::TraversalCounters;
use crate::numeric::FixedPoint;
use crate::run::Error;

/// Sums of a round, in integers: threads may add in any order.
#[derive(Debug)]
pub struct RoundSums {
    /// Films by layer: radiance times the target's étendue, and its change with √2 times the radius.
    pub films: Films,
    /// All layers together: their error bars need the sums of each replicate.
    pub total: Accumulator,
    /// The same sum of the differences.
    pub total_difference: Accumulator,
    /// Work done for the replicates that have ended.
    pub counters: TraversalCounters,
    /// Work done for the replicate under way.
    under_way: TraversalCounters,
    /// Passes of each replicate.
    pub passes: u64,
    scale: FixedPoint,
}

impl RoundSums {
    /// Empty sums.
    pub fn new(setup: &Setup, passes: u64) -> Self {
        let scale = setup
            .job(setup.pixel_stream(), &|| false)
            .scale(setup.target.headroom());
        let accumulator = || Accumulator::new(setup.target.texels(), 3, scale);
        let layers = || (0..setup.layers()).map(|_| accumulator()).collect();
        Self {
            films: Films {
                values: layers(),
                differences: layers(),
            },
            total: accumulator(),
            total_difference: accumulator(),
            counters: TraversalCounters::default(),
            under_way: TraversalCounters::default(),
            passes,
            scale,
        }
    }

    /// Sums of `passes` passes of each replicate, as they were written. The films are not empty.
    pub fn of_films(
        films: Films,
        [total, total_difference]: [Accumulator; 2],
        counters: TraversalCounters,
        passes: u64,
    ) -> Self {
        Self {
            scale: total.scale(),
            films,
            total,
            total_difference,
            counters,
            under_way: TraversalCounters::default(),
            passes,
        }
    }

    /// All films, in the order of a file: values, differences, and the sums of both over all layers.
    pub fn all(&self) -> impl Iterator<Item = &Accumulator> {
        let layers = self.films.values.iter().chain(&self.films.differences);
        layers.chain([&self.total, &self.total_difference])
    }

    /// Adds the replicates of another part of the same round.
    ///
    /// # Errors
    ///
    /// If the two are not of the same round, or a sum overflows.
    pub fn merge(&mut self, other: &Self) -> Result<(), AccumulatorError> {
        let layers = self
            .films
            .values
            .iter_mut()
            .chain(&mut self.films.differences);
        let films = layers.chain([&mut self.total, &mut self.total_difference]);
        for (film, others) in films.zip(other.all()) {
            film.merge(others)?;
        }
        self.counters += other.counters;
        Ok(())
    }

    /// Number of replicates that have ended.
    pub fn replicates(&self) -> u32 {
        self.total.replicates()
    }

    /// Adds a pass of the replicate under way; after `stop` asked for an end that replicate
    /// is of no use, and is not to be ended.
    ///
    /// # Errors
    ///
    /// If a contribution is not representable.
    pub fn gather(&mut self, pass: &Pass, stop: &(dyn Fn() -> bool + Sync)) -> Result<(), Error> {
        let done = pass.gather(&self.films, self.scale, stop);
        self.under_way += done.counters;
        if done.refused > 0 {
            return Err(Error::NotRepresentable(format!(
                "{} contributions to pixels are NaN, infinite or out of range",
                done.refused
            )));
        }
        Ok(())
    }

    /// Counts work for the replicate under way.
    pub fn count(&mut self, counters: TraversalCounters) {
        self.under_way += counters;
    }

    /// Ends a replicate.
    ///
    /// # Errors
    ///
    /// If a sum overflows.
    pub fn end_replicate(&mut self) -> Result<(), Error> {
        let Films {
            values,
            differences,
        } = &mut self.films;
        for (layers, total) in [
            (values, &mut self.total),
            (differences, &mut self.total_difference),
        ] {
            for layer in layers {
                total.deposit_all(layer)?;
                layer.flush()?;
            }
            total.flush()?;
        }
        self.counters += std::mem::take(&mut self.under_way);
        Ok(())
    }
}
