//! What became of the light of some cells.

use crate::transport::flux::Flux;

/// Where the light of the cells went.
#[derive(Clone, Copy, Debug)]
pub struct Balance<const N: usize> {
    /// Light that set out towards the cells' surface \[W\], all signatures together, mean of channels.
    pub emitted: f64,
    /// On the film \[W\].
    pub received: Flux<N>,
    /// Cells finished.
    pub cells: u64,
    /// ... of which crossed by a border between topologies.
    pub cut_cells: u64,
    /// ... and of which no border could be found.
    pub unresolved_cells: u64,
    /// The flux that may be elsewhere because of borders \[W\].
    pub uncertain: Flux<N>,
}

impl<const N: usize> Default for Balance<N> {
    fn default() -> Self {
        Self {
            emitted: 0.0,
            received: Flux::BLACK,
            cells: 0,
            cut_cells: 0,
            unresolved_cells: 0,
            uncertain: Flux::BLACK,
        }
    }
}

impl<const N: usize> std::ops::AddAssign for Balance<N> {
    fn add_assign(&mut self, other: Self) {
        self.emitted += other.emitted;
        self.received += other.received;
        self.cells += other.cells;
        self.cut_cells += other.cut_cells;
        self.unresolved_cells += other.unresolved_cells;
        self.uncertain += other.uncertain;
    }
}
