//! The cone of a spot, which may be narrower than any patch of a first surface.

use glam::{DVec2, DVec3};

use super::chart::Chart;
use super::roots::middles;
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

/// A direction from the cone's tip to a place is known to this many units of rounding of the coordinates it
/// comes from, by their distance: a place is a product of a matrix and a sum of three vectors (16 roundings at
/// most), the difference and its length add 6, and an angle compares two such directions by 9 more. A patch that
/// is seen at a smaller angle is a point, however often it is divided.
const ROUNDINGS: f64 = 64.0;

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
    pub fn overlap(&self, world: &World, chart: &Chart, corners: [DVec2; 3]) -> ConeOverlap {
        let [a, b, c] = corners;
        let [bc, ca, ab] = middles(corners);
        let nodes = [a, b, c, bc, ca, ab];
        let mut rounding: f64 = 0.0;
        let directions = nodes.map(|at| {
            chart.place(world, at).map_or(DVec3::ZERO, |place| {
                let position = place.point.position;
                let offset = position - self.origin;
                let size = position.length().max(self.origin.length());
                // Of the tip itself there is no direction.
                if offset.length() > 0.0 {
                    let relative = f64::EPSILON * (size / offset.length()).max(1.0);
                    rounding = rounding.max(ROUNDINGS * relative);
                }
                offset.normalize_or_zero()
            })
        });
        let middle = directions.iter().sum::<DVec3>().normalize_or_zero();
        let radius = directions
            .iter()
            .map(|direction| angle(middle, *direction))
            .fold(0.0, f64::max);
        // From so near, a patch is all round.
        let is_wide = radius > 1.0;
        let nearest = angle(middle, self.axis) - BULGE * radius - rounding;
        ConeOverlap {
            is_possible: is_wide || nearest <= self.cutoff_angle,
            relative_size: if radius <= rounding {
                0.0
            } else {
                radius / self.cutoff_angle
            },
        }
    }
}

/// Between unit vectors \[rad\]; without loss of accuracy for small ones.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
