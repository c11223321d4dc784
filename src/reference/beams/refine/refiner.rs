//! The refiner of cells.

use std::cell::RefCell;

use glam::DVec2;

use super::balance::Balance;
use super::density::most_density;
use super::limits::{Asked, Limits};
use super::nodes::NodeFinder;
use crate::geometry::TraversalCounters;
use crate::reference::beams::cell::{BeamCell, BeamNode, CellSummary};
use crate::reference::beams::cut::{self, CutPiece};
use crate::reference::beams::deposit::{
    Coarse, Levels, TexelBlock, deposit_points, deposit_uncertain, texels_of, uncertain_boxes,
};
use crate::reference::beams::film::BeamFilm;
use crate::reference::beams::limit::Limit;
use crate::reference::beams::store::PathStore;
use crate::transport::clearance::{CellClearance, Clearance, Trail};
use crate::transport::first_surface::{Cone, SharedPlaces, SurfaceChart, SurfacePatch};
use crate::transport::fixed_signature::PathFollower;
use crate::transport::flux::Flux;
use crate::transport::signature::Signature;

/// Most divisions of a patch: to a quarter of a billionth of its side.
const MAX_LEVEL: u32 = 32;

/// Flux, in tolerances, that a cell may hold however smooth it looks: six nodes tell only so much. At an
/// error of 0.1 % this asks for some thousands of cells at least.
const MOST_TOLERANCES: f64 = 4096.0;

/// Least number of divisions of a cell that brings much light, all of it far beside the film. After fewer,
/// its nodes are not enough to show that.
const LEAST_LEVEL_OFF: u32 = 2;

/// Part of a cut cell that always counts as uncertain: a border may have a corner inside the cell that
/// neither fineness shows.
const CORNER: f64 = 1.0 / 64.0;

/// Part of the flux that needs no clearance down to which a cell that hides a sliver of light is divided.
const LEAST_SLIVER: f64 = 1.0 / 64.0;

/// Flux, in tolerances, up to which a cell of more than one topology is cut, not divided.
const CUT_TOLERANCES: f64 = 256.0;

/// Part of the opening of a spot's cone down to which a cell without light at the cone's border is divided.
/// The part of the cone that reaches in between its nodes is then less than a millionth of the cone.
const LEAST_IN_CONE: f64 = 1.0 / 256.0;

/// Largest distance of weights from a plane, as a part of them, that is smooth enough to derive bounds from.
/// With a twentieth, bounds are too narrow for a valley narrower than a cell (Fresnel's at Brewster's angle,
/// in a ball of index 24).
const STILL_BENT: f64 = 1.0 / 32.0;

/// Distance of a cell's weights from a plane, as a part of them, above which its quarters must show a quarter
/// of it.
const NOTED_BEND: f64 = 1.0 / 64.0;

/// Least part of a noted bend that halving should leave: it leaves a quarter of a smooth one. A smaller part
/// may be chance, with nodes on both sides of a valley. At a sixteenth, and without [`STILL_BENT`], balls of
/// eight indices of twenty-five are out of their bounds.
const BY_CHANCE: f64 = 1.0 / 5.0;

/// Part of the bend of a line with a kink that halving it leaves.
const LEFT_OF_KINK: f64 = 0.5;

/// Part of the light within a bend of a texel line that may be on the wrong side of it although no change
/// shows that.
const HIDDEN: f64 = 1.0 / 32.0;

/// The same if the map has kinks.
const HIDDEN_BY_KINKS: f64 = 1.0 / 8.0;

/// Flux of a bend, in tolerances, below which neither rule applies.
const LEAST_BENT: f64 = 1.0 / 64.0;

/// Flux, in tolerances, up to which a cell's light may be spread evenly over some texels that are side by
/// side.
const FAINT: f64 = 0.25;

/// Number of cells between two questions to the limit: some milliseconds' work.
const PATIENCE: u64 = 256;

/// Number of cells of one patch after which the largest that wait are left to others, and between two such
/// times: some tens of milliseconds' work.
const BEFORE_LEAVING: u64 = 4096;

/// Number of patches that are left together.
const LEFT_TOGETHER: usize = 32;

/// Number of pieces of light that a task leaves at most, since they take memory; it does the rest itself.
pub const MOST_LEFT: usize = 256;

/// Memory \[bytes\] of so many pieces, if all are patches: a cell takes less. The rest is a piece's own
/// place, and that of its sums.
const LEFT_BYTES: usize = MOST_LEFT * (LEFT_TOGETHER * size_of::<[DVec2; 3]>() + 256);

