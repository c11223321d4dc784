//! Facets near a leg, and the part of its light that may pass through them.

use glam::DVec3;

use super::end::LegEnd;
use super::legs::{LegLine, Legs};
use crate::geometry::PlanePair;
use crate::reference::beams::facets::polygon::is_below;
use crate::transport::facets::table::Facet;
use crate::transport::screen::Screen;

impl Legs<'_> {
    /// The space between the planes of the facets that the leg starts and ends on. What is before the first
    /// or beyond the second, or within `flatness` of either, is in nobody's way. A plane that some of the
    /// light passes the other way, or along, tells nothing.
    pub(super) fn between_ends(&self, from: Option<u32>, end: LegEnd) -> [PlanePair; 2] {
        /// Rounding of a product of unit vectors, a few times.
        const GRAZING: f64 = 64.0 * f64::EPSILON;
        let facets = self.paths.facets;
        let to = match (end, self.screen) {
            (LegEnd::Facet(to), _) => Some(to),
            (LegEnd::Sensor, Screen::Receiver(receiver)) => facets.of(receiver.shape(), 0),
            _ => None,
        };
        // The normal on the side that light goes to, and the plane's place along it.
        let ahead = |facet: u32| {
            let plane = facets.get(facet);
            let first = self.lines.first()?.ray.direction;
            let along = plane.normal() * plane.normal().dot(first).signum();
            let mut lines = self.lines.iter();
            lines
                .all(|line| along.dot(line.ray.direction) > GRAZING)
                .then(|| (along, along.dot(plane.origin())))
        };
        let start = from.and_then(ahead);
        let end = to.and_then(ahead);
        [
            start.map_or(PlanePair::EVERYWHERE, |(along, at)| {
                PlanePair::above(along, at + self.flatness)
            }),
            end.map_or(PlanePair::EVERYWHERE, |(along, at)| {
                PlanePair::below(along, at - self.flatness)
            }),
        ]
    }

    /// The part of the leg's light that may meet a facet which is between its ends and may be in its hull:
    /// 0 if planes and edges show that none does, `None` if only cutting tells.
    pub(super) fn part_across(&self, facet: u32, allowed: f64) -> Option<f64> {
        let other = self.paths.facets.get(facet);
        let first = self.lines[0].ray.direction;
        if let Some(part) = self.part_through(other, allowed) {
            return Some(part);
        }
        let side = other.normal().dot(first);
        let is_one_sided = self.is_affine()
            || self
                .lines
                .iter()
                .all(|line| other.normal().dot(line.ray.direction) * side > 0.0);
        let part = self.part_within(other, first, allowed)?;
        if is_one_sided {
            return Some(part);
        }
        // Some of the light comes from the facet's other side, from where its edges turn the other way.
        Some(part + self.part_within(other, -first, allowed)?)
    }

    /// The part of the leg's light that may pass between a facet's edges, seen along `direction`: the least
    /// that an edge lets through. `None` if a cut along them would separate more than `allowed` of it.
    fn part_within(&self, facet: &Facet, direction: DVec3, allowed: f64) -> Option<f64> {
        let mut least: Option<f64> = None;
        for edge in self.paths.facets.edges(facet, direction) {
            let sides = self.lines.iter().map(|line| edge.side(&line.ray));
            let rounding = edge.rounding(&self.lines[0].ray);
            if is_below(sides.clone(), rounding) {
                return Some(0.0);
            }
            if self.is_affine() {
                continue;
            }
            // Lines along which polygons were cut are bent: their ends, and the light between them, are a
            // little on the other side.
            let (low, high) = sides.clone().fold((0.0_f64, 0.0_f64), |(low, high), side| {
                (low.min(side), high.max(side))
            });
            let part = high / (high - low);
            // Straight cuts end at corners: light that bends over the edge between them is in none.
            let is_uncut = is_below(sides.take(self.corners), rounding);
            if is_uncut || part <= allowed {
                least = Some(least.map_or(part, |least| least.min(part)));
            }
        }
        least
    }

    /// The part of the leg's light that may pass through a facet's plane: 0 if the plane is not between
    /// starts and ends. `None` if only cutting separates more than `allowed` of it.
    fn part_through(&self, facet: &Facet, allowed: f64) -> Option<f64> {
        let range = |place: fn(&LegLine) -> DVec3| {
            let heights = self.lines.iter().map(|line| facet.height(place(line)));
            heights.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), height| {
                (low.min(height), high.max(height))
            })
        };
        let (start_low, start_high) = range(|line| line.ray.origin);
        let (low, high) = range(|line| line.end);
        if start_low.min(low) >= -self.flatness || start_high.max(high) <= self.flatness {
            return Some(0.0);
        }
        if self.is_affine() {
            return None;
        }
        // All starts are on one side, and some ends are a little through the plane, as they were cut along a
        // line that is bent. They are a part p of the range of heights. In a triangle on that side they are
        // no more than 1 − (1 − p)² of the area.
        let part = if start_low >= -self.flatness {
            -low / (high - low)
        } else if start_high <= self.flatness {
            high / (high - low)
        } else {
            return None;
        };
        let part = 2.0 * part;
        (part <= allowed).then_some(part)
    }
}
