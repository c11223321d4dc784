//! Polygons that no straight cut divides: they are halved, or left to cells.

use super::refiner::FacetRefiner;
use crate::geometry::Shape;
use crate::reference::beams::facets::charts::chart_of;
use crate::reference::beams::facets::land::{deposit_uncertain_area, node};
use crate::reference::beams::facets::polygon::{LegEnd, LightPolygon};
use crate::reference::beams::refine::Refiner;
use crate::transport::facets::path::FacetLight;
use crate::transport::first_surface::{SurfaceChart, SurfacePatch};
use crate::transport::path_end::next_hit;

/// Most obstacles that are not flat which the search for the next facet passes over.
const MAX_OBSTACLES: u32 = 8;

impl<const N: usize> FacetRefiner<'_, '_, N> {
    /// Divides a polygon that something without edges may be in the way of: halves it, or lets cells find the
    /// border. If these see none, all of its light is uncertain.
    pub(super) fn divide(
        &mut self,
        polygon: &LightPolygon<N>,
        area: f64,
        sight: LegEnd,
        generic: &mut Refiner<'_, '_, N>,
    ) {
        if self.is_worth_halving(polygon, area)
            && let Some(halves) = polygon.halves(self.paths)
        {
            self.pending.extend(halves);
            return;
        }
        let chart = self.chart(polygon);
        for corners in polygon.fan() {
            let cut_before = generic.balance.cut_cells;
            generic.refine(&SurfacePatch {
                chart,
                corners: corners.map(|corner| corner.at),
            });
            if generic.balance.cut_cells == cut_before {
                self.doubt(polygon.with(corners.to_vec()), sight);
            }
        }
    }

    /// Marks all light of a polygon as uncertain in the place where it would fall if nothing but facets were
    /// in its way.
    fn doubt(&mut self, mut polygon: LightPolygon<N>, sight: LegEnd) {
        let mut sight = Some(sight);
        while polygon.events < self.paths.events() {
            let facet = match sight.take() {
                _ if polygon.events == 0 => polygon.chain[0],
                Some(LegEnd::Facet(facet)) => facet,
                _ => match self.next_facet(&polygon) {
                    Some(facet) => facet,
                    None => return,
                },
            };
            if polygon.events > 0 {
                polygon.chain.push(facet);
            }
            self.meet(&mut polygon, facet);
        }
        let place = |light: &FacetLight<N>| node(self.paths, *self.screen, light);
        let Some(corners) = polygon
            .corners
            .iter()
            .map(place)
            .collect::<Option<Vec<_>>>()
        else {
            return;
        };
        let area = polygon.area_and_middle().0;
        self.balance.uncertain +=
            deposit_uncertain_area(self.film, self.bends_lines(), &corners, area, area);
    }

    /// The facet that a polygon's middle would meet next without all that is not flat.
    pub(super) fn next_facet(&mut self, polygon: &LightPolygon<N>) -> Option<u32> {
        let scene = self.paths.scene();
        let middle = polygon.area_and_middle().1;
        let light: FacetLight<N> = self.paths.follow(&polygon.chain, polygon.events, middle);
        if !light.is_on_its_way() {
            return None;
        }
        let mut ray = self
            .paths
            .search_ray(&light, &polygon.chain, polygon.events);
        for _ in 0..MAX_OBSTACLES {
            let (along, hit) = next_hit(scene, ray, &mut self.counters)?;
            if let Some(facet) = self.paths.facets().of(hit.shape, hit.face) {
                return Some(facet);
            }
            ray = scene
                .world()
                .bounce_point(&along, &hit)
                .spawn(along.direction);
        }
        None
    }

    /// Gives a polygon to the refiner of cells.
    pub(super) fn give_back(
        &mut self,
        polygon: &LightPolygon<N>,
        generic: &mut Refiner<'_, '_, N>,
    ) {
        let chart = self.chart(polygon);
        for corners in polygon.fan() {
            let corners = corners.map(|corner| corner.at);
            generic.refine(&SurfacePatch { chart, corners });
        }
    }

    /// The chart of a polygon's coordinates.
    fn chart(&self, polygon: &LightPolygon<N>) -> SurfaceChart {
        let facets = self.paths.facets();
        let facet = polygon.chain[0];
        let shape = &self.paths.scene().world().shapes()[facets.get(facet).shape as usize];
        chart_of(facets, facet, matches!(shape, Shape::Mesh(_)))
    }
}
