//! Texels that known obstacles divide: their parts are asked by shafts, and cut along the shadow's edge.

use super::edge::{CELLS, CORNERS, EdgeCell, EdgeTexel, NoCut};
use super::leaf::Leaf;
use super::light::DirectLight;
use super::look::Sum;
use super::shaft::{Obstacle, are_simple, are_tangled};
use super::shafts::Shafts;
use crate::scene::Emitter;

impl DirectLight<'_> {
    /// Adds a leaf's part of its texel's light, cut along the edges of the shadows of some obstacles.
    pub(super) fn cut_by(
        &mut self,
        texel: usize,
        leaf: &Leaf,
        emitter: &Emitter,
        (shafts, obstacles): (&Shafts, &[Obstacle]),
        sum: &mut Sum,
    ) -> Result<(), NoCut> {
        let (flux, area) = self.gauss(texel, leaf, emitter).ok_or(NoCut::NoSurface)?;
        let mut edge = EdgeTexel {
            light: self,
            texel,
            emitter,
            base: 0.0,
        };
        let mut shares = [0.0; 4];
        for (share, corner) in shares.iter_mut().zip(CORNERS) {
            *share = edge.share(leaf.from + corner * leaf.size)?;
        }
        edge.base = shares[0];
        sum.area += area;
        sum.flux += flux * edge.base;
        let cell = EdgeCell {
            from: leaf.from,
            size: leaf.size,
            shares,
            inner: [shares[0]; 4],
            is_suspicious: true,
        };
        edge.divide(cell, (shafts, obstacles), sum)
    }
}

impl EdgeTexel<'_, '_> {
    /// Adds a cell: whole if no obstacle divides it, else cut or in quarters.
    fn divide(
        &mut self,
        mut cell: EdgeCell,
        (shafts, obstacles): (&Shafts, &[Obstacle]),
        sum: &mut Sum,
    ) -> Result<(), NoCut> {
        let [a, b, c, d] = cell.outline().map(|at| self.patch(at));
        let corners = [a?, b?, c?, d?].map(|patch| patch.point.position);
        let within = shafts.dividing(corners, obstacles);
        if within.is_empty() {
            // A corner may lie on the line that ends a shadow, and see either side of it.
            let [first, others @ ..] = cell.shares;
            let share = if others.iter().all(|share| *share == first) {
                first
            } else {
                self.share(cell.from + 0.5 * cell.size)?
            };
            return self.add(&cell.outline(), share, sum);
        }
        let is_simple = are_simple(&within);
        let is_tangled = are_tangled(&within);
        if is_tangled && cell.is_last() {
            // No point may have found the sliver.
            sum.error += self.light_at(cell.from + 0.5 * cell.size)? * (cell.size * cell.size);
        }
        let is_small = cell.is_last() || !is_tangled && cell.size <= 1.0 / CELLS as f64;
        if is_small || is_simple {
            cell.inner = self.inner(&cell)?;
            if !cell.is_even() && self.add_parts(&cell, sum)? {
                return Ok(());
            }
        }
        let quarters = if is_small && cell.is_even() {
            if cell.is_last() {
                return self.add(&cell.outline(), cell.shares[0], sum);
            }
            let quarters = self.quarters(&cell)?;
            if cell.is_like(&quarters) {
                return self.add(&cell.outline(), cell.shares[0], sum);
            }
            quarters
        } else {
            self.corners_of_quarters(&cell)?
        };
        for quarter in quarters {
            self.divide(quarter, (shafts, &within), sum)?;
        }
        Ok(())
    }
}
