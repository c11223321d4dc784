//! Convex polygons of light, and their cuts.

use std::ops::Range;

use glam::DVec2;

use crate::transport::facets::path::{FacetChain, FacetLight, FacetPaths};

/// A convex polygon of light that has gone by one chain of facets so far.
#[derive(Clone, Debug)]
pub(super) struct LightPolygon<const N: usize> {
    /// The light of its corners on the leg that comes next.
    pub(super) corners: Vec<FacetLight<N>>,
    /// The facets that it met, and its events there.
    pub(super) chain: FacetChain,
    /// The signatures that it is followed for, by number. Its events are the first ones of each.
    pub(super) signatures: Range<usize>,
    /// Coordinate area of light that may go another way. A cut along a bent line put it on the wrong side, or
    /// the obstacles on its way are not known.
    pub(super) uncertain_area: f64,
    /// Number of times that it was halved or cut without leaving its leg.
    pub(super) cuts: u32,
    /// The coordinate area that it was cut from: a facet, or a part of it close to a light.
    pub(super) whole: f64,
}

/// Two parts of a polygon.
pub(super) struct Parts<const N: usize> {
    pub(super) above: Vec<FacetLight<N>>,
    pub(super) below: Vec<FacetLight<N>>,
    /// The ends of the line between.
    pub(super) line: [DVec2; 2],
}

/// The relation of a line to a polygon.
pub(super) enum PolygonCut<const N: usize> {
    /// All of it is above.
    Above,
    /// All of it is below.
    Below,
    /// It is in two parts, one on each side.
    Through(Parts<N>),
}

/// Size, as a fraction of the largest value, below which values are zero: they are differences of products
/// whose rounding is as large.
const SMALLEST: f64 = 1e-13;

/// True if values are zero or less, give or take `rounding`, or the tolerance of [`LightPolygon::cut`].
pub(super) fn is_below(values: impl Iterator<Item = f64> + Clone, rounding: f64) -> bool {
    let largest = values.clone().fold(0.0_f64, |l, value| l.max(value.abs()));
    let zero = rounding.max(SMALLEST * largest);
    values.into_iter().all(|value| value <= zero)
}

impl<const N: usize> LightPolygon<N> {
    /// The area in coordinates of the first facet, and the middle.
    pub(super) fn area_and_middle(&self) -> (f64, DVec2) {
        area_and_middle(self.corners.iter().map(|corner| corner.at))
    }

    /// The area in coordinates of the first facet.
    pub(super) fn area(&self) -> f64 {
        self.area_and_middle().0
    }

    /// The length of its outline times its largest coordinate: what rounding of its area grows with.
    pub(super) fn extent(&self) -> f64 {
        let places = self.corners.iter().map(|corner| corner.at);
        let next = places.clone().cycle().skip(1);
        let length: f64 = places.clone().zip(next).map(|(a, b)| a.distance(b)).sum();
        length * places.fold(0.0, |most, at| at.abs().max_element().max(most))
    }

    /// Largest flux \[W\] of a corner for a unit of coordinate area, in units of the source's strength.
    pub(super) fn largest_weight(&self) -> f64 {
        self.corners.iter().fold(0.0, |largest, corner| {
            largest.max(corner.emitted * corner.throughput.max_magnitude())
        })
    }

    /// True if all corners went the same way.
    pub(super) fn is_one_topology(&self) -> bool {
        let first = self.corners.first().map(|corner| corner.state);
        self.corners
            .iter()
            .all(|corner| Some(corner.state) == first)
    }

    /// The same chain and leg with other corners.
    pub(super) fn with(&self, corners: Vec<FacetLight<N>>) -> Self {
        Self {
            corners,
            chain: self.chain.clone(),
            signatures: self.signatures.clone(),
            uncertain_area: self.uncertain_area,
            cuts: self.cuts + 1,
            whole: self.whole,
        }
    }

    /// Uncertain area that may be in this part of a whole: twice its share, as it is along some of the
    /// borders only.
    pub(super) fn share_of_uncertain_area(&self, whole: f64) -> f64 {
        self.uncertain_area * (2.0 * self.area() / whole).min(1.0)
    }

