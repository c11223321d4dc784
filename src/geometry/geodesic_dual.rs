//! Linear interpolation between the middles of a geodesic's triangles.

use glam::{DMat3, DVec3};

use super::geodesic::Geodesic;
use super::geodesic_lattice::{GeodesicLattice, border};

/// The sphere of directions, divided into triangles between the middles of a [`Geodesic`]'s triangles.
///
/// Around each vertex of the geodesic lies a polygon of middles: six, or five at a corner of the icosahedron.
/// It is cut into an inner triangle of every other middle, and ears. Values at middles that are interpolated
/// linearly in these triangles are continuous over the whole sphere, and take three values a place.
#[derive(Clone, Debug)]
pub struct GeodesicDual {
    /// Unit directions, by the geodesic's triangles.
    middles: Vec<DVec3>,
    /// What serves far from the edges of the icosahedron.
    lattice: GeodesicLattice,
    /// The polygons around vertices on edges of the icosahedron, and which of them each of the lattice's
    /// numbers has.
    polygons: Vec<Polygon>,
    borders: Vec<u32>,
}

/// A polygon of middles around a vertex.
#[derive(Clone, Debug)]
struct Polygon {
    /// The inner triangle: every other middle, counter-clockwise seen from outside.
    inner: [u32; 3],
    /// The tips of ears beyond its edges, the first edge from the first middle to the second: three, or two.
    tips: [Option<u32>; 3],
    /// The normals of the planes through these edges, inward.
    lines: [DVec3; 3],
    /// By ear: those of the planes from its tip to the edge's end, and from the edge's start to its tip.
    sides: [[DVec3; 2]; 3],
    /// The polygons beside it.
    beside: Vec<u32>,
}

impl Polygon {
    fn new(geodesic: &Geodesic, middles: &[DVec3], vertex: u32, first: u32) -> Self {
        // The triangles around the vertex, counter-clockwise.
        let mut ring = Vec::with_capacity(6);
        let mut next = first;
        while ring.is_empty() || next != first && ring.len() < 6 {
            ring.push(next);
            // Across the edge from the vertex to the corner before it.
            let corners = geodesic.triangles()[next as usize];
            let corner = corners.iter().position(|corner| *corner == vertex);
            next = geodesic.neighbours(next)[(corner.unwrap_or(0) + 1) % 3];
        }
        let at = |triangle: u32| middles[triangle as usize];
        let inner = [ring[0], ring[2], ring[4]];
        let tips = [ring.get(1), ring.get(3), ring.get(5)].map(Option::<&u32>::copied);
        let ends = |ear: usize| [at(inner[ear]), at(inner[(ear + 1) % 3])];
        Self {
            inner,
            tips,
            lines: std::array::from_fn(|ear| {
                let [start, end] = ends(ear);
                start.cross(end)
            }),
            sides: std::array::from_fn(|ear| {
                let [start, end] = ends(ear);
                let tip = tips[ear].map_or(DVec3::ZERO, at);
                [tip.cross(end), start.cross(tip)]
            }),
            beside: Vec::new(),
        }
    }

    /// The three middles between which a direction lies that is in the polygon, with their shares; one of
    /// these is negative if the direction is not in it.
    #[inline]
    fn between(&self, direction: DVec3) -> [(u32, f64); 3] {
        let sides = self.lines.map(|line| line.dot(direction));
        let beyond = |ear: usize| self.tips[ear].filter(|_| sides[ear] < 0.0);
        let found = (0..3).find_map(|ear| beyond(ear).map(|tip| (ear, tip)));
        let (triangles, shares) = if let Some((ear, tip)) = found {
            let [end, start] = self.sides[ear].map(|side| side.dot(direction));
            let triangles = [self.inner[ear], tip, self.inner[(ear + 1) % 3]];
            (triangles, [end, -sides[ear], start])
        } else {
            (self.inner, [sides[1], sides[2], sides[0]])
        };
        let scale = 1.0 / (shares[0] + shares[1] + shares[2]);
        std::array::from_fn(|k| (triangles[k], shares[k] * scale))
    }
}

/// The least of three shares.
#[inline]
fn least(three: &[(u32, f64); 3]) -> f64 {
    three[0].1.min(three[1].1).min(three[2].1)
}

