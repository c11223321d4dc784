//! Stage `march` (section 3.3): where a photon meets a slab's pictures.
//!
//! Against the nearest surfaces a photon is at an interface where its depth is between those of the near and
//! the far picture. After its first event it is marched against the far picture alone: it meets that once it
//! is as deep.

use std::ops::ControlFlow;

use glam::{DVec2, DVec3};

use super::buffers::{Met, Pictures, Slab, Texel};
use super::meeting::Optics;
use super::photon::Photon;
use super::settings::Settings;
use super::variants::{Buffers, March};
use super::work::Work;
use crate::approximation::bands::signed;
use crate::geometry::{Ray, TraversalCounters};

/// What a photon is marched against.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// The nearest surfaces.
    Near,
    /// The farthest.
    Far,
    /// All layers of a picture.
    All,
}

/// A photon's straight way through a slab: its place in texels and depth, and how that changes by metre.
#[derive(Clone, Copy, Debug)]
struct Way {
    start: DVec3,
    along: DVec3,
    /// Where it leaves the slab \[m\].
    end: f64,
}

impl Way {
    fn at(&self, distance: f64) -> DVec3 {
        self.start + self.along * distance
    }

    /// The distance within a range at which a depth is reached; its start if depth does not change.
    fn reach(&self, depth: f64, [from, to]: [f64; 2]) -> f64 {
        let distance = (depth - self.start.z) / self.along.z;
        if distance.is_finite() {
            distance.clamp(from, to)
        } else {
            from
        }
    }

    /// Goes through the texels on the way: `visit([column, row], [from, to])`, until it breaks.
    #[inline]
    fn texels<B>(
        &self,
        side: usize,
        mut visit: impl FnMut([usize; 2], [f64; 2]) -> ControlFlow<B>,
    ) -> Option<B> {
        let mut x = Border::new(self.start.x, self.along.x, side);
        let mut y = Border::new(self.start.y, self.along.y, side);
        let mut from = 0.0_f64;
        loop {
            let to = x.next.min(y.next).min(self.end).max(from);
            if let ControlFlow::Break(found) =
                visit([x.texel as usize, y.texel as usize], [from, to])
            {
                return Some(found);
            }
            if to >= self.end {
                return None;
            }
            let is_inside = if x.next <= y.next {
                x.cross()
            } else {
                y.cross()
            };
            if !is_inside {
                return None;
            }
            from = to;
        }
    }
}

/// The next border of a texel that a way crosses along one axis.
struct Border {
    start: f64,
    /// Metres by texel, along the way; infinite if it does not cross any.
    metres: f64,
    texel: i64,
    step: i64,
    last: i64,
    /// The distance of the next border \[m\].
    next: f64,
}

impl Border {
    #[inline]
    fn new(start: f64, along: f64, side: usize) -> Self {
        let last = signed(side) - 1;
        let texel = if along < 0.0 {
            start.ceil() - 1.0
        } else {
            start.floor()
        };
        let mut border = Self {
            start,
            metres: 1.0 / along,
            texel: (texel as i64).clamp(0, last),
            step: if along < 0.0 { -1 } else { 1 },
            last,
            next: f64::INFINITY,
        };
        if along != 0.0 {
            border.next = border.distance();
        }
        border
    }

    #[inline]
    fn distance(&self) -> f64 {
        let edge = self.texel + i64::from(self.step > 0);
        (edge as f64 - self.start) * self.metres
    }

    /// Goes into the next texel; false beyond the picture.
    #[inline]
    fn cross(&mut self) -> bool {
        self.texel += self.step;
        self.next = self.distance();
        (0..=self.last).contains(&self.texel)
    }
}

/// The middle of a texel.
#[inline]
fn centre([column, row]: [usize; 2]) -> DVec2 {
    DVec2::new(column as f64 + 0.5, row as f64 + 0.5)
}

/// The march through one slab's pictures.
#[derive(Clone, Copy, Debug)]
pub struct Marcher<'a> {
    /// The slab.
    pub slab: &'a Slab<'a>,
    /// Its pictures.
    pub pictures: &'a Pictures,
    /// The settings.
    pub settings: &'a Settings,
    /// The surfaces' optics.
    pub optics: &'a Optics<'a>,
}

