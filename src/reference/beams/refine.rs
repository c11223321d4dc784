//! Dividing cells until their light is placed well enough.

use glam::DVec2;

use super::cell::{Cell, Look, Node, Smooth, look};
use super::deposit::{Patch, deposit_mixed, deposit_smooth};
use super::film::BeamFilm;
use crate::transport::first_surface::{Chart, Root};
use crate::transport::flux::Flux;
use crate::transport::prescribed::{PathEnd, PathFollower};

/// No cell is divided more often: a quarter of a billionth of a root's side.
const MAX_LEVEL: u32 = 32;

/// Cells without any landed node are divided down to this many tolerances.
const DARK_TOLERANCES: f64 = 64.0;

/// Where the light of the cells went \[W\].
#[derive(Clone, Copy, Debug)]
pub struct Balance<const N: usize> {
    /// Light that set out towards the cells' surface, all signatures together, mean channel.
    pub emitted: f64,
    /// On the film.
    pub received: Flux<N>,
    /// Landed beyond the film's border.
    pub outside: Flux<N>,
    /// In mixed cells.
    pub mixed: Flux<N>,
    /// Cells finished.
    pub cells: u64,
    /// ... of them mixed.
    pub mixed_cells: u64,
}

/// A small store of paths by chart coordinates, for one chart: neighbours share their edges'
/// middles. What it holds is what following the path would give, so forgetting costs time only.
pub struct PathStore<const N: usize> {
    entries: Vec<(DVec2, u32, PathEnd<N>)>,
    generation: u32,
}

const STORE: usize = 1 << 12;

/// Divides cells of one source's light, for one signature.
pub struct Refiner<'a, 'f, const N: usize> {
    follower: &'f mut PathFollower<'a, N>,
    film: &'f BeamFilm<N>,
    /// Misplaced flux that a cell may have \[W\].
    tolerance: f64,
    pending: Vec<Cell<N>>,
    patch: Patch<N>,
    /// What was found so far.
    pub balance: Balance<N>,
}

impl<'a, 'f, const N: usize> Refiner<'a, 'f, N> {
    /// A refiner without any cell.
    pub fn new(
        follower: &'f mut PathFollower<'a, N>,
        film: &'f BeamFilm<N>,
        tolerance: f64,
    ) -> Self {
        Self {
            follower,
            film,
            tolerance,
            pending: Vec::new(),
            patch: Patch::new(),
            balance: Balance {
                emitted: 0.0,
                received: Flux::BLACK,
                outside: Flux::BLACK,
                mixed: Flux::BLACK,
                cells: 0,
                mixed_cells: 0,
            },
        }
    }

    fn node(&mut self, chart: &Chart, at: DVec2) -> Node<N> {
        Node {
            at,
            path: self.follower.follow(chart, at, false),
        }
    }

    /// Divides a root until all its light is placed.
    pub fn refine(&mut self, root: &Root) {
        let corners = root.corners.map(|at| self.node(&root.chart, at));
        self.pending.push(Cell { corners, level: 0 });
        while let Some(cell) = self.pending.pop() {
            let middles = cell.middles().map(|at| self.node(&root.chart, at));
            let seen = look(&cell, &middles);
            if self.is_coarse(&cell, &middles, &seen) {
                self.pending.extend(cell.quarters(&middles));
            } else {
                self.finish(&cell, &middles, &seen);
            }
        }
    }

    fn is_coarse(&self, cell: &Cell<N>, middles: &[Node<N>; 3], seen: &Look) -> bool {
        if cell.level >= MAX_LEVEL {
            return false;
        }
        let nodes = cell.corners.iter().chain(middles);
        let area = cell.area();
        match seen {
            Look::Dark => false,
            Look::Smooth(smooth) => {
                if self.is_off_film(smooth) {
                    return false;
                }
                let weight = nodes
                    .map(|node| node.path.weight.max_magnitude())
                    .sum::<f64>()
                    / 6.0;
                area * misplaced(smooth, weight) > self.tolerance
            }
            Look::Mixed => {
                let weight = nodes
                    .clone()
                    .map(|node| node.path.weight.max_magnitude())
                    .fold(0.0, f64::max);
                if weight > 0.0 {
                    area * weight > self.tolerance
                } else {
                    let emitted = nodes.map(|node| node.path.emitted).fold(0.0, f64::max);
                    area * emitted > self.tolerance * DARK_TOLERANCES
                }
            }
        }
    }

    fn is_off_film(&self, smooth: &Smooth) -> bool {
        let [columns, rows] = self.film.size();
        let margin = 2.0 * smooth.bend;
        let end = DVec2::new(columns as f64, rows as f64);
        (smooth.high + margin).cmplt(DVec2::ZERO).any() || (smooth.low - margin).cmpgt(end).any()
    }

    fn finish(&mut self, cell: &Cell<N>, middles: &[Node<N>; 3], seen: &Look) {
        let balance = &mut self.balance;
        balance.cells += 1;
        balance.emitted += cell.area()
            * middles
                .iter()
                .map(|node| node.path.emitted)
                .sum::<f64>()
            / 3.0;
        match seen {
            Look::Dark => {}
            Look::Smooth(smooth) => {
                if !self.is_off_film(smooth) {
                    let received =
                        deposit_smooth(self.film, &mut self.patch, cell, middles, smooth);
                    self.balance.received += received;
                }
            }
            Look::Mixed => {
                self.balance.mixed_cells += 1;
                let received = deposit_mixed(self.film, cell, middles);
                self.balance.received += received;
                self.balance.mixed += received;
            }
        }
    }
}

/// The part of a cell's flux that an affine map may put into wrong texels, for a unit of area.
///
/// A bend of δ texels moves light across the texel lines that its image meets: a part of about δ,
/// less where the image is large and most of its light is far from any line.
pub(super) fn misplaced(smooth: &Smooth, weight: f64) -> f64 {
    let height = (smooth.high - smooth.low).min_element();
    weight * (smooth.bend / (1.0 + 0.25 * height)).min(1.0) + smooth.weight_bend
}
