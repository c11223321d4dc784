//! Beams in parts of some tasks.
//!
//! Which pass a run needs next is known once those before are whole: its own schedule is followed again each
//! time, with passes that are there instead of followed. Light that photons measure after the last pass is
//! measured where parts are put together.

use std::collections::VecDeque;

use super::divided::{GatherError, Next};
use super::gather::{Gathered, Step, Wanted};
use super::identity::{About, RunIdentity, ShardError, filter_of};
use super::part::Part;
use super::sums::Sums;
use crate::reference::beams::inputs::BeamInputs;
use crate::reference::beams::light::BeamLight;
use crate::reference::beams::pass::Passes;
use crate::reference::beams::piece::Piece;
use crate::reference::beams::refine::{Asked, Sounding};
use crate::reference::beams::run::Setup;
use crate::reference::beams::source::PassSource;
use crate::reference::beams::tasks::TaskCount;
use crate::reference::beams::traced::BatchSums;
use crate::reference::beams::{BeamReport, BeamSettings};
use crate::reference::shard::{Round, Shard};
use crate::run::{Budget, Error, Estimate, Progress, Refusal};
use crate::scene::{ReconstructionFilter, Scene};

/// Most memory \[bytes\] that the films of a piece take, if it has more than one batch.
pub const MOST_BYTES: usize = 512 << 20;

/// Does the shard's part of a piece. `None` if it was stopped before its end.
///
/// # Errors
///
/// If a texel's flux is not representable, or the piece names a signature that is none.
pub fn run_part(
    inputs: &BeamInputs,
    settings: &BeamSettings,
    sensor: &str,
    piece: &Piece,
    shard: Shard,
    progress: &Progress,
) -> Result<Option<Part>, Error> {
    let sums = piece.trace(inputs, shard, progress)?;
    let identity = Identity::new(inputs, settings, sensor);
    Ok(sums.map(|sums| Part {
        run: identity.of(piece),
        shard,
        whole: None,
        sums: Sums::Beams(sums),
    }))
}

/// Refuses budgets whose end other machines would have to know.
///
/// # Errors
///
/// If time or rays are limited.
pub fn check_error_only(budget: &Budget) -> Result<(), Refusal> {
    if budget.time.is_none() && budget.work.is_none() {
        return Ok(());
    }
    let reason =
        "beams that are divided among machines run to an error: give neither --time nor --rays";
    Err(Refusal::new(reason))
}

/// The piece that a run needs next, or its result: that of the run in one piece, bit for bit. The films of a
/// piece take `most_bytes` at most, if it has more than one batch.
///
/// # Errors
///
/// If the budget limits time or rays, or parts are of another run, or missing.
pub fn next(
    setup: &mut Setup,
    sensor: &str,
    budget: &Budget,
    gathered: &Gathered,
    most_bytes: usize,
) -> Result<Next<(Estimate, BeamReport)>, GatherError> {
    check_error_only(budget).map_err(Error::from)?;
    let tasks = TaskCount::new(&setup.inputs.lights, &setup.inputs.facets);
    let mut pieces = Pieces {
        identity: Identity::new(&setup.inputs, &setup.settings(), sensor),
        gathered,
        tasks,
        most_of_piece: (most_bytes / setup.inputs.film_bytes().max(1)).max(1),
        number: 0,
        waiting: VecDeque::new(),
        there: VecDeque::new(),
        needed: None,
        problem: None,
    };
    let spent = setup.spend(budget, &mut pieces)?;
    if let Some(problem) = pieces.problem {
        return Err(problem.into());
    }
    let Some((piece, run)) = pieces.needed else {
        let found = setup.finish(budget, spent)?;
        return Ok(Next::Done(Box::new(found)));
    };
    let batches = piece.asked().map_err(Error::from)?;
    let most_parts = batches.iter().map(|batch| tasks.of(batch.len())).max();
    let most_parts = u32::try_from(most_parts.unwrap_or(1)).unwrap_or(u32::MAX);
    let work = setup.sounded_batches(batches);
    let work: f64 = work.values().map(Sounding::work).sum();
    Ok(Next::Step(Box::new(Wanted {
        step: Step::Piece(piece),
        key: run.key(),
        // It is a forecast, and there is something to do.
        work: (work as u64).max(1),
        most_parts: most_parts.max(1),
        left: 0,
        run,
    })))
}

