//! Cuts of polygons whose light does not all meet the same thing.

use glam::DVec2;

use super::refiner::{FacetRefiner, MAX_CUTS};
use crate::reference::beams::facets::leg::LegEnd;
use crate::reference::beams::facets::polygon::{LightPolygon, Parts, PolygonCut};
use crate::transport::facets::path::FacetLight;
use crate::transport::first_surface::Source;

impl<const N: usize> FacetRefiner<'_, '_, '_, N> {
    /// Cuts out the part of a polygon within a facet's outline; the rest waits. Either a ray met the facet
    /// or, short of another end, it may be in the way.
    pub(super) fn cut_out(
        &mut self,
        mut polygon: LightPolygon<N>,
        facet: u32,
        short_of: Option<LegEnd>,
    ) {
        polygon.cuts += 1;
        if polygon.cuts > MAX_CUTS {
            self.give_back(&polygon);
            return;
        }
        let facets = self.paths.facets;
        let direction = polygon.corners[0].ray.direction;
        let mut values = Vec::with_capacity(polygon.corners.len());
        let mut was_cut = false;
        for edge in facets.edges(facets.get(facet), direction) {
            let side = |light: &FacetLight<N>| edge.side(&light.ray);
            values.clear();
            values.extend(polygon.corners.iter().map(side));
            match polygon.cut(&values, self.paths) {
                PolygonCut::Above => {}
                PolygonCut::Below => {
                    if short_of.is_none() {
                        // A ray through it met the facet: a sliver on the facet's edge.
                        self.settle(polygon, LegEnd::Facet(facet));
                    } else if was_cut {
                        // The light that may meet the facet is on the other side of the cut.
                        self.pending.push(polygon);
                    } else {
                        let area = polygon.area();
                        self.divide(&polygon, area, LegEnd::Facet(facet));
                    }
                    return;
                }
                PolygonCut::Through(parts) => {
                    let Some([mut inside, rest]) = self.split(&polygon, parts, &values, side)
                    else {
                        return;
                    };
                    self.pending.push(rest);
                    // All edges of a facet are one cut.
                    inside.cuts = polygon.cuts;
                    polygon = inside;
                    was_cut = true;
                }
            }
        }
        let area = polygon.area();
        let Some(end) = short_of else {
            self.go_on(polygon, area, LegEnd::Facet(facet));
            return;
        };
        if !was_cut && self.cut_where_surfaces_cross(&polygon, facet, end) {
            return;
        }
        if self.may_go_to_a_facet(&polygon) {
            self.go_on(polygon, area, LegEnd::Facet(facet));
        } else if was_cut {
            // Within its edges the facet may be behind something else, or it is the receiver: a ray will show
            // that.
            self.pending.push(polygon);
        } else {
            self.divide(&polygon, area, LegEnd::Facet(facet));
        }
    }

    /// Cuts a polygon whose leg starts or ends on both sides of a facet's plane, all of it within the facet's
    /// outline. The facet crosses the surface that the leg starts or ends on.
    fn cut_where_surfaces_cross(
        &mut self,
        polygon: &LightPolygon<N>,
        facet: u32,
        leg_end: LegEnd,
    ) -> bool {
        let (paths, screen) = (self.paths, self.screen);
        let plane = paths.facets.get(facet);
        let start = |light: &FacetLight<N>| Some(plane.height(light.ray.origin));
        let end = |light: &FacetLight<N>| {
            let place = leg_end.place(paths, screen, &light.ray)?;
            Some(plane.height(place))
        };
        self.cut_along(polygon, start) || self.cut_along(polygon, end)
    }

    /// Cuts a polygon where a function is zero; both parts wait. The function is linear along the polygon's
    /// edges for parallel light, and nearly so for light from a point. `false` if it is nowhere zero, or not
    /// known everywhere.
    fn cut_along(
        &mut self,
        polygon: &LightPolygon<N>,
        side: impl Fn(&FacetLight<N>) -> Option<f64>,
    ) -> bool {
        let values: Option<Vec<f64>> = polygon.corners.iter().map(&side).collect();
        let Some(values) = values else {
            return false;
        };
        let PolygonCut::Through(parts) = polygon.cut(&values, self.paths) else {
            return false;
        };
        let bent = |light: &FacetLight<N>| side(light).unwrap_or(f64::INFINITY);
        if let Some(both) = self.split(polygon, parts, &values, bent) {
            self.pending.extend(both);
        }
        true
    }

    /// The parts of a polygon above and below a cut, with the area that the cut made uncertain. `None` if the
    /// cut's line is too bent to be taken for straight: the polygon is halved instead.
    fn split(
        &mut self,
        polygon: &LightPolygon<N>,
        parts: Parts<N>,
        values: &[f64],
        side: impl Fn(&FacetLight<N>) -> f64,
    ) -> Option<[LightPolygon<N>; 2]> {
        let area = polygon.area();
        let weight = self.strength * polygon.largest_weight();
        let uncertain_area = self.bow(polygon, &parts.line, values, side) * area;
        if uncertain_area * weight > self.tolerance(polygon) && self.is_worth_halving(polygon, area)
        {
            self.part(polygon, area);
            return None;
        }
        Some([parts.above, parts.below].map(|corners| {
            let mut part = polygon.with(corners);
            // The light that this cut made uncertain is on either side of its line.
            part.uncertain_area =
                (part.share_of_uncertain_area(area) + uncertain_area).min(part.area());
            part
        }))
    }

    /// The part of a polygon that a straight cut puts on the wrong side of the bent line where `side` is
    /// zero. It is 0 for parallel light.
    ///
    /// The function falls from its largest to its smallest value over the polygon's width. A value of ε in
    /// the middle of the cut shows that the line is ε / (largest − smallest) of the width away. The area
    /// between an arc and its chord is 2/3 of height times length; ends may be off as well.
    fn bow(
        &self,
        polygon: &LightPolygon<N>,
        line: &[DVec2; 2],
        values: &[f64],
        side: impl Fn(&FacetLight<N>) -> f64,
    ) -> f64 {
        if matches!(self.paths.source, Source::Parallel { .. }) {
            return 0.0;
        }
        let range = values.iter().fold(f64::NEG_INFINITY, |l, &v| l.max(v))
            - values.iter().fold(f64::INFINITY, |l, &v| l.min(v));
        let middle = 0.5 * (line[0] + line[1]);
        let light = self.paths.follow(&polygon.chain, middle);
        side(&light).abs() / range
    }
}
