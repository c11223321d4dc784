//! The search for obstacles in the way of legs.

use glam::DVec3;

use super::end::LegEnd;
use crate::geometry::{Hull, Ray, TraversalCounters, bulge};
use crate::reference::beams::facets::polygon::LightPolygon;
use crate::transport::clearance::Clearance;
use crate::transport::facets::path::{FacetLight, FacetPaths};
use crate::transport::facets::table::Facets;
use crate::transport::first_surface::Source;
use crate::transport::path_end::next_hit;
use crate::transport::screen::Screen;

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
    /// The face that it ends on, of a mesh that is not flat; 0 elsewhere.
    face: u32,
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
            Self::Facet(facet) => facets.get(facet).shape() == shape,
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
        let bounds = paths.scene.world().bounds();
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
        matches!(self.paths.source, Source::Parallel { .. })
    }

    /// The obstacle of those in `watch` that may be in the way of a polygon's next leg. A facet is none if
    /// `allowed` of the light or less may meet it, but that part counts as uncertain. A leg to a shape that
    /// is not flat is obstructed, too, if the shape may not keep back all of its light.
    pub(in crate::reference::beams::facets) fn way<const N: usize>(
        &mut self,
        polygon: &LightPolygon<N>,
        end: LegEnd,
        watch: Watch,
        allowed: f64,
        counters: &mut TraversalCounters,
    ) -> LegWay {
        if !end.is_known(self.paths, self.screen) {
            // Light that lands there is followed by other means.
            return LegWay::Clear {
                uncertain_part: 0.0,
            };
        }
        if self.sweep(polygon, end, counters).is_none() {
            return LegWay::Obstructed;
        }
        self.look(polygon, end, watch, allowed)
    }

    /// The obstacle that may be in the hulls of a leg.
    fn look<const N: usize>(
        &self,
        polygon: &LightPolygon<N>,
        end: LegEnd,
        watch: Watch,
        allowed: f64,
    ) -> LegWay {
        let (mut uncertain_part, mut in_the_way) = (0.0, None);
        let mut seen: Vec<u32> = Vec::new();
        let from = polygon.chain.left();
        let facets = self.paths.facets;
        let between = self.between_ends(from, end);
        let is_watched =
            |shape| end != LegEnd::Blocked(shape) && watch.may_hold_shape(shape, facets);
        let is_obstructed = self.hulls.iter().any(|hull| {
            self.clearance
                .may_be_between(hull, &between, is_watched, |shape, face| {
                    // A face without area is in nobody's way.
                    let Some(facet) = facets.of(shape, face) else {
                        return false;
                    };
                    let is_end = from == Some(facet) || end == LegEnd::Facet(facet);
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

    /// Finds the lines and hulls of a leg. `None` if some of its light does not get there, or if a shape that
    /// ends it may not keep back all of its light.
    fn sweep<const N: usize>(
        &mut self,
        polygon: &LightPolygon<N>,
        end: LegEnd,
        counters: &mut TraversalCounters,
    ) -> Option<()> {
        self.lines.clear();
        self.hulls.clear();
        for corner in &polygon.corners {
            let line = self.line(polygon, corner, end, counters)?;
            self.lines.push(line);
        }
        self.corners = self.lines.len();
        let mut bulges = [0.0_f64; 2];
        // The side that a triangle of the fan shares with the one before.
        let mut shared = None;
        for index in 1..self.corners.saturating_sub(1) {
            let next = index + 1;
            let mut middle = |ends: [usize; 2]| self.middle(polygon, ends, end, counters);
            let first = match shared {
                Some(line) => line,
                None => middle([0, index])?,
            };
            let (far, last) = (middle([index, next])?, middle([next, 0])?);
            shared = Some(last);
            let [a, b, c] = [0, index, next].map(|corner| self.lines[corner]);
            let six = [a, b, c, far, last, first];
            let (starts, ends) = (six.map(|one| one.ray.origin), six.map(|one| one.end));
            if let LegEnd::Blocked(shape) = end {
                let faces = six.map(|one| one.face);
                if !self.clearance.is_kept_back(starts, ends, shape, faces) {
                    return None;
                }
            }
            bulges = [bulges[0].max(bulge(&starts)), bulges[1].max(bulge(&ends))];
        }
        self.hull(bulges);
        Some(())
    }

    /// The line of the light in the middle between two corners; `None` if it does not get there, or went
    /// another way.
    fn middle<const N: usize>(
        &mut self,
        polygon: &LightPolygon<N>,
        [a, b]: [usize; 2],
        end: LegEnd,
        counters: &mut TraversalCounters,
    ) -> Option<LegLine> {
        if self.is_affine() && !matches!(end, LegEnd::Blocked(_)) {
            let [p, q] = [a, b].map(|corner| self.lines[corner]);
            return Some(LegLine {
                ray: Ray::new(0.5 * (p.ray.origin + q.ray.origin), p.ray.direction),
                end: 0.5 * (p.end + q.end),
                face: 0,
            });
        }
        let at = 0.5 * (polygon.corners[a].at + polygon.corners[b].at);
        let light = self.paths.follow(&polygon.chain, at);
        if light.state != polygon.corners[0].state {
            return None;
        }
        let line = self.line(polygon, &light, end, counters)?;
        self.lines.push(line);
        Some(line)
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

    /// A line up to its end; `None` if the end is not ahead, or if a search finds another shape there.
    fn line<const N: usize>(
        &self,
        polygon: &LightPolygon<N>,
        light: &FacetLight<N>,
        end: LegEnd,
        counters: &mut TraversalCounters,
    ) -> Option<LegLine> {
        let (ray, mut face) = (light.ray, 0);
        // At an edge that two facets share, the distance is zero, give or take its rounding.
        let ahead = |end: DVec3| {
            let is_ahead = (end - ray.origin).dot(ray.direction) >= -self.flatness;
            is_ahead.then_some(end)
        };
        let end = match end {
            LegEnd::Blocked(shape) => {
                let search = self.paths.search_ray(light, &polygon.chain);
                let (along, hit) = next_hit(self.paths.scene, search, counters)?;
                if hit.shape != shape || light.state != polygon.corners[0].state {
                    return None;
                }
                face = hit.face;
                along.at(hit.distance)
            }
            LegEnd::Away => ahead(ray.at(self.clearance.way_out(ray.origin)))?,
            _ => ahead(end.place(self.paths, self.screen, &ray)?)?,
        };
        Some(LegLine { ray, end, face })
    }

    /// True if the sensor sees nothing of the leg's ends on a surface of this shape.
    pub(in crate::reference::beams::facets) fn is_end_unseen(&self, shape: u32) -> bool {
        let ends: Vec<DVec3> = self.lines.iter().map(|line| line.end).collect();
        self.screen.is_out_of_sight(self.paths.scene, shape, &ends)
    }
}
