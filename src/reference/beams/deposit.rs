//! Deposits of finished cells on texels.

use glam::DVec2;

use super::cell::BeamNode;
use super::cut::CutPiece;
use super::film::{BeamFilm, TexelSums};
use crate::film::coverage::{TrianglePart, deal};
use crate::transport::flux::Flux;

/// Sums of the few texels that a cell touches, gathered before they go to the film: a cell's five triangles
/// share most of their texels.
pub struct TexelBlock<const N: usize> {
    origin: [usize; 2],
    size: [usize; 2],
    sums: Vec<TexelSums<N>>,
}

/// Most texels a side of a block; larger images go to the film directly.
const BLOCK: usize = 24;

impl<const N: usize> Default for TexelBlock<N> {
    /// An empty block.
    fn default() -> Self {
        Self {
            origin: [0; 2],
            size: [0; 2],
            sums: vec![TexelSums::default(); BLOCK * BLOCK],
        }
    }
}

impl<const N: usize> TexelBlock<N> {
    /// Covers the texels of a box; `false` if they are too many, or the box is empty.
    fn cover(&mut self, low: DVec2, high: DVec2, film: [usize; 2]) -> bool {
        if !low.cmple(high).all() {
            return false;
        }
        for axis in 0..2 {
            let last = film[axis] as f64 - 1.0;
            let from = low[axis].floor().clamp(0.0, last) as usize;
            let to = high[axis].floor().clamp(0.0, last) as usize;
            self.origin[axis] = from;
            self.size[axis] = to - from + 1;
        }
        let fits = self.size[0].max(self.size[1]) <= BLOCK;
        if fits {
            self.sums[..self.size[0] * self.size[1]].fill(TexelSums::default());
        }
        fits
    }

    #[inline]
    fn at(&mut self, [column, row]: [usize; 2]) -> &mut TexelSums<N> {
        let (x, y) = (column - self.origin[0], row - self.origin[1]);
        &mut self.sums[y * self.size[0] + x]
    }

    fn covered(&self) -> &[TexelSums<N>] {
        &self.sums[..self.size[0] * self.size[1]]
    }
}

/// A finished cell's light at two finenesses.
pub struct Levels<'a, const N: usize> {
    /// Pieces of its quarters: B.
    pub fine: &'a [CutPiece<N>],
    /// Pieces of the cell itself: A.
    pub coarse: &'a [CutPiece<N>],
}

/// Flux of a part of a triangle, whose weight is linear between the corners.
#[inline]
pub(super) fn flux_of<const N: usize>(piece: &CutPiece<N>, part: &TrianglePart) -> Flux<N> {
    let [a, b, c] = piece.corners.each_ref().map(|node| node.weight);
    (a * part.share + (b - a) * part.moment.x + (c - a) * part.moment.y) * piece.area
}

#[inline]
pub(super) fn image_of<const N: usize>(piece: &CutPiece<N>) -> [DVec2; 3] {
    // Pieces are made of landed nodes only.
    piece
        .corners
        .each_ref()
        .map(|node| node.landing.unwrap_or(DVec2::NAN))
}

impl<const N: usize> Levels<'_, N> {
    /// Deals out (4B − A)/3, with B the quarters as affine triangles, and A the cell itself as one.
    ///
    /// The error of affine cells is of second order in their size, so that halving them leaves a quarter of
    /// it. Richardson's extrapolation removes it texel by texel.
    ///
    /// `bend` is the distance, in texels, of the cell's light from A.
    fn deal_out(
        &self,
        size: [usize; 2],
        bend: f64,
        mut add: impl FnMut([usize; 2], &TexelSums<N>),
    ) {
        // Halving an arc leaves a quarter of its distance from the chord.
        let fine_bend = 0.25 * bend;
        for piece in self.fine {
            let image = image_of(piece);
            let near_lines =
                flux_of(piece, &TrianglePart::WHOLE) * part_near_lines(&image, fine_bend);
            deal(image, size, |texel, part| {
                let flux = flux_of(piece, &part);
                let sums = TexelSums {
                    flux: flux * (4.0 / 3.0),
                    difference: flux,
                    near_lines,
                };
                add(texel, &sums);
            });
        }
        for piece in self.coarse {
            deal(image_of(piece), size, |texel, part| {
                let flux = flux_of(piece, &part);
                let sums = TexelSums {
                    flux: flux * (-1.0 / 3.0),
                    difference: flux * -1.0,
                    ..TexelSums::default()
                };
                add(texel, &sums);
            });
        }
    }

    /// The box round all landings.
    fn bounds(&self) -> (DVec2, DVec2) {
        let mut low = DVec2::INFINITY;
        let mut high = DVec2::NEG_INFINITY;
        for at in self.fine.iter().chain(self.coarse).flat_map(image_of) {
            (low, high) = (low.min(at), high.max(at));
        }
        (low, high)
    }
}

