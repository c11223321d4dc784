//! The search for obstacles in the way of legs.

use glam::{DVec2, DVec3};

use crate::geometry::{Hull, Ray, Shape, TraversalCounters, bulge};
use crate::reference::beams::facets::polygon::LightPolygon;
use crate::transport::clearance::Clearance;
use crate::transport::facets::path::{FacetLight, FacetPaths};
use crate::transport::facets::table::Facets;
use crate::transport::first_surface::Source;
use crate::transport::path_end::next_hit;
use crate::transport::screen::Screen;

/// The goal of all light of a leg if nothing is in its way.
#[derive(Clone, Copy, Debug)]
pub(in crate::reference::beams::facets) enum Goal {
    /// To a facet, within its edges.
    Facet(u32),
    /// To the plane of the receiver.
    Receiver,
    /// Out of the scene.
    Away,
}

impl Goal {
    /// True if the place of the light at the goal is known before a search. It is not for the surfaces that a
    /// camera sees, nor on a receiver on whose film lines are not lines.
    fn is_known(self, paths: &FacetPaths<'_>, screen: &Screen<'_>) -> bool {
        !matches!(self, Self::Receiver) || rectangular_receiver(paths, screen).is_some()
    }

    /// The point where a ray's line meets a facet's or a rectangular receiver's plane; `None` for other
    /// goals.
    pub(in crate::reference::beams::facets) fn place(
        self,
        paths: &FacetPaths<'_>,
        screen: &Screen<'_>,
        ray: &Ray,
    ) -> Option<DVec3> {
        match self {
            Self::Facet(facet) => Some(paths.facets().get(facet).meet(ray)?.position),
            Self::Receiver => {
                Some(ray.at(rectangular_receiver(paths, screen)?.meet_beyond(ray)?.0))
            }
            Self::Away => None,
        }
    }
}

/// The receiver, if it is a rectangle. On its film, lines of the plane are lines; on a disc's, which is
/// polar, they are not.
pub(in crate::reference::beams::facets) fn rectangular_receiver<'a>(
    paths: &FacetPaths<'a>,
    screen: &Screen<'_>,
) -> Option<&'a Shape> {
    let Screen::Receiver(receiver) = screen else {
        return None;
    };
    let shape = &paths.scene().world().shapes()[receiver.shape() as usize];
    matches!(shape, Shape::Rectangle(_)).then_some(shape)
}

/// The obstacle that may be in the way of a leg.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(in crate::reference::beams::facets) enum LegWay {
    /// Nothing is, but for a part of the light.
    Clear {
        /// The part that bends round an edge, if corners do not show it.
        uncertain_part: f64,
    },
    /// This facet.
    Facet(u32),
    /// Something that has no edges to cut along.
    Obstructed,
}

/// Most corners of a hull's ends: most polygons have no more.
const HULL_CORNERS: usize = 6;

/// The space that the light of a polygon sweeps on a leg, or that of a part of it.
pub(super) type LegHull = Hull<HULL_CORNERS>;

/// A line of a leg's light.
#[derive(Clone, Copy)]
pub(super) struct LegLine {
    pub(super) ray: Ray,
    pub(super) end: DVec3,
}

/// The things that are searched for in the space that a leg sweeps.
#[derive(Clone, Copy, Debug)]
pub(in crate::reference::beams::facets) enum Watch {
    /// All that may be there.
    Everything,
    /// This facet alone.
    Facet(u32),
    /// This shape alone.
    Shape(u32),
}

impl Watch {
    fn may_hold_shape(self, shape: u32, facets: &Facets) -> bool {
        match self {
            Self::Everything => true,
            Self::Facet(facet) => facets.get(facet).shape == shape,
            Self::Shape(only) => only == shape,
        }
    }

    fn may_hold_facet(self, facet: u32) -> bool {
        !matches!(self, Self::Facet(only) if only != facet)
    }
}

/// Search for obstacles in the way of legs.
pub(in crate::reference::beams::facets) struct Legs<'f> {
    pub(super) paths: &'f FacetPaths<'f>,
    pub(super) screen: &'f Screen<'f>,
    pub(super) clearance: &'f Clearance<'f>,
    /// Distance from a plane that its points may have: u = 2⁻⁵³ of their coordinates, a few times.
    pub(super) flatness: f64,
    /// Lines of the polygon's corners first, then of its sides' and diagonals' middles.
    pub(super) lines: Vec<LegLine>,
    pub(super) corners: usize,
    pub(super) hulls: Vec<LegHull>,
}

