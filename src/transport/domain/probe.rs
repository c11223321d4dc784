//! Conservative tests if light of a cell can meet a box or a ball at all.

use glam::DVec3;

use crate::geometry::Bounds;
use crate::numeric::math;
use crate::numeric::rotation;

/// All points that light of a cell can pass through if nothing is in its way, or a set that holds them. "May
/// overlap" is never wrongly false, but may be wrongly true.
#[derive(Clone, Copy, Debug)]
pub enum Probe {
    /// A pyramid between four planes through its apex.
    Frustum {
        /// Start of the light.
        apex: DVec3,
        /// Unit normals of the planes, pointing inside.
        inward: [DVec3; 4],
        /// Largest distance of the start from the apex.
        apex_radius: f64,
    },
    /// A circular cone.
    Cone {
        /// Start of the light.
        apex: DVec3,
        /// Unit vector along the middle.
        axis: DVec3,
        /// Half the opening angle \[rad\], at most π.
        half_angle: f64,
        /// Largest distance of the start from the apex.
        apex_radius: f64,
    },
    /// A parallel beam of rectangular cross-section, endless both ways.
    Prism {
        /// Unit vectors across the beam.
        across: [DVec3; 2],
        /// The beam's extent along each of them.
        ranges: [[f64; 2]; 2],
    },
}

impl Probe {
    /// True if light of the cell may pass through the box.
    pub fn may_overlap_box(&self, bounds: &Bounds) -> bool {
        let center = bounds.center();
        let half = 0.5 * bounds.extent();
        // The extent of the box from its centre along a unit vector.
        let reach = |direction: DVec3| half.dot(direction.abs());
        match self {
            Self::Cone { .. } => self.may_overlap_ball(center, half.length()),
            _ => self.between_planes(center, reach),
        }
    }

    /// True if light of the cell may pass through the ball.
    pub fn may_overlap_ball(&self, center: DVec3, radius: f64) -> bool {
        match *self {
            Self::Cone {
                apex,
                axis,
                half_angle,
                apex_radius,
            } => {
                let to = center - apex;
                let distance = to.length();
                let reach = (radius + apex_radius) * (1.0 + SLACK);
                if distance <= reach {
                    return true;
                }
                let angle = rotation::angle_between(to, axis);
                angle <= half_angle + math::asin(reach / distance) + SLACK
            }
            _ => self.between_planes(center, |_| radius),
        }
    }

    /// The plane tests of frustum and prism for a body of the given reach.
    fn between_planes(&self, center: DVec3, reach: impl Fn(DVec3) -> f64) -> bool {
        match *self {
            Self::Frustum {
                apex,
                inward,
                apex_radius,
            } => {
                let to = center - apex;
                let rounding = SLACK * (center.abs() + apex.abs()).max_element();
                inward
                    .iter()
                    .all(|normal| normal.dot(to) >= -(reach(*normal) + apex_radius + rounding))
            }
            Self::Prism { across, ranges } => {
                across.iter().zip(&ranges).all(|(axis, [from, to])| {
                    let place = center.dot(*axis);
                    let reach = reach(*axis) + SLACK * center.abs().max_element();
                    place + reach >= *from && place - reach <= *to
                })
            }
            Self::Cone { .. } => true,
        }
    }
}

/// Relative room for the rounding of these tests themselves. It is a few hundred units in the last place,
/// since each test does about twenty operations.
const SLACK: f64 = 1e-13;
