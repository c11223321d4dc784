//! The error-driven hierarchy: cells of the water's grid are joined where few beams do (beyond the paper).
//!
//! Rays between the corners of a cell land where linear interpolation does not take them. Let δ be the
//! largest distance by which it misses, at the middles of the cell's sides and at its centre, in the lowest
//! plane. It spoils the light of a cell with flux Φ and an image of side s by about Φ δ/s, or Φ δ by a texel
//! if the image is smaller than that. Four cells are joined if that is at most `lod` for the cell that they
//! make, with lengths in texels and Φ in those of a texel in flat water.
//!
//! Cells at a shadow's border are not joined, and neighbours differ by one level at most: the finer one's
//! vertex in the middle of a side is a vertex of the coarser one, too, so that no light is lost or counted
//! twice between them.

use glam::{DVec2, DVec3};

use super::beam::Ruling;
use super::grid::JoinedGrid;
use super::volume::LitVertex;

/// What an error is measured by.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// The largest error of a joined cell, in texels.
    pub most: f64,
    /// The side of a texel \[m\].
    pub texel: f64,
    /// The depth in which rays land \[m\].
    pub bottom: f64,
    /// The axis across which the grid is.
    pub axis: DVec3,
    /// The flux through a unit of area in flat water, by the source's strength.
    pub flat: f64,
}

impl JoinedGrid {
    /// The triangles between vertices of the grid, row by row, after cells were joined.
    pub fn triangles(self, vertices: &[Option<LitVertex>], tolerance: &Tolerance) -> Vec<[u32; 3]> {
        self.triangles_of(&self.split(vertices, tolerance))
    }

    /// The triangles of the cells that are left, by which are split.
    fn triangles_of(self, split: &[Flags]) -> Vec<[u32; 3]> {
        let mut triangles = Vec::new();
        for level in 0..=self.levels {
            let side = self.cells >> level;
            for row in 0..side {
                for column in 0..side {
                    let is_split = level > 0 && split[level as usize].at(column, row);
                    let is_there =
                        level == self.levels || split[level as usize + 1].at(column / 2, row / 2);
                    if is_there && !is_split {
                        self.cell(level, [column, row], split, &mut triangles);
                    }
                }
            }
        }
        triangles
    }

    /// Whether each cell is split, level by level: 0 are the smallest cells, which are not.
    fn split(self, vertices: &[Option<LitVertex>], tolerance: &Tolerance) -> Vec<Flags> {
        let mut split = vec![Flags::new(self.cells, false)];
        for level in 1..=self.levels {
            let side = self.cells >> level;
            let mut flags = Flags::new(side, false);
            for row in 0..side {
                for column in 0..side {
                    let below = &split[level as usize - 1];
                    let has_split = (0..4).any(|i| below.at(2 * column + i % 2, 2 * row + i / 2));
                    let is_split =
                        has_split || !self.can_join(level, [column, row], vertices, tolerance);
                    flags.set(column, row, is_split);
                }
            }
            split.push(flags);
        }
        // Where a cell is split, cells beside it must be as small: those that they are parts of are split.
        for level in 1..self.levels {
            let side = self.cells >> level;
            for row in 0..side {
                for column in 0..side {
                    if !split[level as usize].at(column, row) {
                        continue;
                    }
                    let above = &mut split[level as usize + 1];
                    above.set(column / 2, row / 2, true);
                    for (x, y) in neighbours([column, row], side) {
                        above.set(x / 2, y / 2, true);
                    }
                }
            }
        }
        split
    }

    fn vertex(self, column: u32, row: u32) -> u32 {
        row * self.side() + column
    }

    /// Whether four cells can be one, which is on this level.
    fn can_join(
        self,
        level: u32,
        [column, row]: [u32; 2],
        vertices: &[Option<LitVertex>],
        tolerance: &Tolerance,
    ) -> bool {
        let half = 1 << (level - 1);
        let (left, top) = (column << level, row << level);
        let mut found = [None; 9];
        for (i, slot) in (0_u32..).zip(&mut found) {
            let vertex = self.vertex(left + i % 3 * half, top + i / 3 * half);
            *slot = vertices[vertex as usize].as_ref();
        }
        let [
            Some(a),
            Some(ab),
            Some(b),
            Some(ac),
            Some(m),
            Some(bd),
            Some(c),
            Some(cd),
            Some(d),
        ] = found
        else {
            return false;
        };
        let all = [a, ab, b, ac, m, bd, c, cd, d];
        if all.iter().any(|vertex| vertex.is_lit != a.is_lit) {
            return false;
        }
        let land =
            |vertex: &LitVertex| Ruling::at(vertex.ruling(), tolerance.bottom) / tolerance.texel;
        let [a_at, ab_at, b_at, ac_at, m_at, bd_at, c_at, cd_at, d_at] = all.map(land);
        let bend = [
            (ab_at, a_at, b_at),
            (ac_at, a_at, c_at),
            (bd_at, b_at, d_at),
            (cd_at, c_at, d_at),
            (m_at, a_at, d_at),
        ]
        .into_iter()
        .map(|(middle, from, to)| middle.distance(0.5 * (from + to)))
        .fold(0.0, f64::max);
        let start = [a, b, c, d]
            .map(|vertex| Ruling::at(vertex.ruling(), vertex.ruling().start) / tolerance.texel);
        let flux = area(start) * m.brightness(tolerance.axis) / tolerance.flat;
        let size = area([a_at, b_at, c_at, d_at]).sqrt().max(1.0);
        bend * flux / size <= tolerance.most
    }