/// Least number of divisions from a cell that is left to the one at hand. A smaller cell has most of its
/// paths in common with those at hand.
const LEAST_LEFT: u32 = 4;

/// Memory that refiners work in, one after the other.
pub struct Scratch<const N: usize> {
    /// The signature whose paths it holds.
    owner: Option<Signature>,
    pub(super) store: PathStore<N>,
    /// Paths beside borders: the halves of an edge are searched, then the edge, then the neighbour's.
    pub(super) borders: PathStore<N>,
    /// The trails of a cell's six paths, for the clearance.
    pub(super) trails: [Trail; 6],
    pub(super) pending: Vec<BeamCell<N>>,
    pub(super) block: TexelBlock<N>,
    pub(super) fine: Vec<CutPiece<N>>,
    pub(super) coarse: Vec<CutPiece<N>>,
}

impl<const N: usize> Scratch<N> {
    /// Memory for signatures of at most `events` events.
    pub fn new(events: usize) -> Self {
        Self {
            owner: None,
            store: PathStore::new(events),
            borders: PathStore::new(events),
            trails: Default::default(),
            pending: Vec::new(),
            block: TexelBlock::default(),
            fine: Vec::new(),
            coarse: Vec::new(),
        }
    }

    /// Forgets all paths. A task, or a piece of light that one left, must find nothing here. Else its work
    /// would depend on what the same thread did before.
    pub fn forget(&mut self) {
        self.owner = None;
        self.store.forget();
        self.borders.forget();
    }

    fn belong_to(&mut self, signature: Signature) {
        if self.owner != Some(signature) {
            self.forget();
            self.owner = Some(signature);
        }
    }
}

/// Memory \[bytes\] to work in, once both stores hold paths with their legs, and of the light that is left.
pub const fn scratch_bytes<const N: usize>(events: usize) -> usize {
    2 * PathStore::<N>::bytes(events) + LEFT_BYTES
}

/// Refiner of cells of one source's light, for one signature.
pub struct Refiner<'a, const N: usize> {
    pub(super) paths: NodeFinder<'a, N>,
    pub(super) film: &'a BeamFilm<N>,
    pub(super) scratch: Scratch<N>,
    /// Memory that it takes for as long as it works.
    lent: &'a RefCell<Scratch<N>>,
    signature: Signature,
    pub(super) clearance: &'a Clearance<'a>,
    pub(super) limit: &'a Limit<'a>,
    /// Number of cells and polygons so far.
    places: u64,
    /// Work that the limit knows of \[rays\].
    pub(super) spent: u64,
    pub(super) stopped: bool,
    /// The cone, for a spot.
    pub(super) cone: Option<Cone>,
    /// The limits of the division.
    limits: Limits,
    /// Misplaced flux \[W\] that a cell may have: the tolerance, as far as it makes sense.
    tolerance: f64,
    /// The light that it left to others.
    left: Vec<LeftLight<N>>,
    /// Most pieces that it may leave.
    most_left: usize,
    /// The balance so far.
    pub balance: Balance<N>,
}

/// A piece of light that is left to another refiner.
pub enum LeftLight<const N: usize> {
    /// A large cell.
    Cell(SurfaceChart, Box<BeamCell<N>>),
    /// Some patches of one chart, by their corners.
    Patches(SurfaceChart, Vec<[DVec2; 3]>),
}

/// A cell ready for the film.
pub(super) struct Finished<const N: usize> {
    pub(super) look: CellSummary<N>,
    /// True for quarters that could not be cut.
    pub(super) failed: [bool; 4],
    /// Uncertain flux \[W\], which may be anywhere near the nodes' landings.
    pub(super) uncertain: Flux<N>,
    pub(super) is_cut: bool,
}

impl<const N: usize> Finished<N> {
    /// A cell that need not be cut.
    pub(super) fn uncut(look: CellSummary<N>) -> Self {
        Self {
            look,
            failed: [false; 4],
            uncertain: Flux::BLACK,
            is_cut: false,
        }
    }
}

