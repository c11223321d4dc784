//! Polygons of light, leg by leg.

use glam::DVec2;

use super::chart_of;
use super::land::{Landing, deposit_astray, land, node};
use super::leg::{Goal, Legs, Way};
use super::polygon::{Cut, Polygon, Sight};
use crate::geometry::{Shape, TraversalCounters};
use crate::reference::beams::deposit::Patch;
use crate::reference::beams::film::BeamFilm;
use crate::reference::beams::refine::{Balance, Refiner};
use crate::transport::facets::path::{FacetLight, FacetPaths};
use crate::transport::first_surface::{Chart, Root, Source};
use crate::transport::guard::Guard;
use crate::transport::prescribed::{End, next_hit};
use crate::transport::screen::Screen;

/// No polygon is cut more often on one leg; what is left is given to the generic refiner.
const MAX_CUTS: u32 = 256;

/// Of a facet's coordinate area: no ray is spent on less, rounding decides where it goes.
const NOTHING: f64 = 1e-15;

/// Light that bends round a facet's edge is slack up to this part of a polygon, and cut off beyond.
const MOST_ASTRAY: f64 = 1.0 / 64.0;

/// At most this many things that are not flat are passed over in search of the next facet.
const MAX_OBSTACLES: u32 = 8;

/// Cuts the light of one source and one signature that meets flat facets.
pub struct FacetRefiner<'a, 'f, const N: usize> {
    paths: &'f FacetPaths<'a>,
    screen: &'f Screen<'a>,
    film: &'f BeamFilm<N>,
    legs: Legs<'a, 'f>,
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
        guard: &'f Guard<'a>,
        film: &'f BeamFilm<N>,
        tolerance: f64,
    ) -> Self {
        let strength = paths.source().strength();
        Self {
            paths,
            screen,
            film,
            legs: Legs::new(paths, screen, guard),
            tolerance,
            strength: strength.0.iter().fold(0.0_f64, |all, &one| all.max(one)),
            pending: Vec::new(),
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
        self.pending.clear();
        self.pending.push(Polygon {
            corners,
            chain,
            events: 0,
            astray: 0.0,
            cuts: 0,
        });
        while generic.may_go_on()
            && let Some(polygon) = self.pending.pop()
        {
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
            self.part(&polygon, area, generic);
            return;
        }
        if !polygon.corners[0].is_on_its_way() {
            if self.is_any_on_its_way(&polygon, middle) {
                self.part(&polygon, area, generic);
            } else {
                self.book(&polygon, area);
            }
            return;
        }
        match self.sight(&polygon, middle) {
            Sight::Facet(facet) if !Self::is_entry(&polygon, facet) => {
                self.cut_out(polygon, facet, true, generic);
            }
            sight => self.go_on(polygon, area, sight, generic),
        }
    }

    /// Whether light within a polygon did not end, as that of its corners did.
    fn is_any_on_its_way(&self, polygon: &Polygon<N>, middle: DVec2) -> bool {
        let is_on_its_way = |at: DVec2| {
            let light: FacetLight<N> = self.paths.follow(&polygon.chain, polygon.events, at);
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

    /// Whether the facet is the one that the polygon starts on, seen from the source.
    fn is_entry(polygon: &Polygon<N>, facet: u32) -> bool {
        polygon.events == 0 && polygon.chain[0] == facet
    }

    /// What light at coordinates `at` meets next.
    fn sight(&mut self, polygon: &Polygon<N>, at: DVec2) -> Sight {
        let scene = self.paths.scene();
        let light: FacetLight<N> = self.paths.follow(&polygon.chain, polygon.events, at);
        let ray = self
            .paths
            .search_ray(&light, &polygon.chain, polygon.events);
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
            return Sight::Away;
        };
        let is_between = polygon.events > 0 && polygon.events < self.paths.events();
        let material = scene.material_of(hit.shape);
        match self.paths.facets().of(hit.shape, hit.face) {
            Some(facet) => Sight::Facet(facet),
            None if is_between && material.is_specular(scene.materials()) => Sight::Curved,
            None => Sight::Blocked(hit.shape),
        }
    }

    /// Cuts out what meets a facet, as a ray showed or as may be; the rest waits.
    fn cut_out(
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

    /// Of light that may not all meet the same: halves it where that is worth while, or else takes it
    /// for what was seen, and all of it for astray.
    fn settle(&mut self, mut polygon: Polygon<N>, sight: Sight, generic: &mut Refiner<'_, '_, N>) {
        let area = polygon.area_and_middle().0;
        if self.is_worth_halving(&polygon, area) {
            self.part(&polygon, area, generic);
        } else {
            polygon.astray = area;
            self.go_on(polygon, area, sight, generic);
        }
    }

    fn is_worth_halving(&self, polygon: &Polygon<N>, area: f64) -> bool {
        area * self.strength * polygon.largest_weight() > self.tolerance && polygon.cuts <= MAX_CUTS
    }

    /// To the next leg, or to the end, if nothing is in the way.
    fn go_on(
        &mut self,
        mut polygon: Polygon<N>,
        area: f64,
        sight: Sight,
        generic: &mut Refiner<'_, '_, N>,
    ) {
        let event = polygon.events;
        let goal = match sight {
            Sight::Facet(facet)
                if event < self.paths.events() && event > 0 || Self::is_entry(&polygon, facet) =>
            {
                Goal::Facet(facet)
            }
            Sight::Facet(_) => {
                // It is met where it must not be. On the way to the first facet: that light has
                // a root of its own.
                self.book(&polygon, area);
                return;
            }
            Sight::Sensor => Goal::Receiver,
            Sight::Away => Goal::Away,
            Sight::Blocked(shape) => {
                if self.legs.is_kept_back(&polygon, shape, &mut self.counters) {
                    self.book(&polygon, area);
                } else {
                    self.divide(&polygon, area, sight, generic);
                }
                return;
            }
            Sight::Curved => {
                self.give_back(&polygon, generic);
                return;
            }
        };
        // What is astray as a whole may be in the way of whatever it likes.
        if polygon.astray < area {
            let flux = area * self.strength * polygon.largest_weight();
            let allowed = (self.tolerance / flux).min(MOST_ASTRAY);
            match self.legs.way(&polygon, goal, allowed) {
                Way::Clear { astray } => {
                    // What cuts along the same edges put astray is the same light.
                    polygon.astray = polygon.astray.max(astray * area).min(area);
                    if astray > allowed && self.is_worth_halving(&polygon, area) {
                        self.part(&polygon, area, generic);
                        return;
                    }
                }
                Way::Facet(facet) => {
                    self.cut_out(polygon, facet, false, generic);
                    return;
                }
                Way::Obstructed => {
                    self.divide(&polygon, area, sight, generic);
                    return;
                }
            }
        }
        match goal {
            Goal::Facet(facet) => {
                if event > 0 {
                    polygon.chain.push(facet);
                }
                self.meet(&mut polygon, facet);
                self.pending.push(polygon);
            }
            Goal::Away => self.book(&polygon, area),
            Goal::Receiver => {
                let landing = land(
                    self.paths,
                    *self.screen,
                    self.film,
                    &mut self.patch,
                    &polygon,
                    self.tolerance,
                );
                match landing {
                    Landing::Done { received, slack } => {
                        self.balance.received += received;
                        self.balance.slack += slack;
                        self.book(&polygon, area);
                    }
                    Landing::TooBent => self.part(&polygon, area, generic),
                    Landing::NotForced => self.give_back(&polygon, generic),
                }
            }
        }
    }

    /// A polygon's next event, on a facet that is the last of its chain.
    fn meet(&self, polygon: &mut Polygon<N>, facet: u32) {
        for corner in &mut polygon.corners {
            *corner = self.paths.onward(corner, facet, polygon.events);
        }
        polygon.events += 1;
        polygon.cuts = 0;
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

    /// Of a polygon that something without edges may be in the way of: halves it, or lets
    /// cells find the border. Where these see none, all of its light is slack.
    fn divide(
        &mut self,
        polygon: &Polygon<N>,
        area: f64,
        sight: Sight,
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
            generic.refine(&Root {
                chart,
                corners: corners.map(|corner| corner.at),
            });
            if generic.balance.cut_cells == cut_before {
                self.doubt(polygon.with(corners.to_vec()), sight);
            }
        }
    }

    /// Books all light of a polygon as slack where it falls if nothing but facets is in its way.
    fn doubt(&mut self, mut polygon: Polygon<N>, sight: Sight) {
        let mut sight = Some(sight);
        while polygon.events < self.paths.events() {
            let facet = match sight.take() {
                _ if polygon.events == 0 => polygon.chain[0],
                Some(Sight::Facet(facet)) => facet,
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
        self.balance.slack += deposit_astray(self.film, &corners, area, area);
    }

    /// The facet that a polygon's middle would meet next if all that is not flat were not there.
    fn next_facet(&mut self, polygon: &Polygon<N>) -> Option<u32> {
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

    /// Lets cells do the rest.
    fn give_back(&mut self, polygon: &Polygon<N>, generic: &mut Refiner<'_, '_, N>) {
        let chart = self.chart(polygon);
        for corners in polygon.fan() {
            let corners = corners.map(|corner| corner.at);
            generic.refine(&Root { chart, corners });
        }
    }

    /// The chart of a polygon's coordinates.
    fn chart(&self, polygon: &Polygon<N>) -> Chart {
        let facets = self.paths.facets();
        let facet = polygon.chain[0];
        let shape = &self.paths.scene().world().shapes()[facets.get(facet).shape as usize];
        chart_of(facets, facet, matches!(shape, Shape::Mesh(_)))
    }
}
