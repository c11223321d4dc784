//! The space that a bundle of neighbouring path segments sweeps, and tests for overlap with it.

use glam::DVec3;

use super::{Bounds, PlanePair};
use crate::numeric::math;

/// The factor from the largest |d| (below) to the bulge of a bundle.
///
/// The bundle is a triangle of paths, known at its three corners and at the middles of its three edges: index
/// `i + 3` is the middle of the edge opposite to corner `i`.
///
/// The quadratic through the six bounds the points between them: with barycentric weights λ it is
/// Σ λᵢ pᵢ + 4 Σ λⱼ λₖ dᵢ, in which dᵢ is the distance of a middle from the mean of its edge's ends. The
/// second sum has its largest weight, 4/3, in the centre. The margin used everywhere here is twice the
/// largest |d|: half as much again, for the part that a quadratic does not show.
const MARGIN: f64 = 2.0;

/// The two corners at the ends of the edge opposite to each corner.
const ENDS: [[usize; 2]; 3] = [[1, 2], [2, 0], [0, 1]];

/// The largest distance of a point of the bundle from the triangle of its corners [scene units]; infinite if
/// a point is not finite.
#[inline]
pub fn bulge(points: &[DVec3; 6]) -> f64 {
    if !points.iter().sum::<DVec3>().is_finite() {
        return f64::INFINITY;
    }
    let mut largest = 0.0_f64;
    for (i, [j, k]) in ENDS.into_iter().enumerate() {
        let mean = 0.5 * (points[j] + points[k]);
        largest = largest.max((points[i + 3] - mean).length_squared());
    }
    MARGIN * largest.sqrt()
}

/// The least and the largest value of a function in the bundle, judged by its six values; unbounded if one of
/// them is not finite.
#[inline]
pub fn range(values: &[f64; 6]) -> [f64; 2] {
    if !values.iter().sum::<f64>().is_finite() {
        return [f64::NEG_INFINITY, f64::INFINITY];
    }
    let mut largest = 0.0_f64;
    for (i, [j, k]) in ENDS.into_iter().enumerate() {
        largest = largest.max((values[i + 3] - 0.5 * (values[j] + values[k])).abs());
    }
    let [a, b, c, ..] = *values;
    let margin = MARGIN * largest;
    [a.min(b).min(c) - margin, a.max(b).max(c) + margin]
}

/// The largest length of a vector in the bundle, judged by its six values.
#[inline]
pub fn longest(vectors: &[DVec3; 6]) -> f64 {
    let longest = vectors[..3]
        .iter()
        .map(|vector| vector.length_squared())
        .fold(0.0, f64::max);
    longest.sqrt() + bulge(vectors)
}

/// The convex hull of a bundle of path segments. It is that of two ends, triangles or polygons of at most `K`
/// corners. The corners are balls, as large as the paths between them bulge.
///
/// Tests for overlap are conservative: false only if no part of the hull is in the tested shape. They look
/// for a plane between the two (separating axes) among a few good ones.
#[derive(Clone, Copy, Debug)]
pub struct Hull<const K: usize = 3> {
    start: Cap<K>,
    end: Cap<K>,
    bounds: Bounds,
    /// Pairs of planes along its sides, which separate best: so many.
    sides: [PlanePair; K],
    side_count: usize,
    /// Pairs of planes across it, and along its two ends.
    others: [PlanePair; 3],
}

/// One end of a hull. If it has less than `K` corners, the last one is there more than once.
#[derive(Clone, Copy, Debug)]
struct Cap<const K: usize> {
    corners: [DVec3; K],
    radius: f64,
}

impl<const K: usize> Cap<K> {
    /// The end with these corners, between which paths bulge so far.
    fn new(corners: [DVec3; K], bulge: f64) -> Self {
        // The points themselves are sums of a few rounded terms of this size.
        let size = corners
            .iter()
            .fold(DVec3::ZERO, |all, one| all.max(one.abs()));
        let radius = bulge + 64.0 * f64::EPSILON * size.max_element();
        if radius.is_finite() {
            Self { corners, radius }
        } else {
            // The cap may be anywhere.
            Self {
                corners: [DVec3::ZERO; K],
                radius: f64::INFINITY,
            }
        }
    }

    fn middle(&self) -> DVec3 {
        self.corners.iter().sum::<DVec3>() / K as f64
    }

    fn halfway(&self, to: &Self) -> Self {
        Self {
            corners: std::array::from_fn(|i| 0.5 * (self.corners[i] + to.corners[i])),
            radius: 0.5 * (self.radius + to.radius),
        }
    }

    fn normal(&self) -> DVec3 {
        let [a, b, c] = [0, 1, 2].map(|i| self.corners[i]);
        (b - a).cross(c - a).normalize_or_zero()
    }

