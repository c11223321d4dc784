//! Rays in a tree's own frame.

use glam::DVec3;

use super::tree_frame::TreeFrame;
use crate::geometry::{
    Bounds, Ray,
    rounding::{UNIT_ROUNDOFF, gamma},
};

/// The unit roundoff of `f32`, 2⁻²⁴.
pub(super) const NARROW_ROUNDOFF: f64 = f32::EPSILON as f64 / 2.0;

/// The largest reciprocal of a direction's component that is told apart from infinity.
///
/// A component below 2⁻⁴⁰ is taken for ±2⁻⁴⁰. Across the frame (a path of at most 2√3) that shifts the ray by
/// less than 2⁻³⁸, far below `f32`'s roundoff.
const LARGEST_RECIPROCAL: f64 = (1u64 << 40) as f64;

/// A ray in `f32`, in the frame of a tree, with a bound on its error.
///
/// # The error bound
///
/// In the frame, boxes and the ray's start have coordinates of at most 1 (see [`TreeFrame`]). Let u = 2⁻²⁴.
/// The slab test computes `(plane − origin) · (1/d)`. Its roundings, each written as a shift of the plane,
/// are: the origin u; the difference u · 2; the reciprocal (one rounding from `f64`) and the product, each
/// u · 2. Sum: 7u. The `f64` computation of the start adds a few roundings of the distance to it, which
/// matters if the ray comes from very far away.
///
/// So the exact ray passes each plane no earlier than one that starts `margin` = 8u + … further along, and no
/// later than one that starts `margin` further back. Near planes are tested with `near_origin`, far planes
/// with `far_origin`. Boxes need no padding of their own (in sum this is about 2⁻²² of the frame's width, the
/// same for all boxes).
pub(in crate::geometry) struct LocalRay {
    pub(super) near_origin: [f32; 3],
    pub(super) far_origin: [f32; 3],
    pub(super) reciprocal: [f32; 3],
    /// For each axis 1 if the direction is negative, else 0.
    pub(super) signs: [u32; 3],
    /// Distance along the world's ray at which this one starts.
    start: f64,
    /// Number of local units in a world unit.
    scale: f64,
    /// The ray as the triangle filter needs it.
    pub(super) sheared: NarrowShear,
}

/// A ray, prepared for the triangle filter; see [`TrianglePack`](super::TrianglePack).
pub(super) struct NarrowShear {
    pub(super) axes: [u32; 3],
    pub(super) origin: [f32; 3],
    pub(super) shear: [f32; 2],
    /// A part of the bound on the error of an edge function, as a factor of the image's largest coordinate.
    pub(super) relative_error: f32,
    /// The constant part of that bound.
    pub(super) absolute_error: f32,
}

impl LocalRay {
    /// The ray in the tree's frame, unless it misses `bounds` or enters them beyond `limit`.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(super) fn enter(frame: &TreeFrame, bounds: &Bounds, ray: &Ray, limit: f64) -> Option<Self> {
        let inverse = ray.direction.recip();
        let entry = slab_entry(bounds, ray.origin, inverse, limit)?;
        // The start is slightly before the entry; rounding of `entry` itself is part of the margin.
        let start = entry * (1.0 - gamma(8));
        let from_center = ray.origin - frame.center;
        let origin = (from_center + ray.direction * start) * frame.scale;
        // The roundings of `from_center`, of the product and of the sum, by the largest term; and those of
        // `entry`, by which the start may lie outside of the frame.
        let far_away = (from_center.abs().max_element() + start) * frame.scale;
        let margin = 8.0 * NARROW_ROUNDOFF + 16.0 * UNIT_ROUNDOFF * far_away;
        let ahead = DVec3::ONE.copysign(ray.direction) * margin;
        let reciprocal = inverse.clamp(
            DVec3::splat(-LARGEST_RECIPROCAL),
            DVec3::splat(LARGEST_RECIPROCAL),
        );
        Some(Self {
            near_origin: narrow(origin + ahead),
            far_origin: narrow(origin - ahead),
            reciprocal: narrow(reciprocal),
            signs: ray
                .direction
                .to_array()
                .map(|d| u32::from(d.is_sign_negative())),
            start,
            scale: frame.scale,
            sheared: NarrowShear::new(origin, ray.direction, inverse, margin),
        })
    }

    /// A distance along the world's ray as one along this ray, rounded up.
    #[inline]
    pub(super) fn local_limit(&self, limit: f64) -> f32 {
        // Rounding to nearest may lose half a step; one whole step up compensates.
        (((limit - self.start) * self.scale) as f32).next_up()
    }
}

impl NarrowShear {
    /// Prepares a ray, and bounds the error of its edge functions.
    ///
    /// # The error bound
    ///
    /// Let u = 2⁻²⁴, and let coordinates in the frame be at most 1. A vertex less the origin is off by u + u
    /// from the two and 2u from the difference, and by the margin m that bounds all errors of the ray. Its
    /// image `x − s z`, |s| ≤ 1, is off by 4u for x and for z, 2u · 2 for s, 2u for the product and 4u for
    /// the difference: δ = 18u + 2m.
    ///
    /// An edge function of images with coordinates up to M (at most 4) is then off by 4δM + 2δ² and, for its
    /// own roundings, 4uM² ≤ 16uM. So it is off by less than (4δ + 16u) M + 2δ². A quarter more covers the
    /// roundings of M and of the bound itself.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn new(origin: DVec3, direction: DVec3, inverse: DVec3, margin: f64) -> Self {
        let magnitude = direction.abs();
        let z = if magnitude.x > magnitude.y && magnitude.x > magnitude.z {
            0
        } else if magnitude.y > magnitude.z {
            1
        } else {
            2
        };
        let (x, y) = ((z + 1) % 3, (z + 2) % 3);
        let (origin, direction) = (narrow(origin), direction.to_array());
        let inverse = inverse[z];
        let image_error = 18.0 * NARROW_ROUNDOFF + 2.0 * margin;
        Self {
            axes: [x, y, z].map(|axis| axis as u32),
            origin: [origin[x], origin[y], origin[z]],
            shear: [
                (direction[x] * inverse) as f32,
                (direction[y] * inverse) as f32,
            ],
            relative_error: (1.25 * (4.0 * image_error + 16.0 * NARROW_ROUNDOFF)) as f32,
            absolute_error: (1.25 * 2.0 * image_error * image_error) as f32,
        }
    }
}

#[inline(always)]
#[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
fn narrow(v: DVec3) -> [f32; 3] {
    v.as_vec3().to_array()
}

/// Distance at which the ray enters the box (0 if it starts inside), if it does before `limit`.
///
/// Differences and products are off by γ₃ of the entry and exit distances, for which the comparison allows.
/// `0 · ∞` (a ray along the border) may count as a miss: no primitive reaches there.
#[inline(always)]
#[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
fn slab_entry(bounds: &Bounds, origin: DVec3, inverse: DVec3, limit: f64) -> Option<f64> {
    let a = (bounds.min - origin) * inverse;
    let b = (bounds.max - origin) * inverse;
    let entry = a.min(b).max_element().max(0.0);
    let exit = a.max(b).min_element();
    let earliest = entry * (1.0 - gamma(4));
    (earliest <= exit * (1.0 + gamma(4)) && earliest <= limit).then_some(entry)
}
