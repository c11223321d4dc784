//! Places that neighbouring faces of a smooth mesh share.

use glam::DVec2;

use super::chart::SurfaceChart;
use super::source::Source;
use crate::geometry::{Mesh, Shape, VertexFans};
use crate::scene::Scene;
use crate::transport::scatter::ShadingNormals;

/// Owners of places that several faces share: edges and vertices of a mesh whose normals are interpolated.
///
/// There the faces see one point with one normal. Light that leaves all of them goes the same way from there
/// on, so that it is followed once. Two things are each face's own: the amount of light that falls on an
/// area, and whether light that leaves runs into its plane
/// ([`PathFollower::emitted_alike`](crate::transport::fixed_signature::PathFollower::emitted_alike)).
pub struct SharedPlaces<'a> {
    scene: &'a Scene,
    /// Faces round each vertex, for smooth meshes, by shape.
    fans: Vec<Option<VertexFans>>,
}

impl<'a> SharedPlaces<'a> {
    /// Looks through the scene's meshes once. With [`ShadingNormals::Adjoint`] flux depends on the angle of
    /// each face to its normals, and nothing is shared.
    pub fn new(scene: &'a Scene, shading_normals: ShadingNormals) -> Self {
        let do_share = shading_normals == ShadingNormals::Flux;
        let fans = scene
            .world()
            .shapes()
            .iter()
            .zip(0..)
            .map(|(shape, index)| {
                let is_first = scene.material_of(index).is_specular(scene.materials());
                match shape {
                    Shape::Mesh(mesh) if do_share && is_first && mesh.has_vertex_normals() => {
                        Some(mesh.vertex_fans())
                    }
                    _ => None,
                }
            });
        Self {
            fans: fans.collect(),
            scene,
        }
    }

    /// True if no place is shared.
    pub fn is_empty(&self) -> bool {
        self.fans.iter().all(Option::is_none)
    }

    /// The chart and coordinates of a shared place on its lowest-numbered face, among those that face the
    /// source as `chart`'s does. They are the arguments if no lower face has it.
    #[inline]
    pub fn owner(&self, source: &Source, chart: &SurfaceChart, at: DVec2) -> (SurfaceChart, DVec2) {
        self.lower_face(source, chart, at).unwrap_or((*chart, at))
    }

    fn lower_face(
        &self,
        source: &Source,
        chart: &SurfaceChart,
        at: DVec2,
    ) -> Option<(SurfaceChart, DVec2)> {
        let &SurfaceChart::Face { shape, face } = chart else {
            return None;
        };
        // Coordinates are binary fractions of few digits: sums are exact.
        let weights = [1.0 - at.x - at.y, at.x, at.y];
        if weights.iter().all(|weight| *weight != 0.0) {
            return None;
        }
        let fans = self.fans.get(shape as usize)?.as_ref()?;
        let Shape::Mesh(mesh) = &self.scene.world().shapes()[shape as usize] else {
            return None;
        };
        let vertices = mesh.triangles()[face as usize];
        let on =
            |index: usize| (weights[index] != 0.0).then_some((vertices[index], weights[index]));
        let mut ends = (0..3).filter_map(on);
        let (first, second) = (ends.next()?, ends.next());
        let side = facing(mesh, face, source);
        let owner = fans
            .of(first.0)
            .iter()
            .copied()
            .take_while(|&other| other < face)
            .find(|&other| {
                let has_second =
                    second.is_none_or(|(end, _)| mesh.triangles()[other as usize].contains(&end));
                has_second && facing(mesh, other, source) * side > 0.0
            })?;
        let theirs = mesh.triangles()[owner as usize];
        let weight = |vertex: u32| match second {
            _ if vertex == first.0 => first.1,
            Some((end, weight)) if vertex == end => weight,
            _ => 0.0,
        };
        let chart = SurfaceChart::Face { shape, face: owner };
        Some((chart, DVec2::new(weight(theirs[1]), weight(theirs[2]))))
    }
}

/// 1 or −1, by the side of a face that the source is on; 0 for a face without area.
#[inline]
fn facing(mesh: &Mesh, face: u32, source: &Source) -> f64 {
    let [a, b, c] = mesh.corners(face);
    let along = source.towards(a).dot((b - a).cross(c - a));
    if along == 0.0 { 0.0 } else { along.signum() }
}
