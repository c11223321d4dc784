//! The parts of a triangle whose images fall in each texel.
//!
//! A triangle of *light space* is mapped onto the film by an affine map. The share of the triangle that lands
//! in a texel is measured where light starts and not where it ends. So the image may be folded over, turned
//! around or collapsed to a needle or a point. All of the triangle is still dealt out, to rounding. The image
//! is cut along texel lines. Every cut is a cut of the triangle itself, along the line on which a linear
//! function takes a whole number.

use glam::DVec2;

/// A part of a triangle: its area and its place, in barycentric coordinates.
///
/// The integral of a function that is linear over the triangle, with values f₀, f₁, f₂ at its vertices, over
/// the part is
///
/// ```text
/// ∫ f = triangle area · (f₀ share + (f₁ − f₀) moment.x + (f₂ − f₀) moment.y)
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TrianglePart {
    /// Its area, as a fraction (0..=1) of the triangle's.
    pub share: f64,
    /// The integral over it of the barycentric weights of the second and the third vertex, as a fraction of
    /// the triangle's area.
    pub moment: DVec2,
}

impl TrianglePart {
    /// All of a triangle.
    pub const WHOLE: Self = Self {
        share: 1.0,
        moment: DVec2::splat(1.0 / 3.0),
    };
}

/// A texel, by column and row.
pub type TexelIndex = [usize; 2];

/// Deals a triangle out to the texels of a film of `size` columns and rows.
///
/// `image` holds the images of its vertices in texels: texel (column, row) is [column, column + 1) x [row,
/// row + 1). `deposit` is called at most once a texel, with the part of the triangle that lands there. Parts
/// that land off the film are not deposited, nor is a triangle whose image is not finite.
#[inline]
pub fn deal(
    image: [DVec2; 3],
    size: [usize; 2],
    mut deposit: impl FnMut(TexelIndex, TrianglePart),
) {
    let low = image[0].min(image[1]).min(image[2]);
    let high = image[0].max(image[1]).max(image[2]);
    let end = DVec2::new(size[0] as f64, size[1] as f64);
    // False for NaN.
    let is_near = high.cmpge(DVec2::ZERO).all() && low.cmplt(end).all() && (high - low).is_finite();
    if !is_near {
        return;
    }
    let (first, last) = (low.floor(), high.floor());
    if first == last {
        deposit([first.x as usize, first.y as usize], TrianglePart::WHOLE);
        return;
    }
    // Polygons are read and written in place: they are large, and copies took as long as the cuts.
    let [rest, next, slab, one, two] = &mut [PartPolygon::EMPTY; 5];
    let (mut rest, mut next) = (rest, next);
    rest.set(image);
    if first.x < 0.0 {
        rest.split::<0>(0.0, slab, next);
        std::mem::swap(&mut rest, &mut next);
    }
    let (from, to) = (first.x.max(0.0), last.x.min(end.x - 1.0));
    let mut column = from;
    while column <= to && !rest.is_empty() {
        if column == last.x {
            deal_rows(rest, one, two, column as usize, end.y, &mut deposit);
            return;
        }
        rest.split::<0>(column + 1.0, slab, next);
        std::mem::swap(&mut rest, &mut next);
        deal_rows(slab, one, two, column as usize, end.y, &mut deposit);
        column += 1.0;
    }
}

