//! Polygons that no straight cut divides: they are halved, or left to cells.

use super::refiner::FacetRefiner;
use crate::reference::beams::facets::leg::LegEnd;
use crate::reference::beams::facets::polygon::LightPolygon;
use crate::transport::facets::path::FacetLight;
use crate::transport::first_surface::SurfacePatch;
use crate::transport::path_end::next_hit;
use crate::transport::signature::Event;

/// Most obstacles that are not flat which the search for the next facet passes over.
const MAX_OBSTACLES: u32 = 8;

impl<const N: usize> FacetRefiner<'_, '_, '_, N> {
    /// Divides a polygon that something without edges may be in the way of: halves it, or lets cells find the
    /// border. If these see none, all of its light is uncertain.
    pub(super) fn divide(&mut self, polygon: &LightPolygon<N>, area: f64, sight: LegEnd) {
        if self.is_worth_halving(polygon, area)
            && let Some(halves) = polygon.halves(self.paths)
        {
            self.pending.extend(halves);
            return;
        }
        for signature in polygon.signatures.clone() {
            for corners in polygon.fan() {
                let patch = self.patch(polygon, &corners);
                let cells = &mut self.cells[signature];
                let cut_before = cells.balance.cut_cells;
                // What is cut must be known at once.
                cells.refine_all(&patch);
                if cells.balance.cut_cells == cut_before {
                    let mut part = polygon.with(corners.to_vec());
                    part.signatures = signature..signature + 1;
                    self.doubt(part, sight);
                }
            }
        }
    }

    /// Marks all light of one signature in a polygon as uncertain, in the place where it would fall if
    /// nothing but facets were in its way.
    fn doubt(&mut self, mut polygon: LightPolygon<N>, sight: LegEnd) {
        let mut sight = Some(sight);
        let signature = polygon.signatures.start;
        let events: Vec<Event> = self.cells[signature].signature().events().collect();
        for event in &events[polygon.chain.events()..] {
            let facet = match sight.take() {
                _ if polygon.chain.events() == 0 => polygon.chain.first(),
                Some(LegEnd::Facet(facet)) => facet,
                _ => match self.next_facet(&polygon) {
                    Some(facet) => facet,
                    None => return,
                },
            };
            self.meet(&mut polygon, facet, *event);
        }
        let nodes = polygon.corners.iter().map(|light| self.node(light));
        if let Some(nodes) = nodes.collect::<Option<Vec<_>>>() {
            let area = polygon.area();
            self.mark_uncertain(signature, &nodes, area, area);
        }
    }

    /// The facet that a polygon's middle would meet next without all that is not flat.
    pub(super) fn next_facet(&mut self, polygon: &LightPolygon<N>) -> Option<u32> {
        let scene = self.paths.scene;
        let middle = polygon.area_and_middle().1;
        let light: FacetLight<N> = self.paths.follow(&polygon.chain, middle);
        if !light.is_on_its_way() {
            return None;
        }
        let mut ray = self.paths.search_ray(&light, &polygon.chain);
        let counters = self.cells[polygon.signatures.start].counters_mut();
        for _ in 0..MAX_OBSTACLES {
            let (along, hit) = next_hit(scene, ray, counters)?;
            if let Some(facet) = self.paths.facets.of(hit.shape, hit.face) {
                return Some(facet);
            }
            ray = scene
                .world()
                .bounce_point(&along, &hit)
                .spawn(along.direction);
        }
        None
    }

    /// Gives a polygon to the refiners of cells.
    pub(super) fn give_back(&mut self, polygon: &LightPolygon<N>) {
        for signature in polygon.signatures.clone() {
            for corners in polygon.fan() {
                let patch = self.patch(polygon, &corners);
                self.cells[signature].leave(patch);
            }
        }
    }

    /// A triangle of a polygon, as a patch of the first facet.
    fn patch(&self, polygon: &LightPolygon<N>, corners: &[FacetLight<N>; 3]) -> SurfacePatch {
        SurfacePatch {
            chart: self.paths.facets.get(polygon.chain.first()).chart,
            corners: corners.each_ref().map(|corner| corner.at),
        }
    }
}
