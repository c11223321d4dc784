//! Surfaces that no node met but that may be in a leg's way.

use glam::{DVec2, DVec3};

use super::cell::Clearance;
use crate::geometry::{Cylinder, Hull, Shape};
use crate::numeric::math;

/// Number of flat-sided panels that a tube is divided into: each is then r (1/cos(π/32) − cos(π/32)), about a
/// hundredth of the radius, thick.
const PANELS: u32 = 32;

impl Clearance<'_> {
    /// True if any part of a shape may be in a hull.
    pub(super) fn may_be_in_the_way<const K: usize>(&self, hull: &Hull<K>, shape: u32) -> bool {
        let world = self.scene.world();
        match &world.shapes()[shape as usize] {
            Shape::Sphere(ball) => {
                hull.may_overlap_ball(ball.center(), ball.radius())
                    && !hull.is_inside_ball(ball.center(), ball.radius())
            }
            Shape::Rectangle(rectangle) => {
                hull.may_overlap_points(&rectangle.corners(), &[rectangle.normal()])
            }
            Shape::Disk(disk) => hull.may_overlap_disk(disk.center(), disk.half_axes()),
            Shape::Cylinder(tube) => tube_may_be_in_the_way(hull, tube),
            Shape::Mesh(_) => world.any_face(shape, hull.plane_pairs(), |_, corners| {
                hull.may_overlap_face(corners)
            }),
        }
    }
}

/// True if the wall of a tube may be in a hull. The tube is hollow: its inside is in nobody's way.
fn tube_may_be_in_the_way<const K: usize>(hull: &Hull<K>, tube: &Cylinder) -> bool {
    let panel = |index: u32| {
        let [from, to] = [index, index + 1].map(|i| f64::from(i) / f64::from(PANELS));
        let on = |u: f64, v: f64| tube.at_uv(DVec2::new(u, v)).position;
        let outward = on(0.5 * (from + to), 0.0) - tube.base();
        // The arc is between its chord and the tangents at its ends, which meet at r / cos(π/n) over the
        // arc's middle.
        let tip = outward / math::cos(std::f64::consts::PI / f64::from(PANELS));
        let top = tube.axis() * tube.length();
        let [a, b, c] = [on(from, 0.0), on(to, 0.0), tube.base() + tip];
        let corners: [DVec3; 6] = [a, b, c, a + top, b + top, c + top];
        hull.may_overlap_points(&corners, &[outward, tube.axis()])
    };
    let [low, high] = hull.reach(tube.axis());
    let base = tube.axis().dot(tube.base());
    high >= base && low <= base + tube.length() && (0..PANELS).any(panel)
}
