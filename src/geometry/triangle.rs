//! The watertight triangle test.
//!
//! Woop, Benthin and Wald, *Watertight ray/triangle intersection*, JCGT 2(1), 2013: the vertices are sheared
//! so that the ray becomes the z axis. The triangle is hit if the origin of the xy plane is inside its image.
//!
//! # Why no ray is lost between triangles
//!
//! 1. The image of a vertex depends on the ray and the vertex alone, so triangles that share a vertex (the
//!    same bits) share its image. From here on, the images *are* the mesh.
//! 2. An edge function is `p.x q.y − p.y q.x`, computed as a difference of two rounded products. Rounding is
//!    monotone, so its sign is either right or zero, never wrong; and the neighbour across the edge computes
//!    exactly the opposite number.
//! 3. If the rounded products are equal, the sign is taken from the products' own rounding errors, which a
//!    fused multiply-add gives exactly. So every sign is exact (as long as no product is subnormal: then zero
//!    stands, which counts as inside on both sides).
//! 4. Zero counts as inside. The test thus accepts exactly the closed image triangles of non-zero area. If a
//!    closed mesh's image covers a neighbourhood of the origin, their (closed) union covers the origin. So at
//!    least one is hit, whether by its inside, an edge or a vertex.

use glam::DVec3;

use super::Ray;

/// A ray, prepared for the triangle test.
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearedRay {
    origin: [f64; 3],
    /// The axes in the order x, y, z of the sheared space; z is the direction's largest.
    axes: [usize; 3],
    shear: [f64; 3],
}

/// The intersection of a sheared ray with a triangle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct TriangleHit {
    pub distance: f64,
    /// The weight of the second vertex.
    pub b1: f64,
    /// The weight of the third vertex.
    pub b2: f64,
}

/// The image of a vertex.
struct ShearedVertex {
    x: f64,
    y: f64,
    /// The coordinate along the largest axis, not yet scaled to distance.
    depth: f64,
}

impl ShearedRay {
    #[inline]
    pub(super) fn new(ray: &Ray) -> Self {
        let direction = ray.direction.to_array();
        let magnitude = ray.direction.abs();
        let z = if magnitude.x > magnitude.y && magnitude.x > magnitude.z {
            0
        } else if magnitude.y > magnitude.z {
            1
        } else {
            2
        };
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let inverse = 1.0 / direction[z];
        Self {
            origin: ray.origin.to_array(),
            axes: [x, y, z],
            shear: [direction[x] * inverse, direction[y] * inverse, inverse],
        }
    }

    #[inline]
    fn image(&self, vertex: &DVec3) -> ShearedVertex {
        let v: &[f64; 3] = vertex.as_ref();
        let [x, y, z] = self.axes;
        let depth = v[z] - self.origin[z];
        ShearedVertex {
            x: (v[x] - self.origin[x]) - self.shear[0] * depth,
            y: (v[y] - self.origin[y]) - self.shear[1] * depth,
            depth,
        }
    }

    /// The intersection of the ray with the triangle at a distance > 0; both sides and the border count.
    #[inline]
    pub(super) fn intersect(&self, vertices: &[DVec3; 3]) -> Option<TriangleHit> {
        let [a, b, c] = vertices;
        let (a, b, c) = (self.image(a), self.image(b), self.image(c));
        let mut weights = [edge(&c, &b), edge(&a, &c), edge(&b, &a)];
        if weights.contains(&0.0) {
            weights = [exact_edge(&c, &b), exact_edge(&a, &c), exact_edge(&b, &a)];
        }
        let [u, v, w] = weights;
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None; // the image has no area
        }
        let inverse = 1.0 / sum;
        // The mean starts from one corner: for a triangle far away the depths are large and their differences
        // exact. So the roundings are relative to the triangle, not to its distance.
        let from_a = (v * (b.depth - a.depth) + w * (c.depth - a.depth)) * inverse;
        let distance = (a.depth + from_a) * self.shear[2];
        // Also false for NaN.
        (distance > 0.0).then_some(TriangleHit {
            distance,
            b1: v * inverse,
            b2: w * inverse,
        })
    }
}

/// Twice the signed area of the triangle (origin, p, q), rounded; zero or of the right sign.
#[inline]
fn edge(p: &ShearedVertex, q: &ShearedVertex) -> f64 {
    p.x * q.y - p.y * q.x
}

/// [`edge`] with the right sign even if the rounded products are equal.
#[cold]
fn exact_edge(p: &ShearedVertex, q: &ShearedVertex) -> f64 {
    let (xy, yx) = (p.x * q.y, p.y * q.x);
    if xy == yx {
        // Both errors are exact, so the sign of their difference is.
        p.x.mul_add(q.y, -xy) - p.y.mul_add(q.x, -yx)
    } else {
        xy - yx
    }
}