impl<'a, const N: usize> Refiner<'a, N> {
    /// A refiner without any cell.
    pub fn new(
        follower: PathFollower<'a, N>,
        shared: &'a SharedPlaces<'a>,
        film: &'a BeamFilm<N>,
        clearance: &'a Clearance<'a>,
        limit: &'a Limit<'a>,
        (signature, limits): Asked,
        lent: &'a RefCell<Scratch<N>>,
    ) -> Self {
        Self {
            cone: Cone::of(follower.source()),
            paths: NodeFinder::new(follower, shared),
            film,
            clearance,
            limit,
            places: 0,
            spent: 0,
            stopped: false,
            // Nothing is allocated.
            scratch: Scratch::new(0),
            lent,
            signature,
            tolerance: limits.tolerance.min(limits.most()),
            limits,
            left: Vec::new(),
            most_left: 0,
            balance: Balance::default(),
        }
    }

    /// Lets it leave so many pieces of light to others, where one thread would take long. What it leaves
    /// depends on the patches alone.
    #[must_use]
    pub fn leaving(mut self, most: usize) -> Self {
        self.most_left = most;
        self
    }

    /// The light that it left since it was taken last.
    pub fn take_left(&mut self) -> Vec<LeftLight<N>> {
        std::mem::take(&mut self.left)
    }

    /// The signature.
    pub fn signature(&self) -> Signature {
        self.signature
    }

    /// The limits of its division.
    pub fn limits(&self) -> &Limits {
        &self.limits
    }

    /// Number of cells and polygons so far.
    pub fn places(&self) -> u64 {
        self.places
    }

    /// The work done so far.
    pub fn counters(&self) -> TraversalCounters {
        self.paths.follower.counters
    }

    /// The same, to be added to.
    pub fn counters_mut(&mut self) -> &mut TraversalCounters {
        &mut self.paths.follower.counters
    }

