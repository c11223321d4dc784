//! Paths followed lately.

use glam::DVec2;

use super::cell::Node;
use crate::transport::first_surface::Chart;

/// A small store of paths by chart coordinates: neighbouring cells share nodes.
///
/// What it holds is what following the path again would give, to the bit; so what it forgets costs
/// time only, and results do not depend on what it happens to hold.
pub struct PathStore<const N: usize> {
    entries: Vec<Option<(u64, Node<N>)>>,
}

/// Entries: some hundred kilobytes, so that they stay in a core's second cache.
const ENTRIES: usize = 1 << 12;

impl<const N: usize> PathStore<N> {
    /// An empty store, for one source and one signature.
    pub fn new() -> Self {
        Self {
            entries: vec![None; ENTRIES],
        }
    }

    /// The path at coordinates of a chart, followed only where it is not held.
    #[inline]
    pub fn get(&mut self, chart: &Chart, at: DVec2, follow: impl FnOnce() -> Node<N>) -> Node<N> {
        let surface = surface_of(chart);
        let entry = &mut self.entries[slot(surface, at)];
        match entry {
            Some((held, node)) if *held == surface && node.at == at => *node,
            _ => {
                let node = follow();
                *entry = Some((surface, node));
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
