//! What a path met, leg by leg.

use glam::DVec2;

use crate::geometry::{Hit, Ray};
use crate::transport::first_surface::SurfaceChart;
use crate::transport::fixed_signature::{PathEnd, PathFollower};
use crate::transport::path_end::End;

/// A straight part of a path: the ray along it, and what it met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Straight {
    /// From where the last part ended, or past a surface that changes nothing.
    pub ray: Ray,
    /// `None` where nothing is there any more.
    pub hit: Option<Hit>,
}

/// How a path ended, whatever it carries.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ending {
    /// How.
    pub end: End,
    /// By way of which surfaces: see [`PathEnd::topology`].
    pub topology: u64,
}

/// A path, leg by leg as its follower tells of them; its memory may be used again.
#[derive(Clone, Debug, PartialEq)]
pub struct Trail {
    /// The first one ends on the chart's surface, whether that is seen or not.
    pub legs: Vec<Straight>,
    /// How it ended.
    pub path: Ending,
}

impl Default for Trail {
    /// Of a path that has not set out.
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
    /// The path that meets the chart's surface at `at`, as of [`PathFollower::follow`].
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
