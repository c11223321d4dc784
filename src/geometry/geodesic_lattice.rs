//! Linear interpolation between the middles of a geodesic's triangles by arithmetic, far from the edges of
//! the icosahedron.

use glam::{DMat3, DVec3};

use super::geodesic::Geodesic;

/// The lattices of triangles that a [`Geodesic`] has on the faces of the icosahedron.
///
/// On a face the polygon of middles around a vertex is a regular hexagon: the places that are nearer to this
/// vertex than to any other. Its inner triangle has the middles of the three triangles that are the right way
/// up. Shares in a plane follow from the weights by the face's corners; those on the sphere are these times
/// the distances of the middles in the plane, for central projection keeps lines straight.
#[derive(Clone, Debug)]
pub(super) struct GeodesicLattice {
    frequency: u32,
    /// Triangles of a face that are the right way up.
    before_upside_down: u32,
    /// By octant: the face whose middle is along the diagonal, and those whose middles have no part along y,
    /// z and x.
    faces: [[u8; 4]; 8],
    /// By face: the map from directions to their weights by its corners.
    weights: [DMat3; 20],
    /// The distances of the middles in the plane of a face, by the nearest: those of all faces are alike.
    distances: Vec<f64>,
}

/// The golden section and its inverse.
const LONG: f64 = 1.618_033_988_749_895;
const SHORT: f64 = LONG - 1.0;

/// The middles of the faces that may be nearest to a direction of the first octant, times √3.
const MIDDLES: [DVec3; 4] = [
    DVec3::ONE,
    DVec3::new(SHORT, 0.0, LONG),
    DVec3::new(LONG, SHORT, 0.0),
    DVec3::new(0.0, LONG, SHORT),
];

/// The products of a direction with [`MIDDLES`], by the sizes of its parts.
#[inline]
fn scores([x, y, z]: [f64; 3]) -> [f64; 4] {
    [
        x + y + z,
        SHORT * x + LONG * z,
        LONG * x + SHORT * y,
        LONG * y + SHORT * z,
    ]
}

/// The octant of a direction: a bit for each part that is below 0.
#[inline]
fn octant(direction: DVec3) -> usize {
    let [x, y, z] = direction
        .to_array()
        .map(|part| usize::from(part.is_sign_negative()));
    x | y << 1 | z << 2
}

impl GeodesicLattice {
    /// Those of a geodesic.
    pub(super) fn new(geodesic: &Geodesic) -> Self {
        let frequency = geodesic.frequency();
        let icosahedron = Geodesic::new(1);
        let nearest = |direction: DVec3| {
            let product = |face: u32| icosahedron.middle(face).dot(direction);
            (1..20).fold(0, |best, face| {
                if product(face) > product(best) {
                    face
                } else {
                    best
                }
            })
        };
        let faces = std::array::from_fn(|octant| {
            let sign = |axis: usize| if octant >> axis & 1 == 0 { 1.0 } else { -1.0 };
            let signs = DVec3::new(sign(0), sign(1), sign(2));
            MIDDLES.map(|middle| nearest(middle * signs) as u8)
        });
        let weights = std::array::from_fn(|face| {
            let [a, b, c] = icosahedron.corners(face as u32);
            DMat3::from_cols(a, b, c).inverse()
        });
        let normal = icosahedron.middle(0);
        let distance = |triangle| 1.0 / normal.dot(geodesic.middle(triangle));
        let distances: Vec<f64> = (0..frequency * frequency).map(distance).collect();
        Self {
            frequency,
            before_upside_down: frequency * (frequency + 1) / 2,
            faces,
            weights,
            distances,
        }
    }

    /// The face whose middle is nearest to a direction, of any length but 0; any of several.
    #[inline]
    pub(super) fn face(&self, direction: DVec3) -> u32 {
        let scores = scores(direction.abs().to_array());
        let low = usize::from(scores[1] > scores[0]);
        let high = 2 + usize::from(scores[3] > scores[2]);
        let is_high = larger(scores[2], scores[3]) > larger(scores[0], scores[1]);
        u32::from(self.faces[octant(direction)][if is_high { high } else { low }])
    }

    /// The map from directions to their weights by the corners of a face, up to a factor. None is negative of
    /// a direction that meets the face.
    pub(super) fn weights(&self, face: u32) -> DMat3 {
        self.weights[face as usize]
    }

