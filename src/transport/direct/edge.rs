//! Texels that a shadow's edge runs through: bisection finds the edge, and the texel is cut along it.
//!
//! A lattice of points, and Gauss points within its cells, tell which cells the edge enters. The edge crosses
//! a cell's border in two places, which bisection finds, and bends between them. A third place, on the normal
//! through the chord's middle, tells by how much. So a cell is cut along a parabola.
//!
//! The area moved by the bend, chord times sagitta, is booked as the error. It is 1.5 times the area between
//! chord and parabola, and larger than the error of a cut with one corner. Irradiance without shadow is
//! smooth, and needs no rays.

use glam::DVec2;

use super::arriving::unshadowed;
use super::leaf::{Leaf, SHADOW_LEVELS};
use super::light::DirectLight;
use super::look::Sum;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::scene::Emitter;
use crate::transport::receiver::ReceiverPatch;

/// Cells along a side of a texel.
pub(super) const CELLS: usize = 8;

/// Number of times that a crossing's interval is halved.
const BISECTIONS: i32 = 14;

/// Largest share of a texel that a cut may leave uncertain; above it, the cell is quartered instead.
const UNCERTAIN: f64 = 1e-4;

/// A square part of a texel, and the share of the emitter that each corner sees, counter-clockwise from the
/// lowest.
#[derive(Clone, Copy)]
pub(super) struct EdgeCell {
    pub(super) from: DVec2,
    pub(super) size: f64,
    pub(super) shares: [f64; 4],
    /// Shares that the Gauss points see.
    pub(super) inner: [f64; 4],
    /// True if these points are not enough, even if they agree.
    pub(super) is_suspicious: bool,
}

/// Two parts of a cell that see different shares.
struct EdgeCut {
    parts: [(Vec<DVec2>, f64); 2],
    /// A point of the edge.
    middle: DVec2,
    /// Share of the texel that may belong to the other part.
    uncertain: f64,
}

impl EdgeCut {
    /// True if a point is in the first part, by the parity of the outline's crossings.
    fn is_first(&self, point: DVec2) -> bool {
        let outline = &self.parts[0].0;
        let mut is_inside = false;
        for (index, a) in outline.iter().enumerate() {
            let b = outline[(index + 1) % outline.len()];
            // Crossings of the outline are counted on the way to the right.
            if (a.y > point.y) != (b.y > point.y) {
                let x = a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x);
                is_inside ^= x > point.x;
            }
        }
        is_inside
    }

    /// True if each of a cell's Gauss points sees the share of the part that holds it.
    fn agrees_with(&self, cell: &EdgeCell) -> bool {
        let points = cell.gauss_points();
        let mut pairs = points.iter().zip(cell.inner);
        pairs.all(|(at, share)| share == self.parts[usize::from(!self.is_first(*at))].1)
    }
}

/// Reasons why something is not cut.
#[derive(Clone, Copy, Debug)]
pub(super) enum NoCut {
    /// There is no surface at a point.
    NoSurface,
    /// More than one edge, or more than two shares: smaller cells may be simpler.
    NotSimple,
}

pub(super) const CORNERS: [DVec2; 4] = [
    DVec2::new(0.0, 0.0),
    DVec2::new(1.0, 0.0),
    DVec2::new(1.0, 1.0),
    DVec2::new(0.0, 1.0),
];

impl EdgeCell {
    fn corner(&self, index: usize) -> DVec2 {
        self.from + CORNERS[index % 4] * self.size
    }

    /// True if all its points see the same share.
    pub(super) fn is_even(&self) -> bool {
        let all = self.shares.iter().chain(&self.inner);
        all.copied().all(|share| share == self.shares[0])
    }

    /// True if it and its quarters all see the same share.
    pub(super) fn is_like(&self, quarters: &[Self; 4]) -> bool {
        let agrees = |one: &Self| one.is_even() && one.shares[0] == self.shares[0];
        self.is_even() && quarters.iter().all(agrees)
    }

    pub(super) fn is_last(&self) -> bool {
        self.size <= 1.0 / f64::from(1_u32 << SHADOW_LEVELS)
    }

    fn gauss_points(&self) -> [DVec2; 4] {
        let leaf = Leaf {
            from: self.from,
            size: self.size,
            level: 0,
        };
        leaf.gauss_points()
    }

    pub(super) fn outline(&self) -> [DVec2; 4] {
        [0, 1, 2, 3].map(|index| self.corner(index))
    }
}

/// True if a cell is one of the leaf's, `across` a side, and not one of the ring around them.
fn is_inside(column: usize, row: usize, across: usize) -> bool {
    (1..=across).contains(&column) && (1..=across).contains(&row)
}

