//! A triangle's image cut along the lines of a grid.
//!
//! The result is the part of the *surface* in each texel. A triangle maps affinely to the film. So a part of
//! its image is as large a share of the image as it is of the triangle. But an image may be a line or a
//! point. So the share is measured in barycentric coordinates, in which every triangle has the same area,
//! 1/2. Only the cuts are found on the film. A cut hands the same point to both of its sides: the shares sum
//! to one but for rounding.

use glam::DVec2;

/// The part of a triangle that falls into one texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TexelPiece {
    pub column: u32,
    pub row: u32,
    /// Its fraction (0..=1) of the triangle's area.
    pub share: f64,
    /// Its centroid, by the weights of the triangle's second and third vertex.
    pub centroid: DVec2,
}

/// A grid of texels. Its border texels reach to infinity, as in `Receiver::texel`.
#[derive(Clone, Copy, Debug)]
pub(super) struct ClipGrid {
    pub columns: u32,
    pub rows: u32,
}

/// A point of the triangle.
#[derive(Clone, Copy, Debug)]
struct ClipCorner {
    /// Column and row on the film, in texels.
    at: [f64; 2],
    barycentric: DVec2,
}

/// A cutter of triangles, which keeps its buffers from one to the next.
#[derive(Debug, Default)]
pub(super) struct Clipper {
    /// The part of the triangle above the rows done.
    rest: Vec<ClipCorner>,
    /// The part in one row, to the right of the columns done.
    strip: Vec<ClipCorner>,
    /// The part in one texel.
    cell: Vec<ClipCorner>,
    spare: Vec<ClipCorner>,
}

impl Clipper {
    /// Hands every piece with area of a triangle to `found`; `image` is on the film, in texels.
    pub fn pieces(&mut self, grid: ClipGrid, image: [DVec2; 3], mut found: impl FnMut(TexelPiece)) {
        let weights = [DVec2::ZERO, DVec2::X, DVec2::Y];
        self.rest.clear();
        self.rest.extend((0..3).map(|i| ClipCorner {
            at: image[i].to_array(),
            barycentric: weights[i],
        }));
        let (first, last) = range(&self.rest, 1, grid.rows);
        for row in first..=last {
            take_below(
                &mut self.rest,
                &mut self.strip,
                &mut self.spare,
                1,
                row,
                last,
            );
            if self.strip.is_empty() {
                continue;
            }
            let (first, last) = range(&self.strip, 0, grid.columns);
            for column in first..=last {
                take_below(
                    &mut self.strip,
                    &mut self.cell,
                    &mut self.spare,
                    0,
                    column,
                    last,
                );
                if let Some((share, centroid)) = area(&self.cell) {
                    found(TexelPiece {
                        column,
                        row,
                        share,
                        centroid,
                    });
                }
            }
        }
    }
}

/// The first and last texel along an axis that a polygon reaches.
fn range(polygon: &[ClipCorner], axis: usize, count: u32) -> (u32, u32) {
    let along = || polygon.iter().map(|corner| corner.at[axis]);
    let low = along().fold(f64::INFINITY, f64::min);
    let high = along().fold(f64::NEG_INFINITY, f64::max);
    let texel = |at: f64| at.clamp(0.0, f64::from(count - 1)) as u32;
    (texel(low), texel(high))
}

/// Moves the part before the end of texel `index` from `rest` to `part`, or all of it if the texel is the
/// last.
fn take_below(
    rest: &mut Vec<ClipCorner>,
    part: &mut Vec<ClipCorner>,
    spare: &mut Vec<ClipCorner>,
    axis: usize,
    index: u32,
    last: u32,
) {
    part.clear();
    if index == last {
        std::mem::swap(rest, part);
        return;
    }
    let line = f64::from(index + 1);
    spare.clear();
    for (i, &from) in rest.iter().enumerate() {
        let to = rest[(i + 1) % rest.len()];
        let is_below = from.at[axis] < line;
        if is_below {
            part.push(from);
        } else {
            spare.push(from);
        }
        if is_below != (to.at[axis] < line) {
            let crossing = crossing(from, to, axis, line);
            part.push(crossing);
            spare.push(crossing);
        }
    }
    std::mem::swap(rest, spare);
}

/// The point at which an edge crosses a line. The order of the edge's ends makes no difference to a bit.
fn crossing(from: ClipCorner, to: ClipCorner, axis: usize, line: f64) -> ClipCorner {
    let (a, b) = if from.at[axis] < to.at[axis] {
        (from, to)
    } else {
        (to, from)
    };
    let t = ((line - a.at[axis]) / (b.at[axis] - a.at[axis])).clamp(0.0, 1.0);
    let mut at = [0, 1].map(|axis| a.at[axis] + (b.at[axis] - a.at[axis]) * t);
    at[axis] = line;
    ClipCorner {
        at,
        barycentric: a.barycentric.lerp(b.barycentric, t),
    }
}

