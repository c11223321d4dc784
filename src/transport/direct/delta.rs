//! Delta emitters: a texel's average by 2 x 2 Gauss points, with a closer look along the edges of shadows.

use glam::DVec3;

use super::arriving::{ends_in_a_step, unshadowed};
use super::glance::Glance;
use super::leaf::{Leaf, SHADOW_LEVELS};
use super::light::DirectLight;
use super::look::{LeafLight, NO_RANGE, POINTS, ShareRange, Sum, joined};
use super::shaft::Obstacle;
use super::shafts::Shafts;
use super::texel::DirectTexel;
use crate::numeric::rotation;
use crate::radiometry::Rgb;
use crate::scene::Emitter;

/// Number of times that all of a texel is quartered, if it has several faces and lies near a shadow's edge.
const EDGE_LEVELS: u32 = 3;

/// Largest part of a texel's light that the kinks of a spot's falloff may misplace in a leaf.
const KINK: f64 = 1e-5;

/// Places of a leaf's outer points, relative to its middle and in units of its size, along each axis.
///
/// A leaf near an edge also looks at the emitter from these points: a grid of 3 x 3 over the leaf and an
/// eighth of its size around it.
///
/// Let s be the leaf's size. An edge that bulges into a leaf between two outer points, by the sagitta
/// s²/(8R), is seen from there for all radii R above s.
const OUTER_POINTS: [f64; 3] = [-0.625, 0.0, 0.625];

