//! The faces of meshes that a light may meet first, by where they are.

use glam::{DVec2, DVec3};
use kiddo::{ImmutableKdTree, SquaredEuclidean};

use crate::reference::beams::pass::Light;
use crate::scene::Scene;
use crate::transport::first_surface::Chart;

/// Barycentric coordinates of a face's middle.
pub(super) const MIDDLE: DVec2 = DVec2::splat(1.0 / 3.0);

/// Faces, found by their middles.
pub(super) struct Faces {
    charts: Vec<Chart>,
    /// `None` of no face at all, or of so many in one place that there is no tree of them.
    tree: Option<ImmutableKdTree<f64, 3>>,
}

impl Faces {
    /// Those of a light.
    pub fn new(scene: &Scene, light: &Light) -> Self {
        let roots = light.roots(scene);
        let mut charts = Vec::new();
        let mut middles = Vec::new();
        for root in roots.iter() {
            let is_face = matches!(root.chart, Chart::Face { .. });
            if let (true, Some(place)) = (is_face, root.chart.place(scene.world(), MIDDLE)) {
                charts.push(root.chart);
                middles.push(place.point.position.to_array());
            }
        }
        let tree = if middles.is_empty() {
            None
        } else {
            ImmutableKdTree::new_from_slice(&middles).ok()
        };
        Self { charts, tree }
    }

    /// The face whose middle is nearest to a place.
    pub fn nearest(&self, place: DVec3) -> Option<Chart> {
        let nearest = self
            .tree
            .as_ref()?
            .query(&place.to_array())
            .nearest_one::<SquaredEuclidean<f64>>()
            .execute();
        self.charts.get(nearest.item as usize).copied()
    }
}
