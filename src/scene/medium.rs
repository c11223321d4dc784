//! Media that absorb light, and the surfaces that bound them.

use glam::DVec3;

use crate::numeric::math;
use crate::radiometry::Rgb;

/// A homogeneous medium that absorbs light, and neither scatters nor emits any.
#[derive(Clone, Debug, PartialEq)]
pub struct Medium {
    /// The file's `id`, or one made from the plugin and a number.
    pub id: String,
    /// The absorption coefficient σ of each channel, per scene unit \[1/m\]; finite and not negative.
    pub absorption: Rgb,
}

impl Medium {
    /// The share of light, per channel, that is left after `length` \[m\] in the medium: exp(−σ length), by
    /// Beer and Lambert.
    ///
    /// The length may be infinite: then only channels that are not absorbed at all are left.
    #[inline]
    pub fn transmittance(&self, length: f64) -> Rgb {
        let of = |absorption: f64| match absorption {
            0.0 => 1.0,
            absorption => math::exp(-absorption * length),
        };
        if self.absorption.is_grey() {
            Rgb::grey(of(self.absorption.0[0]))
        } else {
            self.absorption.map(of)
        }
    }
}

/// The index of a [`Medium`] in [`Scene::media`](super::Scene::media), or the lack of any.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct MediumId(u32);

impl MediumId {
    /// Nothing that absorbs.
    pub const CLEAR: Self = Self(0);

    /// The medium at this place of the scene's list.
    pub fn new(index: usize) -> Self {
        Self(index as u32 + 1)
    }

    /// Its place in the scene's list; `None` if it is clear.
    #[inline]
    pub fn index(self) -> Option<usize> {
        (self.0 as usize).checked_sub(1)
    }
}

/// The media on both sides of a surface that bounds any.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Boundary {
    /// The medium on the side that the normal points away from.
    pub interior: MediumId,
    /// The medium on the side that the normal points to.
    pub exterior: MediumId,
}

impl Boundary {
    /// True if light is absorbed on either side.
    pub fn absorbs(self) -> bool {
        [self.interior, self.exterior] != [MediumId::CLEAR; 2]
    }

    /// The medium on the side of the surface to which `direction` points.
    #[inline]
    pub fn beyond(self, geometric_normal: DVec3, direction: DVec3) -> MediumId {
        if direction.dot(geometric_normal) > 0.0 {
            self.exterior
        } else {
            self.interior
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_is_absorbed_exponentially_and_channel_by_channel() {
        let medium = Medium {
            id: "ink".to_owned(),
            absorption: Rgb::new(0.0, 0.5, 3.0),
        };
        // Rounding of one product and one exponential.
        let [red, green, blue] = medium.transmittance(2.0).0;
        assert_eq!(red, 1.0);
        assert!((green - 0.367_879_441_171_442_33).abs() < 1e-15);
        assert!((blue - 0.002_478_752_176_666_358_5).abs() < 1e-15);
        // Lengths add where shares multiply.
        let parts = medium.transmittance(0.7) * medium.transmittance(1.3);
        assert!((parts.0[1] - green).abs() < 1e-15);
    }

    #[test]
    fn only_what_is_not_absorbed_comes_from_infinity() {
        let medium = Medium {
            id: "ink".to_owned(),
            absorption: Rgb::new(0.0, 1e-300, 3.0),
        };
        assert_eq!(medium.transmittance(f64::INFINITY), Rgb::new(1.0, 0.0, 0.0));
        assert_eq!(medium.transmittance(0.0), Rgb::WHITE);
    }

    #[test]
    fn a_surface_has_its_exterior_where_the_normal_points() {
        let boundary = Boundary {
            interior: MediumId::new(0),
            exterior: MediumId::CLEAR,
        };
        assert_eq!(boundary.beyond(DVec3::Z, DVec3::Z), MediumId::CLEAR);
        assert_eq!(boundary.beyond(DVec3::Z, -DVec3::Z), MediumId::new(0));
        assert_eq!(MediumId::new(0).index(), Some(0));
        assert_eq!(MediumId::CLEAR.index(), None);
    }
}
