//! Right-handed orthonormal coordinates at a surface.

use glam::DVec3;

/// Three unit vectors at right angles, `s` × `t` = `n`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The first tangent: x of local directions.
    pub s: DVec3,
    /// The second tangent: y.
    pub t: DVec3,
    /// The normal: z.
    pub n: DVec3,
}

impl Frame {
    /// A frame with the unit normal `n`; its tangents may be any.
    #[inline]
    pub fn around(n: DVec3) -> Self {
        let (s, t) = n.any_orthonormal_pair();
        Self { s, t, n }
    }

    /// The frame with the unit normal `n` whose `s` is the part of `along` at a right angle to it.
    ///
    /// Any frame around `n` if `along` is parallel to `n` or no direction at all.
    pub fn along(n: DVec3, along: DVec3) -> Self {
        let across = along - n * n.dot(along);
        // Below this share of `along` the difference consists of rounding errors, and has no meaningful
        // direction.
        if across.length_squared() <= 1e-24 * along.length_squared() || !across.is_finite() {
            return Self::around(n);
        }
        // Projected once more, for the part of the right angle that the difference lost.
        let s = (across - n * n.dot(across)).normalize();
        Self {
            s,
            t: n.cross(s),
            n,
        }
    }

    /// A direction's coordinates.
    #[inline]
    pub fn to_local(&self, world: DVec3) -> DVec3 {
        DVec3::new(world.dot(self.s), world.dot(self.t), world.dot(self.n))
    }

    /// The direction with these coordinates.
    #[inline]
    pub fn to_world(&self, local: DVec3) -> DVec3 {
        self.s * local.x + self.t * local.y + self.n * local.z
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_frame_is_right_handed_and_undoes_itself() {
        let n = DVec3::new(0.3, -0.8, -0.2).normalize();
        let along = DVec3::new(1.0, 2.0, 3.0);
        for frame in [
            Frame::around(n),
            Frame::along(n, along),
            Frame::along(n, n),
            Frame::along(n, DVec3::ZERO),
            Frame::along(n, DVec3::NAN),
        ] {
            // A dozen operations on numbers up to 4.
            let tolerance = 32.0 * f64::EPSILON;
            assert!(frame.s.cross(frame.t).abs_diff_eq(n, tolerance));
            assert!((frame.s.length() - 1.0).abs() < tolerance);
            let back = frame.to_world(frame.to_local(along));
            assert!(back.abs_diff_eq(along, tolerance), "{back}");
        }
        assert!(Frame::along(n, along).s.dot(along) > 0.0);
    }
}
