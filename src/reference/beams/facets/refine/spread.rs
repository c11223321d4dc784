//! Polygons whose light meets several facets, found from neighbour to neighbour.
//!
//! The light of a polygon meets facets as if these were drawn on it: each vertex has an image, the place of
//! the light that meets it. Where facets share all light among them, their images share the polygon. So it is
//! cut along the images' edges, with nothing left between the parts. A cut along a facet's edges whose rest
//! waits ([`cut_out`](FacetRefiner::cut_out)) goes on where no edge may be. That makes several times as many
//! polygons.

use glam::{DMat2, DVec2, DVec3};

use super::refiner::FacetRefiner;
use crate::reference::beams::facets::leg::LegEnd;
use crate::reference::beams::facets::polygon::LightPolygon;
use crate::transport::facets::path::FacetLight;
use crate::transport::facets::table::Facet;
use crate::transport::first_surface::Source;

/// Most facets that are looked at for one polygon.
const MOST_FACETS: usize = 256;

/// Most corners of a facet, and most facets beside it: work grows with their square.
const MOST_SIDES: usize = 32;

/// Most steps to a vertex's image. A step leaves of the error what is not affine in the map: light of a lamp
/// takes three or four of them, that of a sun one.
const MOST_STEPS: u32 = 12;

/// Largest error of a vertex's image, as a part of the size of the first facet, or of the part of it that a
/// polygon was cut from. Facets about a vertex have the same image of it, so that nothing is left between
/// them.
const OF_IMAGE: f64 = 1e-12;

/// Rounding of areas, in units of 2⁻⁵² of the outline times its largest coordinate: that of a polygon, and of
/// some ten parts of it.
const ROUNDING: f64 = 32.0;

/// An affine map from a facet's coordinates to those of a polygon's light.
struct AffineMap {
    at: DVec2,
    from: DVec2,
    slope: DMat2,
}

impl AffineMap {
    /// The map that three places of a polygon's light have. `None` if its light does not meet the plane, or
    /// goes along it.
    fn of<const N: usize>(polygon: &LightPolygon<N>, facet: &Facet) -> Option<Self> {
        let count = polygon.corners.len();
        let [a, b, c] = [0, count / 3, 2 * count / 3].map(|index| &polygon.corners[index]);
        let [p, q, r] = [met(facet, a)?, met(facet, b)?, met(facet, c)?];
        let inverse = DMat2::from_cols(q - p, r - p).inverse();
        let slope = DMat2::from_cols(b.at - a.at, c.at - a.at) * inverse;
        slope.is_finite().then_some(Self {
            at: a.at,
            from: p,
            slope,
        })
    }

    fn map(&self, place: DVec2) -> DVec2 {
        self.at + self.slope * (place - self.from)
    }
}

/// The place on a facet's plane that light meets.
fn met<const N: usize>(facet: &Facet, light: &FacetLight<N>) -> Option<DVec2> {
    let point = facet.meet(&light.ray)?;
    Some(facet.coordinates(point.position))
}

/// What a facet has of a polygon.
enum Share<const N: usize> {
    /// None of it.
    Nothing,
    /// A part.
    Part(LightPolygon<N>),
    /// An edge is too bent to be taken for straight. Or light that meets a vertex went another way, or none
    /// does.
    Unknown,
}

