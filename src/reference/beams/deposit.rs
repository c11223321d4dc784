//! From a finished cell to texels.

use glam::DVec2;

use super::cell::{Cell, Node, Smooth};
use super::film::{BeamFilm, TexelSums};
use crate::film::coverage::{Part, deal};
use crate::transport::flux::Flux;

/// Sums of the few texels that a cell touches, gathered before they go to the film: a cell's
/// five triangles share most of their texels.
pub struct Patch<const N: usize> {
    origin: [usize; 2],
    size: [usize; 2],
    sums: Vec<TexelSums<N>>,
}

/// A patch has at most this many texels a side; larger images go to the film directly.
const PATCH: usize = 24;

impl<const N: usize> Patch<N> {
    /// An empty patch.
    pub fn new() -> Self {
        Self {
            origin: [0; 2],
            size: [0; 2],
            sums: vec![TexelSums::default(); PATCH * PATCH],
        }
    }

    /// Covers the texels of a box; `false` where it is too large.
    fn cover(&mut self, low: DVec2, high: DVec2, film: [usize; 2]) -> bool {
        for axis in 0..2 {
            let last = film[axis] as f64 - 1.0;
            let from = low[axis].floor().clamp(0.0, last) as usize;
            let to = high[axis].floor().clamp(0.0, last) as usize;
            self.origin[axis] = from;
            self.size[axis] = to - from + 1;
            if self.size[axis] > PATCH {
                return false;
            }
        }
        self.sums[..self.size[0] * self.size[1]].fill(TexelSums::default());
        true
    }

    #[inline]
    fn at(&mut self, [column, row]: [usize; 2]) -> &mut TexelSums<N> {
        let (x, y) = (column - self.origin[0], row - self.origin[1]);
        &mut self.sums[y * self.size[0] + x]
    }

    fn flush(&self, film: &BeamFilm<N>) {
        for y in 0..self.size[1] {
            for x in 0..self.size[0] {
                let sums = &self.sums[y * self.size[0] + x];
                film.add([self.origin[0] + x, self.origin[1] + y], sums);
            }
        }
    }
}

/// Flux of a triangle's part: its weight is linear between the corners.
#[inline]
pub(super) fn flux_of<const N: usize>(area: f64, weights: [Flux<N>; 3], part: &Part) -> Flux<N> {
    let [a, b, c] = weights;
    (a * part.share + (b - a) * part.moment.x + (c - a) * part.moment.y) * area
}

/// Puts a smooth cell on the film: its four quarters as affine triangles (B), itself as one (A),
/// and (4B − A)/3 as the answer.
///
/// The error of affine cells is of second order in their size, so that halving them leaves a
/// quarter of it: Richardson's extrapolation removes it texel by texel.
pub fn deposit_smooth<const N: usize>(
    film: &BeamFilm<N>,
    patch: &mut Patch<N>,
    cell: &Cell<N>,
    middles: &[Node<N>; 3],
    smooth: &Smooth,
) -> Flux<N> {
    let size = film.size();
    let gathered = patch.cover(smooth.low, smooth.high, size);
    let mut add = |texel: [usize; 2], sums: TexelSums<N>| {
        if gathered {
            let at = patch.at(texel);
            at.flux += sums.flux;
            at.difference += sums.difference;
            at.astray += sums.astray;
        } else {
            film.add(texel, &sums);
        }
    };
    let mut received = Flux::BLACK;
    // Halving an arc leaves a quarter of its distance from the chord.
    let bend = 0.25 * smooth.bend;
    let quarter = 0.25 * cell.area();
    for triangle in cell.quarters(middles) {
        let Some((image, weights)) = image_of(&triangle) else {
            continue;
        };
        let low = image[0].min(image[1]).min(image[2]);
        let extent = image[0].max(image[1]).max(image[2]) - low;
        let crossed = (low + extent).floor().cmpgt(low.floor());
        // Of a triangle as wide as `extent`, about 2 bend / extent is within `bend` of a line.
        let near = |axis: usize| {
            if crossed.test(axis) {
                (2.0 * bend / extent[axis]).min(1.0)
            } else {
                0.0
            }
        };
        let near = (near(0) + near(1)).min(1.0);
        let all = flux_of(quarter, weights, &Part::WHOLE);
        deal(image, size, |texel, part| {
            let flux = flux_of(quarter, weights, &part);
            received += flux * (4.0 / 3.0);
            add(
                texel,
                TexelSums {
                    flux: flux * (4.0 / 3.0),
                    difference: flux,
                    astray: all * near,
                    slack: Flux::BLACK,
                },
            );
        });
    }
    if let Some((image, weights)) = image_of(cell) {
        let area = cell.area();
        deal(image, size, |texel, part| {
            let flux = flux_of(area, weights, &part);
            received += flux * (-1.0 / 3.0);
            add(
                texel,
                TexelSums {
                    flux: flux * (-1.0 / 3.0),
                    difference: flux * -1.0,
                    astray: Flux::BLACK,
                    slack: Flux::BLACK,
                },
            );
        });
    }
    if gathered {
        patch.flush(film);
    }
    received
}

