//! The faces of meshes, by position.

use glam::{DVec2, DVec3};
use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::geometry::Shape;
use crate::scene::Scene;
use crate::transport::first_surface::SurfaceChart;

/// Barycentric coordinates of a face's middle.
pub(super) const MIDDLE: DVec2 = DVec2::splat(1.0 / 3.0);

/// Faces of all shapes that mirror or refract, found by their middles.
pub(super) struct Faces {
    /// Shape and face.
    faces: Vec<(u32, u32)>,
    /// The tree of the middles; `None` if there is no face, or so many in one place that no tree can be
    /// built.
    tree: Option<ImmutableKdTree<f64, 3>>,
}

impl Faces {
    /// The faces of a scene.
    pub fn new(scene: &Scene) -> Self {
        let (mut faces, mut middles) = (Vec::new(), Vec::new());
        for (index, shape) in scene.world().shapes().iter().enumerate() {
            let index = index as u32;
            let is_specular = scene.material_of(index).is_specular(scene.materials());
            if let (true, Shape::Mesh(mesh)) = (is_specular, shape) {
                for face in 0..mesh.triangle_count() as u32 {
                    let [a, b, c] = mesh.corners(face);
                    faces.push((index, face));
                    middles.push(((a + b + c) / 3.0).to_array());
                }
            }
        }
        let tree = if middles.is_empty() {
            None
        } else {
            ImmutableKdTree::new_from_slice(&middles).ok()
        };
        Self { faces, tree }
    }

    /// The face whose middle is nearest to a place.
    pub fn nearest(&self, place: DVec3) -> Option<SurfaceChart> {
        let nearest = self
            .tree
            .as_ref()?
            .query(&place.to_array())
            .nearest_one::<SquaredEuclidean<f64>>()
            .execute();
        let &(shape, face) = self.faces.get(nearest.item as usize)?;
        Some(SurfaceChart::Face { shape, face })
    }
}