impl<const N: usize> FacetRefiner<'_, '_, '_, N> {
    /// Takes a polygon on to all facets that its light meets, if those around `first` share all of it among
    /// them. `false` if they do not: something else is in its way, or hides them from a part of it.
    pub(super) fn spread(&mut self, polygon: &LightPolygon<N>, first: u32) -> bool {
        let facets = self.paths.facets;
        let direction = polygon.corners[0].ray.direction;
        let is_from_front = |facet: u32| facets.get(facet).is_from_front(direction);
        let side = is_from_front(first);
        let area = polygon.area();
        let rounding = ROUNDING * f64::EPSILON * polygon.extent();
        let mut images = Vec::new();
        let mut asked = vec![first];
        let mut parts = Vec::new();
        let (mut shared, mut next) = (0.0, 0);
        // All are asked even if nothing seems to be left. A last one may have less than is lost by rounding,
        // and be the only light of a texel.
        while let Some(&facet) = asked.get(next) {
            next += 1;
            let corners = facets.outline(facets.get(facet)).len();
            if corners.max(facets.beside(facet).len()) > MOST_SIDES {
                return false;
            }
            match self.share(polygon, facet, &mut images) {
                Share::Nothing => continue,
                Share::Part(part) => {
                    shared += part.area();
                    parts.push((part, facet));
                    if shared > area + rounding {
                        return false;
                    }
                }
                Share::Unknown => return false,
            }
            for &other in facets.beside(facet) {
                // Beyond its outline a surface folds back, and lies behind itself.
                let is_seen = is_from_front(other) == side && polygon.chain.left() != Some(other);
                if is_seen && !asked.contains(&other) {
                    asked.push(other);
                }
            }
            if asked.len() > MOST_FACETS {
                return false;
            }
        }
        // Of a needle that rounding decides about, nothing is known.
        if (shared - area).abs() > rounding || rounding >= area {
            return false;
        }
        for (part, facet) in parts {
            let area = part.area();
            self.go_on(part, area, LegEnd::Facet(facet));
        }
        true
    }

    /// What a facet has of a polygon, given images of vertices. Adds those that it finds.
    fn share(
        &self,
        polygon: &LightPolygon<N>,
        facet: u32,
        images: &mut Vec<(DVec3, DVec2)>,
    ) -> Share<N> {
        let facet = self.paths.facets.get(facet);
        let vertices = self.paths.facets.outline(facet);
        let Some(map) = AffineMap::of(polygon, facet) else {
            return Share::Unknown;
        };
        let mut outline = Vec::with_capacity(vertices.len());
        for &vertex in vertices {
            if let Some((_, image)) = images.iter().find(|(place, _)| *place == vertex) {
                outline.push(*image);
                continue;
            }
            let Some(image) = self.image(polygon, facet, vertex, &map) else {
                return Share::Unknown;
            };
            images.push((vertex, image));
            outline.push(image);
        }
        let places: Vec<DVec2> = polygon.corners.iter().map(|light| light.at).collect();
        let common = common(&places, &outline);
        if common.len() < 3 {
            return Share::Nothing;
        }
        let corners = common.into_iter().map(|at| {
            let known = polygon.corners.iter().find(|light| light.at == at);
            known.map_or_else(|| self.paths.follow(&polygon.chain, at), |light| *light)
        });
        let mut part = polygon.with(corners.collect());
        let area = part.area();
        let [bent, most] = self.bent_edges(polygon, &places, (facet, &map), &outline);
        let flux = most * self.strength * polygon.largest_weight();
        if flux > self.tolerance(polygon) && self.is_worth_halving(polygon, polygon.area()) {
            return Share::Unknown;
        }
        part.uncertain_area = (part.share_of_uncertain_area(polygon.area()) + bent).min(area);
        Share::Part(part)
    }

    /// The place of the light that meets a vertex, by steps of an affine map.
    fn image(
        &self,
        polygon: &LightPolygon<N>,
        facet: &Facet,
        vertex: DVec3,
        map: &AffineMap,
    ) -> Option<DVec2> {
        let wanted = facet.coordinates(vertex);
        let mut at = map.map(wanted);
        let near =
            (OF_IMAGE * polygon.whole.sqrt()).max(4.0 * f64::EPSILON * at.abs().max_element());
        for _ in 0..MOST_STEPS {
            let light: FacetLight<N> = self.paths.follow(&polygon.chain, at);
            if light.state != polygon.corners[0].state {
                return None;
            }
            let step = map.slope * (wanted - met(facet, &light)?);
            at += step;
            if step.abs().max_element() <= near {
                return Some(at);
            }
        }
        None
    }

    /// The area \[coordinates\] that the straight images of a facet's edges put on the wrong side within a
    /// polygon: that of all, and the largest of one. It is 0 for parallel light.
    ///
    /// An edge's true image is bent by d in the middle of its part within the polygon. The area between is no
    /// more than d times the part's length, as the bend is concave.
    fn bent_edges(
        &self,
        polygon: &LightPolygon<N>,
        places: &[DVec2],
        (facet, map): (&Facet, &AffineMap),
        outline: &[DVec2],
    ) -> [f64; 2] {
        if matches!(self.paths.source, Source::Parallel { .. }) {
            return [0.0; 2];
        }
        let vertices = self.paths.facets.outline(facet);
        let edges = (0..outline.len()).map(|index| [index, (index + 1) % outline.len()]);
        let bend = |ends: [usize; 2]| {
            let [a, b] = within(places, ends.map(|end| outline[end]))?;
            let light: FacetLight<N> = self.paths.follow(&polygon.chain, 0.5 * (a + b));
            let [from, to] = ends.map(|end| facet.coordinates(vertices[end]));
            let (along, off) = (to - from, met(facet, &light)? - from);
            let off = off - along * (off.dot(along) / along.length_squared());
            Some((map.slope * off).perp_dot(b - a).abs())
        };
        let areas = edges.filter_map(bend);
        areas.fold([0.0, 0.0], |[all, most], area| {
            [all + area, f64::max(most, area)]
        })
    }
}

