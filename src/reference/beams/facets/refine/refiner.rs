//! The refiner of polygons.

use glam::{DVec2, DVec3};

use crate::reference::beams::deposit::TexelBlock;
use crate::reference::beams::facets::leg::{LegEnd, LegWay, Legs, Watch};
use crate::reference::beams::facets::polygon::LightPolygon;
use crate::reference::beams::refine::Refiner;
use crate::transport::clearance::Clearance;
use crate::transport::facets::path::{FacetChain, FacetLight, FacetPaths};
use crate::transport::first_surface::Fan;
use crate::transport::path_end::{End, next_hit};
use crate::transport::screen::Screen;
use crate::transport::signature::Event;

/// Most cuts of a polygon on one leg; after them it is given to the refiner of cells.
pub(super) const MAX_CUTS: u32 = 256;

/// Part of the area that a polygon was cut from below which no ray is spent on it: rounding decides where it
/// goes.
const NOTHING: f64 = 1e-15;

/// Largest part of a polygon whose light may count as uncertain because it bends round a facet's edge; more
/// is cut off.
const MOST_UNCERTAIN: f64 = 1.0 / 64.0;

/// Refiner of the light of one source and some signatures that meets flat facets.
pub struct FacetRefiner<'f, 'r, 'c, const N: usize> {
    pub(super) paths: &'f FacetPaths<'f>,
    pub(super) screen: &'f Screen<'f>,
    pub(super) legs: Legs<'f>,
    /// Planes that polygons are cut along before cells follow what a camera sees.
    pub(super) view: Vec<[DVec3; 2]>,
    /// The refiners of cells that polygons are given back to, one a signature, in the order of their events.
    /// Each has the film, the tolerance and the balance of its signature, too.
    pub(super) cells: &'r mut [Refiner<'c, N>],
    /// Flux \[W\] of light whose weight is one.
    pub(super) strength: f64,
    pub(super) pending: Vec<LightPolygon<N>>,
    pub(super) block: TexelBlock<N>,
}

