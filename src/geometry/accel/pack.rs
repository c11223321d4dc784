//! Eight triangles side by side.

use glam::DVec3;

use super::{
    ray::LocalRay,
    tree::{Frame, WIDTH},
};

/// The triangles of a leaf in `f32`, for a filter that spares most of the exact tests.
///
/// The filter is the watertight test (see [`triangle`](crate::geometry)) in single precision: it
/// drops a triangle only if edge functions have opposite signs by more than their error bound
/// (derived at [`NarrowShear`](super::ray::NarrowShear)), so never one that the exact test accepts.
#[derive(Clone, Debug)]
#[repr(C, align(32))]
pub(in crate::geometry) struct TrianglePack {
    /// By vertex, by axis; in the tree's frame.
    vertices: [[[f32; WIDTH]; 3]; 3],
    faces: [u32; WIDTH],
    count: u32,
}

impl TrianglePack {
    /// The pack of at most eight faces with these corners, in world space.
    pub(in crate::geometry) fn new(
        frame: Frame,
        triangles: impl Iterator<Item = (u32, [DVec3; 3])>,
    ) -> Self {
        let mut pack = Self {
            vertices: [[[0.0; WIDTH]; 3]; 3],
            faces: [0; WIDTH],
            count: 0,
        };
        for (slot, (face, corners)) in triangles.take(WIDTH).enumerate() {
            pack.faces[slot] = face;
            pack.count += 1;
            for (vertex, corner) in corners.into_iter().enumerate() {
                let local = frame.to_local(corner).as_vec3();
                for axis in 0..3 {
                    pack.vertices[vertex][axis][slot] = local[axis];
                }
            }
        }
        pack
    }

    #[inline]
    pub(in crate::geometry) fn face(&self, slot: usize) -> u32 {
        self.faces[slot]
    }

    /// The slots whose triangles the ray's line may meet, as bits.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(in crate::geometry) fn candidates(&self, ray: &LocalRay) -> u32 {
        let ray = &ray.sheared;
        let [x_axis, y_axis, z_axis] = ray.axes;
        let mut x = [[0.0f32; WIDTH]; 3];
        let mut y = [[0.0f32; WIDTH]; 3];
        for vertex in 0..3 {
            let corner = &self.vertices[vertex];
            let (xs, ys, zs) = (&corner[x_axis], &corner[y_axis], &corner[z_axis]);
            for i in 0..WIDTH {
                let z = zs[i] - ray.origin[2];
                x[vertex][i] = (xs[i] - ray.origin[0]) - ray.shear[0] * z;
                y[vertex][i] = (ys[i] - ray.origin[1]) - ray.shear[1] * z;
            }
        }
        let mut bits = 0;
        let mut may_meet = [false; WIDTH];
        for i in 0..WIDTH {
            let u = x[2][i] * y[1][i] - y[2][i] * x[1][i];
            let v = x[0][i] * y[2][i] - y[0][i] * x[2][i];
            let w = x[1][i] * y[0][i] - y[1][i] * x[0][i];
            let reach = greater(
                greater(
                    greater(x[0][i].abs(), y[0][i].abs()),
                    greater(x[1][i].abs(), y[1][i].abs()),
                ),
                greater(x[2][i].abs(), y[2][i].abs()),
            );
            let error = ray.relative_error * reach + ray.absolute_error;
            let least = lesser(u, lesser(v, w));
            let greatest = greater(u, greater(v, w));
            may_meet[i] = (least >= -error) | (greatest <= error);
        }
        for (i, may) in may_meet.into_iter().enumerate() {
            bits |= u32::from(may) << i;
        }
        bits & ((1 << self.count) - 1)
    }
}

// `f32::max` and `min` must look out for NaN, which takes more than one instruction.

#[inline(always)]
#[allow(clippy::inline_always)]
fn greater(a: f32, b: f32) -> f32 {
    if a > b { a } else { b }
}

#[inline(always)]
#[allow(clippy::inline_always)]
fn lesser(a: f32, b: f32) -> f32 {
    if a < b { a } else { b }
}
