//! Legs that cross cells, and the cells around a place.
//!
//! Places are relative to the object's centre, along the axes of its own space.

use glam::DVec3;

/// A leg of a photon's way, without its flux.
#[derive(Clone, Copy, Debug)]
pub struct Leg {
    /// Its start.
    pub from: DVec3,
    /// Its unit direction.
    pub direction: DVec3,
    /// Its length \[m\]; infinite if it leaves the scene.
    pub length: f64,
}

impl Leg {
    /// The place at some length.
    #[inline]
    pub fn at(&self, length: f64) -> DVec3 {
        self.from + self.direction * length
    }
}

/// A leg's part in a cell.
#[derive(Clone, Copy, Debug)]
pub struct Crossed {
    /// The cell.
    pub cell: u32,
    /// The length \[m\] at which the leg enters it.
    pub from: f64,
    /// The length \[m\] at which it leaves it.
    pub to: f64,
    /// The direction from the centre to the cell's middle: a unit vector on shells; of cubes the middle
    /// itself, by half the edge of them all.
    pub outward: DVec3,
}

/// Some cells with their shares in a mean.
#[derive(Clone, Copy, Debug, Default)]
pub struct Stencil {
    cells: [u32; 8],
    weights: [f64; 8],
    len: usize,
}

impl Stencil {
    /// One cell.
    pub fn one(cell: u32) -> Self {
        let mut stencil = Self::default();
        stencil.push(cell, 1.0);
        stencil
    }

    /// Eight cells with their shares.
    #[inline]
    pub fn eight(cell: impl Fn(usize) -> (u32, f64)) -> Self {
        let all: [(u32, f64); 8] = std::array::from_fn(cell);
        Self {
            cells: all.map(|(cell, _)| cell),
            weights: all.map(|(_, weight)| weight),
            len: 8,
        }
    }

    /// One cell more.
    #[inline]
    pub fn push(&mut self, cell: u32, weight: f64) {
        self.cells[self.len] = cell;
        self.weights[self.len] = weight;
        self.len += 1;
    }

    /// The cells.
    #[inline]
    pub fn cells(&self) -> &[u32] {
        &self.cells[..self.len]
    }

    /// The cells with their shares.
    #[inline]
    pub fn iter(&self) -> impl Iterator<Item = (u32, f64)> + '_ {
        self.cells().iter().copied().zip(self.weights)
    }
}
