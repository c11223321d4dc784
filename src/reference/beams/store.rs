//! Paths followed lately.

use glam::DVec2;

use super::cell::Node;
use crate::transport::first_surface::Chart;

/// A small store of paths by chart coordinates: neighbouring cells share nodes.
///
/// What it holds is what following the path again would give, to the bit; so what it forgets costs
/// time only, and results do not depend on what it happens to hold.
pub struct PathStore<const N: usize> {
    entries: Vec<Option<Entry<N>>>,
    /// Entries of earlier generations are forgotten.
    generation: u32,
}

/// A path held.
#[derive(Clone, Copy)]
struct Entry<const N: usize> {
    generation: u32,
    surface: u64,
    node: Node<N>,
}

/// Entries: some hundred kilobytes, so that they stay in a core's second cache.
const ENTRIES: usize = 1 << 12;

impl<const N: usize> Default for PathStore<N> {
    /// An empty store, for one source and one signature.
    fn default() -> Self {
        Self {
            entries: vec![None; ENTRIES],
            generation: 0,
        }
    }
}

impl<const N: usize> PathStore<N> {
    /// Forgets all paths: what a task finds here, and so the work it counts, must not depend on
    /// the tasks before it on the same thread.
    pub fn forget(&mut self) {
        self.generation = self.generation.wrapping_add(1);
        if self.generation == 0 {
            self.entries.fill(None);
        }
    }

    /// The path at coordinates of a chart, followed only where it is not held.
    #[inline]
    pub fn get(&mut self, chart: &Chart, at: DVec2, follow: impl FnOnce() -> Node<N>) -> Node<N> {
        let surface = surface_of(chart);
        let generation = self.generation;
        let place = &mut self.entries[slot(surface, at)];
        match place {
            Some(held)
                if held.generation == generation
                    && held.surface == surface
                    && held.node.at == at =>
            {
                held.node
            }
            _ => {
                let node = follow();
                *place = Some(Entry {
                    generation,
                    surface,
                    node,
                });
                node
            }
        }
    }
}

/// A number for the surface that coordinates refer to.
fn surface_of(chart: &Chart) -> u64 {
    match *chart {
        Chart::Cap { shape, .. } | Chart::Parameters { shape } => u64::from(shape) << 33,
        Chart::Face { shape, face } => u64::from(shape) << 33 | 1 << 32 | u64::from(face),
    }
}

/// Coordinates are short binary fractions on a grid: multiplications mix their high bits down.
#[inline]
fn slot(surface: u64, at: DVec2) -> usize {
    let mixed = (at.x.to_bits() ^ surface.rotate_left(17))
        .wrapping_mul(0x9e37_79b9_7f4a_7c15)
        .wrapping_add(at.y.to_bits())
        .wrapping_mul(0xbf58_476d_1ce4_e5b9);
    (mixed >> 52) as usize
}

const _: () = assert!(ENTRIES == 1 << (64 - 52));
