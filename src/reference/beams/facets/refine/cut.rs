//! Polygons cut along what part of them meets.

use glam::DVec2;

use super::FacetRefiner;
use crate::reference::beams::facets::polygon::{Cut, Polygon, Sight};
use crate::reference::beams::refine::Refiner;
use crate::transport::facets::path::FacetLight;
use crate::transport::first_surface::Source;

impl<const N: usize> FacetRefiner<'_, '_, N> {
    /// Cuts out what meets a facet, as a ray showed or as may be; the rest waits.
    pub(super) fn cut_out(
        &mut self,
        mut polygon: Polygon<N>,
        facet: u32,
        is_seen: bool,
        generic: &mut Refiner<'_, '_, N>,
    ) {
        let facets = self.paths.facets();
        polygon.cuts += 1;
        let weight = self.strength * polygon.largest_weight();
        let direction = polygon.corners[0].ray.direction;
        let mut values = Vec::with_capacity(polygon.corners.len());
        let mut was_cut = false;
        for edge in facets.edges(facets.get(facet), direction) {
            values.clear();
            values.extend(polygon.corners.iter().map(|corner| edge.side(&corner.ray)));
            match polygon.cut(&values, self.paths) {
                Cut::Above => {}
                Cut::Below => {
                    if is_seen {
                        // A ray through it met the facet: a sliver on the facet's edge.
                        self.settle(polygon, Sight::Facet(facet), generic);
                    } else if was_cut {
                        // The light that may meet the facet is on the other side of the cut.
                        self.pending.push(polygon);
                    } else {
                        let area = polygon.area_and_middle().0;
                        self.divide(&polygon, area, Sight::Facet(facet), generic);
                    }
                    return;
                }
                Cut::Through(parts) => {
                    let area = polygon.area_and_middle().0;
                    let astray = self.bow(&polygon, &parts.line, &values, |light| {
                        edge.side(&light.ray)
                    }) * area;
                    if astray * weight > self.tolerance && self.is_worth_halving(&polygon, area) {
                        self.part(&polygon, area, generic);
                        return;
                    }
                    let mut rest = polygon.with(parts.below);
                    polygon.corners = parts.above;
                    // What this cut put astray is on either side of its line.
                    for part in [&mut rest, &mut polygon] {
                        part.astray = (part.share_of_astray(area) + astray).min(part.area());
                    }
                    self.pending.push(rest);
                    was_cut = true;
                }
            }
        }
        let area = polygon.area_and_middle().0;
        let is_goal = polygon.events > 0 && polygon.events < self.paths.events();
        if is_seen || is_goal {
            self.go_on(polygon, area, Sight::Facet(facet), generic);
        } else if was_cut {
            // Within its edges the facet may be behind something else, the receiver may be what it is: a ray will show that.
            self.pending.push(polygon);
        } else {
            self.divide(&polygon, area, Sight::Facet(facet), generic);
        }
    }

    /// The part of a polygon that a straight cut puts on the wrong side of the bent line where
    /// `side` is zero; 0 for parallel light.
    ///
    /// The function falls from its largest to its smallest value over the polygon's width; a value of
    /// ε in the middle of the cut tells that the line is ε / (largest − smallest) of the width away.
    /// The area between an arc and its chord is 2/3 of height and length; ends may be off as well.
    fn bow(
        &self,
        polygon: &Polygon<N>,
        line: &[DVec2; 2],
        values: &[f64],
        side: impl Fn(&FacetLight<N>) -> f64,
    ) -> f64 {
        if matches!(self.paths.source(), Source::Parallel { .. }) {
            return 0.0;
        }
        let range = values.iter().fold(f64::NEG_INFINITY, |l, &v| l.max(v))
            - values.iter().fold(f64::INFINITY, |l, &v| l.min(v));
        let middle = 0.5 * (line[0] + line[1]);
        let light = self.paths.follow(&polygon.chain, polygon.events, middle);
        side(&light).abs() / range
    }
}
