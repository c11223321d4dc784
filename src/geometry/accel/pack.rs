//! Eight triangles side by side.

use glam::DVec3;

use super::{
    lanes::{Lanes, WIDTH},
    ray::{LocalRay, NarrowShear},
    tree_frame::TreeFrame,
};

/// The triangles of a leaf in `f32`, for a filter that spares most of the exact tests.
///
/// The filter is the watertight test (see `geometry/triangle.rs`) in single precision. It drops a triangle
/// only if edge functions have opposite signs by more than their error bound (derived at [`NarrowShear`]), so
/// never one that the exact test accepts.
#[derive(Clone, Debug)]
pub(in crate::geometry) struct TrianglePack {
    /// Coordinates by vertex and axis, in the tree's frame. Slots without a triangle are NaN.
    vertices: [[[f32; WIDTH]; 3]; 3],
}

impl TrianglePack {
    /// The pack of at most eight triangles with these corners, in world space.
    pub(in crate::geometry) fn new(
        frame: TreeFrame,
        triangles: impl Iterator<Item = [DVec3; 3]>,
    ) -> Self {
        let mut pack = Self {
            vertices: [[[f32::NAN; WIDTH]; 3]; 3],
        };
        for (slot, corners) in triangles.take(WIDTH).enumerate() {
            for (vertex, corner) in corners.into_iter().enumerate() {
                let local = frame.to_local(corner).as_vec3();
                for axis in 0..3 {
                    pack.vertices[vertex][axis][slot] = local[axis];
                }
            }
        }
        pack
    }

    /// The slots whose triangles the ray's line may meet, as bits.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(in crate::geometry) fn candidates(&self, lanes: impl Lanes, ray: &LocalRay) -> u32 {
        let ray = &ray.sheared;
        let zero = lanes.splat(0.0);
        let (a, b, c) = (
            image(lanes, &self.vertices[0], ray),
            image(lanes, &self.vertices[1], ray),
            image(lanes, &self.vertices[2], ray),
        );
        let (u, v, w) = (edge(lanes, c, b), edge(lanes, a, c), edge(lanes, b, a));
        let reach = lanes.max(
            lanes.max(largest(lanes, a), largest(lanes, b)),
            largest(lanes, c),
        );
        let error = lanes.add(
            lanes.mul(lanes.splat(ray.relative_error), reach),
            lanes.splat(ray.absolute_error),
        );
        let least = lanes.min(lanes.min(u, v), w);
        let greatest = lanes.max(lanes.max(u, v), w);
        // Both comparisons are false for the NaN of an empty slot.
        lanes.at_most(lanes.sub(zero, error), least) | lanes.at_most(greatest, error)
    }
}

// Functions, not closures: these must be compiled for the caller's registers.

/// The images of eight vertices: x and y.
#[inline(always)]
#[allow(clippy::inline_always)]
fn image<L: Lanes>(
    lanes: L,
    vertices: &[[f32; WIDTH]; 3],
    ray: &NarrowShear,
) -> (L::Vector, L::Vector) {
    let [x_axis, y_axis, z_axis] = ray.axes.map(|axis| axis as usize % 3);
    let [ox, oy, oz] = ray.origin;
    let [sx, sy] = ray.shear;
    let x = lanes.sub(lanes.load(&vertices[x_axis]), lanes.splat(ox));
    let y = lanes.sub(lanes.load(&vertices[y_axis]), lanes.splat(oy));
    let z = lanes.sub(lanes.load(&vertices[z_axis]), lanes.splat(oz));
    (
        lanes.sub(x, lanes.mul(lanes.splat(sx), z)),
        lanes.sub(y, lanes.mul(lanes.splat(sy), z)),
    )
}

/// Twice the signed areas of eight triangles (origin, p, q).
#[inline(always)]
#[allow(clippy::inline_always)]
fn edge<L: Lanes>(lanes: L, p: (L::Vector, L::Vector), q: (L::Vector, L::Vector)) -> L::Vector {
    lanes.sub(lanes.mul(p.0, q.1), lanes.mul(p.1, q.0))
}

/// The larger of |x| and |y|.
#[inline(always)]
#[allow(clippy::inline_always)]
fn largest<L: Lanes>(lanes: L, (x, y): (L::Vector, L::Vector)) -> L::Vector {
    let zero = lanes.splat(0.0);
    lanes.max(
        lanes.max(x, lanes.sub(zero, x)),
        lanes.max(y, lanes.sub(zero, y)),
    )
}
