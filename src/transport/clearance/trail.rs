//! The surfaces that a path met, leg by leg.

use glam::DVec2;

use crate::geometry::{Hit, Ray};
use crate::transport::first_surface::SurfaceChart;
use crate::transport::fixed_signature::{PathEnd, PathFollower};
use crate::transport::path_end::End;

/// A straight part of a path: the ray along it, and its hit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Straight {
    /// The ray, from the end of the part before, or past a surface that changes nothing.
    pub ray: Ray,
    /// The hit; `None` if the ray leaves the scene.
    pub hit: Option<Hit>,
}

/// The way a path ended, apart from the flux that it carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ending {
    /// The end.
    pub end: End,
    /// The surfaces that took part: see [`PathEnd::topology`].
    pub topology: u64,
}

/// A path, leg by leg as its follower reports it. Its memory may be used again.
#[derive(Clone, Debug, PartialEq)]
pub struct Trail {
    /// The legs. The first one ends on the chart's surface, even if something hides that.
    pub legs: Vec<Straight>,
    /// The path's end.
    pub path: Ending,
}

impl Default for Trail {
    /// The trail of a path that has not set out.
    fn default() -> Self {
        Self {
            legs: Vec::new(),
            path: Ending {
                end: End::Hidden,
                topology: 0,
            },
        }
    }
}

impl<const N: usize> From<&PathEnd<N>> for Ending {
    fn from(path: &PathEnd<N>) -> Self {
        Self {
            end: path.end,
            topology: path.topology,
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
        trail.path = Ending::from(&path);
        trail
    }
}
