//! Polygons that something ends before their goal.
//!
//! The polygon's middle met it. Beside the middle, other things may still be before it: the next glass, the
//! receiver, any surface that a camera sees. It may also be the facet that the polygon starts on, where
//! another surface crosses it.

use super::refiner::FacetRefiner;
use super::stopper::Stopper;
use crate::reference::beams::facets::land::{deposit_uncertain_area, node};
use crate::reference::beams::facets::leg::{Goal, LegWay, Watch, rectangular_receiver};
use crate::reference::beams::facets::polygon::LightPolygon;
use crate::transport::screen::Screen;

impl<const N: usize> FacetRefiner<'_, '_, '_, N> {
    /// Books a polygon that ends on a facet or a blocker, or finds the part of it that does not.
    pub(super) fn stop(&mut self, polygon: LightPolygon<N>, area: f64, stopper: Stopper) {
        let (watch, allowed) = (self.watch(&polygon), self.allowed(&polygon, area));
        let (goal, shape, way) = match stopper {
            Stopper::Facet(facet) => {
                let goal = Goal::Facet(facet);
                let shape = self.paths.facets().get(facet).shape;
                (goal, shape, self.legs.way(&polygon, goal, watch, allowed))
            }
            Stopper::Shape(shape) => {
                let counters = self.followed[polygon.signatures.start].counters();
                let way = self
                    .legs
                    .way_to_blocker(&polygon, shape, watch, allowed, counters);
                (Goal::Away, shape, way)
            }
        };
        let is_seen_by_camera = || {
            matches!(self.screen, Screen::Camera { .. })
                && self.has_all_events(&polygon)
                && !self.legs.is_end_unseen(shape)
        };
        match way {
            LegWay::Clear { .. } if is_seen_by_camera() => {
                let is_cut = match stopper {
                    Stopper::Facet(facet) => self.cut_to_view(&polygon, facet),
                    Stopper::Shape(_) => false,
                };
                if !is_cut {
                    self.give_back(&polygon);
                }
            }
            LegWay::Clear { uncertain_part }
                if uncertain_part > allowed && self.is_worth_halving(&polygon, area) =>
            {
                self.part(&polygon, area);
            }
            LegWay::Clear { uncertain_part } => {
                self.end(
                    &polygon,
                    (uncertain_part * area).max(polygon.uncertain_area),
                    area,
                );
            }
            LegWay::Facet(facet) => self.cut_out(polygon, facet, Some(goal)),
            LegWay::Obstructed => self.divide(&polygon, area, stopper.into()),
        }
    }

    /// The things that light of a polygon might meet before the one that ends it.
    fn watch(&self, polygon: &LightPolygon<N>) -> Watch {
        match self.screen {
            // Anything that is met first on the way to the first facet has a patch of its own.
            _ if polygon.chain.events() == 0 => Watch::Facet(polygon.chain.first()),
            Screen::Receiver(receiver) if self.has_all_events(polygon) => {
                Watch::Shape(receiver.shape())
            }
            Screen::Receiver(_) | Screen::Camera { .. } => Watch::Everything,
        }
    }

    /// Books a polygon that does not land, as far as is known. After its last event, its uncertain part may
    /// land.
    pub(super) fn end(&mut self, polygon: &LightPolygon<N>, uncertain_area: f64, area: f64) {
        if uncertain_area > 0.0 && self.has_all_events(polygon) {
            let nodes: Vec<_> = polygon
                .corners
                .iter()
                .filter_map(|light| node(self.paths, *self.screen, light))
                .collect();
            let bends_lines = self.bends_lines();
            let cells = &mut self.followed[polygon.signatures.start].cells;
            cells.balance.uncertain +=
                deposit_uncertain_area(cells.film(), bends_lines, &nodes, uncertain_area, area);
        }
        self.book(polygon, area);
    }

    /// True if lines may not be lines on the film: on a rectangle they are.
    pub(super) fn bends_lines(&self) -> bool {
        rectangular_receiver(self.paths, self.screen).is_none()
    }
}
