//! Polygons of light, leg by leg.

use std::collections::HashSet;

use glam::DVec2;

use super::chart_of;
use super::land::{Landing, land};
use super::polygon::{Cut, Polygon, Sample, Sight};
use crate::geometry::{Shape, TraversalCounters};
use crate::reference::beams::deposit::Patch;
use crate::reference::beams::film::BeamFilm;
use crate::reference::beams::refine::{Balance, Refiner};
use crate::transport::facets::path::{FacetLight, FacetPaths};
use crate::transport::first_surface::{Root, Source};
use crate::transport::prescribed::{End, next_hit};
use crate::transport::screen::Screen;

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
    /// Corners of the facet's light from which nothing is in the way of the last leg.
    clear: HashSet<[u64; 2]>,
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
            clear: HashSet::new(),
            patch: Patch::default(),
            balance: Balance::default(),
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
            samples: Vec::new(),
            astray: 0.0,
            cuts: 0,
        });
        self.clear.clear();
        while let Some(polygon) = self.pending.pop() {
            self.follow(polygon, generic);
        }
    }

    /// The next leg of a polygon, or its end.
    fn follow(&mut self, mut polygon: Polygon<N>, generic: &mut Refiner<'_, '_, N>) {
        let (area, middle) = polygon.area_and_middle();
        if polygon.corners.len() < 3 || area <= NOTHING {
            return;
        }
        if !polygon.is_one_family() || polygon.cuts > MAX_CUTS {
            self.part(&polygon, area, generic);
            return;
        }
        if !polygon.corners[0].is_on_its_way() {
            let light: FacetLight<N> = self.paths.follow(&polygon.chain, polygon.events, middle);
            if light.is_on_its_way() {
                self.part(&polygon, area, generic);
            } else {
                self.book(&polygon, area);
            }
            return;
        }
        let is_new = polygon.cuts == 0;
        let is_by_middle = polygon.samples.is_empty();
        if is_by_middle {
            self.look(&mut polygon, middle);
        }
        let is_clipped = |sample: &Sample| matches!(sample.sight, Sight::Facet(_));
        // A facet's edges say where its light ends; of anything else only more rays do.
        let is_last = polygon.events == self.paths.events();
        if is_new || is_by_middle && !polygon.samples.iter().all(is_clipped) {
            for index in 0..polygon.corners.len() {
                let corner = polygon.corners[index].at;
                // Pieces on both sides of a cut end at the same places: one ray speaks for all.
                let key = corner.to_array().map(f64::to_bits);
                if !(is_last && is_new && self.clear.contains(&key)) {
                    self.look(&mut polygon, corner + (middle - corner) * INWARD);
                    let seen = polygon.samples.last().map(|sample| sample.sight);
                    if is_last && seen == Some(Sight::Sensor) {
                        self.clear.insert(key);
                    }
                }
            }
        }
        let sight = polygon.samples[0].sight;
        // What is nearest hides what is behind it.
        let nearest = polygon
            .samples
            .iter()
            .filter_map(|sample| match sample.sight {
                Sight::Facet(facet) if !Self::is_entry(&polygon, facet) => {
                    Some((sample.distance, facet))
                }
                _ => None,
            })
            .min_by(|a, b| a.0.total_cmp(&b.0));
        if let Some((_, facet)) = nearest {
            self.cut_out(polygon, facet, is_by_middle, generic);
        } else if polygon.samples.iter().all(|sample| sample.sight == sight) {
            self.go_on(polygon, area, sight, generic);
        } else {
            self.settle(polygon, area, sight, generic);
        }
    }

    /// Whether the facet is the one that the polygon starts on, seen from the source.
    fn is_entry(polygon: &Polygon<N>, facet: u32) -> bool {
        polygon.events == 0 && polygon.chain[0] == facet
    }

    /// Looks along the light at coordinates `at`.
    fn look(&mut self, polygon: &mut Polygon<N>, at: DVec2) {
        let light: FacetLight<N> = self.paths.follow(&polygon.chain, polygon.events, at);
        let (sight, distance) = self.sight(polygon, &light);
        polygon.samples.push(Sample {
            ray: light.ray,
            sight,
            distance,
        });
    }

    /// What light meets next, and how far off.
    fn sight(&mut self, polygon: &Polygon<N>, light: &FacetLight<N>) -> (Sight, f64) {
        let scene = self.paths.scene();
        let ray = self.paths.search_ray(light, &polygon.chain, polygon.events);
        let found = next_hit(scene, ray, &mut self.counters);
        let hit = found.as_ref().map(|(_, hit)| hit);
        if polygon.events == self.paths.events() {
            let ray = found.as_ref().map_or(ray, |(ray, _)| *ray);
            let (end, ..) = self.screen.end(scene, &ray, hit, &mut self.counters);
            if matches!(end, End::Landed(_)) {
                return (Sight::Sensor, f64::INFINITY);
            }
        }
        let Some(hit) = hit else {
            return (Sight::End, f64::INFINITY);
        };
        let is_between = polygon.events > 0 && polygon.events < self.paths.events();
        let material = scene.material_of(hit.shape);
        let sight = match self.paths.facets().of(hit.shape, hit.face) {
            Some(facet) => Sight::Facet(facet),
            None if is_between && material.is_specular(scene.materials()) => Sight::Curved,
            None => Sight::End,
        };
        (sight, hit.distance)
    }

    /// Cuts out what meets a facet; the rest waits.
    fn cut_out(
        &mut self,
        mut polygon: Polygon<N>,
        facet: u32,
        is_by_middle: bool,
        generic: &mut Refiner<'_, '_, N>,
    ) {
        let facets = self.paths.facets();
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
                    let area = polygon.area_and_middle().0;
                    if is_by_middle {
                        // A ray through it met the facet: a sliver on the facet's edge.
                        self.settle(polygon, area, Sight::Facet(facet), generic);
                    } else {
                        // The light that met the facet is on the other side of a bent cut.
                        polygon.samples.clear();
                        self.pending.push(polygon);
                    }
                    return;
                }
                Cut::Through(parts) => {
                    let area = polygon.area_and_middle().0;
                    let astray = self.bow(&polygon, &parts.line, &values, |light| {
                        edge.side(&light.ray)
                    }) * area;
                    if astray * weight > self.tolerance {
                        self.part(&polygon, area, generic);
                        return;
                    }
                    let mut rest = polygon.with(parts.below);
                    let is_below = |sample: &Sample| edge.side(&sample.ray) < 0.0;
                    let samples = polygon.samples.iter().copied();
                    rest.samples = samples
                        .filter(|sample| is_below(sample) && sample.sight != Sight::Facet(facet))
                        .collect();
                    polygon.samples.retain(|sample| !is_below(sample));
                    // What earlier cuts put astray is on either side of this one.
                    let earlier = polygon.astray;
                    polygon.corners = parts.above;
                    let area = rest.area_and_middle().0;
                    let kept = polygon.area_and_middle().0;
                    let share = kept / (kept + area);
                    rest.astray = (earlier * (1.0 - share) + astray).min(area);
                    polygon.astray = (earlier * share + astray).min(kept);
                    self.pending.push(rest);
                }
            }
        }
        let area = polygon.area_and_middle().0;
        self.go_on(polygon, area, Sight::Facet(facet), generic);
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

    /// Of light that does not all meet the same: halves it where that is worth while, or else takes
    /// it for what its middle is, and all of it for astray.
    fn settle(
        &mut self,
        mut polygon: Polygon<N>,
        area: f64,
        sight: Sight,
        generic: &mut Refiner<'_, '_, N>,
    ) {
        let goes_on = match sight {
            Sight::Facet(facet) => {
                polygon.events < self.paths.events()
                    && (polygon.events > 0 || Self::is_entry(&polygon, facet))
            }
            Sight::Sensor => true,
            Sight::End | Sight::Curved => false,
        };
        if goes_on && !self.is_worth_halving(&polygon, area) {
            polygon.astray = area;
            self.go_on(polygon, area, sight, generic);
        } else {
            self.part(&polygon, area, generic);
        }
    }

    fn is_worth_halving(&self, polygon: &Polygon<N>, area: f64) -> bool {
        area * self.strength * polygon.largest_weight() > self.tolerance && polygon.cuts <= MAX_CUTS
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
                } else if !Self::is_entry(&polygon, facet) {
                    // Something else is met first: that light has a root of its own.
                    self.book(&polygon, area);
                    return;
                }
                for corner in &mut polygon.corners {
                    *corner = self.paths.onward(corner, facet, event);
                }
                polygon.events += 1;
                polygon.cuts = 0;
                polygon.samples.clear();
                self.pending.push(polygon);
            }
            Sight::Facet(_) | Sight::End => self.book(&polygon, area),
            Sight::Sensor => {
                let landing = land(
                    self.paths,
                    *self.screen,
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
                    Landing::TooBent => self.part(&polygon, area, generic),
                    Landing::NotForced => self.give_back(&polygon, generic),
                }
            }
            Sight::Curved => self.give_back(&polygon, generic),
        }
    }

    /// What set out towards a finished polygon.
    fn book(&mut self, polygon: &Polygon<N>, area: f64) {
        let emitted: f64 = polygon.corners.iter().map(|corner| corner.emitted).sum();
        self.balance.emitted +=
            area * emitted * self.paths.source().strength().mean() / polygon.corners.len() as f64;
        self.balance.cells += 1;
    }

    /// Halves it where that is worth while.
    fn part(&mut self, polygon: &Polygon<N>, area: f64, generic: &mut Refiner<'_, '_, N>) {
        if self.is_worth_halving(polygon, area)
            && let Some(halves) = polygon.halves(self.paths)
        {
            self.pending.extend(halves);
        } else {
            self.give_back(polygon, generic);
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
