//! Cubes around an object.

use glam::DVec3;

use super::leg::{Crossed, Leg, Stencil};
use crate::numeric::math;

/// A cube about the object's centre, cut into equal cubes.
#[derive(Clone, Copy, Debug)]
pub struct Grid {
    /// Cubes along each side.
    side: u32,
    /// Half of the whole's edge \[m\].
    half: f64,
    /// Cells are numbered block by block, of 2^block cells a side: a leg, and a look-up, stays in a few pages
    /// of memory.
    block: u32,
}

impl Grid {
    /// `side`³ cubes within `half` of the centre along each axis.
    pub fn new(side: u32, half: f64) -> Self {
        /// Blocks of 8³ sums of 8 bytes are a page.
        const LARGEST: u32 = 3;
        Self {
            side,
            half,
            block: side.trailing_zeros().min(LARGEST),
        }
    }

    /// Cubes along each side.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Half of the whole's edge \[m\].
    pub fn half(&self) -> f64 {
        self.half
    }

    /// All cubes.
    pub fn count(&self) -> usize {
        (self.side as usize).pow(3)
    }

    /// A cube's edge \[m\].
    pub fn edge(&self) -> f64 {
        2.0 * self.half / f64::from(self.side)
    }

    /// A cube's volume \[m³\].
    pub fn volume(&self) -> f64 {
        math::powi(self.edge(), 3)
    }

    /// The number of a cube by its places along the axes.
    #[inline]
    pub fn index(&self, at: [u32; 3]) -> u32 {
        let (bits, blocks) = (self.block, self.side >> self.block);
        let [x, y, z] = at.map(|place| place >> bits);
        let block = (z * blocks + y) * blocks + x;
        let [x, y, z] = at.map(|place| place & ((1 << bits) - 1));
        block << (3 * bits) | z << (2 * bits) | y << bits | x
    }

    /// The places of a cube along the axes.
    #[inline]
    pub fn places(&self, cell: u32) -> [u32; 3] {
        let (bits, blocks) = (self.block, self.side >> self.block);
        let block = cell >> (3 * bits);
        let first = [
            block % blocks,
            block / blocks % blocks,
            block / (blocks * blocks),
        ];
        let mask = (1 << bits) - 1;
        let within = [cell, cell >> bits, cell >> (2 * bits)];
        std::array::from_fn(|axis| first[axis] << bits | within[axis] & mask)
    }

    /// The middle of a cube.
    #[inline]
    pub fn middle(&self, cell: u32) -> DVec3 {
        let at = DVec3::from_array(self.places(cell).map(f64::from));
        (at + 0.5) * self.edge() - self.half
    }

    /// A cube's area \[m²\] across a unit direction: h² (|x| + |y| + |z|).
    #[inline]
    pub fn across(&self, direction: DVec3) -> f64 {
        math::powi(self.edge(), 2) * direction.abs().element_sum()
    }

    /// The cubes that a leg crosses, in their order.
    #[inline]
    pub fn cross(&self, leg: &Leg) -> impl Iterator<Item = Crossed> {
        Walk::new(self, leg)
    }

    /// The cube of a place, or the nearest one.
    #[inline]
    pub fn nearest(&self, place: DVec3) -> Stencil {
        let [x, y, z] = ((place + self.half) * self.per_metre())
            .to_array()
            .map(|at| (at.max(0.0) as u32).min(self.side - 1));
        Stencil::one(self.index([x, y, z]))
    }

    /// The eight cubes around a place, with their shares in a trilinear mean.
    #[inline]
    pub fn linear(&self, place: DVec3) -> Stencil {
        let last = self.side - 1;
        let at = (place + self.half) * self.per_metre() - 0.5;
        let at = at.clamp(DVec3::ZERO, DVec3::splat(f64::from(last)));
        // Of the lower and of the higher cube along each axis: its share, and its part of a number.
        let [x, y, z] = std::array::from_fn(|axis| {
            let low = (at[axis] as u32).min(last.saturating_sub(1));
            let high = at[axis] - f64::from(low);
            let place = |along: u32| {
                let mut place = [0; 3];
                place[axis] = along;
                self.index(place)
            };
            [(1.0 - high, place(low)), (high, place((low + 1).min(last)))]
        });
        Stencil::eight(|corner| {
            let (x, y, z) = (x[corner & 1], y[corner >> 1 & 1], z[corner >> 2]);
            // Numbers of cells are sums of what their places along the axes give.
            (x.1 + y.1 + z.1, x.0 * y.0 * z.0)
        })
    }

    /// Cubes by length \[1/m\].
    #[inline]
    fn per_metre(&self) -> f64 {
        0.5 * f64::from(self.side) / self.half
    }
}

/// A leg on its way through cubes.
struct Walk {
    grid: Grid,
    /// The cube that is next, by its places along the axes.
    cell: [u32; 3],
    /// The lengths at which the leg meets the next border along each axis, and those between borders.
    next: [f64; 3],
    step: [f64; 3],
    /// What a border adds to a place, modulo 2³².
    sign: [u32; 3],
    /// The length at which the leg enters the next cube, and that at which it leaves them all.
    enter: f64,
    leave: f64,
    is_done: bool,
}

impl Walk {
    /// That of a leg that crosses no cube.
    const DONE: Self = Self {
        grid: Grid {
            side: 1,
            half: 0.0,
            block: 0,
        },
        cell: [0; 3],
        next: [0.0; 3],
        step: [0.0; 3],
        sign: [0; 3],
        enter: 0.0,
        leave: 0.0,
        is_done: true,
    };

