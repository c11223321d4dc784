//! Polygons that end on a surface of which a camera sees a small part.
//!
//! Cells find the light that a camera sees. They would follow the borders of all that the polygon holds, to a
//! fineness that the film asks for. So what is far beside the film is cut off before.

use super::refiner::FacetRefiner;
use crate::reference::beams::facets::leg::LegEnd;
use crate::reference::beams::facets::polygon::{LightPolygon, PolygonCut};
use crate::transport::facets::path::FacetLight;

impl<const N: usize> FacetRefiner<'_, '_, '_, N> {
    /// Cuts a polygon that ends on a facet along a plane beside the camera's film; both parts wait. `false`
    /// if no plane parts it.
    ///
    /// The planes are a little beyond those that a camera's view ends at: of the part outside, nothing is
    /// seen, even if the cut's line is bent.
    pub(super) fn cut_to_view(&mut self, polygon: &LightPolygon<N>, facet: u32) -> bool {
        let (paths, screen) = (self.paths, self.screen);
        for [point, normal] in &self.view {
            let rounding = self.legs.flatness() * normal.length();
            let side = |light: &FacetLight<N>| {
                let end = LegEnd::Facet(facet).place(paths, screen, &light.ray)?;
                let value = normal.dot(end - *point);
                Some(if value.abs() <= rounding { 0.0 } else { value })
            };
            let values: Option<Vec<f64>> = polygon.corners.iter().map(side).collect();
            let Some(values) = values else {
                return false;
            };
            if let PolygonCut::Through(parts) = polygon.cut(&values, paths) {
                for corners in [parts.above, parts.below] {
                    let mut part = polygon.with(corners);
                    // What a view is cut from may be larger by any factor: its own size is what counts.
                    part.whole = part.area();
                    // Any border may be in a small part.
                    part.uncertain_area = polygon.uncertain_area.min(part.whole);
                    self.pending.push(part);
                }
                return true;
            }
        }
        false
    }

    /// The same for a polygon that lands, by the facet that it lands on.
    pub(super) fn is_sensor_cut_to_view(&mut self, polygon: &LightPolygon<N>) -> bool {
        !self.view.is_empty()
            && self
                .next_facet(polygon)
                .is_some_and(|facet| self.cut_to_view(polygon, facet))
    }
}
