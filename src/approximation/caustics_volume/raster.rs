//! The rasteriser: pictures of triangles, and of other shapes by rays.
//!
//! A triangle covers the texels whose centres are in it. A centre on an edge is in the triangle to the right
//! of it or below, so that each is in one triangle of two that share the edge. An edge function is computed
//! from its lower end to its upper one, whichever triangle asks: neighbours get the same number, and there
//! are no cracks.

use glam::DVec2;

use crate::approximation::bands::{Band, in_bands, signed};

/// Something drawn: a triangle, or the texels that a shape may be in.
#[derive(Clone, Copy, Debug)]
pub struct Item {
    /// The shape.
    pub shape: u32,
    /// The form.
    pub form: Form,
}

/// The form of something drawn, in texels.
#[derive(Clone, Copy, Debug)]
pub enum Form {
    /// A triangle of a mesh or a part of a rectangle.
    Triangle {
        /// The face of a mesh; 0 of a rectangle.
        face: u32,
        /// Corners in the image.
        corners: [DVec2; 3],
        /// What is linear between them: depth, or its reciprocal.
        values: [f64; 3],
    },
    /// A rectangle of the image, every texel of which is asked by a ray.
    Sampled {
        /// Its corner of lowest coordinates.
        low: DVec2,
        /// Its corner of highest coordinates.
        high: DVec2,
    },
}

/// A fragment: a texel's centre in an item.
#[derive(Clone, Copy, Debug)]
pub struct Fragment {
    /// The shape.
    pub shape: u32,
    /// The face of a mesh; 0 of other shapes.
    pub face: u32,
    /// Depth or its reciprocal; `None` of what a ray is to ask.
    pub value: Option<f64>,
    /// The texel's centre.
    pub at: DVec2,
}

impl Form {
    fn range(&self) -> [DVec2; 2] {
        match self {
            Self::Triangle { corners, .. } => {
                let [a, b, c] = *corners;
                [a.min(b).min(c), a.max(b).max(c)]
            }
            Self::Sampled { low, high } => [*low, *high],
        }
    }
}

/// True if a triangle's box has the centre of a texel of a picture: without one, nothing of it is drawn.
pub fn has_centre(side: usize, corners: &[DVec2; 3]) -> bool {
    let [a, b, c] = *corners;
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    let is_among = |(first, last): (i64, i64)| first.max(0) <= last.min(signed(side) - 1);
    is_among(centres(low.x, high.x)) && is_among(centres(low.y, high.y))
}

/// The first and last texel whose centres are between two coordinates.
fn centres(low: f64, high: f64) -> (i64, i64) {
    ((low - 0.5).ceil() as i64, (high - 0.5).floor() as i64)
}

/// Draws items in their order into a picture of `side` x `side` texels: `add(texel, fragment)`.
pub fn draw<V: Clone + Default + Send + Sync>(
    side: usize,
    items: &[Item],
    add: impl Fn(&mut V, &Fragment) + Sync,
) -> Vec<V> {
    let rows = |item: &Item| {
        let [low, high] = item.form.range();
        centres(low.y, high.y)
    };
    let last = signed(side) - 1;
    let (picture, _) = in_bands([side; 2], items, rows, |item: &Item, band: &mut Band<V>| {
        let [low, high] = item.form.range();
        let (top, bottom) = centres(low.y, high.y);
        let (left, right) = centres(low.x, high.x);
        let (left, right) = (left.max(0), right.min(last));
        let [first, end] = band.rows();
        let triangle = Triangle::of(&item.form);
        for row in top.max(first)..=bottom.min(end - 1) {
            let (left, right) = match &triangle {
                Some(triangle) => triangle.columns(row as f64 + 0.5, (left, right)),
                None => (left, right),
            };
            let mut at = DVec2::new(0.0, row as f64 + 0.5);
            for (column, texel) in (left..=right).zip(band.line(row, left, right)) {
                at.x = column as f64 + 0.5;
                let (face, value) = match &triangle {
                    None => (0, None),
                    Some(triangle) => match triangle.at(at) {
                        None => continue,
                        value => (triangle.face, value),
                    },
                };
                let fragment = Fragment {
                    shape: item.shape,
                    face,
                    value,
                    at,
                };
                add(texel, &fragment);
            }
        }
    });
    picture
}

/// An edge, from its lower end to its upper one.
#[derive(Clone, Copy)]
struct Edge {
    low: DVec2,
    along: DVec2,
    /// 1 if the triangle is to its left, else -1.
    sign: f64,
}

