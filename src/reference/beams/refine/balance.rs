//! The balance of some cells' light.

use crate::transport::flux::Flux;

/// The balance of the light of some cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Balance<const N: usize> {
    /// Light \[W\] that set out towards the cells' surface, all signatures together, mean of channels.
    pub emitted: f64,
    /// Flux \[W\] on the film.
    pub received: Flux<N>,
    /// Number of cells finished.
    pub cells: u64,
    /// Number of those that a border between topologies crosses.
    pub cut_cells: u64,
    /// Number of those with a part in which no border could be found.
    pub unresolved_cells: u64,
    /// Uncertain flux \[W\]: it may be elsewhere because of borders.
    pub uncertain: Flux<N>,
}

impl<const N: usize> std::ops::AddAssign for Balance<N> {
    fn add_assign(&mut self, other: Self) {
        self.emitted += other.emitted;
        self.received += other.received;
        // Those of parts come from files, which may say anything.
        self.cells = self.cells.saturating_add(other.cells);
        self.cut_cells = self.cut_cells.saturating_add(other.cut_cells);
        self.unresolved_cells = self.unresolved_cells.saturating_add(other.unresolved_cells);
        self.uncertain += other.uncertain;
    }
}