/// One emitter's light in one texel.
pub(super) struct EdgeTexel<'a, 'b> {
    pub(super) light: &'a mut DirectLight<'b>,
    pub(super) texel: usize,
    pub(super) emitter: &'a Emitter,
    /// The share that most of a leaf is assumed to see, before cells tell otherwise.
    pub(super) base: f64,
}

impl DirectLight<'_> {
    /// Adds a leaf's part of its texel's light, cut along the shadow's edge. `None` if the leaf's surface is
    /// not one smooth one.
    pub(super) fn cut(
        &mut self,
        texel: usize,
        leaf: &Leaf,
        emitter: &Emitter,
        sum: &mut Sum,
    ) -> Option<()> {
        let across = (CELLS >> leaf.level.min(8)).max(2);
        let size = leaf.size / across as f64;
        // One more cell around the leaf: an edge beside it may reach in.
        let side = across + 3;
        let mut first = None;
        let mut shares = Vec::with_capacity(side * side);
        for index in 0..side * side {
            let place = DVec2::new((index % side) as f64, (index / side) as f64) - 1.0;
            let at = self.receiver.clamped(texel, leaf.from + place * size);
            let patch = self.patch(texel, at)?;
            if !first.get_or_insert(patch).continues(&patch) {
                return None;
            }
            shares.push(self.arriving(&patch.point, emitter).1);
        }
        let of = |column: usize, row: usize| {
            [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(i, j)| shares[(row + j) * side + column + i])
        };
        let base = of(1, 1)[0];
        let (flux, area) = self.gauss(texel, leaf, emitter)?;
        sum.area += area;
        sum.flux += flux * base;
        let mut edge = EdgeTexel {
            light: self,
            texel,
            emitter,
            base,
        };
        // Cells and the ring around them. The Gauss points of the ring belong to other texels.
        let mut cells = Vec::with_capacity((across + 2) * (across + 2));
        for index in 0..(across + 2) * (across + 2) {
            let (column, row) = (index % (across + 2), index / (across + 2));
            let shares = of(column, row);
            let mut cell = EdgeCell {
                from: leaf.from + (DVec2::new(column as f64, row as f64) - 1.0) * size,
                size,
                shares,
                inner: [shares[0]; 4],
                is_suspicious: false,
            };
            if is_inside(column, row, across) {
                cell.inner = edge.inner(&cell).ok()?;
            }
            cells.push(cell);
        }
        edge.follow(&mut cells, across).ok()?;
        for (index, cell) in cells.into_iter().enumerate() {
            if is_inside(index % (across + 2), index / (across + 2), across) {
                edge.cell(cell, sum).ok()?;
            }
        }
        Some(())
    }

    /// A leaf's flux without shadow \[W\] and its area \[m²\], by 2 x 2 Gauss points.
    pub(super) fn gauss(&self, texel: usize, leaf: &Leaf, emitter: &Emitter) -> Option<(Rgb, f64)> {
        let weight = leaf.size * leaf.size / 4.0;
        let (mut flux, mut area) = (Rgb::BLACK, 0.0);
        for at in leaf.gauss_points() {
            let patch = self.patch(texel, at)?;
            flux += unshadowed(&patch.point, emitter).0 * (patch.density * weight);
            area += patch.density * weight;
        }
        Some((flux, area))
    }
}

impl EdgeTexel<'_, '_> {
    /// Looks closely at the cells beside an edge, and so follows narrow shadows from one cell to the next. A
    /// cell that hid something becomes suspicious.
    fn follow(&mut self, cells: &mut [EdgeCell], across: usize) -> Result<(), NoCut> {
        let wide = across + 2;
        let mut pending: Vec<usize> = (0..cells.len()).filter(|&i| !cells[i].is_even()).collect();
        let mut is_known: Vec<bool> = cells.iter().map(|cell| !cell.is_even()).collect();
        while let Some(index) = pending.pop() {
            let (column, row) = (index % wide, index / wide);
            for row in row.max(2) - 1..=(row + 1).min(across) {
                for column in column.max(2) - 1..=(column + 1).min(across) {
                    let beside = row * wide + column;
                    if std::mem::replace(&mut is_known[beside], true) {
                        continue;
                    }
                    let cell = &mut cells[beside];
                    if !cell.is_like(&self.quarters(cell)?) {
                        cell.is_suspicious = true;
                        pending.push(beside);
                    }
                }
            }
        }
        Ok(())
    }

