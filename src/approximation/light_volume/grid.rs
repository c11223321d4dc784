//! The grid that samples the water where its cells can be joined.

/// A grid of cells that can be joined by fours, some times.
#[derive(Clone, Copy, Debug)]
pub struct JoinedGrid {
    /// Cells along each side.
    pub(super) cells: u32,
    /// Times that cells can be joined.
    pub(super) levels: u32,
}

impl JoinedGrid {
    /// The smallest such grid that has at least `side` vertices along each side.
    pub fn new(buckets: u32, side: u32) -> Self {
        let mut levels = 0;
        while (buckets << levels) + 1 < side {
            levels += 1;
        }
        Self {
            cells: buckets << levels,
            levels,
        }
    }

    /// Vertices along each side.
    pub fn side(self) -> u32 {
        self.cells + 1
    }
}
