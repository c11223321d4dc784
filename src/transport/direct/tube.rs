//! A tube as an obstacle: its rims, the lines at which rays graze it, and where it meets the receiver.

use glam::DVec3;

use super::shaft::{Obstacle, Origin};
use super::shafts::{Shafts, TOUCHING};
use crate::geometry::{Bounds, Cylinder, Frame};

impl Shafts<'_> {
    /// The lines that a tube's shadow may end at. Its bounds instead if it touches the receiver's plane
    /// otherwise than upright, as it then meets it in an ellipse or along a line. The same if the emitter is
    /// on its wall.
    pub(super) fn of_tube(&self, tube: &Cylinder, bounds: Bounds) -> Vec<Obstacle> {
        let floor = &self.scene.world().shapes()[self.receiver.shape() as usize];
        let Some([center, _]) = floor.plane() else {
            return vec![Obstacle::Box(bounds)];
        };
        let (axis, radius) = (tube.axis(), tube.radius());
        let ends = [0.0, tube.length()].map(|along| tube.base() + axis * along);
        let [first, last] = ends.map(|end| self.normal.dot(end - center));
        let lean = self.normal.cross(axis).length();
        let reach = radius * lean;
        let near = TOUCHING * (ends[0].length() + ends[1].length() + radius + center.length());
        let (lowest, highest) = (first.min(last) - reach, first.max(last) + reach);
        if highest < -near {
            return Vec::new();
        }
        if lowest <= near && lean > TOUCHING || self.is_on_wall(tube) {
            return vec![Obstacle::Box(bounds)];
        }
        if self.is_along(tube) {
            // Its wall is seen from the edge, and hides nothing.
            return Vec::new();
        }
        let Frame { s, t, .. } = Frame::around(axis);
        let rim = |middle| Obstacle::Rim(middle, [s * radius, t * radius]);
        let line = |out: DVec3| Obstacle::Edge(ends.map(|end| end + out));
        // What is in the plane, or below it, ends there.
        let rims = [(ends[0], first), (ends[1], last)].map(|(end, height)| {
            if height <= near {
                rim(end - axis * (height / self.normal.dot(axis)))
            } else {
                rim(end)
            }
        });
        let mut found: Vec<Obstacle> = rims.into();
        found.extend(grazed(self.origin, tube).into_iter().flatten().map(line));
        found
    }

    /// True if the emitter is on a tube's wall, give or take rounding: the wall is then seen from the edge.
    fn is_on_wall(&self, tube: &Cylinder) -> bool {
        let Origin::At(position) = self.origin else {
            return false;
        };
        let offset = position - tube.base();
        let along = offset.dot(tube.axis());
        let off = (offset - tube.axis() * along).length() - tube.radius();
        let near = TOUCHING * (tube.radius() + tube.length());
        off.abs() <= near && (-near..=tube.length() + near).contains(&along)
    }

    /// True if the emitter's light is parallel and along a tube's axis: the shadow is no wider than rounding.
    fn is_along(&self, tube: &Cylinder) -> bool {
        match self.origin {
            Origin::At(_) => false,
            Origin::Towards(direction) => {
                let width = tube.length() * direction.cross(tube.axis()).length();
                width <= 1e-12 * tube.radius()
            }
        }
    }
}

/// The vectors from a tube's axis to the two lines at which an emitter's rays graze it. `None` if the emitter
/// is within the endless tube, or shines along it.
///
/// Let d be the emitter's distance from the axis, and r the radius. The lines are at the angle arccos(r/d)
/// from the direction towards the emitter, on either side; for parallel light at a right angle.
fn grazed(origin: Origin, tube: &Cylinder) -> Option<[DVec3; 2]> {
    let (axis, radius) = (tube.axis(), tube.radius());
    let way = origin.from(tube.base());
    let across = way - axis * way.dot(axis);
    let distance = across.length();
    let least = match origin {
        Origin::At(_) => radius,
        Origin::Towards(_) => 0.0,
    };
    if distance <= least {
        return None;
    }
    let towards = across / distance;
    let cos = least / distance;
    let sin = ((1.0 - cos) * (1.0 + cos)).sqrt();
    let aside = axis.cross(towards);
    Some([1.0, -1.0].map(|side| (towards * cos + aside * (side * sin)) * radius))
}