impl<'f> Legs<'f> {
    /// The search for one source.
    pub(in crate::reference::beams::facets) fn new(
        paths: &'f FacetPaths<'f>,
        screen: &'f Screen<'f>,
        clearance: &'f Clearance<'f>,
    ) -> Self {
        let bounds = paths.scene().world().bounds();
        let reach = bounds.min.abs().max(bounds.max.abs()).max_element();
        Self {
            paths,
            screen,
            clearance,
            flatness: 64.0 * f64::EPSILON * reach,
            lines: Vec::new(),
            corners: 0,
            hulls: Vec::new(),
        }
    }

    /// Distance \[m\] from a plane that points of it may have by rounding.
    pub(in crate::reference::beams::facets) fn flatness(&self) -> f64 {
        self.flatness
    }

    /// True if lines of one direction stay lines of one direction.
    pub(super) fn is_affine(&self) -> bool {
        matches!(self.paths.source(), Source::Parallel { .. })
    }

    /// The obstacle of those in `watch` that may be in the way of a polygon's next leg. A facet is none if
    /// `allowed` of the light or less may meet it, but that part counts as uncertain.
    pub(in crate::reference::beams::facets) fn way<const N: usize>(
        &mut self,
        polygon: &LightPolygon<N>,
        goal: Goal,
        watch: Watch,
        allowed: f64,
    ) -> LegWay {
        if !goal.is_known(self.paths, self.screen) {
            // Light that lands there is followed by other means.
            return LegWay::Clear {
                uncertain_part: 0.0,
            };
        }
        if self.sweep(polygon, goal).is_none() {
            return LegWay::Obstructed;
        }
        self.look(polygon, goal, None, watch, allowed)
    }

    /// The obstacle of those in `watch` that may be in the way of a polygon's next leg to a shape that is not
    /// flat. The leg is obstructed, too, if the shape may not keep back all of its light.
    pub(in crate::reference::beams::facets) fn way_to_blocker<const N: usize>(
        &mut self,
        polygon: &LightPolygon<N>,
        shape: u32,
        watch: Watch,
        allowed: f64,
        counters: &mut TraversalCounters,
    ) -> LegWay {
        if self.sweep_to(polygon, shape, counters).is_none() {
            return LegWay::Obstructed;
        }
        self.look(polygon, Goal::Away, Some(shape), watch, allowed)
    }

    /// The obstacle that may be in the hulls of a leg.
    fn look<const N: usize>(
        &self,
        polygon: &LightPolygon<N>,
        goal: Goal,
        blocker: Option<u32>,
        watch: Watch,
        allowed: f64,
    ) -> LegWay {
        let (mut uncertain_part, mut in_the_way) = (0.0, None);
        let mut seen: Vec<u32> = Vec::new();
        let from = polygon.chain.left();
        let facets = self.paths.facets();
        let between = self.between_ends(from, goal);
        let is_watched = |shape| blocker != Some(shape) && watch.may_hold_shape(shape, facets);
        let is_obstructed = self.hulls.iter().any(|hull| {
            self.clearance
                .may_be_between(hull, &between, is_watched, |shape, face| {
                    // A face without area is in nobody's way.
                    let Some(facet) = facets.of(shape, face) else {
                        return false;
                    };
                    let is_end =
                        from == Some(facet) || matches!(goal, Goal::Facet(to) if to == facet);
                    if is_end || !watch.may_hold_facet(facet) {
                        return false;
                    }
                    let Some(part) = self.part_across(facet, allowed) else {
                        in_the_way = Some(facet);
                        return true;
                    };
                    if part > 0.0 && !seen.contains(&facet) {
                        seen.push(facet);
                        uncertain_part += part;
                    }
                    false
                })
        });
        match in_the_way {
            Some(facet) => LegWay::Facet(facet),
            None if is_obstructed => LegWay::Obstructed,
            None => LegWay::Clear { uncertain_part },
        }
    }

    /// Finds the lines and hulls of a leg; `None` if some of its light does not get there.
    fn sweep<const N: usize>(&mut self, polygon: &LightPolygon<N>, goal: Goal) -> Option<()> {
        self.lines.clear();
        self.hulls.clear();
        for corner in &polygon.corners {
            let line = self.line(&corner.ray, goal)?;
            self.lines.push(line);
        }
        self.corners = self.lines.len();
        let mut bulges = [0.0; 2];
        // The side that a triangle of the fan shares with the one before.
        let mut shared: Option<LegLine> = None;
        for index in 1..self.corners.saturating_sub(1) {
            let (next, state) = (index + 1, polygon.corners[0].state);
            let middle = |legs: &mut Self, a: usize, b: usize| {
                let [p, q] = [a, b].map(|corner| legs.lines[corner]);
                if legs.is_affine() {
                    return Some(LegLine {
                        ray: Ray::new(0.5 * (p.ray.origin + q.ray.origin), p.ray.direction),
                        end: 0.5 * (p.end + q.end),
                    });
                }
                let at = 0.5 * (polygon.corners[a].at + polygon.corners[b].at);
                let light: FacetLight<N> = legs.paths.follow(&polygon.chain, at);
                let line = (light.state == state).then(|| legs.line(&light.ray, goal))??;
                legs.lines.push(line);
                Some(line)
            };
            let first = match shared {
                Some(line) => line,
                None => middle(self, 0, index)?,
            };
            let (far, last) = (middle(self, index, next)?, middle(self, next, 0)?);
            shared = Some(last);
            let [a, b, c] = [0, index, next].map(|corner| self.lines[corner]);
            let six = [a, b, c, far, last, first];
            bulges = wider(bulges, &six.map(|one| [one.ray.origin, one.end]));
        }
        self.hull(bulges);
        Some(())
    }

