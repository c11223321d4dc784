//! Geodesic spheres: directions divided into triangles that are found by arithmetic, without a search.

use std::collections::HashMap;

use glam::{DMat3, DVec3};

use super::icosahedron::{ICOSAHEDRON_FACES, icosahedron_corners};

/// The sphere of directions, divided into `20 frequency²` triangles.
///
/// Each face of an icosahedron is cut into `frequency²` equal triangles, whose corners are pushed onto the
/// sphere. Central projection keeps lines straight: the triangle of a direction is the one that its ray meets
/// on the icosahedron.
#[derive(Clone, Debug)]
pub struct Geodesic {
    frequency: u32,
    /// Maps a direction to its weights by the corners of a face of the icosahedron.
    weights: [DMat3; 20],
    /// The middles of the icosahedron's faces.
    middles: [DVec3; 20],
    /// By the signs of a direction: the faces that may be nearest to it, in order, with their middles.
    octants: [[(u32, DVec3); 4]; 8],
    vertices: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
    neighbours: Vec<[u32; 3]>,
}

/// A direction's place in a triangle of a [`Geodesic`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GeodesicPlace {
    /// The triangle.
    pub triangle: u32,
    /// Its weights by the triangle's corners, in the plane of the icosahedron's face; they sum to 1.
    pub weights: [f64; 3],
}

impl Geodesic {
    /// The division by a frequency; 0 counts as 1.
    pub fn new(frequency: u32) -> Self {
        let frequency = frequency.max(1);
        let corners = icosahedron_corners();
        let frames = ICOSAHEDRON_FACES.map(|face| face.map(|corner| corners[corner]));
        let middles = frames.map(|[a, b, c]| (a + b + c).normalize());
        let mut geodesic = Self {
            frequency,
            weights: frames.map(|[a, b, c]| DMat3::from_cols(a, b, c).inverse()),
            middles,
            octants: std::array::from_fn(|octant| candidates(&middles, octant)),
            vertices: Vec::new(),
            triangles: Vec::new(),
            neighbours: Vec::new(),
        };
        geodesic.add_triangles(&frames);
        geodesic.add_neighbours();
        geodesic
    }

    fn add_triangles(&mut self, frames: &[[DVec3; 3]; 20]) {
        /// Vertices of different faces are the same below 1/GRID; others are farther apart than 1/frequency.
        const GRID: f64 = 1e9;
        let mut known: HashMap<[i64; 3], u32> = HashMap::new();
        for face in frames {
            for [a, b, is_up] in lattice(self.frequency) {
                let corners = lattice_corners(self.frequency, [a, b], is_up == 1);
                let triangle = corners.map(|weights| {
                    let place: DVec3 = (0..3).map(|k| face[k] * f64::from(weights[k])).sum();
                    let direction = place.normalize();
                    let key = (direction * GRID).to_array().map(|x| x.round() as i64);
                    // Rounding may fall either way for vertices of two faces.
                    let near = (0..27).find_map(|step: i64| {
                        let [x, y, z] = [step % 3 - 1, step / 3 % 3 - 1, step / 9 - 1];
                        known.get(&[key[0] + x, key[1] + y, key[2] + z])
                    });
                    if let Some(&vertex) = near {
                        return vertex;
                    }
                    let vertex = self.vertices.len() as u32;
                    self.vertices.push(direction);
                    known.insert(key, vertex);
                    vertex
                });
                self.triangles.push(triangle);
            }
        }
    }

    fn add_neighbours(&mut self) {
        let mut edges: HashMap<[u32; 2], u32> = HashMap::new();
        for (index, triangle) in self.triangles.iter().enumerate() {
            for k in 0..3 {
                edges.insert([triangle[k], triangle[(k + 1) % 3]], index as u32);
            }
        }
        self.neighbours = self
            .triangles
            .iter()
            .map(|triangle| {
                // Across the edge opposite to each corner; its other triangle runs along it the other way.
                std::array::from_fn(|k| edges[&[triangle[(k + 2) % 3], triangle[(k + 1) % 3]]])
            })
            .collect();
    }

    /// The number of parts into which each edge of the icosahedron is cut.
    pub fn frequency(&self) -> u32 {
        self.frequency
    }

    /// The unit directions of all `10 frequency² + 2` vertices.
    pub fn vertices(&self) -> &[DVec3] {
        &self.vertices
    }

    /// The triangles, counter-clockwise seen from outside.
    pub fn triangles(&self) -> &[[u32; 3]] {
        &self.triangles
    }

    /// The triangles across the edges of a triangle; each edge is opposite to the corner of its place.
    #[inline]
    pub fn neighbours(&self, triangle: u32) -> [u32; 3] {
        self.neighbours[triangle as usize]
    }