impl<'f, 'r, 'c, const N: usize> FacetRefiner<'f, 'r, 'c, N> {
    /// A refiner without any polygon, for the signatures of `cells` in the [order of their
    /// events](super::by_events).
    ///
    /// Signatures that begin with the same events share the polygons that had these.
    pub fn new(
        paths: &'f FacetPaths<'f>,
        screen: &'f Screen<'f>,
        clearance: &'f Clearance<'f>,
        cells: &'r mut [Refiner<'c, N>],
    ) -> Self {
        let strength = paths.source.strength();
        Self {
            paths,
            screen,
            legs: Legs::new(paths, screen, clearance),
            view: screen.planes_beside_view(),
            cells,
            strength: strength.0.iter().fold(0.0_f64, |all, &one| all.max(one)),
            pending: Vec::new(),
            block: TexelBlock::default(),
        }
    }

    /// Follows all light of the source that meets a facet first. Light that does not go by facets alone is
    /// given to the refiners of cells, as is light of more than one topology within the tolerance.
    pub fn refine(&mut self, facet: u32) {
        let facets = self.paths.facets;
        let entry = facets.get(facet);
        let chain = FacetChain::to(facet);
        let corners = facets
            .outline(entry)
            .iter()
            .map(|&corner| self.paths.follow(&chain, entry.coordinates(corner)))
            .collect();
        self.pending.clear();
        self.pending.push(LightPolygon {
            corners,
            chain,
            signatures: 0..self.cells.len(),
            uncertain_area: 0.0,
            cuts: 0,
            whole: 1.0,
        });
        self.part_wide();
        while let Some(polygon) = self.pending.pop()
            && self.cells[polygon.signatures.start].may_go_on()
        {
            self.follow(polygon);
        }
    }

    /// Halves polygons that the source sees at so wide an angle that corners do not tell how much light they
    /// hold.
    fn part_wide(&mut self) {
        let Some(origin) = self.paths.source.origin() else {
            return;
        };
        let mut wide = std::mem::take(&mut self.pending);
        while let Some(mut polygon) = wide.pop() {
            let facet = self.paths.facets.get(polygon.chain.first());
            let places = polygon.corners.iter().map(|light| facet.point(light.at));
            let halves = if Fan::new(origin, places).is_too_wide() && polygon.cuts < MAX_CUTS {
                polygon.halves(self.paths)
            } else {
                None
            };
            if let Some(halves) = halves {
                wide.extend(halves);
            } else {
                polygon.cuts = 0;
                polygon.whole = polygon.area();
                self.pending.push(polygon);
            }
        }
    }

    /// Takes a polygon to its next leg, or to its end.
    fn follow(&mut self, polygon: LightPolygon<N>) {
        let (area, middle) = polygon.area_and_middle();
        if polygon.corners.len() < 3 || area <= NOTHING * polygon.whole {
            return;
        }
        if !polygon.is_one_topology() || polygon.cuts > MAX_CUTS {
            self.part(&polygon, area);
            return;
        }
        if !polygon.corners[0].is_on_its_way() {
            if self.is_any_on_its_way(&polygon, middle) {
                self.part(&polygon, area);
            } else {
                self.book(&polygon, area);
            }
            return;
        }
        match self.sight(&polygon, middle) {
            LegEnd::Facet(facet) if !Self::is_entry(&polygon, facet) => {
                if !self.may_go_to_a_facet(&polygon) || !self.spread(&polygon, facet) {
                    self.cut_out(polygon, facet, None);
                }
            }
            sight => self.go_on(polygon, area, sight),
        }
    }

    /// True if some light within a polygon is on its way, although that of its corners ended.
    fn is_any_on_its_way(&self, polygon: &LightPolygon<N>, middle: DVec2) -> bool {
        let is_on_its_way = |at: DVec2| {
            let light: FacetLight<N> = self.paths.follow(&polygon.chain, at);
            light.is_on_its_way()
        };
        let corners = &polygon.corners;
        let next = corners.iter().cycle().skip(1);
        is_on_its_way(middle)
            || corners
                .iter()
                .zip(next)
                .any(|(a, b)| is_on_its_way(0.5 * (a.at + b.at)))
    }

    /// True if the facet is the one that the polygon starts on, seen from the source.
    fn is_entry(polygon: &LightPolygon<N>, facet: u32) -> bool {
        polygon.chain.events() == 0 && polygon.chain.first() == facet
    }

    /// True if a polygon's next event may be on any facet that it meets.
    pub(super) fn may_go_to_a_facet(&self, polygon: &LightPolygon<N>) -> bool {
        polygon.chain.events() > 0 && !self.has_all_events(polygon)
    }

    /// The thing that light at coordinates `at` meets next.
    fn sight(&mut self, polygon: &LightPolygon<N>, at: DVec2) -> LegEnd {
        let scene = self.paths.scene;
        let light: FacetLight<N> = self.paths.follow(&polygon.chain, at);
        let ray = self.paths.search_ray(&light, &polygon.chain);
        let has_all_events = self.has_all_events(polygon);
        let counters = self.cells[polygon.signatures.start].counters_mut();
        let found = next_hit(scene, ray, counters);
        let hit = found.as_ref().map(|(_, hit)| hit);
        if has_all_events {
            let ray = found.as_ref().map_or(ray, |(ray, _)| *ray);
            let (end, ..) = self.screen.end(scene, &ray, hit, counters);
            if matches!(end, End::Landed(_)) {
                return LegEnd::Sensor;
            }
        }
        let Some(hit) = hit else {
            return LegEnd::Away;
        };
        let is_between = self.may_go_to_a_facet(polygon);
        let material = scene.material_of(hit.shape);
        match self.paths.facets.of(hit.shape, hit.face) {
            Some(facet) => LegEnd::Facet(facet),
            None if is_between && material.is_specular(scene.materials()) => LegEnd::Curved,
            None => LegEnd::Blocked(hit.shape),
        }
    }

    /// Settles a polygon whose light may not all meet the same thing. It is halved if that is worth while;
    /// otherwise all of it counts as meeting what was seen, and as uncertain.
    pub(super) fn settle(&mut self, mut polygon: LightPolygon<N>, sight: LegEnd) {
        let area = polygon.area_and_middle().0;
        if self.is_worth_halving(&polygon, area) {
            self.part(&polygon, area);
        } else {
            polygon.uncertain_area = area;
            self.go_on(polygon, area, sight);
        }
    }

    pub(super) fn is_worth_halving(&self, polygon: &LightPolygon<N>, area: f64) -> bool {
        area * self.strength * polygon.largest_weight() > self.tolerance(polygon)
            && polygon.cuts <= MAX_CUTS
    }

    /// Takes a polygon to the next leg, or to the end, if nothing is in the way. Else it is divided.
    pub(super) fn go_on(&mut self, mut polygon: LightPolygon<N>, area: f64, sight: LegEnd) {
        if sight == LegEnd::Curved {
            self.give_back(&polygon);
            return;
        }
        if sight == LegEnd::Sensor && self.is_sensor_cut_to_view(&polygon) {
            return;
        }
        let blocker = self.blocker(&polygon, sight);
        // If all of it is uncertain, obstacles do not matter to light that goes on.
        if blocker.is_some() || polygon.uncertain_area < area {
            let allowed = self.allowed(&polygon, area);
            let watch = match blocker {
                Some(_) => self.watch(&polygon),
                None => Watch::Everything,
            };
            let counters = self.cells[polygon.signatures.start].counters_mut();
            match self.legs.way(&polygon, sight, watch, allowed, counters) {
                LegWay::Clear { .. } if blocker.is_some_and(|on| self.is_seen(&polygon, on)) => {
                    let is_cut = match sight {
                        LegEnd::Facet(facet) => self.cut_to_view(&polygon, facet),
                        _ => false,
                    };
                    if !is_cut {
                        self.give_back(&polygon);
                    }
                    return;
                }
                LegWay::Clear { uncertain_part } => {
                    // Cuts along the same edges made the same light uncertain.
                    polygon.uncertain_area =
                        polygon.uncertain_area.max(uncertain_part * area).min(area);
                    if uncertain_part > allowed && self.is_worth_halving(&polygon, area) {
                        self.part(&polygon, area);
                        return;
                    }
                }
                LegWay::Facet(facet) => {
                    self.cut_out(polygon, facet, Some(sight));
                    return;
                }
                LegWay::Obstructed => {
                    self.divide(&polygon, area, sight);
                    return;
                }
            }
        }
        match sight {
            LegEnd::Facet(facet) if blocker.is_none() => {
                for (event, signatures) in self.ways_on(&polygon) {
                    let mut onward = polygon.clone();
                    onward.signatures = signatures;
                    self.meet(&mut onward, facet, event);
                    self.pending.push(onward);
                }
            }
            LegEnd::Sensor => self.land(&polygon, area),
            _ => self.end(&polygon, area),
        }
    }

    /// The shape that ends a polygon which meets it: one that is not flat, or one with a facet where light
    /// must not go on.
    ///
    /// The polygon's middle met it. Beside the middle, other things may still be before it: the next glass,
    /// the receiver, any surface that a camera sees. It may also be the facet that the polygon starts on,
    /// where another surface crosses it.
    fn blocker(&self, polygon: &LightPolygon<N>, sight: LegEnd) -> Option<u32> {
        match sight {
            LegEnd::Blocked(shape) => Some(shape),
            LegEnd::Facet(facet) => {
                let goes_on = self.may_go_to_a_facet(polygon) || Self::is_entry(polygon, facet);
                (!goes_on).then(|| self.paths.facets.get(facet).shape())
            }
            LegEnd::Sensor | LegEnd::Away | LegEnd::Curved => None,
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

    /// True if a camera may see the light of a polygon's last leg on a shape that the leg ends on.
    fn is_seen(&self, polygon: &LightPolygon<N>, shape: u32) -> bool {
        matches!(self.screen, Screen::Camera { .. })
            && self.has_all_events(polygon)
            && !self.legs.is_end_unseen(shape)
    }

    /// The part of a polygon that may be uncertain, as light that bends round an edge.
    pub(super) fn allowed(&self, polygon: &LightPolygon<N>, area: f64) -> f64 {
        let flux = area * self.strength * polygon.largest_weight();
        (self.tolerance(polygon) / flux).min(MOST_UNCERTAIN)
    }

    /// Takes a polygon through its next event, on a facet.
    pub(super) fn meet(&self, polygon: &mut LightPolygon<N>, facet: u32, event: Event) {
        for corner in &mut polygon.corners {
            *corner = self.paths.onward(corner, &polygon.chain, facet, event);
        }
        polygon.chain.push(facet, event);
        polygon.cuts = 0;
    }

    /// Books the light that set out towards a finished polygon.
    pub(super) fn book(&mut self, polygon: &LightPolygon<N>, area: f64) {
        let emitted: f64 = polygon.corners.iter().map(|corner| corner.emitted).sum();
        let emitted =
            area * emitted * self.paths.source.strength().mean() / polygon.corners.len() as f64;
        for cells in &mut self.cells[polygon.signatures.clone()] {
            cells.balance.emitted += emitted;
            cells.balance.cells += 1;
        }
    }

    /// Halves a polygon if that is worth while; otherwise gives it back.
    pub(super) fn part(&mut self, polygon: &LightPolygon<N>, area: f64) {
        if self.is_worth_halving(polygon, area)
            && let Some(halves) = polygon.halves(self.paths)
        {
            self.pending.extend(halves);
        } else {
            self.give_back(polygon);
        }
    }
}