    /// Finds the hulls of the lines of the polygon's corners, given how far its light bulges between them.
    fn hull(&mut self, bulges: [f64; 2]) {
        let [mut starts, mut ends] = [Vec::new(), Vec::new()];
        // Parts of the polygon have the first corner in common, and each the last one of the part before.
        let mut first = 1;
        while first + 1 < self.corners {
            let last = (first + HULL_CORNERS - 2).min(self.corners - 1);
            let lines = || self.lines[..1].iter().chain(&self.lines[first..=last]);
            starts.clear();
            starts.extend(lines().map(|line| line.ray.origin));
            ends.clear();
            ends.extend(lines().map(|line| line.end));
            self.hulls.push(Hull::of_polygons(&starts, &ends, bulges));
            first = last;
        }
    }

    /// A line up to its goal; `None` if the goal is not ahead.
    fn line(&self, ray: &Ray, goal: Goal) -> Option<LegLine> {
        let end = match goal {
            Goal::Away => ray.at(self.clearance.way_out(ray.origin)),
            _ => goal.place(self.paths, self.screen, ray)?,
        };
        // At an edge that two facets share, the distance is zero, give or take its rounding.
        let is_ahead = (end - ray.origin).dot(ray.direction) >= -self.flatness;
        is_ahead.then_some(LegLine { ray: *ray, end })
    }

    /// Finds the lines and hulls of a leg to a shape that is not flat. `None` if the shape may not keep back
    /// all of its light.
    fn sweep_to<const N: usize>(
        &mut self,
        polygon: &LightPolygon<N>,
        shape: u32,
        counters: &mut TraversalCounters,
    ) -> Option<()> {
        self.lines.clear();
        self.hulls.clear();
        self.corners = polygon.corners.len();
        let state = polygon.corners[0].state;
        let mut meet = |at: DVec2| {
            let light: FacetLight<N> = self.paths.follow(&polygon.chain, at);
            if light.state != state {
                return None;
            }
            let ray = self.paths.search_ray(&light, &polygon.chain);
            let (along, hit) = next_hit(self.paths.scene(), ray, counters)?;
            let line = LegLine {
                ray: light.ray,
                end: along.at(hit.distance),
            };
            (hit.shape == shape).then_some((line, hit.face))
        };
        for corner in &polygon.corners {
            self.lines.push(meet(corner.at)?.0);
        }
        let mut bulges = [0.0; 2];
        for triangle in polygon.fan() {
            let [a, b, c] = triangle.map(|corner| corner.at);
            let six = [a, b, c, 0.5 * (b + c), 0.5 * (c + a), 0.5 * (a + b)];
            let mut found = [(self.lines[0], 0); 6];
            for (place, at) in found.iter_mut().zip(six) {
                *place = meet(at)?;
            }
            let starts = found.map(|(line, _)| line.ray.origin);
            let ends = found.map(|(line, _)| line.end);
            let faces = found.map(|(_, face)| face);
            if !self.clearance.is_kept_back(starts, ends, shape, faces) {
                return None;
            }
            self.lines.extend(found[3..].iter().map(|(line, _)| *line));
            bulges = wider(bulges, &found.map(|(line, _)| [line.ray.origin, line.end]));
        }
        self.hull(bulges);
        Some(())
    }

    /// True if the sensor sees nothing of the leg's ends on a surface of this shape.
    pub(in crate::reference::beams::facets) fn is_end_unseen(&self, shape: u32) -> bool {
        let ends: Vec<DVec3> = self.lines.iter().map(|line| line.end).collect();
        self.screen
            .is_out_of_sight(self.paths.scene(), shape, &ends)
    }
}

/// The bulges at both ends of a leg, or those of a triangle of its light where they are larger.
fn wider(bulges: [f64; 2], triangle: &[[DVec3; 2]; 6]) -> [f64; 2] {
    std::array::from_fn(|end| bulges[end].max(bulge(&triangle.map(|line| line[end]))))
}
