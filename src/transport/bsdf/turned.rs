//! Normals that a bump or normal map turns.

use glam::{DVec2, DVec3};

use crate::geometry::Frame;

/// A normal turned by a texture, and Mitsuba's remedies for its worst effects.
#[derive(Clone, Copy, Debug)]
pub(super) struct TurnedNormal {
    /// The turned unit normal in the frame of the unturned one.
    pub normal: DVec3,
    /// True if the normal is turned round the unturned one when it faces away from the viewer.
    pub flips: bool,
    /// True if the shadows that it makes have a soft border.
    pub softens: bool,
}

impl TurnedNormal {
    /// A turned normal, given with any length; the unturned one if the length is zero.
    pub fn new(normal: DVec3, flips: bool, softens: bool) -> Self {
        Self {
            normal: normal.try_normalize().unwrap_or(DVec3::Z),
            flips,
            softens,
        }
    }

    /// The frame of the lobe, in that of the unturned normal, for a view along `wi`.
    ///
    /// With `flips`, a normal that `wi` sees from behind is turned by half a turn about the unturned one. The
    /// source is Schüssler et al., *Microfacet-Based Normal Mapping for Robust Monte Carlo Path Tracing*,
    /// 2017.
    pub fn frame(&self, wi: DVec3) -> Frame {
        let mut n = self.normal;
        if self.flips && wi.z * wi.dot(n) <= 0.0 {
            n = DVec3::new(-n.x, -n.y, n.z);
        }
        let s = (DVec3::X - n * n.x).try_normalize().unwrap_or(DVec3::Y);
        Frame {
            s,
            t: n.cross(s),
            n,
        }
    }

    /// The share of light along `wo` (in the frame of the unturned normal) that the bumps do not shadow: G₁
    /// of GGX with α² = tan²/8 of the turned normal, at most 1.
    ///
    /// The source is Conty Estevez, Lecocq and Stein, *A Microfacet-Based Shadowing Function to Solve the
    /// Bump Terminator Problem* (Ray Tracing Gems, 2019, chapter 12).
    pub fn shadowing(&self, wo: DVec3) -> f64 {
        if !self.softens {
            return 1.0;
        }
        let alpha_squared = (0.125 * tan_squared(self.normal)).min(1.0);
        // Along an unturned surface, or one turned by a right angle, tan is infinite.
        let slant = alpha_squared * tan_squared(wo);
        if slant.is_nan() {
            1.0
        } else {
            2.0 / (1.0 + (1.0 + slant).sqrt())
        }
    }
}

fn tan_squared(v: DVec3) -> f64 {
    (v.x * v.x + v.y * v.y) / (v.z * v.z)
}

/// The normal, in the surface's shading frame and of any length, of a surface raised by a height.
///
/// Let p(u, v) be the surface, n its shading normal and h the height. Then the raised surface has the
/// tangents ∂p + (∂h − n·∂p) n along u and v. The change of n itself is left out, as Mitsuba does (and Blinn,
/// 1978).
pub(super) fn raised(
    frame: &Frame,
    geometric_normal: DVec3,
    [dp_du, dp_dv]: [DVec3; 2],
    slope: DVec2,
) -> DVec3 {
    let along = |dp: DVec3, dh: f64| dp + frame.n * (dh - frame.n.dot(dp));
    let normal = along(dp_du, slope.x).cross(along(dp_dv, slope.y));
    let outward = if normal.dot(geometric_normal) < 0.0 {
        -normal
    } else {
        normal
    };
    frame.to_local(outward)
}
