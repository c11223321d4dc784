//! Cells of space around an object.
//!
//! Places are relative to the object's centre, along the axes of its own space.

use glam::DVec3;

use super::grid::Grid;
use super::leg::Stencil;
use super::shells::Shells;
use crate::numeric::math;

/// Cells of space.
#[derive(Clone, Debug)]
pub enum Cells {
    /// Cubes.
    Grid(Grid),
    /// Triangles on shells.
    Shells(Box<Shells>),
}

impl Cells {
    /// All cells.
    pub fn count(&self) -> usize {
        match self {
            Self::Grid(grid) => grid.count(),
            Self::Shells(shells) => shells.count(),
        }
    }

    /// The middle of a cell.
    #[inline]
    pub fn middle(&self, cell: u32) -> DVec3 {
        match self {
            Self::Grid(grid) => grid.middle(cell),
            Self::Shells(shells) => shells.middle(cell),
        }
    }

    /// A cell's volume \[m³\].
    #[inline]
    pub fn volume(&self, cell: u32) -> f64 {
        match self {
            Self::Grid(grid) => grid.volume(),
            Self::Shells(shells) => shells.volume(cell),
        }
    }

    /// The largest distance \[m\] between two places of a cell.
    pub fn diagonal(&self) -> f64 {
        match self {
            Self::Grid(grid) => grid.edge() * 3.0f64.sqrt(),
            Self::Shells(shells) => {
                let radii = shells.radii();
                let thickest = radii
                    .windows(2)
                    .fold(0.0, |most: f64, pair| most.max(pair[1] - pair[0]));
                let widest =
                    radii[radii.len() - 1] * 1.3 / f64::from(shells.geodesic().frequency());
                math::hypot(thickest, widest)
            }
        }
    }

    /// The cells around a place with their shares in a linear mean.
    #[inline]
    pub fn linear(&self, place: DVec3) -> Stencil {
        match self {
            Self::Grid(grid) => grid.linear(place),
            Self::Shells(shells) => shells.linear(place),
        }
    }

    /// The cell of a place.
    #[inline]
    pub fn nearest(&self, place: DVec3) -> Stencil {
        match self {
            Self::Grid(grid) => grid.nearest(place),
            Self::Shells(shells) => shells.nearest(place),
        }
    }
}