    /// The triangles that it is made of, all with its first corner.
    pub(super) fn fan(&self) -> impl Iterator<Item = [FacetLight<N>; 3]> + '_ {
        let triangle = |index| [0, index, index + 1].map(|corner| self.corners[corner]);
        (1..self.corners.len().saturating_sub(1)).map(triangle)
    }

    /// Cuts it where a function is zero, given its values at the corners. The function is linear along its
    /// edges.
    pub(super) fn cut(&self, values: &[f64], paths: &FacetPaths) -> PolygonCut<N> {
        let largest = values.iter().fold(0.0_f64, |l, value| l.max(value.abs()));
        let snap = |value: f64| {
            if value.abs() <= SMALLEST * largest {
                0.0
            } else {
                value
            }
        };
        if values.iter().all(|&value| snap(value) >= 0.0) {
            return PolygonCut::Above;
        }
        if values.iter().all(|&value| snap(value) <= 0.0) {
            return PolygonCut::Below;
        }
        let mut parts = Parts {
            above: Vec::with_capacity(self.corners.len() + 1),
            below: Vec::with_capacity(self.corners.len() + 1),
            line: [DVec2::ZERO; 2],
        };
        let mut crossings = 0;
        let mut cross = |at: DVec2| {
            if crossings < 2 {
                parts.line[crossings] = at;
            }
            crossings += 1;
        };
        let count = self.corners.len();
        for index in 0..count {
            let next = (index + 1) % count;
            let (corner, other) = (&self.corners[index], &self.corners[next]);
            let (is, will) = (snap(values[index]), snap(values[next]));
            if is >= 0.0 {
                parts.above.push(*corner);
            }
            if is <= 0.0 {
                parts.below.push(*corner);
            }
            if is == 0.0 {
                cross(corner.at);
            }
            if is * will < 0.0 {
                let t = is / (is - will);
                let at = corner.at + (other.at - corner.at) * t;
                let between = paths.follow(&self.chain, at);
                parts.above.push(between);
                parts.below.push(between);
                cross(at);
            }
        }
        PolygonCut::Through(parts)
    }

    /// Its halves, across its longest diagonal or edge.
    pub(super) fn halves(&self, paths: &FacetPaths) -> Option<[Self; 2]> {
        let (_, middle) = self.area_and_middle();
        // Lengths as on the surface: coordinates may be stretched.
        let facet = paths.facets.get(self.chain.first());
        let place = |at: DVec2| facet.point(at).position;
        let mut longest = (0.0, DVec2::ZERO);
        for (index, a) in self.corners.iter().enumerate() {
            for b in &self.corners[index + 1..] {
                let length = place(a.at).distance_squared(place(b.at));
                if length > longest.0 {
                    longest = (length, b.at - a.at);
                }
            }
        }
        let values: Vec<f64> = self
            .corners
            .iter()
            .map(|corner| (corner.at - middle).dot(longest.1))
            .collect();
        match self.cut(&values, paths) {
            PolygonCut::Through(parts) => {
                let whole = self.area();
                Some([parts.above, parts.below].map(|corners| {
                    let mut half = self.with(corners);
                    half.uncertain_area = half.share_of_uncertain_area(whole).min(half.area());
                    half
                }))
            }
            PolygonCut::Above | PolygonCut::Below => None,
        }
    }
}

/// Area and middle of a convex polygon.
fn area_and_middle(corners: impl Iterator<Item = DVec2> + Clone) -> (f64, DVec2) {
    let mut rest = corners.clone();
    let Some(first) = rest.next() else {
        return (0.0, DVec2::ZERO);
    };
    let (mut area, mut moment, mut sum, mut count) = (0.0, DVec2::ZERO, DVec2::ZERO, 0.0);
    for (a, b) in rest.clone().zip(rest.skip(1)) {
        let (a, b) = (a - first, b - first);
        let part = 0.5 * a.perp_dot(b);
        area += part;
        moment += (a + b) * (part / 3.0);
    }
    for corner in corners {
        sum += corner;
        count += 1.0;
    }
    let middle = first + moment / area;
    // The centroid of a needle is not a number.
    let middle = if middle.is_finite() {
        middle
    } else {
        sum / count
    };
    (area.abs(), middle)
}