    /// The corners of a triangle: unit directions.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.vertices[vertex as usize])
    }

    /// The unit direction of a triangle's middle in the plane of the icosahedron's face.
    pub fn middle(&self, triangle: u32) -> DVec3 {
        let face = triangle / (self.frequency * self.frequency);
        let normal = self.middles[face as usize];
        let corners = self.corners(triangle).into_iter();
        let sum: DVec3 = corners.map(|corner| corner / normal.dot(corner)).sum();
        sum.normalize()
    }

    /// The weights of a triangle's corners by those of its face, times the frequency.
    pub(super) fn weights(&self, triangle: u32) -> [[u32; 3]; 3] {
        let f = self.frequency;
        let number = triangle % (f * f);
        let ups = f * (f + 1) / 2;
        // Rows begin with one triangle less each.
        let (mut rest, mut a) = (if number < ups { number } else { number - ups }, 0);
        let mut row = if number < ups { f } else { f - 1 };
        while rest >= row {
            (rest, a, row) = (rest - row, a + 1, row - 1);
        }
        lattice_corners(f, [a, rest], number < ups)
    }

    /// The face of the icosahedron whose middle is nearest to a direction; the first of several.
    ///
    /// The icosahedron is its own mirror image in each plane of coordinates. So a face whose middle has
    /// another sign than the direction along an axis is farther than its image, by twice the product of both
    /// parts along it. Four faces are left, unless a direction is so close to a plane that rounding decides.
    #[inline]
    fn face(&self, direction: DVec3) -> usize {
        /// Parts of a direction by its largest above which a face and its mirror image differ by far more
        /// than rounding does, 1e-16.
        const CLEAR: f64 = 1e-9;
        let parts = direction.abs();
        if parts.min_element() > CLEAR * parts.max_element() {
            let faces = &self.octants[octant(direction)];
            let [a, b, c, d] = faces.map(|(_, middle)| middle.dot(direction));
            let (low, high) = (usize::from(b > a), 2 + usize::from(d > c));
            let is_high = (if d > c { d } else { c }) > (if b > a { b } else { a });
            return faces[if is_high { high } else { low }].0 as usize;
        }
        let mut face = 0;
        let mut nearest = f64::NEG_INFINITY;
        for (index, middle) in self.middles.iter().enumerate() {
            let cosine = middle.dot(direction);
            if cosine > nearest {
                (nearest, face) = (cosine, index);
            }
        }
        face
    }

    /// The triangle that a direction is in; any length but 0.
    #[inline]
    pub fn place(&self, direction: DVec3) -> GeodesicPlace {
        let face = self.face(direction);
        let f = self.frequency;
        let weights = self.weights[face] * direction;
        let scale = f64::from(f) / weights.element_sum();
        // Rounding may put a direction on an edge a hair outside; NaN becomes a corner.
        let [a, b] = [weights.x, weights.y].map(|w| (w * scale).clamp(0.0, f64::from(f)));
        let c = (f64::from(f) - a - b).max(0.0);
        let whole = |x: f64| (x as u32).min(f - 1);
        let (ia, mut ib, ic) = (whole(a), whole(b), whole(c));
        let mut is_up = ia + ib + ic + 1 >= f;
        if ia + ib >= f {
            ib = f - 1 - ia;
            is_up = true;
        }
        let (x, y) = (a - f64::from(ia), b - f64::from(ib));
        // Which way up is as good as random: chosen without a branch.
        let before = if is_up { 0 } else { f * (f + 1) / 2 - ia };
        let number = before + ia * f - ia * ia.saturating_sub(1) / 2 + ib;
        let up = [x, y, 1.0 - x - y];
        let down = [1.0 - x, 1.0 - y, x + y - 1.0];
        let parts: [f64; 3] = std::array::from_fn(|k| if is_up { up[k] } else { down[k] });
        GeodesicPlace {
            triangle: face as u32 * f * f + number,
            weights: parts.map(|part| part.clamp(0.0, 1.0)),
        }
    }
}

/// The octant of a direction: a bit for each part that is below 0.
#[inline]
fn octant(direction: DVec3) -> usize {
    let [x, y, z] = direction.to_array().map(|part| usize::from(part < 0.0));
    x | y << 1 | z << 2
}

/// The faces that may be nearest to directions of an octant: the four whose middles lie in it or on its
/// borders.
fn candidates(middles: &[DVec3; 20], octant: usize) -> [(u32, DVec3); 4] {
    /// Rounding of parts that are 0; others are at least 0.35.
    const ROUNDING: f64 = 1e-9;
    let signs: [f64; 3] =
        std::array::from_fn(|axis| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 });
    let mut all = (0..).zip(middles).filter(|(_, middle)| {
        let inward = **middle * DVec3::from_array(signs);
        inward.min_element() > -ROUNDING
    });
    std::array::from_fn(|_| {
        all.next()
            .map_or((0, middles[0]), |(face, middle)| (face, *middle))
    })
}