    /// Adds a cell, whole, cut or in quarters.
    fn cell(&mut self, cell: EdgeCell, sum: &mut Sum) -> Result<(), NoCut> {
        let mut pending = vec![cell];
        while let Some(cell) = pending.pop() {
            if cell.is_even() && (cell.is_last() || !cell.is_suspicious) {
                self.add(&cell.outline(), cell.shares[0], sum)?;
                continue;
            }
            if !cell.is_even() && self.add_parts(&cell, sum)? {
                continue;
            }
            let quarters = self.quarters(&cell)?;
            if cell.is_like(&quarters) {
                self.add(&cell.outline(), cell.shares[0], sum)?;
            } else {
                pending.extend(quarters);
            }
        }
        Ok(())
    }

    /// Adds a cell whose points see different shares: cut, or mixed if it is the last. `false` if it must be
    /// divided.
    pub(super) fn add_parts(&mut self, cell: &EdgeCell, sum: &mut Sum) -> Result<bool, NoCut> {
        let cut = match self.along_edge(cell) {
            Ok(cut) => Some(cut),
            Err(NoCut::NotSimple) => None,
            Err(NoCut::NoSurface) => return Err(NoCut::NoSurface),
        };
        if let Some(cut) = cut
            && cut.uncertain <= UNCERTAIN
            && cut.agrees_with(cell)
        {
            self.add_cut(&cut, sum)?;
            return Ok(true);
        }
        if cell.is_last() {
            self.add_mixed(cell, sum)?;
        }
        Ok(cell.is_last())
    }

    /// Shares that a cell's Gauss points see.
    pub(super) fn inner(&mut self, cell: &EdgeCell) -> Result<[f64; 4], NoCut> {
        let mut inner = [0.0; 4];
        for (share, at) in inner.iter_mut().zip(cell.gauss_points()) {
            *share = self.share(at)?;
        }
        Ok(inner)
    }

    /// Adds both parts of a cell, and the uncertain area between them.
    fn add_cut(&self, cut: &EdgeCut, sum: &mut Sum) -> Result<(), NoCut> {
        let [(_, a), (_, b)] = cut.parts;
        for (outline, share) in &cut.parts {
            self.add(outline, *share, sum)?;
        }
        sum.error += self.light_at(cut.middle)? * (cut.uncertain * (a - b).abs());
        Ok(())
    }

    /// The share that a point of the texel sees.
    pub(super) fn share(&mut self, at: DVec2) -> Result<f64, NoCut> {
        let patch = self.patch(at)?;
        Ok(self.light.share(&patch.point, self.emitter))
    }

    pub(super) fn patch(&self, at: DVec2) -> Result<ReceiverPatch, NoCut> {
        let at = self.light.receiver.clamped(self.texel, at);
        let patch = self.light.patch(self.texel, at);
        patch.ok_or(NoCut::NoSurface)
    }

    /// A cell's quarters, with what their Gauss points see.
    pub(super) fn quarters(&mut self, cell: &EdgeCell) -> Result<[EdgeCell; 4], NoCut> {
        let mut quarters = self.corners_of_quarters(cell)?;
        for quarter in &mut quarters {
            quarter.inner = self.inner(quarter)?;
        }
        Ok(quarters)
    }

    /// A cell's quarters, with what their corners see.
    pub(super) fn corners_of_quarters(&mut self, cell: &EdgeCell) -> Result<[EdgeCell; 4], NoCut> {
        let [a, b, c, d] = cell.shares;
        let mut at = |x: f64, y: f64| self.share(cell.from + DVec2::new(x, y) * cell.size);
        let (bottom, right, top, left) =
            (at(0.5, 0.0)?, at(1.0, 0.5)?, at(0.5, 1.0)?, at(0.0, 0.5)?);
        let middle = at(0.5, 0.5)?;
        let size = 0.5 * cell.size;
        let quarter = |x: f64, y: f64, shares: [f64; 4]| EdgeCell {
            from: cell.from + DVec2::new(x, y) * size,
            size,
            shares,
            inner: [shares[0]; 4],
            is_suspicious: true,
        };
        Ok([
            quarter(0.0, 0.0, [a, bottom, middle, left]),
            quarter(1.0, 0.0, [bottom, b, right, middle]),
            quarter(1.0, 1.0, [middle, right, c, top]),
            quarter(0.0, 1.0, [left, middle, top, d]),
        ])
    }