/// What all parts of a run have in common.
struct Identity<'a> {
    scene: &'a Scene,
    sensor: &'a str,
    filter: Option<ReconstructionFilter>,
    settings: String,
    size: [usize; 2],
}

impl<'a> Identity<'a> {
    fn new(inputs: &BeamInputs<'a>, settings: &BeamSettings, sensor: &'a str) -> Self {
        Self {
            scene: inputs.scene,
            sensor,
            filter: filter_of(&inputs.target),
            settings: serde_json::to_string(settings).unwrap_or_default(),
            size: inputs.target.size(),
        }
    }

    /// That of a piece: parts of pieces with other limits are of other runs.
    fn of(&self, piece: &Piece) -> RunIdentity {
        let piece_settings = serde_json::to_string(piece).unwrap_or_default();
        let about = About {
            method: "beams",
            scene: self.scene,
            sensor: self.sensor,
            filter: self.filter,
            settings: format!("{}, {piece_settings}", self.settings),
            size: self.size,
            layers: Vec::new(),
        };
        let round = Round {
            number: piece.number,
            replicates: 1,
            each: piece.len() as u64,
            before: 0,
        };
        RunIdentity::new(about, round)
    }
}

/// Passes whose pieces are there already, up to the one that is needed.
struct Pieces<'a, 'g> {
    identity: Identity<'a>,
    gathered: &'g Gathered,
    tasks: TaskCount,
    /// Most signatures of a piece, if it has more than one batch.
    most_of_piece: usize,
    /// Number of the next piece.
    number: u64,
    /// The batches of the pass that are not yet in a piece.
    waiting: VecDeque<Vec<Asked>>,
    /// The sums of the piece's batches that are still to be taken.
    there: VecDeque<BatchSums>,
    needed: Option<(Piece, RunIdentity)>,
    problem: Option<ShardError>,
}

impl Pieces<'_, '_> {
    /// The next piece of the pass: as many batches as memory has room for, but one at least.
    fn piece(&mut self, passes: &Passes) -> Piece {
        let (mut batches, mut signatures) = (Vec::new(), 0);
        while let Some(batch) = self.waiting.front() {
            signatures += batch.len();
            if signatures > self.most_of_piece && !batches.is_empty() {
                break;
            }
            batches.extend(self.waiting.pop_front());
        }
        let guard = passes.limit.left_of_guard();
        let piece = Piece::new(self.number, passes.flux, guard, &batches);
        self.number += 1;
        piece
    }

    /// Gets the sums of the next piece. False if they are not there.
    fn read(&mut self, passes: &Passes) -> bool {
        let piece = self.piece(passes);
        let run = self.identity.of(&piece);
        let there = &mut self.there;
        let mut take = |sums: &Sums| {
            let Sums::Beams(sums) = sums else {
                return false;
            };
            there.extend(sums.iter().cloned());
            sums.len() == piece.len()
        };
        match self.gathered.round(&run, &mut take) {
            Ok(Some(true)) => return true,
            Ok(Some(false)) => self.problem = Some(of_other_tasks()),
            Ok(None) => self.needed = Some((piece, run)),
            Err(problem) => self.problem = Some(problem),
        }
        false
    }
}

impl PassSource for Pieces<'_, '_> {
    fn begin_pass(&mut self, batches: &[Vec<Asked>]) {
        self.waiting = batches.iter().cloned().collect();
        self.there.clear();
    }

    fn batch(
        &mut self,
        passes: &Passes,
        _: &[BeamLight],
        asked: &[Asked],
    ) -> Result<Option<BatchSums>, Error> {
        if self.there.is_empty() && !self.read(passes) {
            return Ok(None);
        }
        let Some(sums) = self.there.pop_front() else {
            return Ok(None);
        };
        // The parts' limits know of their own work alone.
        let work = sums.work();
        passes.limit.spend(work);
        if passes.limit.is_beyond_rays() {
            return Ok(Some(BatchSums::Beyond { work }));
        }
        let is_whole = sums.is_whole(self.tasks.of(asked.len()), asked.len());
        if !is_whole || !passes.has_films_like(&sums)? {
            self.problem = Some(of_other_tasks());
            return Ok(None);
        }
        Ok(Some(sums))
    }
}

fn of_other_tasks() -> ShardError {
    ShardError::Malformed("its sums are of other tasks than its run has".to_owned())
}
