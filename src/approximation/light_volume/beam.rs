//! Beams: light between three rays, and their cross-sections.

use glam::{DVec2, DVec3};

use super::slicing::Slicing;

/// A ray of light below the water's surface, by where it crosses planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ruling {
    /// Where it crosses the top plane, continued upwards.
    pub base: DVec2,
    /// How far it goes across the axis for each unit of depth.
    pub slope: DVec2,
    /// The depth at which it leaves the water's surface \[m\].
    pub start: f64,
}

impl Ruling {
    /// A ray from a place along a downward vector, both in local coordinates. `None` if it goes down less
    /// than 1 in 1000.
    pub fn new((across, start): (DVec2, f64), (sideways, down): (DVec2, f64)) -> Option<Self> {
        /// Rays flatter than this leave any scene before they are deep.
        const FLATTEST: f64 = 1e-3;
        let slope = sideways / down;
        (down > FLATTEST && slope.is_finite()).then_some(Self {
            base: across - slope * start,
            slope,
            start,
        })
    }

    /// Where it crosses the plane at a depth.
    #[inline]
    pub fn at(&self, depth: f64) -> DVec2 {
        self.base + self.slope * depth
    }

    /// Where it starts: across the axis, and in depth.
    #[inline]
    fn origin(&self) -> DVec3 {
        self.at(self.start).extend(self.start)
    }

    /// The cosine of its angle with the axis.
    #[inline]
    pub fn cos(&self) -> f64 {
        1.0 / (1.0 + self.slope.length_squared()).sqrt()
    }
}

/// Light between three rays that start at the corners of a triangle of water.
#[derive(Clone, Copy, Debug)]
pub struct Beam {
    /// The rays.
    pub rulings: [Ruling; 3],
    /// The light at the rays, by the stages before the cross-section, as if all of the triangle had it
    /// \[m²\]: flux by the source's strength. Linear between.
    pub light: [f64; 3],
    /// The triangle of water.
    pub triangle: u32,
    /// Barycentric weights of the triangle's second and third vertex at each ray.
    pub corners: [DVec2; 3],
}

/// A beam's cross-section at a depth.
#[derive(Clone, Copy, Debug)]
pub struct Section {
    /// Where the rays are.
    pub corners: [DVec2; 3],
    /// Twice its area, signed: it changes sign where the beam turns inside out.
    pub twice_area: f64,
}

impl Section {
    /// Its area \[m²\].
    #[inline]
    pub fn area(&self) -> f64 {
        0.5 * self.twice_area.abs()
    }

    /// The rays' weights at a place; `None` outside.
    ///
    /// Of two sections that share a side, just one has each place on it.
    #[inline]
    pub fn weights(&self, place: DVec2) -> Option<[f64; 3]> {
        let turn = if self.twice_area < 0.0 { -1.0 } else { 1.0 };
        let [a, b, c] = [
            self.corners[0] - place,
            self.corners[1] - place,
            self.corners[2] - place,
        ];
        // Opposite to each corner. Products swap sign exactly with their order: neighbours agree.
        let sides = [
            b.perp_dot(c) * turn,
            c.perp_dot(a) * turn,
            a.perp_dot(b) * turn,
        ];
        if sides[0] < 0.0 || sides[1] < 0.0 || sides[2] < 0.0 {
            return None;
        }
        let is_in = owns(sides[0], (c - b) * turn)
            && owns(sides[1], (a - c) * turn)
            && owns(sides[2], (b - a) * turn);
        let sum = sides[0] + sides[1] + sides[2];
        (is_in && sum > 0.0).then(|| [sides[0] / sum, sides[1] / sum, sides[2] / sum])
    }
}

/// True if a place belongs to a triangle as far as one of its sides tells: if it is within, or on a side that
/// runs upwards, or to the left.
///
/// - `side`: positive within.
/// - `along`: the side, run anticlockwise. That of a neighbour runs the other way.
#[inline]
pub fn owns(side: f64, along: DVec2) -> bool {
    side > 0.0 || side == 0.0 && (along.y > 0.0 || along.y == 0.0 && along.x < 0.0)
}