    /// The film.
    pub fn film(&self) -> &'a BeamFilm<N> {
        self.film
    }

    /// True if work was stopped before it was done: then nothing here is valid.
    pub fn was_stopped(&self) -> bool {
        self.stopped
    }

    /// Tells the limit of the work since it was told last.
    pub fn tell_limit(&mut self) {
        let work = self.limit.work(self.counters().rays, self.places);
        self.limit.spend(work - self.spent);
        self.spent = work;
    }

    /// True if work may go on, by a question to the limit now and then. Called once for each cell or polygon.
    pub fn may_go_on(&mut self) -> bool {
        self.places += 1;
        if self.places.is_multiple_of(PATIENCE) {
            self.tell_limit();
            self.stopped |= self.limit.is_reached();
        }
        !self.stopped
    }

    /// Divides a patch until all its light is placed, but for that of cells that it leaves.
    pub fn refine(&mut self, patch: &SurfacePatch) {
        self.with_scratch(|refiner| {
            let whole = refiner.whole(patch);
            refiner.divide(&patch.chart, whole);
        });
    }

    /// Divides a patch until all its light is placed.
    pub fn refine_all(&mut self, patch: &SurfacePatch) {
        let most = std::mem::take(&mut self.most_left);
        self.refine(patch);
        self.most_left = most;
    }

    /// Leaves a patch to others, or divides it if it may leave no more.
    pub fn leave(&mut self, SurfacePatch { chart, corners }: SurfacePatch) {
        let has_room = self.left.len() < self.most_left;
        match self.left.last_mut() {
            Some(LeftLight::Patches(of, patches))
                if patches.len() < LEFT_TOGETHER && of.is_that_of(&chart) =>
            {
                patches.push(corners);
            }
            _ if has_room => self.left.push(LeftLight::Patches(chart, vec![corners])),
            _ => self.refine(&SurfacePatch { chart, corners }),
        }
    }

    /// Goes on with light that another refiner of the same source and signature left.
    pub fn refine_left(&mut self, left: LeftLight<N>) {
        match left {
            LeftLight::Cell(chart, cell) => {
                self.with_scratch(|refiner| refiner.divide(&chart, *cell));
            }
            LeftLight::Patches(chart, patches) => {
                for corners in patches {
                    self.refine(&SurfacePatch { chart, corners });
                }
            }
        }
    }

    /// Works with the lent memory.
    pub(super) fn with_scratch<T>(&mut self, work: impl FnOnce(&mut Self) -> T) -> T {
        let lent = self.lent;
        std::mem::swap(&mut self.scratch, &mut lent.borrow_mut());
        self.scratch.belong_to(self.signature);
        let done = work(self);
        std::mem::swap(&mut self.scratch, &mut lent.borrow_mut());
        done
    }

    fn divide(&mut self, chart: &SurfaceChart, whole: BeamCell<N>) {
        self.scratch.pending.clear();
        self.scratch.pending.push(whole);
        let mut cells = 0_u64;
        while self.may_go_on()
            && let Some(mut cell) = self.scratch.pending.pop()
        {
            cells += 1;
            if cells.is_multiple_of(BEFORE_LEAVING) {
                self.leave_largest(chart, cell.level);
            }
            let middles = self.middles(chart, &cell);
            if let Some(quarters) = self.place_or_divide(chart, &mut cell, &middles) {
                self.scratch.pending.extend(quarters);
            }
        }
    }

    /// Leaves the largest cells that wait to others, if they are much larger than the one at hand.
    fn leave_largest(&mut self, chart: &SurfaceChart, level: u32) {
        let pending = &mut self.scratch.pending;
        // A cell's quarters go on top: the largest are at the bottom.
        let Some(lowest) = pending.first().map(|cell| cell.level) else {
            return;
        };
        if level >= lowest + LEAST_LEFT && self.left.len() < self.most_left {
            let count = pending.partition_point(|cell| cell.level == lowest);
            let largest = pending.drain(..count);
            self.left
                .extend(largest.map(|cell| LeftLight::Cell(*chart, Box::new(cell))));
        }
    }

    /// The cell that is all of a patch.
    pub(super) fn whole(&mut self, patch: &SurfacePatch) -> BeamCell<N> {
        let corners = patch
            .corners
            .map(|at| self.stored(&patch.chart, at, CellClearance::default()));
        BeamCell::of_patch(corners)
    }

    /// The nodes at the middles of a cell's edges.
    pub(super) fn middles(&mut self, chart: &SurfaceChart, cell: &BeamCell<N>) -> [BeamNode<N>; 3] {
        cell.middles()
            .map(|at| self.stored(chart, at, cell.clearance))
    }

    /// Puts a cell's light on the film; its quarters if it must be divided.
    pub(super) fn place_or_divide(
        &mut self,
        chart: &SurfaceChart,
        cell: &mut BeamCell<N>,
        middles: &[BeamNode<N>; 3],
    ) -> Option<[BeamCell<N>; 4]> {
        let look = CellSummary::at(&cell.corners, middles);
        if self.is_ready(chart, cell, middles, &look)
            && let Some(finished) = self.finished(chart, cell, middles, look)
        {
            self.finish(cell, middles, &finished);
            return None;
        }
        let noted_bend = self.noted_bend(cell, &look);
        Some(cell.quarters(middles, noted_bend, look.bend))
    }

    /// True if a cell's nodes stand for all of it.
    fn is_ready(
        &mut self,
        chart: &SurfaceChart,
        cell: &mut BeamCell<N>,
        middles: &[BeamNode<N>; 3],
        look: &CellSummary<N>,
    ) -> bool {
        if look.emitted == 0.0 {
            return cell.level >= MAX_LEVEL || !self.may_hide_light(chart, cell);
        }
        let area = cell.area();
        let set_out = self.may_deliver(area, look);
        let flux = if look.is_one_topology() {
            f64::max(
                area * look.weight.max_magnitude(),
                if look.any_landed { 0.0 } else { set_out },
            )
        } else {
            set_out
        };
        if cell.level >= MAX_LEVEL || flux <= self.limits.uncleared() {
            return true;
        }
        // Light may get through at an angle that no node came at: the clearance knows of surfaces only.
        let may_get_through = look.any_turned_back && !look.any_landed;
        if !look.is_one_topology()
            || may_get_through
            || look.any_landed
                && flux > self.tolerance_of(look) * MOST_TOLERANCES
                && !(cell.level >= LEAST_LEVEL_OFF && look.is_far_off(self.film.size()))
        {
            return false;
        }
        if !cell.clearance.all {
            let Scratch { store, trails, .. } = &mut self.scratch;
            let in_sight = cell.clearance.is_in_sight();
            for (node, trail) in nodes(cell, middles).iter().zip(&mut *trails) {
                self.paths.trail(store, chart, node.at, in_sight, trail);
            }
            let follower = &mut self.paths.follower;
            cell.clearance = self
                .clearance
                .clear(follower, chart, trails, cell.clearance);
        }
        cell.clearance.all
    }

    /// Misplaced flux \[W\] that a cell may have: of n texels, light that is misplaced by chance has √n times
    /// less effect on each.
    fn tolerance_of(&self, look: &CellSummary<N>) -> f64 {
        (self.tolerance * look.texels(self.film.size()).sqrt()).min(self.limits.most())
    }

    /// Flux \[W\] that a cell of this area may deliver although no node of it landed. It is twice the part,
    /// of all that sets out, that the best path of the discovery delivered.
    fn may_deliver(&self, area: f64, look: &CellSummary<N>) -> f64 {
        area * look.emitted * (2.0 * self.limits.peak).min(1.0)
    }

    /// True if a spot may shine on a part of a cell, none of whose nodes is lit.
    fn may_hide_light(&self, chart: &SurfaceChart, cell: &BeamCell<N>) -> bool {
        self.cone.is_some_and(|cone| {
            let corners = cell.corners.map(|node| node.at);
            let overlap = cone.overlap(self.paths.follower.scene().world(), chart, corners);
            overlap.is_possible && overlap.relative_size > LEAST_IN_CONE
        })
    }

    /// The node at coordinates of a chart, in a cell with legs `known` to be clear.
    #[inline]
    fn stored(&mut self, chart: &SurfaceChart, at: DVec2, known: CellClearance) -> BeamNode<N> {
        let store = &mut self.scratch.store;
        self.paths
            .node(store, chart, at, known.is_in_sight(), !known.all)
    }

    /// The cell ready for the film; `None` if it must be divided.
    fn finished(
        &mut self,
        chart: &SurfaceChart,
        cell: &BeamCell<N>,
        middles: &[BeamNode<N>; 3],
        look: CellSummary<N>,
    ) -> Option<Finished<N>> {
        let area = cell.area();
        let is_last = cell.level >= MAX_LEVEL || area * look.emitted == 0.0;
        let mut finished = Finished::uncut(look);
        self.scratch.fine.clear();
        self.scratch.coarse.clear();
        if !look.any_landed {
            let is_dark = is_last
                || look.is_one_topology()
                || self.may_deliver(area, &look) <= self.limits.uncleared() * LEAST_SLIVER
                || !self.may_hide_sliver(chart, cell, middles);
            return is_dark.then_some(finished);
        }
        if look.is_off(self.film.size())
            && (look.is_one_topology() || self.lands_beside(chart, cell, middles, &look))
        {
            return Some(finished);
        }
        let flux = area * look.weight.max_magnitude();
        if look.is_one_topology() {
            let tolerance = self.tolerance_of(&look);
            let is_misplaced = area * misplaced(&look) > tolerance;
            // No cell round a patch tells if kinks hide its bend.
            let is_unseen = look.is_kinked && cell.level == 0 && flux > tolerance;
            if !is_last && (is_misplaced || is_unseen || self.may_hide_valley(cell, area, &look)) {
                return None;
            }
            for corners in cell.quarter_corners(middles) {
                self.scratch.fine.extend(cut::whole(corners));
            }
            self.scratch.coarse.extend(cut::whole(cell.corners));
            return Some(finished);
        }
        let in_question = flux > self.tolerance_of(&look) * CUT_TOLERANCES;
        // Three topologies meet at a point: cells round it are divided, not cut.
        let is_corner = look.topologies > 2 && flux > self.tolerance;
        if !is_last && (in_question || is_corner) {
            return None;
        }
        self.cut(chart, cell, middles, &mut finished);
        // The nodes on both sides of a border do not show how the light bends: the film does.
        let levels = Levels {
            fine: &self.scratch.fine,
            coarse: &self.scratch.coarse,
            coarser: None,
        };
        let moved = self
            .scratch
            .block
            .gather(self.film, &levels, &Coarse::NONE, 0.0);
        // Three parts. The first is flux that came and went across the border. The second is flux that
        // halving the cell moved from texel to texel: all of it, for a cell too large to tell. The third is
        // flux that a corner of the border may hide.
        let moved = if flux > 0.0 { moved / flux } else { 0.0 };
        finished.uncertain = finished.uncertain * 2.0 + look.weight * (area * (moved + CORNER));
        // It may be on any texel of its boxes: bounds widen on all of them.
        let nodes = nodes(cell, middles);
        let boxes = uncertain_boxes(self.film.size(), &nodes, &self.scratch.fine);
        let texels: f64 = boxes.map(|[first, last]| texels_of(first, last)).sum();
        let widened = finished.uncertain.max_magnitude() * texels.sqrt();
        (is_last || widened <= self.tolerance).then_some(finished)
    }

    /// Distance of a cell's weights from a plane, if its quarters must show that they are smooth; else 0.
    fn noted_bend(&self, cell: &BeamCell<N>, look: &CellSummary<N>) -> f64 {
        let is_noted = look.weight_bend > NOTED_BEND * look.weight.max_magnitude()
            && 0.25 * cell.area() * look.weight_bend > LEAST_BENT * self.tolerance_of(look);
        if is_noted { look.weight_bend } else { 0.0 }
    }

    /// True if a cell's light may be weaker or stronger between its nodes than they show, by more than its
    /// bounds. Its weights are still far off a plane, or on one by chance.
    fn may_hide_valley(&self, cell: &BeamCell<N>, area: f64, look: &CellSummary<N>) -> bool {
        let is_still_bent = look.weight_bend > STILL_BENT * look.weight.max_magnitude()
            && area * look.weight_bend > LEAST_BENT * self.tolerance_of(look);
        let is_by_chance = look.weight_bend < BY_CHANCE * cell.noted_bend;
        is_still_bent || is_by_chance
    }

    fn finish(&mut self, cell: &BeamCell<N>, middles: &[BeamNode<N>; 3], finished: &Finished<N>) {
        let balance = &mut self.balance;
        let look = &finished.look;
        let area = cell.area();
        balance.cells += 1;
        balance.emitted += area * middles.iter().map(|node| node.emitted).sum::<f64>() / 3.0;
        if self.scratch.fine.is_empty() && !finished.is_cut {
            return;
        }
        let levels = Levels {
            fine: &self.scratch.fine,
            coarse: &self.scratch.coarse,
            coarser: if finished.is_cut {
                None
            } else {
                cell.coarser.as_ref()
            },
        };
        let flux = area * look.weight.max_magnitude();
        let is_faint = flux <= FAINT * self.tolerance * look.texels(self.film.size()).sqrt();
        let coarse = if is_faint {
            Coarse {
                coarsest: self.film.coarsest(),
                // The quadratic map is that of one topology.
                density: if finished.is_cut {
                    1.0
                } else {
                    most_density(cell, middles)
                },
            }
        } else {
            Coarse::NONE
        };
        let hidden = hidden_part(cell, look);
        self.scratch
            .block
            .gather(self.film, &levels, &coarse, hidden);
        balance.received += self.scratch.block.deposit(self.film);
        if finished.is_cut {
            balance.cut_cells += 1;
            let quarters = cell.quarter_corners(middles);
            for (corners, failed) in quarters.iter().zip(finished.failed) {
                if failed {
                    balance.received += deposit_points(self.film, corners, 0.25 * area);
                }
            }
            balance.unresolved_cells += u64::from(finished.failed != [false; 4]);
            balance.uncertain += finished.uncertain;
            let nodes = nodes(cell, middles);
            deposit_uncertain(self.film, &nodes, &self.scratch.fine, finished.uncertain);
        }
    }
}

