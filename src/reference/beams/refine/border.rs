//! Cells that a border between topologies crosses.

use super::refiner::{Finished, Refiner, Scratch};
use crate::reference::beams::cell::{BeamCell, BeamNode, CellSummary};
use crate::reference::beams::cut::{self, CUT_ERROR, CutPiece};
use crate::reference::beams::deposit::{box_round, image_of};
use crate::transport::first_surface::SurfaceChart;

impl<const N: usize> Refiner<'_, N> {
    /// True if a cell may hide light that lands although none of its nodes did: such light is found between
    /// two nodes of different topologies. For example, on the two sides of a border light may have one
    /// reflection less and one more than a sliver between them.
    pub(super) fn may_hide_sliver(
        &mut self,
        chart: &SurfaceChart,
        cell: &BeamCell<N>,
        middles: &[BeamNode<N>; 3],
    ) -> bool {
        let Self {
            paths,
            scratch: Scratch { borders, .. },
            ..
        } = self;
        let in_sight = cell.clearance.is_in_sight();
        let mut follow = |at| paths.node(borders, chart, at, in_sight, false);
        let [a, b, c] = &cell.corners;
        let [bc, ca, ab] = middles;
        [[a, ab], [ab, b], [b, bc], [bc, c], [c, ca], [ca, a]]
            .iter()
            .any(|[from, to]| cut::lands_between(from, to, &mut follow))
    }

    /// True if no light of a cell that holds more than one topology lands on the film, given that none of its
    /// nodes does. Perhaps only one node landed, which does not show how far light reaches up to the border:
    /// the cut does.
    pub(super) fn lands_beside(
        &mut self,
        chart: &SurfaceChart,
        cell: &BeamCell<N>,
        middles: &[BeamNode<N>; 3],
        look: &CellSummary<N>,
    ) -> bool {
        let mut cut = Finished::uncut(*look);
        self.cut(chart, cell, middles, &mut cut);
        let Scratch { fine, coarse, .. } = &mut self.scratch;
        let [low, high] = box_round(fine.iter().flat_map(image_of).chain([look.low, look.high]));
        fine.clear();
        coarse.clear();
        CellSummary { low, high, ..*look }.is_off(self.film.size())
    }

    /// Cuts a cell that holds more than one topology, at both finenesses.
    pub(super) fn cut(
        &mut self,
        chart: &SurfaceChart,
        cell: &BeamCell<N>,
        middles: &[BeamNode<N>; 3],
        finished: &mut Finished<N>,
    ) {
        finished.is_cut = true;
        let Self {
            paths,
            scratch:
                Scratch {
                    fine,
                    coarse,
                    borders,
                    ..
                },
            ..
        } = self;
        let area = cell.area();
        let in_sight = cell.clearance.is_in_sight();
        let mut follow = |at| paths.node(borders, chart, at, in_sight, false);
        let mut unresolved = 0.0;
        let quarters = cell.quarter_corners(middles);
        for (corners, failed) in quarters.iter().zip(&mut finished.failed) {
            if let Some(pieces) = cut::cut(corners, &mut follow) {
                fine.extend(pieces.iter());
            } else {
                *failed = true;
                unresolved += 0.25 * area;
            }
        }
        let flux = |pieces: &mut dyn Iterator<Item = &CutPiece<N>>| -> f64 {
            pieces.map(|piece| piece.area * mean_weight(piece)).sum()
        };
        let fine_flux = flux(&mut fine.iter());
        let largest = finished.look.weight.max_magnitude();
        let bent = if unresolved > 0.0 {
            largest * unresolved
        } else if let Some(pieces) = cut::cut(&cell.corners, &mut follow) {
            coarse.extend(pieces.iter());
            let coarse_flux = flux(&mut coarse.iter());
            (fine_flux - coarse_flux).abs() + CUT_ERROR * largest * area
        } else {
            // No coarse answer to compare with: half of the cell may be on the wrong side.
            0.5 * (largest * area)
        };
        if coarse.is_empty() {
            // Nothing to extrapolate from: the fine pieces stand for both.
            coarse.extend_from_slice(fine);
        }
        if largest > 0.0 {
            finished.uncertain = finished.look.weight * (bent / largest);
        }
    }
}

fn mean_weight<const N: usize>(piece: &CutPiece<N>) -> f64 {
    let [a, b, c] = piece.corners.each_ref().map(|node| node.weight);
    (a + b + c).max_magnitude() / 3.0
}