impl Beam {
    /// The cross-section at a depth.
    #[inline]
    pub fn section(&self, depth: f64) -> Section {
        let [a, b, c] = &self.rulings;
        let corners = [a.at(depth), b.at(depth), c.at(depth)];
        Section {
            corners,
            twice_area: (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]),
        }
    }

    /// The slope of the ray with these weights.
    #[inline]
    pub fn slope(&self, weights: [f64; 3]) -> DVec2 {
        let [a, b, c] = &self.rulings;
        a.slope * weights[0] + b.slope * weights[1] + c.slope * weights[2]
    }

    /// The ray with these weights. It starts where it crosses the plane through the starts of the three.
    #[inline]
    pub fn ruling(&self, weights: [f64; 3]) -> Ruling {
        let [a, b, c] = &self.rulings;
        let base = a.base * weights[0] + b.base * weights[1] + c.base * weights[2];
        let slope = self.slope(weights);
        let [low, right, above] = [a.origin(), b.origin(), c.origin()];
        let normal = (right - low).cross(above - low);
        let across = normal.truncate();
        let start = (normal.dot(low) - across.dot(base)) / (across.dot(slope) + normal.z);
        // A ray along the plane, or a triangle without area.
        let start = if start.is_finite() { start } else { a.start };
        Ruling { base, slope, start }
    }

    /// The place on the triangle of water at which the ray with these weights starts: barycentric weights of
    /// the triangle's second and third vertex.
    #[inline]
    pub fn corner(&self, weights: [f64; 3]) -> DVec2 {
        let [a, b, c] = self.corners;
        a * weights[0] + b * weights[1] + c * weights[2]
    }

    /// The depth at which the beam begins: that of its highest ray.
    pub fn top(&self) -> f64 {
        let starts = self.rulings.each_ref().map(|ruling| ruling.start);
        starts.into_iter().fold(f64::INFINITY, f64::min)
    }

    /// The least and the largest coordinates of its rays at a depth.
    #[inline]
    pub fn reach(&self, depth: f64) -> [DVec2; 2] {
        let [a, b, c] = &self.rulings;
        let (a, b, c) = (a.at(depth), b.at(depth), c.at(depth));
        [a.min(b).min(c), a.max(b).max(c)]
    }

    /// 1 / area of the cross-sections in the planes above and below a depth, linear between; infinite where
    /// one of them is a focus.
    #[inline]
    pub fn by_area(&self, slicing: &Slicing, depth: f64) -> f64 {
        let (index, t) = slicing.slice(depth);
        let at = |plane: u32| 1.0 / self.section(slicing.plane(plane)).area();
        match t {
            // 0 by infinity is no number.
            0.0 => at(index),
            1.0 => at(index + 1),
            t => at(index) * (1.0 - t) + at(index + 1) * t,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn section(corners: [[f64; 2]; 3]) -> Section {
        let corners = corners.map(DVec2::from);
        Section {
            corners,
            twice_area: (corners[1] - corners[0]).perp_dot(corners[2] - corners[0]),
        }
    }

    #[test]
    fn each_place_of_a_fan_of_sections_is_in_one_of_them() {
        // Eight triangles about a point, turned both ways; places on their sides and at the point among them.
        let rim: Vec<[f64; 2]> = [
            (2, 0),
            (2, 2),
            (0, 2),
            (-2, 2),
            (-2, 0),
            (-2, -2),
            (0, -2),
            (2, -2),
        ]
        .map(|(x, y)| [f64::from(x), f64::from(y)])
        .to_vec();
        for turned in [false, true] {
            let fan: Vec<Section> = (0..8)
                .map(|i| {
                    let (a, b) = (rim[i], rim[(i + 1) % 8]);
                    section(if turned {
                        [[0.0; 2], b, a]
                    } else {
                        [[0.0; 2], a, b]
                    })
                })
                .collect();
            for x in -7..8 {
                for y in -7..8 {
                    let place = DVec2::new(f64::from(x), f64::from(y)) * 0.25;
                    let owners = fan.iter().filter(|it| it.weights(place).is_some()).count();
                    assert_eq!(owners, 1, "{place} {turned}");
                }
            }
        }
    }

    #[test]
    fn weights_are_those_of_the_place() {
        let section = section([[0.0, 0.0], [0.0, 3.0], [4.0, 0.0]]);
        let [a, b, c] = section.weights(DVec2::new(1.0, 0.5)).unwrap();
        let back = section.corners[0] * a + section.corners[1] * b + section.corners[2] * c;
        assert!(back.abs_diff_eq(DVec2::new(1.0, 0.5), 4.0 * f64::EPSILON));
        assert!(section.weights(DVec2::new(2.0, 2.0)).is_none());
        assert_eq!(section.area(), 6.0);
    }
}