/// A convex polygon's share of its triangle, and its centroid; `None` if it has no area.
fn area(polygon: &[ClipCorner]) -> Option<(f64, DVec2)> {
    let (first, others) = polygon.split_first()?;
    let origin = first.barycentric;
    let mut share = 0.0;
    let mut moment = DVec2::ZERO;
    for edge in others.windows(2) {
        let (p, q) = (edge[0].barycentric - origin, edge[1].barycentric - origin);
        // Twice the area; the whole triangle has 1.
        let fan = p.perp_dot(q);
        share += fan;
        moment += (p + q) * fan;
    }
    (share > 0.0).then(|| (share, origin + moment / (3.0 * share)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pieces(columns: u32, rows: u32, image: [(f64, f64); 3]) -> Vec<TexelPiece> {
        let mut all = Vec::new();
        let image = image.map(|(x, y)| DVec2::new(x, y));
        Clipper::default().pieces(ClipGrid { columns, rows }, image, |piece| all.push(piece));
        all
    }

    /// Each cut adds rounding of at most a few u to a share; there are no more than 2 (8 + 8) cuts.
    const ROUNDING: f64 = 32.0 * 4.0 * f64::EPSILON;

    #[test]
    fn half_a_square_falls_half_on_the_diagonal_texels_and_wholly_below() {
        let all = pieces(4, 4, [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0)]);
        assert_eq!(all.len(), 4 + 6);
        for piece in all {
            // The triangle has 8 texels.
            let expected = if piece.column == piece.row { 0.5 } else { 1.0 } / 8.0;
            assert!((piece.share - expected).abs() <= ROUNDING, "{piece:?}");
        }
    }

    #[test]
    fn shares_sum_to_one_whatever_the_image() {
        for image in [
            [(0.3, 0.2), (7.9, 1.1), (2.2, 6.6)],
            [(7.0, 7.0), (1.0, 7.0), (1.0, 1.0)],
            // Beyond the border, turned round, a line, a line along a texel's edge, a point.
            [(-1e-7, 3.0), (8.0, 8.0 + 1e-7), (8.0 + 1e-7, -1e-7)],
            [(0.3, 0.2), (2.2, 6.6), (7.9, 1.1)],
            [(0.5, 0.5), (3.5, 3.5), (7.25, 7.25)],
            [(3.0, 0.5), (3.0, 3.5), (3.0, 7.25)],
            [(2.0, 2.0); 3],
        ] {
            let sum: f64 = pieces(8, 8, image).iter().map(|piece| piece.share).sum();
            assert!((sum - 1.0).abs() <= ROUNDING, "{image:?}: {sum}");
        }
    }

    #[test]
    fn an_image_without_area_is_shared_by_the_surface_that_it_came_from() {
        // Along the line the surface's width grows from nothing to the full edge at x = 2: half the
        // triangle's height is a quarter of its area.
        let all = pieces(2, 1, [(0.0, 0.5), (2.0, 0.5), (2.0, 0.5)]);
        assert_eq!(all.len(), 2);
        assert!((all[0].share - 0.25).abs() <= ROUNDING);
        assert!((all[1].share - 0.75).abs() <= ROUNDING);
        // On a texel's border it belongs to the texel that begins there.
        let all = pieces(2, 1, [(1.0, 0.0), (1.0, 1.0), (1.0, 0.5)]);
        assert_eq!(all.len(), 1);
        assert_eq!(all[0].column, 1);
    }

    #[test]
    fn a_piece_lies_where_its_centroid_does() {
        let image = [(0.3, 0.2), (7.9, 1.1), (2.2, 6.6)].map(|(x, y)| DVec2::new(x, y));
        let grid = ClipGrid {
            columns: 8,
            rows: 8,
        };
        let mut sum = DVec2::ZERO;
        Clipper::default().pieces(grid, image, |piece| {
            let DVec2 { x, y } = piece.centroid;
            let at = image[0] * (1.0 - x - y) + image[1] * x + image[2] * y;
            assert_eq!((at.x as u32, at.y as u32), (piece.column, piece.row));
            sum += piece.centroid * piece.share;
        });
        assert!(sum.abs_diff_eq(DVec2::splat(1.0 / 3.0), ROUNDING));
    }
}