/// Deals out the part `rest` of a triangle, which lies in one column. It and two more polygons are
/// overwritten.
#[inline]
fn deal_rows<'a>(
    mut rest: &'a mut PartPolygon,
    mut next: &'a mut PartPolygon,
    piece: &mut PartPolygon,
    column: usize,
    end: f64,
    deposit: &mut impl FnMut(TexelIndex, TrianglePart),
) {
    let rows = rest.vertices().iter().map(|vertex| vertex.at[1]);
    let (low, high) = rows.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), y| {
        (low.min(y), high.max(y))
    });
    if rest.is_empty() || high < 0.0 || low >= end {
        return;
    }
    let (first, last) = (low.floor(), high.floor());
    if first < 0.0 {
        rest.split::<1>(0.0, piece, next);
        std::mem::swap(&mut rest, &mut next);
    }
    let mut row = first.max(0.0);
    while row <= last.min(end - 1.0) && !rest.is_empty() {
        let is_last = row == last;
        let part = if is_last {
            rest.part()
        } else {
            rest.split::<1>(row + 1.0, piece, next);
            std::mem::swap(&mut rest, &mut next);
            piece.part()
        };
        if part.share > 0.0 {
            deposit([column, row as usize], part);
        }
        if is_last {
            return;
        }
        row += 1.0;
    }
}

/// A vertex of a part of a triangle.
#[derive(Clone, Copy, Debug)]
struct PartVertex {
    /// Its image.
    at: [f64; 2],
    /// Barycentric weights of the triangle's second and third vertex.
    weights: DVec2,
}

/// A convex part of a triangle.
#[derive(Clone, Copy, Debug)]
struct PartPolygon {
    /// Three corners, and one more for each of four cuts; one to spare.
    vertices: [PartVertex; 8],
    len: usize,
}

impl PartPolygon {
    const EMPTY: Self = Self {
        vertices: [PartVertex {
            at: [0.0; 2],
            weights: DVec2::ZERO,
        }; 8],
        len: 0,
    };

    /// All of a triangle.
    #[inline]
    fn set(&mut self, image: [DVec2; 3]) {
        self.len = 0;
        for (at, weights) in image.into_iter().zip([DVec2::ZERO, DVec2::X, DVec2::Y]) {
            self.push(PartVertex {
                at: at.to_array(),
                weights,
            });
        }
    }

    #[inline]
    fn is_empty(&self) -> bool {
        self.len == 0
    }

    #[inline]
    fn push(&mut self, vertex: PartVertex) {
        self.vertices[self.len] = vertex;
        self.len += 1;
    }

    #[inline]
    fn vertices(&self) -> &[PartVertex] {
        &self.vertices[..self.len]
    }

    /// The parts below and not below `line` in one coordinate of the image.
    #[inline]
    fn split<const AXIS: usize>(&self, line: f64, below: &mut Self, above: &mut Self) {
        (below.len, above.len) = (0, 0);
        let Some(mut previous) = self.vertices().last() else {
            return;
        };
        for vertex in self.vertices() {
            let (was, is) = (previous.at[AXIS] - line, vertex.at[AXIS] - line);
            if (was < 0.0) != (is < 0.0) {
                let mut crossing = crossing(previous, vertex, was / (was - is));
                crossing.at[AXIS] = line;
                below.push(crossing);
                above.push(crossing);
            }
            if is < 0.0 {
                below.push(*vertex);
            } else {
                above.push(*vertex);
            }
            previous = vertex;
        }
    }

    /// Area and moment by a fan of triangles; the reference triangle has area 1/2.
    #[inline]
    fn part(&self) -> TrianglePart {
        let mut part = TrianglePart::default();
        if let [first, rest @ ..] = self.vertices() {
            for pair in rest.windows(2) {
                let (a, b) = (pair[0].weights, pair[1].weights);
                let twice_area = (a - first.weights).perp_dot(b - first.weights);
                part.share += twice_area;
                part.moment += (first.weights + a + b) * (twice_area / 3.0);
            }
        }
        part
    }
}