impl Marcher<'_> {
    fn way(&self, ray: &Ray) -> Way {
        let cuboid = self.slab.cuboid;
        let along = cuboid.frame().to_local(ray.direction);
        Way {
            start: self.slab.place(cuboid.to_local(ray.origin)),
            along: (along.truncate() * self.slab.scale()).extend(along.z),
            end: cuboid.leaves(ray, self.slab.depths).0,
        }
    }

    /// The first surface on a photon's way through the slab that it accepts.
    pub fn first(&self, photon: &Photon, against: Against, work: &mut Work) -> Option<Met> {
        work.photons += 1;
        let way = self.way(&photon.ray);
        let is_asked = matches!(self.pictures, Pictures::Asked);
        match (self.settings.march, is_asked) {
            (March::Texels, _) | (March::Exact, false) => {
                self.by_texels(photon, &way, against, work)
            }
            (March::Steps, _) => self.by_steps(photon, &way, against, work),
            (March::Exact, true) => self.exactly(photon, &way, against, work),
        }
    }

    /// The surface of a layer at texel coordinates, met at a distance, if the photon accepts it.
    fn accepted(
        &self,
        photon: &Photon,
        layer: usize,
        at: DVec2,
        distance: f64,
        work: &mut Work,
    ) -> Option<Met> {
        // Most photons within a body march below faces that they do not accept: their normals say so.
        if let Some((shape, normal)) = self.pictures.face_normal(self.slab, layer, at)
            && self.settings.buffers == Buffers::F32
            && !self.optics.accepts(photon, shape, normal, false)
        {
            return None;
        }
        let mut met = self
            .pictures
            .surface(self.slab, self.settings, layer, at, work)?;
        met.point.position = photon.ray.at(distance);
        met.point.position_error = DVec3::ZERO;
        let shape = met.hit.shape;
        self.optics
            .accepts(photon, shape, met.point.geometric_normal, false)
            .then_some(met)
    }

    /// The layers that a march asks, in the order of the way.
    fn layers(&self, way: &Way, against: Against) -> Vec<usize> {
        match against {
            Against::Near => vec![0],
            Against::Far => vec![1],
            Against::All if way.along.z < 0.0 => (0..self.pictures.layers()).rev().collect(),
            Against::All => (0..self.pictures.layers()).collect(),
        }
    }

    /// The length of a texel \[m\], the larger one: how far a picture's depths may be off at a slope of 1.
    fn texel(&self) -> f64 {
        1.0 / self.slab.scale().min_element()
    }

    fn by_texels(
        &self,
        photon: &Photon,
        way: &Way,
        against: Against,
        work: &mut Work,
    ) -> Option<Met> {
        match (self.pictures, against) {
            (Pictures::NearFar(texels), Against::Near | Against::Far) => {
                self.by_near_and_far(photon, way, against, texels, work)
            }
            (Pictures::Asked, Against::Near | Against::Far) => {
                self.by_asked(photon, way, against, work)
            }
            (Pictures::NearFar(_) | Pictures::Asked | Pictures::Peeled(_), _) => {
                self.by_layers(photon, way, work)
            }
        }
    }

    /// How far behind the far picture a photon may be in a texel, and be taken for between the two.
    fn slack(&self) -> f64 {
        match self.settings.march {
            March::Exact => 0.0,
            March::Texels | March::Steps => self.texel(),
        }
    }

    /// The march of the paper: a texel's nearest and farthest surface against the depths in it.
    fn by_near_and_far(
        &self,
        photon: &Photon,
        way: &Way,
        against: Against,
        texels: &[[Texel; 2]],
        work: &mut Work,
    ) -> Option<Met> {
        let (side, slack) = (self.slab.side, self.slack());
        let mut before = way.start.z;
        let (mut steps, mut accepted) = (0, Work::default());
        let found = way.texels(side, |texel, range| {
            steps += 1;
            let after = way.start.z + way.along.z * range[1];
            let (low, high) = (before.min(after), before.max(after));
            before = after;
            let [near, far] = &texels[texel[1] * side + texel[0]];
            let (near, far) = (f64::from(near.depth), f64::from(far.depth));
            let (layer, depth, is_met) = match against {
                Against::Far => (1, far, high >= far),
                Against::Near | Against::All => (0, near, high >= near && low <= far + slack),
            };
            // Where nothing is, depths are infinite.
            if is_met && depth < f64::INFINITY {
                let distance = way.reach(depth, range);
                let met = self.accepted(photon, layer, centre(texel), distance, &mut accepted);
                if let Some(met) = met {
                    return ControlFlow::Break(met);
                }
            }
            ControlFlow::Continue(())
        });
        work.steps += steps;
        // Against the near picture also the far one is asked.
        work.fetches += if against == Against::Far {
            steps
        } else {
            2 * steps
        };
        *work += accepted;
        found
    }

    /// The same with surfaces asked by rays, at the middle of a texel's part of the way.
    fn by_asked(
        &self,
        photon: &Photon,
        way: &Way,
        against: Against,
        work: &mut Work,
    ) -> Option<Met> {
        let slack = self.slack();
        way.texels(self.slab.side, |_, range| {
            work.steps += 1;
            let at = way.at(0.5 * (range[0] + range[1])).truncate();
            let [a, b] = range.map(|distance| way.at(distance).z);
            let layer = usize::from(against == Against::Far);
            let Some(depth) = self.pictures.depth(self.slab, layer, at, work) else {
                return ControlFlow::Continue(());
            };
            let is_met = a.max(b) >= depth
                && (against == Against::Far
                    || self
                        .pictures
                        .depth(self.slab, 1, at, work)
                        .is_some_and(|far| a.min(b) <= far + slack));
            let met = is_met
                .then(|| self.accepted(photon, layer, at, way.reach(depth, range), work))
                .flatten();
            met.map_or(ControlFlow::Continue(()), ControlFlow::Break)
        })
    }

    /// The march against all layers: those whose depths are among the texel's, in the order of the way.
    fn by_layers(&self, photon: &Photon, way: &Way, work: &mut Work) -> Option<Met> {
        let (slack, layers) = (self.texel(), self.layers(way, Against::All));
        way.texels(self.slab.side, |texel, range| {
            work.steps += 1;
            let at = centre(texel);
            let [a, b] = range.map(|distance| way.at(distance).z);
            for &layer in &layers {
                let depth = self.pictures.depth(self.slab, layer, at, work);
                if let Some(depth) = depth
                    && a.min(b) - slack <= depth
                    && depth <= a.max(b)
                    && let Some(met) =
                        self.accepted(photon, layer, at, way.reach(depth, range), work)
                {
                    return ControlFlow::Break(met);
                }
            }
            ControlFlow::Continue(())
        })
    }

    fn by_steps(
        &self,
        photon: &Photon,
        way: &Way,
        against: Against,
        work: &mut Work,
    ) -> Option<Met> {
        let (slack, layers) = (self.texel(), self.layers(way, against));
        let step = way.end / f64::from(self.settings.steps);
        (1..=self.settings.steps).find_map(|index| {
            work.steps += 1;
            let distance = step * f64::from(index);
            let place = way.at(distance);
            let at = place.truncate();
            layers.iter().find_map(|&layer| {
                let depth = self.pictures.depth(self.slab, layer, at, work)?;
                let is_met = match against {
                    Against::Near => {
                        let far = self.pictures.depth(self.slab, 1, at, work)?;
                        place.z >= depth && place.z <= far + slack
                    }
                    Against::Far => place.z >= depth,
                    // What was crossed since the last step.
                    Against::All => {
                        let last = way.at(distance - step).z;
                        depth <= place.z.max(last) && depth >= place.z.min(last) - slack
                    }
                };
                is_met
                    .then(|| self.accepted(photon, layer, at, distance, work))
                    .flatten()
            })
        })
    }

    /// The crossing with the space between the near and the far surfaces as they are: on a surface, found by
    /// rays, or through a wall where one of them jumps. Walls are sought at the middle of each texel's part
    /// of the way, and found by bisection.
    fn exactly(
        &self,
        photon: &Photon,
        way: &Way,
        against: Against,
        work: &mut Work,
    ) -> Option<Met> {
        /// Halvings of the distance between two samples.
        const BISECTIONS: u32 = 40;
        let layer = usize::from(against == Against::Far);
        let hits = self.hits(photon, way, work);
        let mut hits = hits.iter().peekable();
        let mut before = 0.0;
        way.texels(self.slab.side, |_, [from, to]| {
            work.steps += 1;
            let sample = 0.5 * (from + to);
            while let Some((distance, met)) = hits.next_if(|(distance, _)| *distance <= sample) {
                if self.is_on(layer, met, way.at(*distance), work)
                    && self
                        .optics
                        .accepts(photon, met.hit.shape, met.point.geometric_normal, false)
                {
                    return ControlFlow::Break(*met);
                }
                before = *distance;
            }
            let Some(mut found) = self.between(photon, way, sample, against, work) else {
                before = sample;
                return ControlFlow::Continue(());
            };
            let [mut low, mut high] = [before, sample];
            for _ in 0..BISECTIONS {
                let middle = 0.5 * (low + high);
                match self.between(photon, way, middle, against, work) {
                    Some(met) => (found, high) = (met, middle),
                    None => low = middle,
                }
            }
            ControlFlow::Break(found)
        })
        .or_else(|| {
            hits.find_map(|(distance, met)| {
                let is_met = self.is_on(layer, met, way.at(*distance), work)
                    && self.optics.accepts(
                        photon,
                        met.hit.shape,
                        met.point.geometric_normal,
                        false,
                    );
                is_met.then_some(*met)
            })
        })
    }

    /// True if a surface on a photon's way is that of a layer.
    fn is_on(&self, layer: usize, met: &Met, place: DVec3, work: &mut Work) -> bool {
        /// What two rays to one point may be off, by the slab's depth.
        const ROUNDING: f64 = 1e-9;
        let found = self.slab.asked(place.truncate(), layer == 1, work);
        // Along the axis a wall is both, and rays along it may miss it.
        found.is_some_and(|found| {
            found.hit.shape == met.hit.shape
                && (found.depth - place.z).abs() <= ROUNDING * self.slab.cuboid.diagonal()
        })
    }

    /// The surface that a photon is taken to meet at a distance: between near and far, or behind far.
    fn between(
        &self,
        photon: &Photon,
        way: &Way,
        distance: f64,
        against: Against,
        work: &mut Work,
    ) -> Option<Met> {
        let place = way.at(distance);
        let at = place.truncate();
        let far = self.pictures.depth(self.slab, 1, at, work)?;
        let (layer, is_there) = match against {
            Against::Far => (1, place.z >= far),
            Against::Near | Against::All => {
                let near = self.pictures.depth(self.slab, 0, at, work)?;
                (0, place.z >= near && place.z <= far)
            }
        };
        is_there
            .then(|| self.accepted(photon, layer, at, distance, work))
            .flatten()
    }

    /// The surfaces on a photon's way, in order, with their distances.
    fn hits(&self, photon: &Photon, way: &Way, work: &mut Work) -> Vec<(f64, Met)> {
        /// Surfaces in a slab along one ray.
        const MOST: usize = 256;
        let scene = self.slab.scene;
        let mut counters = TraversalCounters::default();
        let mut found = Vec::new();
        let (mut ray, mut done) = (photon.ray, 0.0);
        while found.len() < MOST {
            let Some(hit) = scene
                .world()
                .closest_hit(&ray, way.end - done, &mut counters)
            else {
                break;
            };
            let point = scene.world().bounce_point(&ray, &hit);
            let distance = done + hit.distance;
            if !scene.material_of(hit.shape).is_passed(scene.materials()) {
                let met = Met {
                    depth: way.at(distance).z,
                    hit,
                    point,
                };
                found.push((distance, met));
            }
            ray = point.spawn(ray.direction);
            done = (ray.origin - photon.ray.origin).dot(photon.ray.direction);
        }
        work.add_rays(counters);
        found
    }
}
