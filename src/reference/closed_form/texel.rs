//! Paths of light, and rectangles on the receiver.

use glam::DVec2;
use rayon::prelude::*;

/// Specular events of light between its source and the receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub enum KnownPath {
    /// None: `LD`.
    Direct,
    /// So many reflections from outside, 1 or more: `LRD`, `LRRD` ...
    Reflected(u32),
    /// Into a transparent body and out of it, with so many reflections inside: `LTTD`, `LTRTD` ...
    Through(u32),
}

impl KnownPath {
    /// The path in Heckbert's notation with R and T for specular events, such as `LTRTD`.
    pub fn signature(self) -> String {
        match self {
            Self::Direct => "LD".to_owned(),
            Self::Reflected(count) => format!("L{}D", "R".repeat(count as usize)),
            Self::Through(count) => format!("LT{}TD", "R".repeat(count as usize)),
        }
    }
}

/// A rectangle on the receiver's plane, sides along x and y.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexelRect {
    /// The corner of smallest coordinates.
    pub min: DVec2,
    /// The corner of largest coordinates.
    pub max: DVec2,
}

impl TexelRect {
    /// The rectangle between two corners.
    pub fn new(min_x: f64, min_y: f64, max_x: f64, max_y: f64) -> Self {
        Self {
            min: DVec2::new(min_x, min_y),
            max: DVec2::new(max_x, max_y),
        }
    }

    /// Area (m²).
    pub fn area(&self) -> f64 {
        let extent = self.max - self.min;
        extent.x * extent.y
    }

    /// Its corners, counter-clockwise from the smallest.
    pub(super) fn corners(&self) -> [DVec2; 4] {
        let (min, max) = (self.min, self.max);
        [min, DVec2::new(max.x, min.y), max, DVec2::new(min.x, max.y)]
    }

    /// The parts in the four quadrants of the plane, those that are not empty, each mirrored into the first.
    pub(super) fn quadrant_parts(&self) -> impl Iterator<Item = Self> {
        let sides = |min: f64, max: f64| [(min.max(0.0), max), ((-max).max(0.0), -min)];
        let (xs, ys) = (sides(self.min.x, self.max.x), sides(self.min.y, self.max.y));
        (0..4)
            .map(move |i| (xs[i & 1], ys[i >> 1]))
            .filter(|((x0, x1), (y0, y1))| x0 < x1 && y0 < y1)
            .map(|((x0, x1), (y0, y1))| Self::new(x0, y0, x1, y1))
    }
}

/// A rectangle cut into equal texels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexelGrid {
    /// The whole rectangle.
    pub bounds: TexelRect,
    /// Number of texels along x.
    pub columns: usize,
    /// Number of texels along y.
    pub rows: usize,
}

impl TexelGrid {
    /// A square [−`half_width`, `half_width`]² of `side`² texels.
    pub fn square(half_width: f64, side: usize) -> Self {
        Self {
            bounds: TexelRect::new(-half_width, -half_width, half_width, half_width),
            columns: side,
            rows: side,
        }
    }

    /// The texel in a column and a row, both counted from the corner of smallest coordinates.
    pub fn texel(&self, column: usize, row: usize) -> TexelRect {
        let extent = self.bounds.max - self.bounds.min;
        // Neighbours must share their border exactly.
        let x = |i: usize| self.bounds.min.x + extent.x * (i as f64 / self.columns as f64);
        let y = |i: usize| self.bounds.min.y + extent.y * (i as f64 / self.rows as f64);
        TexelRect::new(x(column), y(row), x(column + 1), y(row + 1))
    }

    /// `value` of every texel, rows from smallest y, in each row from smallest x; computed on all cores.
    pub fn map(&self, value: impl Fn(&TexelRect) -> f64 + Sync) -> Vec<f64> {
        (0..self.columns * self.rows)
            .into_par_iter()
            .map(|i| value(&self.texel(i % self.columns, i / self.columns)))
            .collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn signatures_are_written_as_everywhere_in_the_program() {
        assert_eq!(KnownPath::Direct.signature(), "LD");
        assert_eq!(KnownPath::Reflected(2).signature(), "LRRD");
        assert_eq!(KnownPath::Through(0).signature(), "LTTD");
        assert_eq!(KnownPath::Through(1).signature(), "LTRTD");
    }

    #[test]
    fn the_quadrant_parts_of_a_texel_have_its_area() {
        let texel = TexelRect::new(-1.0, -0.5, 3.0, 0.25);
        let areas: Vec<f64> = texel.quadrant_parts().map(|part| part.area()).collect();
        assert_eq!(areas.len(), 4);
        assert_eq!(areas.iter().sum::<f64>(), texel.area());
        assert_eq!(
            TexelRect::new(0.0, 0.0, 1.0, 1.0).quadrant_parts().count(),
            1
        );
        assert_eq!(
            TexelRect::new(-2.0, 1.0, -1.0, 2.0).quadrant_parts().next(),
            Some(TexelRect::new(1.0, 1.0, 2.0, 2.0))
        );
    }
}
