//! The surfaces that a path met, leg by leg.

use glam::DVec2;

use crate::geometry::{Hit, Ray};
use crate::transport::first_surface::SurfaceChart;
use crate::transport::fixed_signature::PathFollower;
use crate::transport::path_end::End;

/// A straight part of a path: the ray along it, and its hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Straight {
    /// The ray, from the end of the part before, or past a surface that changes nothing.
    pub ray: Ray,
    /// The hit; `None` if the ray leaves the scene.
    pub hit: Option<Hit>,
}

/// A path, leg by leg as its follower reports it. Its memory may be used again.
#[derive(Clone, Debug, PartialEq)]
pub struct Trail {
    /// The legs. The first one ends on the chart's surface, even if something hides that.
    pub legs: Vec<Straight>,
    /// The path's end.
    pub end: End,
    /// The surfaces that took part: see
    /// [`PathEnd::topology`](crate::transport::fixed_signature::PathEnd::topology).
    pub topology: u64,
}

impl Default for Trail {
    /// The trail of a path that has not set out.
    fn default() -> Self {
        Self {
            legs: Vec::new(),
            end: End::Hidden,
            topology: 0,
        }
    }
}

impl Trail {
    /// The path that meets the chart's surface at `at`, as [`PathFollower::follow`] finds it.
    pub fn follow<const N: usize>(
        follower: &mut PathFollower<'_, N>,
        chart: &SurfaceChart,
        at: DVec2,
        in_sight: bool,
    ) -> Self {
        let mut trail = Self::default();
        let path = follower.follow_legs(chart, at, in_sight, |ray, hit| {
            trail.legs.push(Straight {
                ray: *ray,
                hit: hit.copied(),
            });
        });
        (trail.end, trail.topology) = (path.end, path.topology);
        trail
    }
}