/// Part of a cell's light that may be in wrong texels although no change shows it.
///
/// Halving an arc leaves a quarter of its bend. A kink far from the middle of an edge stays where it is, and
/// the middle may hardly show it. So if there are kinks, quarters may be off by all that the cell's nodes
/// show, and by half of what those of the cell round it showed.
fn hidden_part<const N: usize>(cell: &BeamCell<N>, look: &CellSummary<N>) -> f64 {
    if look.is_kinked {
        HIDDEN_BY_KINKS * misplaced_by(look.bend.max(LEFT_OF_KINK * cell.outer_bend), look)
    } else {
        HIDDEN * misplaced_by(look.bend, look)
    }
}

fn nodes<const N: usize>(cell: &BeamCell<N>, middles: &[BeamNode<N>; 3]) -> [BeamNode<N>; 6] {
    let [a, b, c] = cell.corners;
    let [d, e, f] = *middles;
    [a, b, c, d, e, f]
}

/// Largest part of a cell's flux that an affine map may put into wrong texels, for a unit of area.
///
/// A bend of δ texels moves light across the texel lines that its image meets: a part of about δ. It is less
/// if the image is large, as most of its light is far from any line.
pub(in crate::reference::beams) fn misplaced<const N: usize>(look: &CellSummary<N>) -> f64 {
    look.weight.max_magnitude() * misplaced_by(look.bend, look) + look.weight_bend
}

/// Part of a cell's light that a bend \[texels\] moves across texel lines.
fn misplaced_by<const N: usize>(bend: f64, look: &CellSummary<N>) -> f64 {
    let height = (look.high - look.low).min_element();
    (bend / (1.0 + 0.25 * height)).min(1.0)
}