/// Puts a cell on the film that is not one family: quarters that are, as triangles; of the rest
/// each landed corner's third, as a point. All of it is slack.
pub fn deposit_mixed<const N: usize>(
    film: &BeamFilm<N>,
    cell: &Cell<N>,
    middles: &[Node<N>; 3],
) -> Flux<N> {
    let size = film.size();
    let quarter = 0.25 * cell.area();
    let mut received = Flux::BLACK;
    for triangle in cell.quarters(middles) {
        let family = triangle.corners[0].path.family;
        let is_one = triangle
            .corners
            .iter()
            .all(|node| node.path.family == family);
        if let (true, Some((image, weights))) = (is_one, image_of(&triangle)) {
            deal(image, size, |texel, part| {
                let flux = flux_of(quarter, weights, &part);
                received += flux;
                film.add(
                    texel,
                    &TexelSums {
                        flux,
                        ..TexelSums::default()
                    },
                );
            });
            continue;
        }
        for node in &triangle.corners {
            if let Some(at) = node.landing()
                && let Some(texel) = texel_at(at, size)
            {
                let flux = node.path.weight * (quarter / 3.0);
                received += flux;
                film.add(
                    texel,
                    &TexelSums {
                        flux,
                        ..TexelSums::default()
                    },
                );
            }
        }
    }
    spread_slack(film, cell, middles);
    received
}

/// All of a mixed cell's light may be anywhere that its nodes landed, or near.
fn spread_slack<const N: usize>(film: &BeamFilm<N>, cell: &Cell<N>, middles: &[Node<N>; 3]) {
    let nodes = cell.corners.iter().chain(middles);
    let mut largest = Flux::BLACK;
    for node in nodes.clone() {
        largest = Flux(std::array::from_fn(|c| {
            f64::max(largest.0[c], node.path.weight.0[c])
        }));
    }
    let slack = largest * cell.area();
    let size = film.size();
    let mut put = |low: DVec2, high: DVec2| {
        let last = DVec2::new(size[0] as f64, size[1] as f64) - 1.0;
        let (low, high) = (low.floor().max(DVec2::ZERO), high.floor().min(last));
        let mut row = low.y;
        while row <= high.y {
            let mut column = low.x;
            while column <= high.x {
                film.add(
                    [column as usize, row as usize],
                    &TexelSums {
                        slack,
                        ..TexelSums::default()
                    },
                );
                column += 1.0;
            }
            row += 1.0;
        }
    };
    // Each family's landings are together; families may be far apart.
    let mut done: [u64; 6] = [0; 6];
    for (index, node) in nodes.clone().enumerate() {
        let family = node.path.family;
        if node.landing().is_none() || done[..index].contains(&family) {
            continue;
        }
        done[index] = family;
        let mut low = DVec2::INFINITY;
        let mut high = DVec2::NEG_INFINITY;
        for other in nodes.clone().filter(|other| other.path.family == family) {
            if let Some(at) = other.landing() {
                low = low.min(at);
                high = high.max(at);
            }
        }
        // The part that no node saw may reach as far again.
        let margin = (high - low).max(DVec2::splat(1e-3));
        put(low - margin, high + margin);
    }
}

fn texel_at(at: DVec2, size: [usize; 2]) -> Option<[usize; 2]> {
    let end = DVec2::new(size[0] as f64, size[1] as f64);
    (at.cmpge(DVec2::ZERO).all() && at.cmplt(end).all()).then(|| [at.x as usize, at.y as usize])
}

#[inline]
fn image_of<const N: usize>(cell: &Cell<N>) -> Option<([DVec2; 3], [Flux<N>; 3])> {
    let [a, b, c] = &cell.corners;
    let image = [a.landing()?, b.landing()?, c.landing()?];
    Some((image, [a.path.weight, b.path.weight, c.path.weight]))
}
