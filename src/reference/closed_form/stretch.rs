//! Stretches of straight lines, and what a texel cuts out of them.

use glam::DVec2;

use super::TexelRect;

/// A stretch of a straight line on the plane, and the flux along it.
pub(super) struct Stretch {
    /// The line's point at t = 0.
    pub(super) origin: DVec2,
    /// A unit vector.
    pub(super) direction: DVec2,
    pub(super) from: f64,
    pub(super) to: f64,
}

impl Stretch {
    /// The range of t inside the texel.
    pub(super) fn clipped(&self, texel: &TexelRect) -> Option<(f64, f64)> {
        let (mut from, mut to) = (self.from, self.to);
        for axis in 0..2 {
            let (origin, direction) = (self.origin[axis], self.direction[axis]);
            let (min, max) = (texel.min[axis], texel.max[axis]);
            if direction == 0.0 {
                if origin < min || origin > max {
                    return None;
                }
                continue;
            }
            let (a, b) = ((min - origin) / direction, (max - origin) / direction);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        (from < to).then_some((from, to))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_texel_cuts_its_own_width_out_of_a_line() {
        let texel = TexelRect::new(1.0, -1.0, 2.0, 1.0);
        let stretch = |direction: DVec2| Stretch {
            origin: DVec2::ZERO,
            direction,
            from: f64::NEG_INFINITY,
            to: f64::INFINITY,
        };
        assert_eq!(stretch(DVec2::X).clipped(&texel), Some((1.0, 2.0)));
        assert_eq!(stretch(DVec2::NEG_X).clipped(&texel), Some((-2.0, -1.0)));
        assert_eq!(stretch(DVec2::Y).clipped(&texel), None);
        let short = Stretch {
            from: 1.5,
            to: 1.75,
            ..stretch(DVec2::X)
        };
        assert_eq!(short.clipped(&texel), Some((1.5, 1.75)));
    }
}