    /// The triangles of a cell that is not split: two, or a fan around its centre if a neighbour is finer.
    fn cell(self, level: u32, [column, row]: [u32; 2], split: &[Flags], into: &mut Vec<[u32; 3]>) {
        let size = 1 << level;
        let (left, top) = (column << level, row << level);
        let corner = |x: u32, y: u32| self.vertex(left + x, top + y);
        let [a, b, c, d] = [
            corner(0, 0),
            corner(size, 0),
            corner(size, size),
            corner(0, size),
        ];
        let side = self.cells >> level;
        let is_finer = |x: Option<u32>, y: Option<u32>| match (x, y) {
            (Some(x), Some(y)) if x < side && y < side => {
                level > 0 && split[level as usize].at(x, y)
            }
            _ => false,
        };
        let half = size / 2;
        let sides = [
            (
                a,
                b,
                is_finer(Some(column), row.checked_sub(1)),
                corner(half, 0),
            ),
            (
                b,
                c,
                is_finer(Some(column + 1), Some(row)),
                corner(size, half),
            ),
            (
                c,
                d,
                is_finer(Some(column), Some(row + 1)),
                corner(half, size),
            ),
            (
                d,
                a,
                is_finer(column.checked_sub(1), Some(row)),
                corner(0, half),
            ),
        ];
        if sides.iter().all(|(.., is_finer, _)| !is_finer) {
            into.extend([[a, b, c], [a, c, d]]);
            return;
        }
        let centre = corner(half, half);
        for (from, to, is_finer, middle) in sides {
            if is_finer {
                into.extend([[centre, from, middle], [centre, middle, to]]);
            } else {
                into.push([centre, from, to]);
            }
        }
    }
}

/// The area of a square-like figure by its corners, row by row.
fn area([a, b, c, d]: [DVec2; 4]) -> f64 {
    0.5 * ((b - a).perp_dot(d - a).abs() + (d - a).perp_dot(c - a).abs())
}

/// The cells that share a side with a cell.
fn neighbours([column, row]: [u32; 2], side: u32) -> impl Iterator<Item = (u32, u32)> {
    let beside = [
        (column.wrapping_sub(1), row),
        (column + 1, row),
        (column, row.wrapping_sub(1)),
        (column, row + 1),
    ];
    beside
        .into_iter()
        .filter(move |&(x, y)| x < side && y < side)
}

/// A flag for each cell of a level.
#[derive(Clone, Debug)]
struct Flags {
    side: u32,
    flags: Vec<bool>,
}

impl Flags {
    fn new(side: u32, flag: bool) -> Self {
        Self {
            side,
            flags: vec![flag; (side * side) as usize],
        }
    }

    fn at(&self, column: u32, row: u32) -> bool {
        self.flags[(row * self.side + column) as usize]
    }

    fn set(&mut self, column: u32, row: u32, flag: bool) {
        self.flags[(row * self.side + column) as usize] = flag;
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;

    #[test]
    fn triangles_of_cells_of_several_sizes_share_all_their_sides() {
        let grid = JoinedGrid::new(2, 17);
        // Cells of eight, but for three that are of four; and one of these is of two.
        let mut split: Vec<Flags> = (0..=3)
            .map(|level| Flags::new(16 >> level, false))
            .collect();
        for (level, column, row) in [(3, 0, 0), (3, 1, 0), (3, 0, 1), (2, 1, 1)] {
            split[level].set(column, row, true);
        }
        let triangles = grid.triangles_of(&split);
        // 1 cell of 8 and 11 of 4, two triangles each or a fan, and 4 of 2.
        assert!(triangles.len() > 2 * 16, "{}", triangles.len());
        let mut sides: BTreeMap<(u32, u32), i32> = BTreeMap::new();
        for [a, b, c] in triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                let along = if from < to { 1 } else { -1 };
                *sides.entry((from.min(to), from.max(to))).or_default() += along;
            }
        }
        let place = |vertex: u32| (vertex % 17, vertex / 17);
        for ((from, to), count) in sides {
            let ((x, y), (u, v)) = (place(from), place(to));
            let is_border = x == u && (x == 0 || x == 16) || y == v && (y == 0 || y == 16);
            assert_eq!(count == 0, !is_border, "({x}, {y}) to ({u}, {v})");
        }
    }
}
