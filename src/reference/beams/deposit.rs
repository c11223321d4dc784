//! Deposits of finished cells on texels.

use glam::DVec2;

use super::cell::{AffineNode, BeamNode};
use super::cut::CutPiece;
use super::film::{BeamFilm, LevelTexel, Sign, TexelSums};
use crate::film::coverage::{TrianglePart, deal};
use crate::transport::flux::Flux;

/// Sums of the texels that a cell touches, gathered before they go to the film: a cell's triangles share most
/// of their texels.
///
/// An image of many texels is gathered on a coarser level, if its light is too faint to make a difference.
#[derive(Default)]
pub struct TexelBlock<const N: usize> {
    level: usize,
    origin: [usize; 2],
    size: [usize; 2],
    sums: Vec<TexelSums<N>>,
}

/// Number of texels whose changes tell by themselves what a cell misplaces.
const FEW_TEXELS: f64 = 16.0;

/// What a cell of many texels may misplace of its light on one of them, by the part that the last halving
/// moved of all its light. With 1, an error of a glass ball's `LTRRTD` is 0.98 of its bar (512 x 512 texels).
const UNEVEN: f64 = 1.5;

/// Texels a side of a block beyond which a coarser level will do.
const BLOCK: usize = 16;

/// The same for light that may be focused within a texel of it: work is still bounded.
const FOCUSED_BLOCK: usize = 64;

/// Coarser levels of the film that a cell's light may be put on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Coarse {
    /// The coarsest level.
    pub coarsest: usize,
    /// The largest density of the cell's light, by its mean; infinite if it may be focused.
    pub density: f64,
}

impl Coarse {
    /// No level but that of the film's own texels.
    pub const NONE: Self = Self {
        coarsest: 0,
        density: 1.0,
    };

    fn most_a_side(&self) -> usize {
        if self.density.is_finite() {
            BLOCK
        } else {
            FOCUSED_BLOCK
        }
    }

    /// Flux that may be misplaced, as a part of the light that is spread evenly within texels of a level. If
    /// rings of focused light meet, a texel of the film has as many times its mean as the side has texels.
    fn misplaced(&self, level: usize) -> f64 {
        let side = (1_u64 << level) as f64;
        (self.density - 1.0).clamp(1.0, side)
    }
}

impl<const N: usize> TexelBlock<N> {
    /// Covers the texels of a box, on a level as coarse as it may be; `false` if the box is empty.
    fn cover(&mut self, low: DVec2, high: DVec2, film: &BeamFilm<N>, coarse: &Coarse) -> bool {
        if !low.cmple(high).all() {
            return false;
        }
        let size = film.size();
        let end = [0, 1].map(|axis| size[axis] as f64 - 1.0);
        let texel = |at: DVec2, axis: usize| at[axis].floor().clamp(0.0, end[axis]) as usize;
        let from = [texel(low, 0), texel(low, 1)];
        let to = [texel(high, 0), texel(high, 1)];
        let sides =
            |level: usize| [0, 1].map(|axis| (to[axis] >> level) - (from[axis] >> level) + 1);
        let most = coarse.most_a_side();
        self.level = (0..coarse.coarsest)
            .find(|level| sides(*level).into_iter().all(|side| side <= most))
            .unwrap_or(coarse.coarsest);
        self.origin = from.map(|first| first >> self.level);
        self.size = sides(self.level);
        self.sums.clear();
        self.sums
            .resize(self.size[0] * self.size[1], TexelSums::default());
        true
    }

    #[inline]
    fn at(&mut self, [column, row]: [usize; 2]) -> &mut TexelSums<N> {
        let (x, y) = (column - self.origin[0], row - self.origin[1]);
        &mut self.sums[y * self.size[0] + x]
    }
}

/// A cell's light at three finenesses.
pub struct Levels<'a, const N: usize> {
    /// Pieces of its quarters: B.
    pub fine: &'a [CutPiece<N>],
    /// Pieces of the cell itself: A.
    pub coarse: &'a [CutPiece<N>],
    /// The corners as the cell that it is a quarter of has them, if it has: C.
    pub coarser: Option<&'a [AffineNode<N>; 3]>,
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
    /// it. Richardson's extrapolation removes it texel by texel. The cell's share C of the affine map of the
    /// cell that it is a quarter of gives the extrapolation of one halving before, (4A − C)/3: its change is
    /// (4B − 5A + C)/3.
    fn deal_out(
        &self,
        size: [usize; 2],
        level: usize,
        mut add: impl FnMut([usize; 2], &TexelSums<N>),
    ) {
        let scale = 1.0 / (1_u64 << level) as f64;
        let mut all = |piece: &CutPiece<N>, flux: f64, change: f64| {
            deal(image_of(piece).map(|at| at * scale), size, |texel, part| {
                let own = flux_of(piece, &part);
                let sums = TexelSums {
                    flux: own * flux,
                    change: own * change,
                    ..TexelSums::default()
                };
                add(texel, &sums);
            });
        };
        for piece in self.fine {
            all(piece, 4.0 / 3.0, 4.0 / 3.0);
        }
        let of_coarse = if self.coarser.is_some() { -5.0 } else { -4.0 };
        for piece in self.coarse {
            all(piece, -1.0 / 3.0, of_coarse / 3.0);
            if let Some(corners) = self.coarser {
                let mut coarser = *piece;
                for (node, affine) in coarser.corners.iter_mut().zip(corners) {
                    node.landing = Some(affine.landing);
                    node.weight = affine.weight;
                }
                all(&coarser, 0.0, 1.0 / 3.0);
            }
        }
    }

    /// The box round all landings.
    fn bounds(&self) -> [DVec2; 2] {
        let pieces = self.fine.iter().chain(self.coarse).flat_map(image_of);
        let coarser = self.coarser.into_iter().flatten().map(|node| node.landing);
        box_round(pieces.chain(coarser))
    }
}