impl DirectLight<'_> {
    /// Average of a delta emitter's light over a texel, as few points see it, or with the `share` that they
    /// are known to see.
    pub(super) fn glance(&mut self, texel: usize, emitter: &Emitter, share: Option<f64>) -> Glance {
        let mut passed = share.map_or(ShareRange::NOTHING_SEEN, ShareRange::of);
        if !self.receiver.has_surface(texel) {
            let value = DirectTexel::default();
            return Glance { value, passed };
        }
        let mut sum = Sum::NOTHING;
        let (width, height) = (self.receiver.width(), self.receiver.height());
        let is_end = |i: usize, count: usize| i == 0 || i + 1 == count;
        let is_border = is_end(texel % width, width) || is_end(texel / width, height);
        let mut pending = vec![Leaf::TEXEL];
        while let Some(leaf) = pending.pop() {
            let Some(flaw) = self.flaw(texel, &leaf, emitter) else {
                pending.extend(leaf.quarters());
                continue;
            };
            let look = self.look(texel, &leaf, emitter, share);
            if look.is_rough(leaf.size) && leaf.level < EDGE_LEVELS {
                pending.extend(leaf.quarters());
                continue;
            }
            sum.add(&look);
            sum.error += flaw;
            passed = passed.with(look.passed);
            if share.is_none() && (is_border || look.is_ragged) {
                // There may be no neighbours on one side, and so no other texel that looks there.
                passed = self.with_outer_points(texel, &leaf, emitter, passed);
            }
        }
        let value = sum
            .average()
            .unwrap_or_else(|| self.at_home(texel, emitter));
        Glance { value, passed }
    }

    /// Average of a delta emitter's light over a texel through which a shadow's edge may run.
    pub(super) fn edge(&mut self, texel: usize, emitter: &Emitter) -> DirectTexel {
        if !self.receiver.has_surface(texel) {
            return DirectTexel::default();
        }
        self.by_cuts(texel, emitter)
            .unwrap_or_else(|| self.by_quarters(texel, emitter))
    }

    /// Average of a delta emitter's light over a texel of a rectangle that these obstacles may divide.
    pub(super) fn divided(
        &mut self,
        texel: usize,
        emitter: &Emitter,
        shafts: &Shafts,
        obstacles: &[Obstacle],
    ) -> Glance {
        let value = self.in_leaves(texel, emitter, |at, leaf, sum| {
            at.cut_by(texel, leaf, emitter, (shafts, obstacles), sum)
                .ok()
        });
        Glance {
            // A rectangle has surface everywhere, all of it smooth.
            value: value.unwrap_or(DirectTexel::UNKNOWN),
            passed: ShareRange::of(0.0).with_share(1.0),
        }
    }

    /// The same as [`edge`](Self::edge), cut along the edge; `None` if the texel's surface is not one smooth
    /// one.
    fn by_cuts(&mut self, texel: usize, emitter: &Emitter) -> Option<DirectTexel> {
        self.in_leaves(texel, emitter, |at, leaf, sum| {
            at.cut(texel, leaf, emitter, sum)
        })
    }

    /// Average of a texel's light, each leaf's part added by `cut`; `None` if that finds one that it cannot
    /// cut.
    fn in_leaves(
        &mut self,
        texel: usize,
        emitter: &Emitter,
        mut cut: impl FnMut(&mut Self, &Leaf, &mut Sum) -> Option<()>,
    ) -> Option<DirectTexel> {
        let mut sum = Sum::NOTHING;
        let mut pending = vec![Leaf::TEXEL];
        while let Some(leaf) = pending.pop() {
            if let Some(flaw) = self.flaw(texel, &leaf, emitter) {
                cut(self, &leaf, &mut sum)?;
                sum.error += flaw;
            } else {
                pending.extend(leaf.quarters());
            }
        }
        // The parts cut off may exceed the whole by rounding.
        sum.flux = Rgb(sum.flux.0.map(|flux| flux.max(0.0)));
        sum.average()
    }

    /// The same as [`edge`](Self::edge), by ever smaller leaves, for any surface.
    fn by_quarters(&mut self, texel: usize, emitter: &Emitter) -> DirectTexel {
        let mut sum = Sum::NOTHING;
        let mut pending = vec![Leaf::TEXEL];
        while let Some(leaf) = pending.pop() {
            let flaw = self.flaw(texel, &leaf, emitter);
            let Some(flaw) = flaw.filter(|_| leaf.level >= EDGE_LEVELS) else {
                pending.extend(leaf.quarters());
                continue;
            };
            let look = self.look(texel, &leaf, emitter, None);
            let passed = self.with_outer_points(texel, &leaf, emitter, look.passed);
            let mixed = passed.is_mixed() && !look.unshadowed.is_black();
            if mixed && leaf.level < SHADOW_LEVELS {
                pending.extend(leaf.quarters());
                continue;
            }
            sum.add(&look);
            sum.error += flaw;
            if mixed {
                // The share that passes is somewhere between the least and the most.
                sum.error += look.unshadowed * (passed.most - passed.least);
            }
        }
        sum.average()
            .unwrap_or_else(|| self.at_home(texel, emitter))
    }

    /// Irradiance of a texel of which a mesh covers so little that no leaf's points found it.
    ///
    /// One point stands for the texel, and its irradiance without shadow for the error.
    fn at_home(&mut self, texel: usize, emitter: &Emitter) -> DirectTexel {
        self.receiver
            .home(self.scene, texel)
            .map_or(DirectTexel::UNKNOWN, |point| {
                let (error, passed) = self.arriving(&point, emitter);
                DirectTexel {
                    irradiance: error * passed,
                    error,
                }
            })
    }

    /// A leaf's part of its texel's irradiance, by 2 x 2 Gauss points.
    fn look(
        &mut self,
        texel: usize,
        leaf: &Leaf,
        emitter: &Emitter,
        share: Option<f64>,
    ) -> LeafLight {
        let mut look = LeafLight {
            flux: Rgb::BLACK,
            unshadowed: Rgb::BLACK,
            area: 0.0,
            range: NO_RANGE,
            passed: ShareRange::NOTHING_SEEN,
            found: 0,
            is_ragged: false,
        };
        let weight = leaf.size * leaf.size / 4.0;
        let mut first = None;
        for at in leaf.gauss_points() {
            let Some(patch) = self.patch(texel, at) else {
                continue;
            };
            let (arriving, passed) = match share {
                Some(share) => (unshadowed(&patch.point, emitter).0, share),
                None => self.arriving(&patch.point, emitter),
            };
            let area = patch.density * weight;
            look.area += area;
            look.unshadowed += arriving * area;
            look.flux += arriving * (passed * area);
            look.range = joined(look.range, (arriving, arriving));
            look.passed = look.passed.with_share(passed);
            look.found += 1;
            look.is_ragged |= !first.get_or_insert(patch).continues(&patch);
        }
        look.is_ragged |= (1..POINTS).contains(&look.found);
        look
    }

    /// Shares that a leaf's outer points see, joined with those of its points. On the receiver's border these
    /// points are moved onto the border.
    fn with_outer_points(
        &mut self,
        texel: usize,
        leaf: &Leaf,
        emitter: &Emitter,
        seen: ShareRange,
    ) -> ShareRange {
        let mut passed = seen;
        for i in OUTER_POINTS {
            for j in OUTER_POINTS {
                if passed.is_mixed() {
                    return passed;
                }
                let at = self.receiver.clamped(texel, leaf.at(i, j));
                if let Some(patch) = self.patch(texel, at) {
                    passed = passed.with_share(self.arriving(&patch.point, emitter).1);
                }
            }
        }
        passed
    }

    /// The flux \[W\] that 2 x 2 Gauss points may be wrong by in a leaf because of a spot's edges; `None` if
    /// the leaf is too large for them, because of these, or of 1/r² and the cosine.
    ///
    /// The relative error for 1/r² and the cosine is about (size / distance)⁴ / 100: a ratio of 1/64 leaves
    /// 1e-9. A spot's falloff has kinks at the angles where the beam starts to fall and where it ends. Let s
    /// be the jump of its slope, and h the leaf's size: across a kink, the two points are off by 0.025 s h²
    /// at most.
    fn flaw(&self, texel: usize, leaf: &Leaf, emitter: &Emitter) -> Option<Rgb> {
        let from = match emitter {
            Emitter::Point { position, .. } => *position,
            Emitter::Spot { to_world, .. } => to_world.point(DVec3::ZERO),
            _ => return Some(Rgb::BLACK),
        };
        let position = |x, y| Some(self.patch(texel, leaf.at(x, y))?.point.position);
        let corners = [(-0.5, -0.5), (0.5, -0.5), (-0.5, 0.5), (0.5, 0.5)]
            .into_iter()
            .filter_map(|(x, y)| position(x, y));
        let Some(middle) = position(0.0, 0.0).or_else(|| corners.clone().next()) else {
            return Some(Rgb::BLACK);
        };
        let is_last = leaf.level >= SHADOW_LEVELS;
        let distance = middle.distance(from);
        let size = self.receiver.texel_area(texel).sqrt() * leaf.size;
        if size > distance / 64.0 && !is_last {
            return None;
        }
        let Emitter::Spot {
            to_world,
            cutoff_angle,
            beam_width,
            intensity,
            ..
        } = emitter
        else {
            return Some(Rgb::BLACK);
        };
        let radius = corners
            .map(|corner| corner.distance(middle))
            .fold(0.0, f64::max);
        // The leaf is seen within about this angle of its middle.
        let reach = 1.1 * radius / distance;
        let angle = rotation::angle_between(middle - from, to_world.vector(DVec3::Z));
        if [cutoff_angle, beam_width]
            .iter()
            .all(|kink| (angle - *kink).abs() >= reach)
        {
            return Some(Rgb::BLACK);
        }
        if ends_in_a_step(emitter) {
            // Not a kink but a step: it is cut like a shadow's edge.
            return is_last.then_some(Rgb::BLACK);
        }
        // Both kinks may be in the leaf. It is as wide as twice the reach at most.
        let part = (2.0 * 0.025 * 2.0 * reach / (cutoff_angle - beam_width)).min(1.0);
        let is_small = part * leaf.size * leaf.size <= KINK;
        (is_small || is_last).then(|| *intensity * (part * size * size / (distance * distance)))
    }
}