    #[inline]
    fn reach(&self, along: DVec3) -> [f64; 2] {
        let values = self.corners.map(|corner| corner.dot(along));
        let low = values.iter().copied().fold(f64::INFINITY, f64::min);
        let high = values.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let radius = self.radius * along.length();
        [low - radius, high + radius]
    }

    fn bounds(&self) -> Bounds {
        Bounds::from_points(self.corners).padded(self.radius)
    }
}

impl Hull {
    /// The hull of the segments from each of the `start` points to the `end` point of the same
    /// index: three corners, then the middles of the edges opposite to them.
    pub fn new(start: &[DVec3; 6], end: &[DVec3; 6]) -> Self {
        let [start, end] = [start, end].map(|points| {
            let [a, b, c, ..] = *points;
            Cap::new([a, b, c], bulge(points))
        });
        Self::between(start, end)
    }
}

impl<const K: usize> Hull<K> {
    /// The hull of the segments between the corners of two polygons, from one to `K`, given how far the paths
    /// between them [bulge](bulge) at each end.
    pub fn of_polygons(start: &[DVec3], end: &[DVec3], bulges: [f64; 2]) -> Self {
        let corners = |of: &[DVec3]| std::array::from_fn(|i| of[i.min(of.len() - 1)]);
        Self::between(
            Cap::new(corners(start), bulges[0]),
            Cap::new(corners(end), bulges[1]),
        )
    }

    fn between(start: Cap<K>, end: Cap<K>) -> Self {
        let along = (end.middle() - start.middle()).normalize_or_zero();
        let side = |i: usize| {
            // The edge opposite to the corner, for a triangle.
            let [j, k] = [(i + 1) % K, (i + 2) % K];
            let [first, last] = [start, end].map(|cap| cap.corners[k] - cap.corners[j]);
            // The larger end's edge: at a light or a focus the other one is a point.
            let edge = if first.length_squared() > last.length_squared() {
                first
            } else {
                last
            };
            let path = (end.corners[j] - start.corners[j]) + (end.corners[k] - start.corners[k]);
            edge.cross(path).normalize_or_zero()
        };
        let axis = |along: DVec3| {
            let [a, b] = [start.reach(along), end.reach(along)];
            PlanePair {
                along,
                low: a[0].min(b[0]),
                high: a[1].max(b[1]),
            }
        };
        let (mut sides, mut side_count) = ([PlanePair::EVERYWHERE; K], 0);
        for across in (0..K).map(side) {
            // Sides between corners that are the same tell nothing.
            if across != DVec3::ZERO {
                sides[side_count] = axis(across);
                side_count += 1;
            }
        }
        Self {
            start,
            end,
            bounds: start.bounds().union(end.bounds()),
            sides,
            side_count,
            others: [along, start.normal(), end.normal()].map(axis),
        }
    }

    /// The slanted pairs of planes that it is between.
    #[inline]
    fn slanted(&self) -> impl Iterator<Item = &PlanePair> {
        self.sides[..self.side_count].iter().chain(&self.others)
    }

    /// Pairs of planes that it is between: those of its box, and slanted ones.
    #[inline]
    pub fn plane_pairs(&self) -> impl Iterator<Item = PlanePair> {
        let Bounds { min, max } = self.bounds;
        let upright = (0..3).map(move |axis| PlanePair {
            along: DVec3::AXES[axis],
            low: min[axis],
            high: max[axis],
        });
        self.slanted().copied().chain(upright)
    }

    /// The first and the second half of all its segments.
    pub fn halves(&self) -> [Self; 2] {
        let middle = self.start.halfway(&self.end);
        [
            Self::between(self.start, middle),
            Self::between(middle, self.end),
        ]
    }

    /// The box around it.
    #[inline]
    pub fn bounds(&self) -> &Bounds {
        &self.bounds
    }

    /// The least and the largest dot product of its points with `along`.
    #[inline]
    pub fn reach(&self, along: DVec3) -> [f64; 2] {
        let [a, b] = [self.start.reach(along), self.end.reach(along)];
        [a[0].min(b[0]), a[1].max(b[1])]
    }

    /// True if all of it is nearer to `center` than `radius`.
    #[inline]
    pub fn is_inside_ball(&self, center: DVec3, radius: f64) -> bool {
        // A ball is convex: the ends suffice.
        [&self.start, &self.end].into_iter().all(|cap| {
            cap.corners
                .iter()
                .all(|corner| (*corner - center).length() + cap.radius < radius)
        })
    }

