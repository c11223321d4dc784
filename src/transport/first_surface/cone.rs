//! The cone of a spot, which may be narrower than any patch of a first surface.

use glam::{DVec2, DVec3};

use super::chart::Chart;
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
    /// The angle that the patch is seen at, from its middle outwards, by the cone's.
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
    pub fn overlap(&self, world: &World, chart: &Chart, corners: [DVec2; 3]) -> ConeOverlap {
        let [a, b, c] = corners;
        let nodes = [a, b, c, 0.5 * (b + c), 0.5 * (c + a), 0.5 * (a + b)];
        let directions = nodes.map(|at| {
            let place = chart.place(world, at);
            place.map_or(DVec3::ZERO, |place| {
                (place.point.position - self.origin).normalize_or_zero()
            })
        });
        let middle = directions.iter().sum::<DVec3>().normalize_or_zero();
        let radius = directions
            .iter()
            .map(|direction| angle(middle, *direction))
            .fold(0.0, f64::max);
        // From so near, a patch is all round.
        let is_wide = radius > 1.0;
        let nearest = angle(middle, self.axis) - BULGE * radius;
        ConeOverlap {
            is_possible: is_wide || nearest <= self.cutoff_angle,
            relative_size: radius / self.cutoff_angle,
        }
    }
}

/// Between unit vectors \[rad\]; without loss of accuracy for small ones.
fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