/// Twice the signed area of a polygon, by triangles about its first corner.
fn turn(outline: &[DVec2]) -> f64 {
    let Some((first, rest)) = outline.split_first() else {
        return 0.0;
    };
    let pairs = rest.windows(2);
    pairs
        .map(|two| (two[0] - *first).perp_dot(two[1] - *first))
        .sum()
}

/// What two convex polygons have in common: the first, cut along each edge of the other (Sutherland and
/// Hodgman, "Reentrant polygon clipping", 1974).
fn common(polygon: &[DVec2], other: &[DVec2]) -> Vec<DVec2> {
    let side = turn(other).signum();
    let mut piece = polygon.to_vec();
    let mut kept = Vec::with_capacity(polygon.len() + other.len());
    for (index, a) in other.iter().enumerate() {
        let b = other[(index + 1) % other.len()];
        let height = |at: DVec2| side * (b - *a).perp_dot(at - *a);
        kept.clear();
        for (number, &at) in piece.iter().enumerate() {
            let next = piece[(number + 1) % piece.len()];
            let (is, will) = (height(at), height(next));
            if is >= 0.0 {
                kept.push(at);
            }
            if is * will < 0.0 {
                kept.push(at + (next - at) * (is / (is - will)));
            }
        }
        std::mem::swap(&mut piece, &mut kept);
    }
    piece
}

/// The part of a line within a convex polygon; `None` if it has none.
fn within(polygon: &[DVec2], [a, b]: [DVec2; 2]) -> Option<[DVec2; 2]> {
    let side = turn(polygon).signum();
    let (mut from, mut to) = (0.0, 1.0);
    for (index, &corner) in polygon.iter().enumerate() {
        let along = polygon[(index + 1) % polygon.len()] - corner;
        let [at_a, at_b] = [a, b].map(|end| side * along.perp_dot(end - corner));
        if at_a < 0.0 && at_b < 0.0 {
            return None;
        }
        let crossing = at_a / (at_a - at_b);
        if at_a < 0.0 {
            from = f64::max(from, crossing);
        } else if at_b < 0.0 {
            to = f64::min(to, crossing);
        }
    }
    (from < to).then(|| [from, to].map(|part| a + (b - a) * part))
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: [DVec2; 4] = [
        DVec2::new(0.0, 0.0),
        DVec2::new(1.0, 0.0),
        DVec2::new(1.0, 1.0),
        DVec2::new(0.0, 1.0),
    ];

    #[test]
    fn four_triangles_about_a_place_share_a_square_whatever_way_they_turn() {
        let middle = DVec2::new(0.3, 0.6);
        let far = [[-2.0, -1.0], [3.0, -0.5], [2.0, 4.0], [-1.0, 3.0]].map(DVec2::from_array);
        let mut area = 0.0;
        for index in 0..4 {
            let mut triangle = [middle, far[index], far[(index + 1) % 4]];
            if index % 2 == 1 {
                triangle.reverse();
            }
            area += 0.5 * turn(&common(&SQUARE, &triangle)).abs();
        }
        assert!((area - 1.0).abs() < 1e-15, "{area}");
    }

    #[test]
    fn a_polygon_beside_another_has_nothing_in_common_with_it() {
        let away = SQUARE.map(|corner| corner + DVec2::new(2.0, 0.5));
        assert!(common(&SQUARE, &away).len() < 3);
    }

    #[test]
    fn a_line_is_cut_to_its_part_within() {
        let line = |a: [f64; 2], b: [f64; 2]| within(&SQUARE, [a, b].map(DVec2::from_array));
        let half = line([-1.0, 0.5], [0.5, 0.5]).unwrap();
        assert_eq!(half, [DVec2::new(0.0, 0.5), DVec2::new(0.5, 0.5)]);
        assert_eq!(line([-1.0, 1.5], [2.0, 1.5]), None);
        assert_eq!(line([1.5, -1.0], [3.0, 0.6]), None);
    }
}
