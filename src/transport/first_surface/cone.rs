//! The cone of a spot, which may be narrower than any patch of a first surface.

use glam::{DVec2, DVec3};

use super::chart::SurfaceChart;
use super::fan::Fan;
use super::source::Source;
use crate::geometry::World;
use crate::numeric::rotation;
use crate::transport::domain::chart::Falloff;

/// The cone of all light of a spot.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    origin: DVec3,
    /// A unit vector.
    axis: DVec3,
    /// Half the opening angle \[rad\].
    cutoff_angle: f64,
}

/// The overlap of a cone and a patch.
#[derive(Clone, Copy, Debug)]
pub struct ConeOverlap {
    /// True if any part of the patch may be in the cone.
    pub is_possible: bool,
    /// The angle from the patch's middle outwards at which it is seen, in units of the cone's. It is 0 for a
    /// patch so small that directions to it are all the same but for rounding.
    pub relative_size: f64,
}

/// Factor for the angle that a patch's six nodes are seen at: they do not show how its surface bulges between
/// them. (An arc of less than a radian bulges by less than a quarter of its half chord.)
const BULGE: f64 = 1.25;

impl Cone {
    /// The cone of a source that has one.
    pub fn of(source: &Source) -> Option<Self> {
        match *source {
            Source::Point {
                origin,
                falloff:
                    Falloff::Spot {
                        axis, cutoff_angle, ..
                    },
                ..
            } => Some(Self {
                origin,
                axis,
                cutoff_angle,
            }),
            _ => None,
        }
    }

    /// Its overlap with a triangle of a chart's coordinates.
    pub fn overlap(&self, world: &World, chart: &SurfaceChart, corners: [DVec2; 3]) -> ConeOverlap {
        self.overlap_of(&Fan::of_triangle(self.origin, world, chart, corners))
    }

    /// Its overlap with a patch as seen from the cone's tip.
    pub(super) fn overlap_of(&self, fan: &Fan) -> ConeOverlap {
        // From so near, a patch is all round.
        let is_wide = fan.radius > 1.0;
        let nearest =
            rotation::angle_between(fan.middle, self.axis) - BULGE * fan.radius - fan.rounding;
        ConeOverlap {
            is_possible: is_wide || nearest <= self.cutoff_angle,
            // A patch that is a point stays one however often it is divided.
            relative_size: if fan.is_point() {
                0.0
            } else {
                fan.radius / self.cutoff_angle
            },
        }
    }
}
