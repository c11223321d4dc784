//! Cubes around an object.

use glam::DVec3;

use super::leg::{Leg, Stencil};

/// A cube about the object's centre, cut into equal cubes.
#[derive(Clone, Debug)]
pub struct Grid {
    /// Cubes along each side.
    side: u32,
    /// Half of the whole's edge \[m\].
    half: f64,
}

impl Grid {
    /// `side`³ cubes within `half` of the centre along each axis.
    pub fn new(side: u32, half: f64) -> Self {
        Self { side, half }
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

    fn index(&self, [x, y, z]: [u32; 3]) -> u32 {
        (z * self.side + y) * self.side + x
    }

    /// The middle of a cube.
    #[inline]
    pub fn middle(&self, cell: u32) -> DVec3 {
        let n = self.side;
        let at = DVec3::new(
            f64::from(cell % n),
            f64::from(cell / n % n),
            f64::from(cell / (n * n)),
        );
        (at + 0.5) * self.edge() - self.half
    }

    /// A cube's area \[m²\] across a unit direction: h² (|x| + |y| + |z|).
    #[inline]
    pub fn across(&self, direction: DVec3) -> f64 {
        self.edge().powi(2) * direction.abs().element_sum()
    }

    /// The cubes that a leg crosses in their order, each with the lengths at which it enters and leaves.
    #[inline]
    pub fn cross(&self, leg: &Leg, mut visit: impl FnMut(u32, f64, f64)) {
        let (from, direction) = (leg.from.to_array(), leg.direction.to_array());
        let (mut enter, mut leave) = (0.0f64, leg.length);
        for axis in 0..3 {
            if direction[axis] == 0.0 {
                if from[axis].abs() >= self.half {
                    return;
                }
                continue;
            }
            let near = -self.half.copysign(direction[axis]);
            enter = enter.max((near - from[axis]) / direction[axis]);
            leave = leave.min((-near - from[axis]) / direction[axis]);
        }
        if enter >= leave {
            return;
        }
        let edge = self.edge();
        let last = f64::from(self.side - 1);
        let mut cell = [0u32; 3];
        let mut next = [f64::INFINITY; 3];
        for axis in 0..3 {
            let place = (from[axis] + enter * direction[axis] + self.half) / edge;
            let at = place.floor().clamp(0.0, last);
            cell[axis] = at as u32;
            if direction[axis] != 0.0 {
                let ahead = at + f64::from(u8::from(direction[axis] > 0.0));
                next[axis] = (ahead * edge - self.half - from[axis]) / direction[axis];
            }
        }
        let step = direction.map(|d| edge / d.abs());
        loop {
            let axis = match next {
                [x, y, z] if x <= y && x <= z => 0,
                [_, y, z] if y <= z => 1,
                _ => 2,
            };
            // Rounding may put a border a hair before the place at which the last cube was left.
            let end = next[axis].clamp(enter, leave);
            visit(self.index(cell), enter, end);
            if next[axis] >= leave {
                return;
            }
            enter = end;
            let at = if direction[axis] > 0.0 {
                cell[axis] + 1
            } else {
                cell[axis].wrapping_sub(1)
            };
            if at >= self.side {
                return;
            }
            cell[axis] = at;
            next[axis] += step[axis];
        }
    }

    /// The cube of a place, or the nearest one.
    #[inline]
    pub fn nearest(&self, place: DVec3) -> Stencil {
        let last = f64::from(self.side - 1);
        let at = ((place + self.half) / self.edge()).floor();
        let at = at.clamp(DVec3::ZERO, DVec3::splat(last));
        Stencil::one(self.index(at.to_array().map(|x| x as u32)))
    }

    /// The eight cubes around a place, with their shares in a trilinear mean.
    #[inline]
    pub fn linear(&self, place: DVec3) -> Stencil {
        let last = f64::from(self.side - 1);
        let at = (place + self.half) / self.edge() - 0.5;
        let at = at.clamp(DVec3::ZERO, DVec3::splat(last));
        let low = at.floor().min(DVec3::splat((last - 1.0).max(0.0)));
        let part = (at - low).to_array();
        let low = low.to_array().map(|x| x as u32);
        let high = low.map(|x| (x + 1).min(self.side - 1));
        let mut stencil = Stencil::default();
        for corner in 0..8 {
            let is_high: [bool; 3] = std::array::from_fn(|axis| corner >> axis & 1 == 1);
            let cell = std::array::from_fn(|k| if is_high[k] { high[k] } else { low[k] });
            let weight: f64 = (0..3)
                .map(|k| if is_high[k] { part[k] } else { 1.0 - part[k] })
                .product();
            stencil.push(self.index(cell), weight);
        }
        stencil
    }
}