    #[inline]
    fn new(grid: &Grid, leg: &Leg) -> Self {
        let half = grid.half;
        let (from, direction) = (leg.from.to_array(), leg.direction.to_array());
        let (mut enter, mut leave) = (0.0f64, leg.length);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if from[axis].abs() >= half {
                    return Self::DONE;
                }
                continue;
            }
            let near = -half.copysign(direction[axis]);
            enter = enter.max((near - from[axis]) / direction[axis]);
            leave = leave.min((-near - from[axis]) / direction[axis]);
        }
        if enter >= leave {
            return Self::DONE;
        }
        let edge = grid.edge();
        let last = f64::from(grid.side - 1);
        let mut cell = [0u32; 3];
        let mut next = [f64::INFINITY; 3];
        for axis in 0..3 {
            let place = (from[axis] + enter * direction[axis] + half) / edge;
            let at = place.floor().clamp(0.0, last);
            cell[axis] = at as u32;
            if direction[axis] != 0.0 {
                let ahead = at + f64::from(u8::from(direction[axis] > 0.0));
                next[axis] = (ahead * edge - half - from[axis]) / direction[axis];
            }
        }
        Self {
            grid: *grid,
            cell,
            next,
            step: direction.map(|d| edge / d.abs()),
            sign: direction.map(|d| if d > 0.0 { 1 } else { u32::MAX }),
            enter,
            leave,
            is_done: false,
        }
    }
}

impl Iterator for Walk {
    type Item = Crossed;

    #[allow(
        clippy::inline_always,
        reason = "what it returns would go through memory, in which loads then wait for stores"
    )]
    #[inline(always)]
    fn next(&mut self) -> Option<Crossed> {
        if self.is_done {
            return None;
        }
        // Which axis is next cannot be foretold: chosen without a branch, steps cost half as much.
        let [x, y, z] = self.next;
        let is_x = x <= y && x <= z;
        let is_y = !is_x && y <= z;
        let is_next = [is_x, is_y, !is_x && !is_y];
        let border = x.min(y).min(z);
        // Rounding may put a border a hair before the place at which the last cube was left.
        let end = border.clamp(self.enter, self.leave);
        let at = DVec3::from_array(self.cell.map(f64::from));
        let crossed = Crossed {
            cell: self.grid.index(self.cell),
            from: self.enter,
            to: end,
            outward: (at + 0.5) * (2.0 / f64::from(self.grid.side)) - 1.0,
        };
        for (axis, is_next) in is_next.into_iter().enumerate() {
            let (sign, step) = (self.sign[axis], self.step[axis]);
            self.cell[axis] = self.cell[axis].wrapping_add(if is_next { sign } else { 0 });
            self.next[axis] += if is_next { step } else { 0.0 };
        }
        self.is_done =
            border >= self.leave || self.cell.iter().any(|place| *place >= self.grid.side);
        self.enter = end;
        Some(crossed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::{Stream, StreamKind};

    #[test]
    fn each_cube_has_a_number_of_its_own() {
        for side in [1, 3, 6, 12, 16, 24] {
            let grid = Grid::new(side, 1.0);
            let mut seen = vec![false; grid.count()];
            for cell in 0..side * side * side {
                let at = [cell % side, cell / side % side, cell / (side * side)];
                let index = grid.index(at);
                assert_eq!(grid.places(index), at);
                assert!(!std::mem::replace(&mut seen[index as usize], true));
            }
        }
    }

    #[test]
    fn a_leg_crosses_its_cubes_without_gaps_and_each_has_what_is_in_it() {
        const PARTS: u32 = 4000;
        let grid = Grid::new(12, 1.5);
        let stream = Stream::new(StreamKind::Random, 2);
        for index in 0..20_000 {
            let [a, b, c, d] = stream.point4(index);
            let [e, f, g, _] = stream.padded4(index, 1);
            let from = DVec3::new(a, b, c) * 6.0 - 3.0;
            let mut towards = DVec3::new(d, e, f) * 3.0 - 1.5;
            if index % 5 == 0 {
                towards = DVec3::new(from.x, from.y, -from.z);
            }
            let leg = Leg {
                from,
                direction: (towards - from).normalize(),
                length: if index % 2 == 0 {
                    f64::INFINITY
                } else {
                    6.0 * g
                },
            };
            let (mut last, mut sum) = (None, 0.0);
            for part in grid.cross(&leg) {
                assert!(last.is_none_or(|last| last == part.from), "{index}");
                last = Some(part.to);
                sum += part.to - part.from;
                let middle = part.outward * grid.half();
                assert!(middle.distance(grid.middle(part.cell)) < 1e-15);
                if part.to - part.from > 1e-9 {
                    let place = leg.at(f64::midpoint(part.from, part.to));
                    assert_eq!(grid.nearest(place).cells(), [part.cell], "{index}");
                }
            }
            // By parts of the leg, an independent reading of how much of it is inside.
            let whole = leg.length.min(12.0);
            let inside = (0..PARTS)
                .map(|part| leg.at((f64::from(part) + 0.5) / f64::from(PARTS) * whole))
                .filter(|place| place.abs().max_element() < 1.5)
                .count();
            let expected = inside as f64 / f64::from(PARTS) * whole;
            // Both ends fall into parts.
            assert!(
                (sum - expected).abs() < 2.0 * whole / f64::from(PARTS),
                "{index}"
            );
        }
    }

    #[test]
    fn a_linear_mean_gives_linear_values_back_between_middles() {
        let grid = Grid::new(8, 2.0);
        for place in [DVec3::new(0.3, -1.2, 0.9), DVec3::ZERO, DVec3::splat(1.7)] {
            let mut mean = DVec3::ZERO;
            for (cell, weight) in grid.linear(place).iter() {
                mean += grid.middle(cell) * weight;
            }
            assert!((mean - place).length() < 1e-12, "{place}");
        }
    }
}
