//! The directions in which a source sees a patch.

use glam::{DVec2, DVec3};

use super::chart::Chart;
use super::roots::middles;
use crate::geometry::World;

/// The directions from a point to places of a patch.
#[derive(Clone, Copy, Debug)]
pub struct Fan {
    /// The middle one, a unit vector; 0 where there is none.
    pub middle: DVec3,
    /// The largest angle between the middle one and another \[rad\].
    pub radius: f64,
    /// What rounding may add to an angle \[rad\].
    pub rounding: f64,
}

/// A direction from a point to a place is known to this many units of rounding of the coordinates it
/// comes from, by their distance: a place is a product of a matrix and a sum of three vectors (16 roundings at
/// most), the difference and its length add 6, and an angle compares two such directions by 9 more.
const ROUNDINGS: f64 = 64.0;

/// Seen at a larger angle, half the opening \[rad\], a patch may be much nearer to the source somewhere than at its
/// corners, and be lit much more: of one that is not, the nearest point is as near as a corner but for a factor
/// cos(1/2).
const WIDEST: f64 = 0.5;

impl Fan {
    /// From `origin` to `places`.
    pub fn new(origin: DVec3, places: impl Iterator<Item = DVec3> + Clone) -> Self {
        let direction = |place: DVec3| (place - origin).normalize_or_zero();
        let middle = places.clone().map(direction).sum::<DVec3>();
        let middle = middle.normalize_or_zero();
        let (mut radius, mut rounding) = (0.0_f64, 0.0_f64);
        for place in places {
            radius = radius.max(angle(middle, direction(place)));
            let (size, distance) = (place.length().max(origin.length()), place.distance(origin));
            // Of the origin itself there is no direction.
            if distance > 0.0 {
                rounding = rounding.max(ROUNDINGS * f64::EPSILON * (size / distance).max(1.0));
            }
        }
        Self {
            middle,
            radius,
            rounding,
        }
    }

    /// From `origin` to the corners and edges' middles of a triangle of a chart's coordinates.
    pub fn of_triangle(origin: DVec3, world: &World, chart: &Chart, corners: [DVec2; 3]) -> Self {
        let [a, b, c] = corners;
        let [bc, ca, ab] = middles(corners);
        let places = [a, b, c, bc, ca, ab].map(|at| {
            let place = chart.place(world, at);
            place.map_or(origin, |place| place.point.position)
        });
        Self::new(origin, places.into_iter())
    }

    /// Whether the patch is so small that all directions to it are the same but for rounding.
    pub fn is_point(&self) -> bool {
        self.radius <= self.rounding
    }

    /// Whether the patch may be lit much more somewhere than at its corners.
    pub fn is_too_wide(&self) -> bool {
        self.radius > WIDEST && !self.is_point()
    }
}

/// Between unit vectors \[rad\]; without loss of accuracy for small ones.
pub(super) fn angle(a: DVec3, b: DVec3) -> f64 {
    a.cross(b).length().atan2(a.dot(b))
}
