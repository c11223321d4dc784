//! The cone of a spot, which may be narrower than any patch of a first surface.

use glam::{DVec2, DVec3};

use super::chart::SurfaceChart;
use super::fan::{Fan, angle};
use super::source::Source;
use crate::geometry::World;
use crate::transport::domain::chart::Falloff;

/// The cone that a spot's light is in.
#[derive(Clone, Copy, Debug)]
pub struct Cone {
    origin: DVec3,
    /// A unit vector.
    axis: DVec3,
    /// Half the opening angle \[rad\].
    cutoff_angle: f64,
}

/// What a cone has to do with a patch.
#[derive(Clone, Copy, Debug)]
pub struct ConeOverlap {
    /// Whether any of the patch may be in the cone.
    pub is_possible: bool,
    /// The angle that the patch is seen at, from its middle outwards, by the cone's; 0 of a patch so small that
    /// directions to it are all the same but for rounding.
    pub relative_size: f64,
}

/// A patch's six nodes do not show how its surface bulges between them: this much may be added to the
/// angle they are seen at. (An arc of less than a radian bulges by less than a quarter of its half
/// chord.)
const BULGE: f64 = 1.25;

impl Cone {
    /// That of a source which has one.
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

    /// Compares it with a triangle of a chart's coordinates.
    pub fn overlap(&self, world: &World, chart: &SurfaceChart, corners: [DVec2; 3]) -> ConeOverlap {
        self.overlap_of(&Fan::of_triangle(self.origin, world, chart, corners))
    }

    /// Compares it with a patch as it is seen from the cone's tip.
    pub(super) fn overlap_of(&self, fan: &Fan) -> ConeOverlap {
        // From so near, a patch is all round.
        let is_wide = fan.radius > 1.0;
        let nearest = angle(fan.middle, self.axis) - BULGE * fan.radius - fan.rounding;
        ConeOverlap {
            is_possible: is_wide || nearest <= self.cutoff_angle,
            // A patch that is a point is one however often it is divided.
            relative_size: if fan.is_point() {
                0.0
            } else {
                fan.radius / self.cutoff_angle
            },
        }
    }
}