impl GeodesicDual {
    /// That of a geodesic.
    pub fn new(geodesic: &Geodesic) -> Self {
        let middles: Vec<DVec3> = (0..geodesic.triangles().len() as u32)
            .map(|triangle| geodesic.middle(triangle))
            .collect();
        let f = geodesic.frequency();
        let mut polygons = Vec::new();
        let mut known = vec![None; geodesic.vertices().len()];
        let mut borders = vec![0; 60 * f as usize];
        for (triangle, corners) in (0..).zip(geodesic.triangles()) {
            let face = triangle / (f * f);
            for (vertex, weights) in corners.iter().zip(geodesic.weights(triangle)) {
                if weights.contains(&0) {
                    let polygon = *known[*vertex as usize].get_or_insert_with(|| {
                        polygons.push(Polygon::new(geodesic, &middles, *vertex, triangle));
                        polygons.len() as u32 - 1
                    });
                    borders[border(f, face, weights)] = polygon;
                }
            }
        }
        for corners in geodesic.triangles() {
            for [own, other] in [[0, 1], [1, 2], [2, 0]] {
                let [own, other] = [own, other].map(|k: usize| known[corners[k] as usize]);
                if let (Some(own), Some(other)) = (own, other) {
                    polygons[own as usize].beside.push(other);
                }
            }
        }
        Self {
            middles,
            lattice: GeodesicLattice::new(geodesic),
            polygons,
            borders,
        }
    }

    /// The unit direction of the middle of a geodesic's triangle.
    #[inline]
    pub fn middle(&self, triangle: u32) -> DVec3 {
        self.middles[triangle as usize]
    }

    /// The unit directions of all middles.
    pub fn middles(&self) -> &[DVec3] {
        &self.middles
    }

    /// The three triangles of the geodesic between whose middles a direction lies, with their shares: these
    /// sum to 1, and none is negative. The direction may have any length but 0.
    #[inline]
    pub fn between(&self, direction: DVec3) -> [(u32, f64); 3] {
        let face = self.lattice.face(direction);
        let found = self
            .lattice
            .between(face, self.lattice.weights(face) * direction);
        found.unwrap_or_else(|border| self.around(border, direction))
    }

    /// The maps from directions that are still to be turned to their weights by the corners of each face of
    /// the icosahedron, for [`between_turned`](Self::between_turned).
    pub fn turned(&self, turn: DMat3) -> [DMat3; 20] {
        std::array::from_fn(|face| self.lattice.weights(face as u32) * turn)
    }