impl Edge {
    fn new(a: DVec2, b: DVec2) -> Self {
        if (a.y, a.x) < (b.y, b.x) {
            Self {
                low: a,
                along: b - a,
                sign: 1.0,
            }
        } else {
            Self {
                low: b,
                along: a - b,
                sign: -1.0,
            }
        }
    }

    /// Twice the signed area of a point and the edge: the same number for both triangles at the edge, but for
    /// its sign.
    #[inline]
    fn at(&self, place: DVec2) -> f64 {
        self.sign * self.along.perp_dot(place - self.low)
    }

    /// True if the triangle has a place on the edge.
    #[inline]
    fn owns(&self) -> bool {
        self.sign > 0.0
    }
}

/// A triangle ready to be asked.
struct Triangle {
    face: u32,
    /// Counterclockwise, each opposite a corner.
    edges: [Edge; 3],
    values: [f64; 3],
}

impl Triangle {
    fn of(form: &Form) -> Option<Self> {
        let Form::Triangle {
            face,
            corners: [a, b, c],
            values: [u, v, w],
        } = *form
        else {
            return None;
        };
        let is_turned = (b - a).perp_dot(c - a) < 0.0;
        let ([a, b, c], values) = if is_turned {
            ([a, c, b], [u, w, v])
        } else {
            ([a, b, c], [u, v, w])
        };
        Some(Self {
            face,
            edges: [Edge::new(b, c), Edge::new(c, a), Edge::new(a, b)],
            values,
        })
    }

    /// The columns of a row among which all texels of the triangle are.
    fn columns(&self, y: f64, (mut left, mut right): (i64, i64)) -> (i64, i64) {
        for edge in &self.edges {
            // Its value is linear along the row, falling to the right if the triangle is to its left.
            let x = edge.low.x + edge.along.x * ((y - edge.low.y) / edge.along.y);
            if x.is_finite() && edge.along.y > 0.0 {
                // A column further, for rounding.
                if edge.owns() {
                    right = right.min((x + 0.5).floor() as i64);
                } else {
                    left = left.max((x - 1.5).ceil() as i64);
                }
            }
        }
        (left, right)
    }

    /// The value at a place, if that is in the triangle.
    #[inline]
    fn at(&self, at: DVec2) -> Option<f64> {
        let weights = self.edges.map(|edge| edge.at(at));
        for (weight, edge) in weights.iter().zip(&self.edges) {
            if *weight < 0.0 || *weight == 0.0 && !edge.owns() {
                return None;
            }
        }
        let sum: f64 = weights.iter().sum();
        let value: f64 = weights.iter().zip(self.values).map(|(w, v)| w * v).sum();
        (sum > 0.0).then(|| value / sum)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_centre_is_in_one_triangle_of_a_fan_also_on_edges() {
        // Corners on centres of texels: many edges pass through others' centres.
        let middle = DVec2::new(8.5, 8.5);
        let ring = [
            [1.5, 1.5],
            [8.5, 0.5],
            [15.5, 1.5],
            [16.5, 8.5],
            [15.5, 15.5],
            [8.5, 16.5],
            [1.5, 15.5],
            [0.5, 8.5],
        ]
        .map(DVec2::from_array);
        for is_turned in [false, true] {
            let items: Vec<Item> = (0..8)
                .map(|index| {
                    let (a, b) = (ring[index], ring[(index + 1) % 8]);
                    let corners = if is_turned {
                        [middle, b, a]
                    } else {
                        [a, b, middle]
                    };
                    // Twice the row, and the column: linear.
                    let values = corners.map(|corner| 2.0 * corner.y + corner.x);
                    let form = Form::Triangle {
                        face: index as u32,
                        corners,
                        values,
                    };
                    Item { shape: 0, form }
                })
                .collect();
            let picture: Vec<Vec<(u32, f64)>> = draw(18, &items, |texel: &mut Vec<_>, fragment| {
                let expected = 2.0 * fragment.at.y + fragment.at.x;
                texel.push((fragment.face, fragment.value.unwrap() - expected));
            });
            for (index, texel) in picture.iter().enumerate() {
                let at = DVec2::new((index % 18) as f64 + 0.5, (index / 18) as f64 + 0.5);
                // Inside of all borders by more than rounding.
                let is_inside = (0..8).all(|index| {
                    (ring[(index + 1) % 8] - ring[index]).perp_dot(at - ring[index]) > 1e-9
                });
                if is_inside {
                    assert_eq!(texel.len(), 1, "{at}: {texel:?}");
                }
                assert!(texel.len() <= 1, "{at}: {texel:?}");
                assert!(texel.iter().all(|(_, off)| off.abs() < 1e-13));
            }
        }
    }
}