#[inline]
fn crossing(a: &PartVertex, b: &PartVertex, t: f64) -> PartVertex {
    PartVertex {
        at: std::array::from_fn(|axis| a.at[axis] + (b.at[axis] - a.at[axis]) * t),
        weights: a.weights + (b.weights - a.weights) * t,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const SIZE: [usize; 2] = [7, 5];

    fn parts(image: [DVec2; 3]) -> Vec<(TexelIndex, TrianglePart)> {
        let mut found = Vec::new();
        deal(image, SIZE, |texel, part| found.push((texel, part)));
        found
    }

    #[test]
    fn half_a_texel_of_each_side_of_a_line_is_dealt_out_by_area() {
        // The right triangle over two texels: three quarters of its area are left of x = 1.
        let found = parts([DVec2::ZERO, DVec2::new(2.0, 0.0), DVec2::new(0.0, 0.5)]);
        assert_eq!(found.len(), 2);
        assert!((found[0].1.share - 0.75).abs() < 1e-15);
        assert!((found[1].1.share - 0.25).abs() < 1e-15);
    }

    #[test]
    fn a_needle_is_dealt_out_along_its_length() {
        // All of the image lies on y = 0.5; x is 0 at one corner and 4 at both others, so the share left of x
        // is (x/4)².
        let found = parts([
            DVec2::new(0.0, 0.5),
            DVec2::new(4.0, 0.5),
            DVec2::new(4.0, 0.5),
        ]);
        for (texel, part) in found.iter().filter(|(texel, _)| texel[0] < 4) {
            let x = texel[0] as f64;
            let expected = ((x + 1.0) * (x + 1.0) - x * x) / 16.0;
            assert!((part.share - expected).abs() < 1e-15, "{texel:?}");
        }
    }

    #[test]
    fn what_is_not_finite_is_left_out() {
        let nan = DVec2::new(f64::NAN, 0.0);
        assert!(parts([nan, DVec2::ONE, DVec2::ZERO]).is_empty());
        assert!(parts([DVec2::INFINITY, DVec2::ONE, DVec2::ZERO]).is_empty());
    }

    fn point(reach: f64) -> impl Strategy<Value = DVec2> {
        // Some points are multiples of 1/4, so that they lie exactly on texel lines.
        (-reach..reach, -reach..reach, any::<bool>()).prop_map(|(x, y, snap)| {
            let at = DVec2::new(x, y);
            if snap { (at * 4.0).round() / 4.0 } else { at }
        })
    }

    proptest! {
        #[test]
        fn all_of_a_triangle_on_the_film_is_dealt_out(
            a in point(2.0), b in point(2.0), c in point(2.0),
        ) {
            let inside = DVec2::new(3.0, 2.5);
            let found = parts([a, b, c].map(|p| p + inside));
            let share: f64 = found.iter().map(|(_, part)| part.share).sum();
            let moment: DVec2 = found.iter().map(|(_, part)| part.moment).sum();
            // Every crossing rounds its weights by a few units of 2⁻⁵³, and a cut line is shared by the parts
            // on both sides: only its ends on the triangle's edges matter.
            prop_assert!((share - 1.0).abs() < 1e-13, "{share}");
            prop_assert!((moment - DVec2::splat(1.0 / 3.0)).abs().max_element() < 1e-13);
        }

        #[test]
        fn a_large_film_cropped_is_the_small_film(
            a in point(9.0), b in point(9.0), c in point(9.0),
        ) {
            let shift = DVec2::splat(16.0);
            let mut all = Vec::new();
            deal([a, b, c].map(|p| p + shift), [32, 32], |texel, part| all.push((texel, part)));
            let cropped: Vec<_> = all
                .into_iter()
                .filter_map(|([x, y], part)| {
                    let texel = [x.checked_sub(16)?, y.checked_sub(16)?];
                    (texel[0] < SIZE[0] && texel[1] < SIZE[1]).then_some((texel, part))
                })
                .collect();
            for (texel, part) in parts([a, b, c]) {
                let share = cropped
                    .iter()
                    .find(|(other, _)| *other == texel)
                    .map_or(0.0, |(_, part)| part.share);
                // The shift rounds images by 2⁻⁴⁹ texels; a share changes with the image by at most 2/extent,
                // and extents below 2⁻²⁰ are not drawn.
                prop_assert!((part.share - share).abs() < 1e-8, "{texel:?}");
            }
        }
    }
}
