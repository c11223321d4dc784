//! Polygons of light, leg by leg.

use glam::DVec2;

use super::chart_of;
use super::land::{Landing, land};
use super::polygon::{Cut, Polygon};
use crate::geometry::{Shape, TraversalCounters};
use crate::reference::beams::deposit::Patch;
use crate::reference::beams::film::BeamFilm;
use crate::reference::beams::refine::{Balance, Refiner};
use crate::transport::facets::path::{FacetLight, FacetPaths};
use crate::transport::first_surface::{Root, Source};
use crate::transport::flux::Flux;
use crate::transport::prescribed::{End, next_hit};
use crate::transport::screen::Screen;

/// What light meets on a leg.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Sight {
    /// A facet.
    Facet(u32),
    /// The sensor, after its last event.
    Sensor,
    /// Something that ends it without an edge that is known here, or nothing.
    End,
    /// A surface that is not flat and sends light on.
    Curved,
}

/// A corner is looked along from this part of its way to the middle: just inside.
const INWARD: f64 = 1.0 / 64.0;

/// No polygon is cut more often on one leg; what is left is given to the generic refiner.
const MAX_CUTS: u32 = 256;

/// Of a facet's coordinate area: no ray is spent on less, rounding decides where it goes.
const NOTHING: f64 = 1e-15;

/// Cuts the light of one source and one signature that meets flat facets.
pub struct FacetRefiner<'a, 'f, const N: usize> {
    paths: &'f FacetPaths<'a>,
    screen: &'f Screen<'a>,
    film: &'f BeamFilm<N>,
    /// Misplaced flux that a polygon may have \[W\].
    tolerance: f64,
    /// Flux of light whose weight is one \[W\].
    strength: f64,
    pending: Vec<Polygon<N>>,
    patch: Patch<N>,
    /// What was found so far, without what was given back.
    pub balance: Balance<N>,
    /// Work done so far, without what was given back.
    pub counters: TraversalCounters,
}

impl<'a, 'f, const N: usize> FacetRefiner<'a, 'f, N> {
    /// A refiner without any polygon.
    pub fn new(
        paths: &'f FacetPaths<'a>,
        screen: &'f Screen<'a>,
        film: &'f BeamFilm<N>,
        tolerance: f64,
    ) -> Self {
        let strength = paths.source().strength();
        Self {
            paths,
            screen,
            film,
            tolerance,
            strength: strength.0.iter().fold(0.0_f64, |all, &one| all.max(one)),
            pending: Vec::new(),
            patch: Patch::new(),
            balance: Balance {
                emitted: 0.0,
                received: Flux::BLACK,
                outside: Flux::BLACK,
                mixed: Flux::BLACK,
                cells: 0,
                mixed_cells: 0,
            },
            counters: TraversalCounters::default(),
        }
    }

    /// All light of the source that meets a facet first. What is not by way of facets alone, or
    /// of more than one family within the tolerance, goes to `generic`.
    pub fn refine(&mut self, facet: u32, generic: &mut Refiner<'_, '_, N>) {
        let facets = self.paths.facets();
        let entry = facets.get(facet);
        let chain = vec![facet];
        let corners = facets
            .outline(entry)
            .iter()
            .map(|&corner| self.paths.follow(&chain, 0, entry.coordinates(corner)))
            .collect();
        self.pending.push(Polygon {
            corners,
            chain,
            events: 0,
            astray: 0.0,
            cuts: 0,
        });
        while let Some(polygon) = self.pending.pop() {
            self.follow(polygon, generic);
        }
    }

    /// The next leg of a polygon, or its end.
    fn follow(&mut self, polygon: Polygon<N>, generic: &mut Refiner<'_, '_, N>) {
        let (area, middle) = polygon.area_and_middle();
        if polygon.corners.len() < 3 || area <= NOTHING {
            return;
        }
        if !polygon.is_one_family() || polygon.cuts > MAX_CUTS {
            self.part(polygon, area, generic);
            return;
        }
        if !polygon.corners[0].is_on_its_way() {
            self.finish_dark(&polygon, area);
            return;
        }
        let light = self.paths.follow(&polygon.chain, polygon.events, middle);
        match self.look(&polygon, &light) {
            Sight::Curved => self.give_back(&polygon, generic),
            Sight::Facet(facet) if !self.is_entry(&polygon, facet) => {
                self.cut_out(polygon, area, facet, generic);
            }
            sight => self.check_corners(polygon, area, middle, sight, generic),
        }
    }

    /// Whether the facet is the one that the polygon starts on, seen from the source.
    fn is_entry(&self, polygon: &Polygon<N>, facet: u32) -> bool {
        polygon.events == 0 && polygon.chain[0] == facet
    }

    /// What light meets next.
    fn look(&mut self, polygon: &Polygon<N>, light: &FacetLight<N>) -> Sight {
        let scene = self.paths.scene();
        let ray = self
            .paths
            .search_ray(light, &polygon.chain, polygon.events);
        let found = next_hit(scene, ray, &mut self.counters);
        let hit = found.as_ref().map(|(_, hit)| hit);
        if polygon.events == self.paths.events() {
            let ray = found.as_ref().map_or(ray, |(ray, _)| *ray);
            let (end, ..) = self.screen.end(scene, &ray, hit, &mut self.counters);
            if matches!(end, End::Landed(_)) {
                return Sight::Sensor;
            }
        }
        let Some(hit) = hit else {
            return Sight::End;
        };
        if let Some(facet) = self.paths.facets().of(hit.shape, hit.face) {
            Sight::Facet(facet)
        } else if polygon.events > 0
            && polygon.events < self.paths.events()
            && scene
                .material_of(hit.shape)
                .is_specular(scene.materials())
        {
            Sight::Curved
        } else {
            Sight::End
        }
    }