/// The triangles of a face by the whole parts of their first two weights, and 1 for those that are the right
/// way up: these first, each kind row by row.
fn lattice(f: u32) -> impl Iterator<Item = [u32; 3]> {
    let up = (0..f).flat_map(move |a| (0..f - a).map(move |b| [a, b, 1]));
    let down = (0..f).flat_map(move |a| (0..(f - a).saturating_sub(1)).map(move |b| [a, b, 0]));
    up.chain(down)
}

/// The weights of a triangle's corners by those of the face, times the frequency.
fn lattice_corners(f: u32, [a, b]: [u32; 2], is_up: bool) -> [[u32; 3]; 3] {
    if is_up {
        let c = f - 1 - a - b;
        [[a + 1, b, c], [a, b + 1, c], [a, b, c + 1]]
    } else {
        let c = f - 2 - a - b;
        [[a, b + 1, c + 1], [a + 1, b, c + 1], [a + 1, b + 1, c]]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::math;

    #[test]
    fn the_triangle_of_a_direction_has_it_and_its_weights_give_it_back() {
        for frequency in [1, 2, 3, 4, 7, 16] {
            let geodesic = Geodesic::new(frequency);
            let f = frequency as usize;
            assert_eq!(geodesic.triangles().len(), 20 * f * f);
            assert_eq!(geodesic.vertices().len(), 10 * f * f + 2);
            for index in 0..2000 {
                let z = 1.0 - 2.0 * (f64::from(index) + 0.5) / 2000.0;
                let turn = 2.399_963 * f64::from(index);
                let across = (1.0 - z * z).sqrt();
                let direction = DVec3::new(across * math::cos(turn), across * math::sin(turn), z);
                let place = geodesic.place(direction);
                let corners = geodesic.corners(place.triangle);
                for k in 0..3 {
                    let edge = corners[(k + 1) % 3].cross(corners[(k + 2) % 3]);
                    assert!(edge.dot(direction) > -1e-12, "{frequency} {index} {k}");
                }
                let sum: f64 = place.weights.iter().sum();
                assert!((sum - 1.0).abs() < 1e-12);
            }
        }
    }

    #[test]
    fn the_face_found_among_four_is_the_nearest_of_all() {
        let geodesic = Geodesic::new(1);
        for octant in geodesic.octants {
            let faces = octant.map(|(face, _)| face);
            assert!(faces.is_sorted() && faces[0] < faces[1] && faces[2] < faces[3]);
        }
        let mut directions = geodesic.vertices().to_vec();
        for index in 0..20_000 {
            let z = 1.0 - 2.0 * (f64::from(index) + 0.5) / 20_000.0;
            let turn = 2.399_963 * f64::from(index);
            let across = (1.0 - z * z).sqrt();
            let direction = DVec3::new(across * math::cos(turn), across * math::sin(turn), z);
            // In planes of coordinates, and as close to them as rounding allows.
            let near = DVec3::new(1e-16, direction.y, -1e-8 * direction.z);
            let tied = DVec3::new(-1e-17, 0.1 * direction.y, direction.z);
            let scaled = direction * 1e-200;
            directions.extend([
                direction,
                near,
                tied,
                DVec3::new(0.0, direction.y, direction.z),
                scaled,
            ]);
        }
        for direction in directions {
            let mut nearest = 0;
            for (face, middle) in geodesic.middles.iter().enumerate() {
                if middle.dot(direction) > geodesic.middles[nearest].dot(direction) {
                    nearest = face;
                }
            }
            assert_eq!(geodesic.face(direction), nearest, "{direction}");
        }
    }

    #[test]
    fn a_vertex_is_found_in_a_triangle_that_has_it_with_all_the_weight() {
        let geodesic = Geodesic::new(5);
        for (index, vertex) in geodesic.vertices().iter().enumerate() {
            let place = geodesic.place(*vertex);
            let corners = geodesic.triangles()[place.triangle as usize];
            let weight: f64 = (0..3)
                .filter(|&k| corners[k] == index as u32)
                .map(|k| place.weights[k])
                .sum();
            assert!((weight - 1.0).abs() < 1e-9, "{index}: {place:?}");
        }
    }

    #[test]
    fn neighbours_share_the_edge_opposite_to_the_corner() {
        let geodesic = Geodesic::new(4);
        for (index, triangle) in geodesic.triangles().iter().enumerate() {
            let neighbours = geodesic.neighbours(index as u32);
            for k in 0..3 {
                let other = geodesic.triangles()[neighbours[k] as usize];
                let edge = [triangle[(k + 1) % 3], triangle[(k + 2) % 3]];
                assert!(edge.iter().all(|vertex| other.contains(vertex)));
                assert!(!other.contains(&triangle[k]));
            }
        }
    }
}