    /// The three triangles between whose middles a direction lies, with their shares, if all triangles around
    /// the vertex nearest to it are on the face that it meets; else the [number](border) of this vertex.
    /// The direction's weights are by the corners of this face.
    ///
    /// Where anything is chosen the choice is as good as random: there are no branches but the last.
    #[allow(
        clippy::inline_always,
        reason = "what it returns would go through memory, in which loads then wait for stores"
    )]
    #[inline(always)]
    pub(super) fn between(&self, face: u32, weights: DVec3) -> Result<[(u32, f64); 3], usize> {
        const THIRD: f64 = 1.0 / 3.0;
        let scale = f64::from(self.frequency) / (weights.x + weights.y + weights.z);
        // The middles of triangles that are the right way up have whole places along the two.
        let (a, b) = (weights.x * scale - THIRD, weights.y * scale - THIRD);
        let ([i, x], [j, y]) = (parts(a), parts(b));
        // Half of the triangles between these hold a vertex in the middle, and others the middle of a
        // triangle that is upside down: it cuts them into three.
        let sum = x + y;
        let over = smaller(1.0 - sum, 0.0);
        let [x, y, z] = [x + over, y + over, 1.0 - sum - 2.0 * over];
        let is_vertex = sum > 1.0;
        // With a vertex in the middle there is no such tip.
        let least = larger(smaller(smaller(x, y), smaller(z, 1.0 - sum)), 0.0);
        let tip = (u32::from(z > least) * (1 + u32::from(x > least))) | (3 * u32::from(is_vertex));
        let f = self.frequency;
        let (i, j) = (i.to_bits() as u32, j.to_bits() as u32);
        // The weights of the vertex less 1.
        let of_vertex = [
            i.wrapping_sub(u32::from(tip == 1)),
            j.wrapping_sub(u32::from(tip == 2)),
        ];
        let last = of_vertex[0].wrapping_add(of_vertex[1]).wrapping_add(2);
        if of_vertex[0] >= f || of_vertex[1] >= f || last >= f {
            let [i, j] = of_vertex.map(|weight| weight.wrapping_add(1).min(f));
            return Err(border(f, face, [i, j, f.saturating_sub(i + j)]));
        }
        // Triangles are numbered row by row, those that are the right way up first.
        let first = i * (2 * f + 1 - i) / 2 + j;
        let second = first + f - i;
        let mut numbers = [
            first + u32::from(is_vertex) * (f - i + 1),
            second,
            first + 1,
            0,
        ];
        let mut shares = [z - least, x - least, y - least, 0.0];
        numbers[tip as usize & 3] = first + self.before_upside_down - i;
        shares[tip as usize & 3] = 3.0 * least;
        let before = face * f * f;
        let three: [(u32, f64); 3] = std::array::from_fn(|k| {
            let number = numbers[k];
            (before + number, shares[k] * self.distances[number as usize])
        });
        let scale = 1.0 / (three[0].1 + three[1].1 + three[2].1);
        Ok(three.map(|(triangle, share)| (triangle, share * scale)))
    }
}

/// The number of a vertex on an edge of the icosahedron, by its whole weights on a face: below 60 times the
/// frequency.
#[inline]
pub(super) fn border(frequency: u32, face: u32, [a, b, c]: [u32; 3]) -> usize {
    let along = match [a, b, c] {
        [0, b, _] => b.min(frequency),
        [a, 0, _] => frequency + a.min(frequency),
        [a, ..] => 2 * frequency + a.min(frequency - 1),
    };
    (face * 3 * frequency + along) as usize
}

/// The larger of two numbers, in one instruction.
#[inline]
fn larger(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

/// The smaller of two numbers, in one instruction.
#[inline]
fn smaller(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

/// A number of a few digits in two parts: a whole one below it, or equal, in the lowest bits of the first;
/// and what is more, from 0 to 1.
#[inline]
fn parts(number: f64) -> [f64; 2] {
    /// A number added to this is rounded to a whole one.
    const WHOLE: f64 = 6_755_399_441_055_744.0;
    let whole = (number - 0.5) + WHOLE;
    [whole, number - (whole - WHOLE)]
}