impl<const N: usize> TexelBlock<N> {
    /// Gathers a cell. Returns the flux \[W\] that halving it moved from texel to texel, the worst channel;
    /// `None` if the cell is too large to be gathered.
    pub fn gather(&mut self, size: [usize; 2], levels: &Levels<N>, bend: f64) -> Option<f64> {
        let (low, high) = levels.bounds();
        if !self.cover(low, high, size) {
            return None;
        }
        levels.deal_out(size, bend, |texel, sums| *self.at(texel) += *sums);
        let mut moved = Flux::<N>::BLACK;
        for sums in self.covered() {
            moved += Flux(sums.difference.0.map(f64::abs));
        }
        Some(0.5 * moved.max_magnitude())
    }

    /// Puts a cell on the film. Returns the flux \[W\] that the film received.
    pub fn deposit(&mut self, film: &BeamFilm<N>, levels: &Levels<N>, bend: f64) -> Flux<N> {
        let mut received = Flux::BLACK;
        let (low, high) = levels.bounds();
        if self.cover(low, high, film.size()) {
            levels.deal_out(film.size(), bend, |texel, sums| *self.at(texel) += *sums);
            for (index, sums) in self.covered().iter().enumerate() {
                let (x, y) = (index % self.size[0], index / self.size[0]);
                film.add([self.origin[0] + x, self.origin[1] + y], sums);
                received += sums.flux;
            }
        } else {
            levels.deal_out(film.size(), bend, |texel, sums| {
                film.add(texel, sums);
                received += sums.flux;
            });
        }
        received
    }
}

/// The part of a triangle's light that is within `bend` of a texel line that its image crosses.
#[inline]
fn part_near_lines(image: &[DVec2; 3], bend: f64) -> f64 {
    let low = image[0].min(image[1]).min(image[2]);
    let high = image[0].max(image[1]).max(image[2]);
    let crossed = high.floor().cmpgt(low.floor());
    // In a triangle as wide as w, about 2 bend / w is within `bend` of a line.
    let near = |axis: usize| {
        if crossed.test(axis) {
            (2.0 * bend / (high[axis] - low[axis])).min(1.0)
        } else {
            0.0
        }
    };
    (near(0) + near(1)).min(1.0)
}

/// Puts a triangle of more than one topology on the film: a third of its flux as a point at each landed
/// corner. Returns the flux \[W\] that the film received.
pub fn deposit_points<const N: usize>(
    film: &BeamFilm<N>,
    corners: &[BeamNode<N>; 3],
    area: f64,
) -> Flux<N> {
    let size = film.size();
    let end = DVec2::new(size[0] as f64, size[1] as f64);
    let mut received = Flux::BLACK;
    for node in corners {
        if let Some(at) = node.landing
            && at.cmpge(DVec2::ZERO).all()
            && at.cmplt(end).all()
        {
            let flux = node.weight * (area / 3.0);
            received += flux;
            let sums = TexelSums {
                flux,
                ..TexelSums::default()
            };
            film.add([at.x as usize, at.y as usize], &sums);
        }
    }
    received
}

/// Marks `flux` as uncertain in each texel of a cut cell's [boxes](uncertain_boxes): it may be there, or not.
pub fn deposit_uncertain<const N: usize>(
    film: &BeamFilm<N>,
    nodes: &[BeamNode<N>; 6],
    pieces: &[CutPiece<N>],
    flux: Flux<N>,
) {
    for [first, last] in uncertain_boxes(film.size(), nodes, pieces) {
        film.add_uncertain(first, last, flux);
    }
}

/// The first and last texel of the boxes on the film that may hold light of a cell which its nodes do not
/// show. For each topology it is the box round its nodes and round its `pieces`, and as far again on all
/// sides. The pieces reach up to the border even if only one node landed.
pub fn uncertain_boxes<const N: usize>(
    size: [usize; 2],
    nodes: &[BeamNode<N>; 6],
    pieces: &[CutPiece<N>],
) -> impl Iterator<Item = [[usize; 2]; 2]> {
    let end = DVec2::new(size[0] as f64, size[1] as f64) - 1.0;
    nodes.iter().enumerate().filter_map(move |(index, node)| {
        let is_new = nodes[..index]
            .iter()
            .all(|one| one.topology != node.topology);
        if node.landing.is_none() || !is_new {
            return None;
        }
        let mut low = DVec2::INFINITY;
        let mut high = DVec2::NEG_INFINITY;
        for at in nodes
            .iter()
            .chain(pieces.iter().flat_map(|piece| &piece.corners))
            .filter(|one| one.topology == node.topology)
            .filter_map(|one| one.landing)
        {
            low = low.min(at);
            high = high.max(at);
        }
        let margin = high - low;
        let low = (low - margin).floor().max(DVec2::ZERO);
        let high = (high + margin).floor().min(end);
        let texel = |at: DVec2| [at.x as usize, at.y as usize];
        low.cmple(high).all().then(|| [texel(low), texel(high)])
    })
}

/// Number of texels of a box, first and last column and row included.
pub fn texels_of(first: [usize; 2], last: [usize; 2]) -> f64 {
    let [columns, rows] = [0, 1].map(|axis| (last[axis] + 1 - first[axis]) as f64);
    columns * rows
}