    /// Cuts out what meets a facet; the rest waits.
    fn cut_out(
        &mut self,
        mut polygon: Polygon<N>,
        area: f64,
        facet: u32,
        generic: &mut Refiner<'_, '_, N>,
    ) {
        let facets = self.paths.facets();
        let waiting = self.pending.len();
        polygon.cuts += 1;
        let weight = self.strength * polygon.largest_weight();
        let direction = polygon.corners[0].ray.direction;
        let mut values = Vec::with_capacity(polygon.corners.len());
        for edge in facets.edges(facets.get(facet), direction) {
            values.clear();
            values.extend(polygon.corners.iter().map(|corner| edge.side(&corner.ray)));
            match polygon.cut(&values, self.paths) {
                Cut::Above => {}
                Cut::Below => {
                    // A ray through the middle met the facet, but the middle is on its edge.
                    self.pending.truncate(waiting);
                    self.part(polygon, area, generic);
                    return;
                }
                Cut::Through(parts) => {
                    let astray = self.bow(&polygon, &parts.line, &values, |light| {
                        edge.side(&light.ray)
                    }) * area;
                    if astray * weight > self.tolerance {
                        self.pending.truncate(waiting);
                        self.part(polygon, area, generic);
                        return;
                    }
                    let mut rest = polygon.with(parts.below);
                    rest.astray += astray;
                    self.pending.push(rest);
                    polygon.corners = parts.above;
                    polygon.astray += astray;
                }
            }
        }
        let (area, middle) = polygon.area_and_middle();
        self.check_corners(polygon, area, middle, Sight::Facet(facet), generic);
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

    /// Looks along the corners, too; then on with what the middle saw.
    fn check_corners(
        &mut self,
        polygon: Polygon<N>,
        area: f64,
        middle: DVec2,
        sight: Sight,
        generic: &mut Refiner<'_, '_, N>,
    ) {
        for corner in &polygon.corners {
            let at = corner.at + (middle - corner.at) * INWARD;
            let light = self.paths.follow(&polygon.chain, polygon.events, at);
            let seen = self.look(&polygon, &light);
            if seen == sight {
                continue;
            }
            match seen {
                Sight::Facet(facet)
                    if !self.is_entry(&polygon, facet) && polygon.cuts < MAX_CUTS =>
                {
                    self.cut_out(polygon, area, facet, generic);
                }
                _ => self.part(polygon, area, generic),
            }
            return;
        }
        self.go_on(polygon, area, sight, generic);
    }

    /// To the next leg, or to the end.
    fn go_on(
        &mut self,
        mut polygon: Polygon<N>,
        area: f64,
        sight: Sight,
        generic: &mut Refiner<'_, '_, N>,
    ) {
        let event = polygon.events;
        match sight {
            Sight::Facet(facet) if event < self.paths.events() => {
                if event > 0 {
                    polygon.chain.push(facet);
                } else if !self.is_entry(&polygon, facet) {
                    // Something else is met first: that light has a root of its own.
                    self.finish_dark(&polygon, area);
                    return;
                }
                for corner in &mut polygon.corners {
                    *corner = self.paths.onward(corner, facet, event);
                }
                polygon.events += 1;
                polygon.cuts = 0;
                self.pending.push(polygon);
            }
            Sight::Facet(_) | Sight::End => self.finish_dark(&polygon, area),
            Sight::Sensor => {
                let landing = land(
                    self.paths,
                    self.screen,
                    self.film,
                    &mut self.patch,
                    &polygon,
                    self.tolerance,
                );
                match landing {
                    Landing::Done { received } => {
                        self.balance.received += received;
                        self.book(&polygon, area);
                    }
                    Landing::TooBent => self.part(polygon, area, generic),
                    Landing::NotForced => self.give_back(&polygon, generic),
                }
            }
            Sight::Curved => self.give_back(&polygon, generic),
        }
    }

    fn finish_dark(&mut self, polygon: &Polygon<N>, area: f64) {
        self.book(polygon, area);
    }

    /// What set out towards a finished polygon.
    fn book(&mut self, polygon: &Polygon<N>, area: f64) {
        let emitted: f64 = polygon.corners.iter().map(|corner| corner.emitted).sum();
        self.balance.emitted += area * emitted / polygon.corners.len() as f64;
        self.balance.cells += 1;
    }

    /// Halves it where that is worth while.
    fn part(&mut self, polygon: Polygon<N>, area: f64, generic: &mut Refiner<'_, '_, N>) {
        let flux = area * self.strength * polygon.largest_weight();
        if flux > self.tolerance
            && polygon.cuts <= MAX_CUTS
            && let Some(halves) = polygon.halves(self.paths)
        {
            self.pending.extend(halves);
        } else {
            self.give_back(&polygon, generic);
        }
    }

    /// Lets cells do the rest.
    fn give_back(&mut self, polygon: &Polygon<N>, generic: &mut Refiner<'_, '_, N>) {
        let facets = self.paths.facets();
        let facet = polygon.chain[0];
        let shape = &self.paths.scene().world().shapes()[facets.get(facet).shape as usize];
        let chart = chart_of(facets, facet, matches!(shape, Shape::Mesh(_)));
        for index in 1..polygon.corners.len() - 1 {
            let corners = [0, index, index + 1].map(|corner| polygon.corners[corner].at);
            generic.refine(&Root { chart, corners });
        }
    }
}
