//! A store of paths followed lately.

use glam::DVec2;

use crate::transport::clearance::{Straight, Trail};
use crate::transport::first_surface::SurfaceChart;
use crate::transport::fixed_signature::{PathEnd, PathFollower};

/// A small store of paths by chart coordinates: neighbouring cells share nodes.
///
/// An entry is equal, to the bit, to the result of following the path again. So forgetting costs time only,
/// and results do not depend on the entries that it happens to hold.
pub struct PathStore<const N: usize> {
    /// Empty until a path is asked for.
    entries: Vec<Option<Entry<N>>>,
    /// Entries of earlier generations are forgotten.
    generation: u32,
    /// Legs of the entries that they were asked for, each at the same distance from the next.
    legs: Vec<Option<Straight>>,
    most_legs: usize,
}

/// A path held.
#[derive(Clone, Copy)]
struct Entry<const N: usize> {
    generation: u32,
    /// Number of legs held; 0 if none was asked for.
    legs: u32,
    surface: u64,
    at: DVec2,
    path: PathEnd<N>,
}

/// Number of entries: some hundred kilobytes, so that they stay in a core's second cache.
const ENTRIES: usize = 1 << 12;

impl<const N: usize> PathStore<N> {
    /// Memory \[bytes\] of a store for signatures of so many events, with legs.
    pub const fn bytes(events: usize) -> usize {
        ENTRIES * (size_of::<Option<Entry<N>>>() + (events + 1) * size_of::<Option<Straight>>())
    }

    /// An empty store, for one source and signatures of at most so many events.
    pub fn new(events: usize) -> Self {
        Self {
            entries: Vec::new(),
            generation: 0,
            legs: Vec::new(),
            most_legs: events + 1,
        }
    }

    /// Forgets all paths.
    pub fn forget(&mut self) {
        self.generation = self.generation.wrapping_add(1);
        if self.generation == 0 {
            self.entries.fill(None);
        }
    }

    /// The path at coordinates of a chart, followed only if it is not held; `with_legs`, these are held, too.
    #[inline]
    pub fn path(
        &mut self,
        follower: &mut PathFollower<'_, N>,
        chart: &SurfaceChart,
        at: DVec2,
        in_sight: bool,
        with_legs: bool,
    ) -> PathEnd<N> {
        let surface = surface_of(chart);
        let slot = slot(surface, at);
        match self.held(slot, surface, at) {
            Some(held) if held.legs > 0 || !with_legs => return held.path,
            _ => {}
        }
        if !with_legs {
            let path = follower.follow(chart, at, in_sight);
            self.hold(slot, surface, at, path, 0);
            return path;
        }
        if self.legs.is_empty() {
            self.legs = vec![None; ENTRIES * self.most_legs];
        }
        let legs = &mut self.legs[slot * self.most_legs..][..self.most_legs];
        let mut count = 0;
        let path = follower.follow_legs(chart, at, in_sight, |ray, hit| {
            legs[count] = Some(Straight {
                ray: *ray,
                hit: hit.copied(),
            });
            count += 1;
        });
        self.hold(slot, surface, at, path, count as u32);
        path
    }

    /// Writes the trail of a path, and returns the path.
    pub fn trail(
        &mut self,
        follower: &mut PathFollower<'_, N>,
        chart: &SurfaceChart,
        at: DVec2,
        in_sight: bool,
        trail: &mut Trail,
    ) -> PathEnd<N> {
        let path = self.path(follower, chart, at, in_sight, true);
        let slot = slot(surface_of(chart), at);
        let count = self.entries[slot].map_or(0, |entry| entry.legs as usize);
        let legs = &self.legs[slot * self.most_legs..][..count];
        trail.legs.clear();
        trail.legs.extend(legs.iter().flatten());
        (trail.end, trail.topology) = (path.end, path.topology);
        path
    }

    #[inline]
    fn held(&self, slot: usize, surface: u64, at: DVec2) -> Option<&Entry<N>> {
        self.entries.get(slot)?.as_ref().filter(|held| {
            held.generation == self.generation && held.surface == surface && held.at == at
        })
    }

    #[inline]
    fn hold(&mut self, slot: usize, surface: u64, at: DVec2, path: PathEnd<N>, legs: u32) {
        if self.entries.is_empty() {
            self.entries = vec![None; ENTRIES];
        }
        self.entries[slot] = Some(Entry {
            generation: self.generation,
            legs,
            surface,
            at,
            path,
        });
    }
}

/// A number for the surface that coordinates refer to.
fn surface_of(chart: &SurfaceChart) -> u64 {
    match *chart {
        SurfaceChart::Cap { shape, .. } | SurfaceChart::Parameters { shape } => {
            u64::from(shape) << 33
        }
        SurfaceChart::Face { shape, face } => u64::from(shape) << 33 | 1 << 32 | u64::from(face),
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