    /// As [`between`](Self::between), for a direction that is still to be turned. `face` is that of a
    /// direction near to it, and becomes its own: results do not depend on it.
    #[allow(
        clippy::inline_always,
        reason = "what it returns would go through memory, in which loads then wait for stores"
    )]
    #[inline(always)]
    pub fn between_turned(
        &self,
        (turn, turned): (&DMat3, &[DMat3; 20]),
        direction: DVec3,
        face: &mut u32,
    ) -> [(u32, f64); 3] {
        let mut weights = turned[*face as usize] * direction;
        if !(weights.x >= 0.0 && weights.y >= 0.0 && weights.z >= 0.0) {
            *face = self.lattice.face(*turn * direction);
            weights = turned[*face as usize] * direction;
        }
        let found = self.lattice.between(*face, weights);
        found.unwrap_or_else(|border| self.around(border, *turn * direction))
    }

    /// As [`between`](Self::between), in the polygon around a vertex on an edge of the icosahedron.
    #[inline(never)]
    fn around(&self, border: usize, direction: DVec3) -> [(u32, f64); 3] {
        let polygon = &self.polygons[self.borders[border] as usize];
        let found = polygon.between(direction);
        if least(&found) >= 0.0 {
            return found;
        }
        self.beside(polygon, direction)
    }

    /// As [`between`](Self::between), in one of the polygons beside one that seems not to hold the direction.
    /// On an edge of the icosahedron the border of two polygons is no mean of their vertices.
    #[inline(never)]
    fn beside(&self, polygon: &Polygon, direction: DVec3) -> [(u32, f64); 3] {
        let mut best = polygon.between(direction);
        for number in &polygon.beside {
            let found = self.polygons[*number as usize].between(direction);
            // Of the far side of the sphere shares are of no triangle.
            let is_near = self.middle(found[0].0).dot(direction) > 0.0;
            if is_near && least(&found) > least(&best) {
                best = found;
            }
        }
        // Rounding may leave a hair less than 0 on a border.
        let held = best.map(|(triangle, share)| (triangle, share.max(0.0)));
        let scale = 1.0 / (held[0].1 + held[1].1 + held[2].1);
        held.map(|(triangle, share)| (triangle, share * scale))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::math;
    use crate::numeric::rotation;
    use crate::numeric::{Stream, StreamKind};

    fn directions(count: u64) -> impl Iterator<Item = DVec3> {
        let stream = Stream::new(StreamKind::Sobol, 5);
        (0..count).map(move |index| {
            let [u, v] = stream.point2(index);
            let z = 1.0 - 2.0 * u;
            let (sine, cosine) = math::sin_cos(std::f64::consts::TAU * v);
            let across = (1.0 - z * z).sqrt();
            DVec3::new(across * cosine, across * sine, z)
        })
    }

    /// A value for each triangle that has nothing to do with those beside it.
    fn value(triangle: u32) -> f64 {
        f64::from(triangle.wrapping_mul(0x9e37_79b9) >> 16) / 65536.0
    }

    fn interpolated(dual: &GeodesicDual, direction: DVec3) -> f64 {
        let three = dual.between(direction);
        three
            .iter()
            .map(|(triangle, share)| value(*triangle) * share)
            .sum()
    }

    #[test]
    fn values_between_middles_are_continuous_everywhere() {
        for frequency in [1, 2, 5, 8] {
            let geodesic = Geodesic::new(frequency);
            let dual = GeodesicDual::new(&geodesic);
            // Values are from 0 to 1 and change over a distance of at least a fifth of an edge of
            // 1.1/frequency: a step changes them by less than 10 · frequency · step, and a jump by more.
            let step = 1e-7;
            for (index, direction) in directions(20_000).enumerate() {
                // Across edges and to corners of the geodesic, where one rule meets another.
                let triangle = geodesic.triangles()[index % geodesic.triangles().len()];
                let [a, b, _] = triangle.map(|vertex| geodesic.vertices()[vertex as usize]);
                let part = (index % 997) as f64 / 996.0;
                let on_edge = a * part + b * (1.0 - part);
                for place in [direction, on_edge.normalize()] {
                    let [x, y] = <[DVec3; 2]>::from(place.any_orthonormal_pair());
                    let own = interpolated(&dual, place);
                    for aside in [x, -x, y, -y] {
                        let other = interpolated(&dual, place + aside * step);
                        assert!(
                            (own - other).abs() < 10.0 * f64::from(frequency) * step,
                            "{frequency} {index}: {own} {other}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn places_far_from_the_edges_of_the_icosahedron_and_near_have_shares_of_the_one_triangle_that_holds_them()
     {
        for frequency in [1, 2, 3, 8] {
            let geodesic = Geodesic::new(frequency);
            let dual = GeodesicDual::new(&geodesic);
            // All polygons, those far from edges too.
            let mut polygons = Vec::new();
            let mut known = vec![false; geodesic.vertices().len()];
            for (triangle, corners) in (0..).zip(geodesic.triangles()) {
                for vertex in corners {
                    if !std::mem::replace(&mut known[*vertex as usize], true) {
                        polygons.push(Polygon::new(&geodesic, &dual.middles, *vertex, triangle));
                    }
                }
            }
            for (index, direction) in directions(3000).enumerate() {
                let holding = polygons.iter().map(|polygon| polygon.between(direction));
                let holding = holding.filter(|three| {
                    dual.middle(three[0].0).dot(direction) > 0.0 && least(three) >= -1e-14
                });
                let found = interpolated(&dual, direction);
                let mut count = 0;
                for three in holding {
                    let expected: f64 = three.iter().map(|(n, share)| value(*n) * share).sum();
                    assert!(
                        (found - expected).abs() < 1e-10,
                        "{frequency} {index}: {three:?}"
                    );
                    count += 1;
                }
                assert!(count > 0, "{frequency} {index}");
            }
        }
    }

    #[test]
    fn a_direction_still_to_be_turned_has_the_shares_of_the_turned_one_by_any_face() {
        let dual = GeodesicDual::new(&Geodesic::new(8));
        let turn = rotation::about(DVec3::new(0.6, 0.0, 0.8), 1.0);
        let turned = dual.turned(turn);
        for (index, direction) in directions(5000).enumerate() {
            let mut face = index as u32 % 20;
            let found = dual.between_turned((&turn, &turned), direction, &mut face);
            let expected = dual.between(turn * direction);
            let sum = |three: [(u32, f64); 3]| -> f64 {
                three.iter().map(|(n, share)| value(*n) * share).sum()
            };
            assert!((sum(found) - sum(expected)).abs() < 1e-12, "{index}");
        }
    }

    #[test]
    fn a_middle_has_its_own_value_and_shares_sum_to_one() {
        for frequency in [1, 3, 8] {
            let geodesic = Geodesic::new(frequency);
            let dual = GeodesicDual::new(&geodesic);
            for triangle in 0..geodesic.triangles().len() as u32 {
                let found = interpolated(&dual, dual.middle(triangle));
                assert!((found - value(triangle)).abs() < 1e-12, "{triangle}");
            }
            for direction in directions(1000) {
                let three = dual.between(direction);
                let sum: f64 = three.iter().map(|(_, share)| share).sum();
                assert!((sum - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn linear_functions_come_back_up_to_the_curvature_of_the_sphere() {
        let geodesic = Geodesic::new(16);
        let dual = GeodesicDual::new(&geodesic);
        for direction in directions(2000) {
            let three = dual.between(direction);
            let found: DVec3 = three
                .iter()
                .map(|(triangle, share)| dual.middle(*triangle) * *share)
                .sum();
            // Every other middle of a polygon is an edge (1.1/16) apart: the chord is an eighth of that
            // squared below the sphere, and within it along the direction.
            assert!(found.distance(direction) < 1.2e-3, "{direction}: {found}");
        }
    }
}