    /// True if a solid ball may overlap it.
    pub fn may_overlap_ball(&self, center: DVec3, radius: f64) -> bool {
        let apart =
            |low: f64, high: f64, middle: f64| middle - radius > high || middle + radius < low;
        let Bounds { min, max } = self.bounds;
        if (0..3).any(|axis| apart(min[axis], max[axis], center[axis]))
            || self
                .slanted()
                .any(|pair| apart(pair.low, pair.high, pair.along.dot(center)))
        {
            return false;
        }
        // The direction from the bundle's middle line to the ball.
        let (from, to) = (self.start.middle(), self.end.middle());
        let line = to - from;
        let t = (center - from).dot(line) / line.length_squared();
        let nearest = from + line * if t > 0.0 { t.min(1.0) } else { 0.0 };
        let along = (center - nearest).normalize_or_zero();
        let [low, high] = self.reach(along);
        along == DVec3::ZERO || !apart(low, high, along.dot(center))
    }

    /// True if the convex hull of `points` may overlap it. `normals` are further directions along which the
    /// two may be apart (for example a flat shape's normal), of any length.
    #[inline]
    pub fn may_overlap_points(&self, points: &[DVec3], normals: &[DVec3]) -> bool {
        let other = Bounds::from_points(points.iter().copied());
        if self.bounds.min.cmpgt(other.max).any() || other.min.cmpgt(self.bounds.max).any() {
            return false;
        }
        !(self.slanted().any(|pair| pair.is_beside(points))
            || normals.iter().any(|&along| {
                let [low, high] = self.reach(along);
                PlanePair { along, low, high }.is_beside(points)
            }))
    }

    /// True if a triangle may overlap it.
    #[inline]
    pub fn may_overlap_face(&self, corners: &[DVec3; 3]) -> bool {
        let [a, b, c] = *corners;
        self.may_overlap_points(corners, &[(b - a).cross(c - a)])
    }

