//! Linear interpolation between the middles of a geodesic's triangles.

use glam::DVec3;

use super::geodesic::Geodesic;

/// The sphere of directions, divided into triangles between the middles of a [`Geodesic`]'s triangles.
///
/// Around each vertex of the geodesic lies a polygon of middles: six, or five at a corner of the icosahedron.
/// It is cut into an inner triangle of every other middle, and ears. Values at middles that are interpolated
/// linearly in these triangles are continuous over the whole sphere, and take three values a place.
#[derive(Clone, Debug)]
pub struct GeodesicDual {
    /// Unit directions, by the geodesic's triangles.
    middles: Vec<DVec3>,
    /// The triangles around each vertex, counter-clockwise seen from outside; of five the last is [`NONE`].
    rings: Vec<[u32; 6]>,
}

const NONE: u32 = u32::MAX;

/// By place in a ring of six, and of five: a bit for each ear that touches the triangle there. The tip of ear
/// k is at the place 2k + 1.
const EARS: [[usize; 6]; 2] = [
    [0b101, 0b001, 0b011, 0b010, 0b110, 0b100],
    [0b001, 0b001, 0b011, 0b010, 0b010, 0b000],
];

/// By place in a ring and a bit for each ear that seems to hold a direction: the ear before the place, if
/// rounding says so of two.
const FIRST_EAR: [[usize; 8]; 6] = {
    const LOWEST: [usize; 8] = [0, 0, 1, 0, 2, 0, 1, 0];
    let mut all = [LOWEST; 6];
    all[0] = [0, 0, 1, 0, 2, 2, 1, 2];
    all
};

impl GeodesicDual {
    /// That of a geodesic.
    pub fn new(geodesic: &Geodesic) -> Self {
        let triangles = geodesic.triangles();
        let mut rings = vec![[NONE; 6]; geodesic.vertices().len()];
        for (first, triangle) in (0..).zip(triangles) {
            for vertex in triangle {
                let ring = &mut rings[*vertex as usize];
                if ring[0] != NONE {
                    continue;
                }
                let mut next = first;
                for place in ring {
                    *place = next;
                    // Across the edge from the vertex to the corner before it.
                    let corners = triangles[next as usize];
                    let corner = corners.iter().position(|corner| corner == vertex);
                    next = geodesic.neighbours(next)[(corner.unwrap_or(0) + 1) % 3];
                    if next == first {
                        break;
                    }
                }
            }
        }
        Self {
            middles: (0..triangles.len() as u32)
                .map(|triangle| geodesic.middle(triangle))
                .collect(),
            rings,
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

    /// The three triangles of a geodesic between whose middles a direction lies, with their shares: these sum
    /// to 1, and none is negative. The direction may have any length but 0.
    #[inline]
    pub fn between(&self, geodesic: &Geodesic, direction: DVec3) -> [(u32, f64); 3] {
        let place = geodesic.place(direction);
        let [a, b, c] = place.weights;
        // As good as random, as all that follows: chosen without branches.
        let corner = usize::from(!(a >= b && a >= c)) * (1 + usize::from(b < c));
        // The nearest vertex is that of the polygon, but for directions close to the polygon's border.
        let nearest = geodesic.triangles()[place.triangle as usize][corner];
        let found = self.around(nearest, place.triangle, direction);
        if found.iter().all(|(_, share)| *share >= 0.0) {
            return found;
        }
        let vertex = self.vertex(geodesic, place.triangle, direction);
        let found = self.around(vertex, place.triangle, direction);
        let held = found.map(|(triangle, share)| (triangle, share.max(0.0)));
        let sum: f64 = held.iter().map(|(_, share)| share).sum();
        held.map(|(triangle, share)| (triangle, share / sum))
    }

    /// The triangle of a vertex's polygon that holds a direction, which lies in one of the geodesic's own;
    /// its shares are negative if the polygon does not hold it.
    #[inline]
    fn around(&self, vertex: u32, triangle: u32, direction: DVec3) -> [(u32, f64); 3] {
        let ring = &self.rings[vertex as usize];
        let is_pentagon = ring[5] == NONE;
        let at: usize = (0..6).map(|k| k * usize::from(ring[k] == triangle)).sum();
        let inner = [ring[0], ring[2], ring[4]];
        let [a, b, c] = inner.map(|triangle| self.middle(triangle));
        // The edges of the inner triangle, and on which side of each the direction is: ears lie beyond them.
        let [ab, bc, ca] = [a.cross(b), b.cross(c), c.cross(a)].map(|line| line.dot(direction));
        // Only ears that touch the geodesic's triangle can hold it.
        let touching = EARS[usize::from(is_pentagon)][at];
        let beyond =
            usize::from(ab < 0.0) | usize::from(bc < 0.0) << 1 | usize::from(ca < 0.0) << 2;
        let is_ear = touching & beyond != 0;
        let ear = FIRST_EAR[at][touching & beyond];
        let next = (ear + 1) % 3;
        let tip = ring[2 * ear + 1];
        let middle = self.middle(if is_ear { tip } else { ring[0] });
        let ends = [[a, b], [b, c], [c, a]][ear];
        let line = [ab, bc, ca][ear];
        let of_ear = [
            middle.cross(ends[1]).dot(direction),
            -line,
            ends[0].cross(middle).dot(direction),
        ];
        let in_ear = [inner[ear], tip, inner[next]];
        let of_inner = [bc, ca, ab];
        let shares: [f64; 3] =
            std::array::from_fn(|k| if is_ear { of_ear[k] } else { of_inner[k] });
        let sum: f64 = shares.iter().sum();
        std::array::from_fn(|k| {
            let triangle = if is_ear { in_ear[k] } else { inner[k] };
            (triangle, shares[k] / sum)
        })
    }

    /// The vertex in whose polygon a direction lies, which lies in some triangle of the geodesic.
    fn vertex(&self, geodesic: &Geodesic, triangle: u32, direction: DVec3) -> u32 {
        let middle = self.middle(triangle);
        // On which side of the lines from the triangle's middle to its neighbours'. Around it follow one
        // another corner 0, the neighbour across the edge from 0 to 1, corner 1, and so on.
        let sides = geodesic
            .neighbours(triangle)
            .map(|neighbour| middle.cross(self.middle(neighbour)).dot(direction));
        let corner = (0..3).find(|k| sides[(k + 1) % 3] >= 0.0 && sides[(k + 2) % 3] < 0.0);
        geodesic.triangles()[triangle as usize][corner.unwrap_or(0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::math;
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

    fn interpolated(dual: &GeodesicDual, geodesic: &Geodesic, direction: DVec3) -> f64 {
        let three = dual.between(geodesic, direction);
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
                    let own = interpolated(&dual, &geodesic, place);
                    for aside in [x, -x, y, -y] {
                        let other = interpolated(&dual, &geodesic, place + aside * step);
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
    fn a_middle_has_its_own_value_and_shares_sum_to_one() {
        for frequency in [1, 3, 8] {
            let geodesic = Geodesic::new(frequency);
            let dual = GeodesicDual::new(&geodesic);
            for triangle in 0..geodesic.triangles().len() as u32 {
                let found = interpolated(&dual, &geodesic, dual.middle(triangle));
                assert!((found - value(triangle)).abs() < 1e-12, "{triangle}");
            }
            for direction in directions(1000) {
                let three = dual.between(&geodesic, direction);
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
            let three = dual.between(&geodesic, direction);
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