    /// Cuts a cell whose corners see two shares, if one edge runs through it.
    fn along_edge(&mut self, cell: &EdgeCell) -> Result<EdgeCut, NoCut> {
        let shares = cell.shares;
        let crossed: Vec<usize> = (0..4)
            .filter(|&i| shares[i] != shares[(i + 1) % 4])
            .collect();
        let [enters, leaves] = crossed[..] else {
            return Err(NoCut::NotSimple);
        };
        let (inner, outer) = (shares[leaves], shares[enters]);
        if shares
            .iter()
            .any(|share| *share != inner && *share != outer)
        {
            return Err(NoCut::NotSimple);
        }
        let precision = math::powi(0.5_f64, BISECTIONS) * cell.size;
        let mut ends = [DVec2::ZERO; 2];
        for (end, corner) in ends.iter_mut().zip([enters, leaves]) {
            let (from, to) = (cell.corner(corner), cell.corner(corner + 1));
            let (before, after) = (shares[corner], shares[(corner + 1) % 4]);
            *end = self.crossing(from, to, before, after, precision)?;
        }
        let [first, second] = ends;
        // The inner part lies to the left of the way from `second` to `first`.
        let chord = first - second;
        let length = chord.length();
        let middle = 0.5 * (first + second);
        let mut sagitta = DVec2::ZERO;
        if length > precision {
            let to_inner = chord.perp() / length;
            let seen = self.share(middle)?;
            let away = if seen == inner { -to_inner } else { to_inner };
            let beyond = if seen == inner { outer } else { inner };
            let mut reach = cell.size / 64.0;
            loop {
                if reach > cell.size {
                    return Err(NoCut::NotSimple);
                }
                if self.share(middle + away * reach)? == beyond {
                    break;
                }
                reach *= 2.0;
            }
            let found = self.crossing(middle, middle + away * reach, seen, beyond, precision)?;
            sagitta = found - middle;
        }
        // A triangle with the parabola's area, 2/3 of chord times sagitta.
        let apex = middle + sagitta * (4.0 / 3.0);
        let part = |from: DVec2, to: DVec2, corners: std::ops::RangeInclusive<usize>| {
            let mut outline = vec![from];
            outline.extend(corners.map(|index| cell.corner(index)));
            outline.extend([to, apex]);
            outline
        };
        Ok(EdgeCut {
            parts: [
                (part(first, second, enters + 1..=leaves), inner),
                (part(second, first, leaves + 1..=enters + 4), outer),
            ],
            middle,
            uncertain: (length + precision) * (sagitta.length() + precision),
        })
    }

    /// The point between two others at which the share changes, to the precision given.
    fn crossing(
        &mut self,
        mut from: DVec2,
        mut to: DVec2,
        before: f64,
        after: f64,
        precision: f64,
    ) -> Result<DVec2, NoCut> {
        while from.distance(to) > precision {
            let middle = 0.5 * (from + to);
            let share = self.share(middle)?;
            if share == before {
                from = middle;
            } else if share == after {
                to = middle;
            } else {
                return Err(NoCut::NotSimple);
            }
        }
        Ok(0.5 * (from + to))
    }

    /// Irradiance without shadow times surface per share of the texel \[W\].
    pub(super) fn light_at(&self, at: DVec2) -> Result<Rgb, NoCut> {
        let patch = self.patch(at)?;
        Ok(unshadowed(&patch.point, self.emitter).0 * patch.density)
    }

    /// Adds the difference between a polygon's light and that assumed for the leaf. Each triangle of a fan is
    /// integrated by the middles of its edges.
    pub(super) fn add(&self, outline: &[DVec2], share: f64, sum: &mut Sum) -> Result<(), NoCut> {
        if share == self.base {
            return Ok(());
        }
        let first = outline[0];
        for pair in outline[1..].windows(2) {
            let (second, third) = (pair[0], pair[1]);
            let area = 0.5 * (second - first).perp_dot(third - first);
            if area == 0.0 {
                continue;
            }
            for (a, b) in [(first, second), (second, third), (third, first)] {
                let light = self.light_at(0.5 * (a + b))?;
                sum.flux += light * ((share - self.base) * area / 3.0);
            }
        }
        Ok(())
    }

    /// Adds a cell of several edges that is not divided further: the average of its points. All that the
    /// points differ by is the error.
    fn add_mixed(&self, cell: &EdgeCell, sum: &mut Sum) -> Result<(), NoCut> {
        let shares = cell.shares.iter().chain(&cell.inner).copied();
        // The Gauss points stand for the cell; the corners also tell of the surface beside it.
        self.add(&cell.outline(), cell.inner.iter().sum::<f64>() / 4.0, sum)?;
        let least = shares.clone().fold(f64::INFINITY, f64::min);
        let most = shares.fold(f64::NEG_INFINITY, f64::max);
        let middle = cell.from + 0.5 * cell.size;
        sum.error += self.light_at(middle)? * (cell.size * cell.size * (most - least));
        Ok(())
    }
}