    /// True if an elliptic disc with these half axes may overlap it.
    pub fn may_overlap_disk(&self, center: DVec3, [u, v]: [DVec3; 2]) -> bool {
        let apart = |low: f64, high: f64, along: DVec3| {
            // An ellipse reaches √(u² + v²) along each direction.
            let reach = math::hypot(along.dot(u), along.dot(v));
            let middle = along.dot(center);
            middle - reach > high || middle + reach < low
        };
        let further = [DVec3::X, DVec3::Y, DVec3::Z, u.cross(v)];
        !(self
            .slanted()
            .any(|pair| apart(pair.low, pair.high, pair.along))
            || further.into_iter().any(|along| {
                let [low, high] = self.reach(along);
                apart(low, high, along)
            }))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn point(size: f64) -> impl Strategy<Value = DVec3> {
        [-size..size, -size..size, -size..size].prop_map(DVec3::from_array)
    }

    /// Corners of any triangle, and the offsets of the middles of its edges from their means.
    type Quadratic = ([DVec3; 3], [DVec3; 3]);

    fn quadratic(size: f64, bend: f64) -> impl Strategy<Value = Quadratic> {
        (
            [point(size), point(size), point(size)],
            [point(bend), point(bend), point(bend)],
        )
    }

    fn nodes(&(corners, bends): &Quadratic) -> [DVec3; 6] {
        std::array::from_fn(|i| {
            if i < 3 {
                return corners[i];
            }
            let [j, k] = ENDS[i - 3];
            0.5 * (corners[j] + corners[k]) + bends[i - 3]
        })
    }

    /// The quadratic through the six nodes.
    fn at(&(corners, bends): &Quadratic, weights: [f64; 3]) -> DVec3 {
        let mut sum = DVec3::ZERO;
        for (i, [j, k]) in ENDS.into_iter().enumerate() {
            sum += corners[i] * weights[i] + bends[i] * (4.0 * weights[j] * weights[k]);
        }
        sum
    }

    fn weights([x, y]: [f64; 2]) -> [f64; 3] {
        let (x, y) = if x + y > 1.0 {
            (1.0 - x, 1.0 - y)
        } else {
            (x, y)
        };
        [1.0 - x - y, x, y]
    }

    /// True if no planes beside the hull tell that a box is beside it, too.
    fn may_overlap_box<const K: usize>(hull: &Hull<K>, bounds: &Bounds) -> bool {
        !hull
            .plane_pairs()
            .any(|pair| pair.is_beside(&bounds.corners()))
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 20_000, ..ProptestConfig::default() })]

        #[test]
        fn whatever_a_path_of_the_bundle_touches_is_reported(
            start in quadratic(1.0, 0.2),
            end in quadratic(1.0, 0.2),
            shrink in prop::sample::select(vec![1.0, 1e-2, 1e-5, 0.0]),
            offset in point(3.0),
            inside in [0.0..1.0, 0.0..1.0],
            t in 0.0..=1.0,
            size in -6.0..1.0,
            to in [point(1.0), point(1.0), point(1.0)],
        ) {
            // Bundles of all widths: the bends shrink with the square.
            let narrow = |(corners, bends): Quadratic, offset: DVec3| -> Quadratic {
                (corners.map(|c| c * shrink + offset), bends.map(|b| b * shrink * shrink))
            };
            let (start, end) = (narrow(start, DVec3::ZERO), narrow(end, offset));
            let hull = Hull::new(&nodes(&start), &nodes(&end));
            let inside = weights(inside);
            let touched = at(&start, inside).lerp(at(&end, inside), t);
            let size = math::powf(10.0, size);
            // A box, a ball, a triangle and a disc through the point.
            let [p, q, r] = to.map(|to| touched + to * size);
            prop_assert!(may_overlap_box(&hull, &Bounds::from_points([p, touched])));
            prop_assert!(may_overlap_box(&hull, &Bounds::from_points([touched, touched])));
            prop_assert!(hull.may_overlap_ball(p, (p - touched).length() * (1.0 + 1e-12)));
            // The point is a mean of the corners.
            let triangle = [p, q, 3.0 * touched - p - q];
            let normal = (p - q).cross(touched - q);
            prop_assert!(hull.may_overlap_points(&triangle, &[normal, r - touched]));
            let (u, v) = (to[0] * size, to[1] * size);
            prop_assert!(hull.may_overlap_disk(touched - 0.6 * u - 0.7999 * v, [u, v]));
            // One of the halves also has it.
            let half = hull.halves()[usize::from(t > 0.5)];
            prop_assert!(may_overlap_box(&half, &Bounds::from_points([touched, touched])));
            prop_assert!(hull.bounds().contains(touched));
        }

        #[test]
        fn what_is_farther_off_than_the_hull_is_wide_is_not_reported(
            start in quadratic(1.0, 0.1),
            end in quadratic(1.0, 0.1),
            azimuth in 0.0..std::f64::consts::TAU,
            t in 0.0..1.0,
            size in 0.0..0.5,
        ) {
            // Along z, within 4 of the axis: a corner is at most √3 off, a middle's bulge at most
            // 2 · 0.1 √3 more, and the ends' depths no more than that.
            let end = (end.0.map(|c| c + 20.0 * DVec3::Z), end.1);
            let hull = Hull::new(&nodes(&start), &nodes(&end));
            let away = DVec3::new(math::cos(azimuth), math::sin(azimuth), 0.0);
            let beside = away * 8.0 + DVec3::Z * (20.0 * t);
            prop_assert!(!hull.may_overlap_ball(beside, size));
            let box_beside = Bounds::from_points([beside]).padded(size);
            let flat = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| beside + axis * size);
            prop_assert!(!may_overlap_box(&hull, &box_beside));
            prop_assert!(!hull.may_overlap_points(&flat, &[away]));
            prop_assert!(!hull.may_overlap_disk(beside, [DVec3::X * size, DVec3::Y * size]));
            let behind = DVec3::Z * (24.0 + size);
            prop_assert!(!hull.may_overlap_ball(behind, size));
        }

        #[test]
        fn a_range_holds_all_values_of_a_quadratic(
            function in quadratic(1.0, 0.5),
            inside in [0.0..1.0, 0.0..1.0],
        ) {
            let value = at(&function, weights(inside));
            let [low, high] = range(&nodes(&function).map(|node| node.x));
            prop_assert!((low..=high).contains(&value.x));
            prop_assert!(value.length() <= longest(&nodes(&function)));
        }
    }

    #[test]
    fn a_slanted_bundle_passes_through_the_corner_of_no_box() {
        // Its box is the unit cube, but it runs along the diagonal.
        let start = [DVec3::ZERO; 6];
        let corners = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| DVec3::ONE + 0.02 * axis);
        let end = nodes(&(corners, [DVec3::ZERO; 3]));
        let hull = Hull::new(&start, &end);
        let corner = Bounds::from_points([DVec3::X]).padded(0.3);
        assert!(!may_overlap_box(&hull, &corner));
        assert!(may_overlap_box(
            &hull,
            &Bounds::from_points([DVec3::splat(0.5)])
        ));
    }

    #[test]
    fn what_is_not_a_number_may_overlap_anything() {
        for index in 0..6 {
            let mut start = [DVec3::ZERO; 6];
            start[index].y = f64::NAN;
            let hull = Hull::new(&start, &[DVec3::ONE; 6]);
            let far = DVec3::splat(10.0);
            assert!(hull.may_overlap_ball(far, 0.1));
            assert!(may_overlap_box(&hull, &Bounds::from_points([far])));
            assert!(hull.may_overlap_points(&[far], &[DVec3::X]));
            assert!(hull.may_overlap_disk(far, [DVec3::X, DVec3::Y]));
            let mut values = [0.0; 6];
            values[index] = f64::NAN;
            assert_eq!(range(&values), [f64::NEG_INFINITY, f64::INFINITY]);
        }
    }
}