impl<const N: usize> TexelBlock<N> {
    /// Gathers a cell, on a level as coarse as it may be. At least `hidden`, a part of its light, may be
    /// misplaced. Returns the flux \[W\] that the last halving moved from texel to texel, the worst channel.
    pub fn gather(
        &mut self,
        film: &BeamFilm<N>,
        levels: &Levels<N>,
        coarse: &Coarse,
        hidden: f64,
    ) -> f64 {
        let [low, high] = levels.bounds();
        self.sums.clear();
        if !self.cover(low, high, film, coarse) {
            return 0.0;
        }
        let level = self.level;
        levels.deal_out(film.level_size(level), level, |texel, sums| {
            *self.at(texel) += *sums;
        });
        let (mut moved, mut all) = (Flux::<N>::BLACK, Flux::<N>::BLACK);
        for sums in &self.sums {
            moved += sums.change.magnitude();
            all += sums.flux.magnitude();
        }
        let (moved, flux) = (moved.max_magnitude(), all.max_magnitude());
        // In a cell of few texels, the neighbours show how much was moved.
        let texels = self.sums.len() as f64;
        let unseen = texels / (texels + FEW_TEXELS);
        let part = if level > 0 {
            coarse.misplaced(level)
        } else if moved > 0.0 {
            (UNEVEN * unseen * moved / flux).min(1.0)
        } else {
            0.0
        };
        // Beside its dim rim a cell's light is as dense as in its middle, if the rim is bent.
        let lit = self.sums.iter().filter(|sums| sums.flux != Flux::BLACK);
        let mean = all * (1.0 / lit.count().max(1) as f64);
        for sums in &mut self.sums {
            if sums.flux != Flux::BLACK {
                sums.misplaced = sums.flux.magnitude().larger(mean) * part.max(hidden);
            }
        }
        0.5 * moved
    }

    /// Puts the gathered cell on the film. Returns the flux \[W\] that the film received.
    pub fn deposit(&self, film: &BeamFilm<N>) -> Flux<N> {
        let mut received = Flux::BLACK;
        let whole = 1_usize << (2 * self.level);
        for (index, sums) in self.sums.iter().enumerate() {
            let (x, y) = (index % self.size[0], index / self.size[0]);
            let texel = LevelTexel {
                level: self.level,
                at: [self.origin[0] + x, self.origin[1] + y],
            };
            let within = film.texels_within(texel);
            let mut sums = *sums;
            if within < whole {
                // A texel at the film's border: the rest of it is beside the film.
                let part = within as f64 / whole as f64;
                sums.flux = sums.flux * part;
                sums.change = sums.change * part;
                sums.misplaced = sums.misplaced * part;
            }
            film.add(texel, &sums);
            received += sums.flux;
        }
        received
    }
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
            let at = [at.x as usize, at.y as usize];
            film.add(LevelTexel { level: 0, at }, &sums);
        }
    }
    received
}

/// The box round some places on a film: its least and its greatest corner.
pub(super) fn box_round(places: impl Iterator<Item = DVec2>) -> [DVec2; 2] {
    places.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[low, high], at| {
        [low.min(at), high.max(at)]
    })
}

/// The first and last texel of a box, as far as it is on a film; `None` if it is not, or is empty.
pub(super) fn texels_in([low, high]: [DVec2; 2], size: [usize; 2]) -> Option<[[usize; 2]; 2]> {
    let end = DVec2::new(size[0] as f64, size[1] as f64) - 1.0;
    let (low, high) = (low.floor().max(DVec2::ZERO), high.floor().min(end));
    let texel = |at: DVec2| [at.x as usize, at.y as usize];
    // False for NaN, too.
    low.cmple(high).all().then(|| [texel(low), texel(high)])
}

/// Marks `flux` as uncertain in each texel of a cut cell's [boxes](uncertain_boxes): it may be there, or not.
pub fn deposit_uncertain<const N: usize>(
    film: &BeamFilm<N>,
    nodes: &[BeamNode<N>; 6],
    pieces: &[CutPiece<N>],
    flux: Flux<N>,
) {
    for [first, last] in uncertain_boxes(film.size(), nodes, pieces) {
        film.add_uncertain(first, last, flux, Sign::Same);
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
    nodes.iter().enumerate().filter_map(move |(index, node)| {
        let is_new = nodes[..index]
            .iter()
            .all(|one| one.topology != node.topology);
        if node.landing.is_none() || !is_new {
            return None;
        }
        let of_pieces = pieces.iter().flat_map(|piece| &piece.corners);
        let own = nodes.iter().chain(of_pieces);
        let own = own.filter(|one| one.topology == node.topology);
        let [low, high] = box_round(own.filter_map(|one| one.landing));
        let margin = high - low;
        texels_in([low - margin, high + margin], size)
    })
}

/// Number of texels of a box, first and last column and row included.
pub fn texels_of(first: [usize; 2], last: [usize; 2]) -> f64 {
    let [columns, rows] = [0, 1].map(|axis| (last[axis] + 1 - first[axis]) as f64);
    columns * rows
}
