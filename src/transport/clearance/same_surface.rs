//! Surfaces at an end of a leg that its light meets only there.

use glam::DVec3;

use super::cell::Clearance;
use super::legs::{Leg, LegContact};
use super::tube::tube_is_met_once;
use crate::geometry::{Hull, Mesh, Shape, range};

impl Clearance<'_> {
    /// True if a leg meets the surface at its start, or at its end, nowhere else.
    pub(super) fn meets_own_surface_once(&self, leg: &Leg, hull: &Hull, shape: u32) -> bool {
        match &self.scene.world().shapes()[shape as usize] {
            // A line meets a plane once. It does not meet a ball again that it leaves; a ball that it enters
            // it meets on the other side, where the leg ends.
            Shape::Sphere(_) | Shape::Rectangle(_) | Shape::Disk(_) => true,
            Shape::Cylinder(tube) => {
                tube_is_met_once(leg, tube, leg.starts_on(shape), leg.ends_on(shape))
            }
            Shape::Mesh(mesh) => self.mesh_is_met_once(leg, hull, shape, mesh),
        }
    }

    /// True if light leaves a mesh for good, or meets it first where the leg ends.
    ///
    /// From one path to the next, the mesh's part in it changes only at a silhouette or a border between
    /// them. So it suffices that no border is in the hull, and that all its faces face as those at the leg's
    /// end on the mesh. A leg may start and end on the same mesh. Then the first half of the hull may have
    /// faces as those at its start only, the second half as those at its end.
    fn mesh_is_met_once(&self, leg: &Leg, hull: &Hull, shape: u32, mesh: &Mesh) -> bool {
        let along = leg.along();
        let sign = |face: u32| facing(&along, mesh.corners(face));
        let alone = |faces: &[u32; 6]| {
            faces
                .iter()
                .all(|face| *face == faces[0])
                .then_some(faces[0])
        };
        let start = leg.starts_on(shape).then(|| Allowed {
            facing: sign(leg.from_faces[0]),
            // A flat face's edges are not in the way of light that leaves it.
            own: alone(&leg.from_faces),
        });
        let end = leg.ends_on(shape).then(|| Allowed {
            facing: sign(leg.to_faces[0]),
            // The chart's own face need not catch the light.
            own: (leg.from == LegContact::Source)
                .then(|| alone(&leg.to_faces))
                .flatten(),
        });
        match (start, end) {
            (Some(start), Some(end)) => {
                let [first, second] = hull.halves();
                self.has_only(&along, &first, shape, &start)
                    && self.has_only(&along, &second, shape, &end)
            }
            (Some(only), None) | (None, Some(only)) => self.has_only(&along, hull, shape, &only),
            (None, None) => false,
        }
    }

    /// True if all faces of a mesh in a hull face the allowed way and are away from any border.
    fn has_only(&self, along: &[DVec3; 6], hull: &Hull, shape: u32, allowed: &Allowed) -> bool {
        let Some(wanted) = allowed.facing else {
            return false;
        };
        let border = self.surfaces[shape as usize].border.as_ref();
        let is_bad = |face: u32, corners: &[DVec3; 3]| {
            let [a, b, c] = *corners;
            let normal = (b - a).cross(c - a);
            if normal == DVec3::ZERO || !hull.may_overlap_points(corners, &[normal]) {
                return false;
            }
            facing(along, *corners) != Some(wanted)
                || allowed.own != Some(face)
                    && (0..3).any(|edge| {
                        let [from, to] = [corners[edge], corners[(edge + 1) % 3]];
                        border.is_none_or(|border| border.is_at(face, edge))
                            && hull.may_overlap_points(&[from, to], &[])
                    })
        };
        let world = self.scene.world();
        !world.any_face(shape, hull.plane_pairs(), is_bad)
    }
}

/// The faces that may be in a part of a leg's hull.
struct Allowed {
    /// True if light goes the way of their normals; `None` if it grazes them.
    facing: Option<bool>,
    /// The face whose edges may be a border.
    own: Option<u32>,
}

/// True if all light goes the way of a face's normal (by its winding), false if all light goes against it;
/// `None` otherwise.
fn facing(along: &[DVec3; 6], [a, b, c]: [DVec3; 3]) -> Option<bool> {
    let normal = (b - a).cross(c - a);
    let [low, high] = range(&along.map(|along| along.dot(normal)));
    if low > 0.0 {
        Some(true)
    } else if high < 0.0 {
        Some(false)
    } else {
        None
    }
}
