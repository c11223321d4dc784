//! Directions in which a source sees a patch.

use glam::{DVec2, DVec3};

use super::chart::SurfaceChart;
use super::triangle::middles;
use crate::geometry::{SurfacePoint, World};
use crate::numeric::rotation;

/// The directions from a point to places of a patch.
#[derive(Clone, Copy, Debug)]
pub struct Fan {
    /// The middle one, a unit vector; 0 if there is none.
    pub middle: DVec3,
    /// Largest angle \[rad\] between the middle one and another.
    pub radius: f64,
    /// Rounding error \[rad\] of an angle.
    pub rounding: f64,
    /// True if no place sees the source at more than rounding above its own plane.
    is_edge_on: bool,
}

/// Units of rounding of the coordinates that a direction comes from, by their distance; the place's own error
/// is added. A place is a product of a matrix and a sum of three vectors: 16 roundings at most. The
/// difference and its length add 6, and an angle compares two such directions by 9 more.
const ROUNDINGS: f64 = 64.0;

/// Largest angle, half the opening \[rad\], at which a patch's corners tell its light. Seen at a larger one,
/// the patch may be much nearer to the source somewhere than at its corners, and be lit much more. On a flat
/// one seen at a smaller angle, the nearest point is as near as a corner but for cos ½, and as bright but for
/// cos³ ½.
const WIDEST: f64 = 0.5;

/// Number of roundings up to which a patch's size is not divided any more: the height of a source over it
/// would be noise.
const SMALLEST: f64 = 1e4;

impl Fan {
    /// The fan from `origin` to `places`.
    pub fn new(origin: DVec3, places: impl Iterator<Item = SurfacePoint> + Clone) -> Self {
        let direction = |place: &SurfacePoint| (place.position - origin).normalize_or_zero();
        let middle = places.clone().map(|place| direction(&place));
        let middle = middle.sum::<DVec3>().normalize_or_zero();
        let mut fan = Self {
            middle,
            radius: 0.0,
            rounding: 0.0,
            is_edge_on: true,
        };
        for place in places {
            let offset = place.position - origin;
            let size = place.position.length().max(origin.length());
            let error = ROUNDINGS * f64::EPSILON * size + place.position_error.length();
            let height = offset.dot(place.geometric_normal).abs();
            fan.is_edge_on &= height <= error;
            fan.radius = fan
                .radius
                .max(rotation::angle_between(middle, direction(&place)));
            // There is no direction to the origin itself.
            if offset != DVec3::ZERO {
                let relative = error / offset.length() + ROUNDINGS * f64::EPSILON;
                fan.rounding = fan.rounding.max(relative);
            }
        }
        fan
    }

    /// The fan from `origin` to the corners and edges' middles of a triangle of a chart's coordinates, as far
    /// as there are any.
    pub fn of_triangle(
        origin: DVec3,
        world: &World,
        chart: &SurfaceChart,
        corners: [DVec2; 3],
    ) -> Self {
        let [a, b, c] = corners;
        let [bc, ca, ab] = middles(corners);
        let places = [a, b, c, bc, ca, ab].map(|at| chart.place(world, at));
        let points = places.into_iter().flatten().map(|place| place.point);
        Self::new(origin, points)
    }

    /// True if the patch is so small that all directions to it are the same but for rounding.
    pub fn is_point(&self) -> bool {
        self.radius <= self.rounding
    }

    /// True if the patch may be lit much more somewhere than at its corners.
    pub fn is_too_wide(&self) -> bool {
        self.radius > WIDEST.max(SMALLEST * self.rounding) && !self.is_edge_on
    }
}
