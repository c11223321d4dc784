//! The tests for light that is followed as polygons between flat faces: see `reference::beams::facets`.

use glam::DVec3;

use super::cell::{Clearance, apart};
use super::legs::{Leg, LegContact, LegSight, way_out};
use crate::geometry::{Hull, PlanePair, Shape};

impl Clearance<'_> {
    /// True if any of the watched shapes may be in a hull. Flat faces are in it only if they may be between
    /// all pairs of planes, too. There `is_in_the_way` decides by shape and face (0 for a rectangle): the
    /// caller knows planes and edges better.
    pub fn may_be_between<const K: usize>(
        &self,
        hull: &Hull<K>,
        pairs: &[PlanePair],
        is_watched: impl Fn(u32) -> bool,
        mut is_in_the_way: impl FnMut(u32, u32) -> bool,
    ) -> bool {
        let world = self.scene.world();
        let is_beside = |corners: &[DVec3]| pairs.iter().any(|pair| pair.is_beside(corners));
        self.surfaces.iter().enumerate().any(|(index, surface)| {
            let shape = index as u32;
            if surface.passed || !is_watched(shape) || apart(&surface.bounds, hull.bounds()) {
                return false;
            }
            match &world.shapes()[index] {
                Shape::Mesh(mesh) if !mesh.has_vertex_normals() => world.any_face(
                    shape,
                    hull.plane_pairs().chain(pairs.iter().copied()),
                    |face, corners| {
                        !is_beside(corners)
                            && hull.may_overlap_face(corners)
                            && is_in_the_way(shape, face)
                    },
                ),
                Shape::Rectangle(rectangle) => {
                    !is_beside(&rectangle.corners())
                        && self.may_be_in_the_way(hull, shape)
                        && is_in_the_way(shape, 0)
                }
                _ => self.may_be_in_the_way(hull, shape),
            }
        })
    }

    /// True if a shape keeps back all light of a bundle that leaves a source or another shape. All six paths
    /// of the bundle (corners, then middles of the opposite edges) end on it.
    pub fn is_kept_back(
        &self,
        start: [DVec3; 6],
        end: [DVec3; 6],
        shape: u32,
        faces: [u32; 6],
    ) -> bool {
        let leg = Leg {
            start,
            end,
            from: LegContact::Source,
            to: LegContact::Surface(shape),
            from_faces: [0; 6],
            to_faces: faces,
            sight: LegSight::NotAsked,
        };
        self.is_hidden(&leg)
    }

    /// A distance at which a ray from `origin` has left the scene.
    pub fn way_out(&self, origin: DVec3) -> f64 {
        way_out(self.scene, origin)
    }
}
