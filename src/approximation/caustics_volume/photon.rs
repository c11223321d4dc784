//! Photons (Table 2), and where they land.

use glam::DVec3;

use crate::geometry::{Hit, Ray};
use crate::radiometry::Rgb;
use crate::transport::signature::Signature;

/// Bytes of a photon's state on a device: energy, position, direction, normal, length, tile and medium
/// (Table 2).
pub const PHOTON_BYTES: u64 = 4 * (3 + 3 + 3 + 3 + 1 + 1 + 1);

/// A photon on its way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photon {
    /// Where it is, and its direction.
    pub ray: Ray,
    /// What it carries \[W\]; of a beam's corner, by what its cell carries.
    pub flux: Rgb,
    /// The length of its way from where it entered the volume \[m\].
    pub length: f64,
    /// Whether it is in a refracting medium.
    pub is_inside: bool,
    /// Its specular events; it is contributive if it has any.
    pub signature: Signature,
    /// The shape that it met last; `u32::MAX` before the first.
    pub last: u32,
    /// The side of that which it would meet, if it met the same place again.
    pub would_meet_front: bool,
    /// The same for photons that went the same way by the same smooth surfaces.
    pub path: u64,
    /// Its number: what its lots are drawn by.
    pub index: u64,
}

impl Photon {
    /// True if it met something that mirrors or refracts.
    #[inline]
    pub fn is_contributive(&self) -> bool {
        !self.signature.is_empty()
    }

    /// The photon further along its way.
    #[inline]
    #[must_use]
    pub fn moved(mut self, distance: f64) -> Self {
        self.ray = Ray::new(self.ray.at(distance), self.ray.direction);
        self.length += distance;
        self
    }
}

/// A photon on a surface that neither mirrors nor refracts.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Landing {
    /// The photon where its last straight way begins.
    pub photon: Photon,
    /// The surface, as far as the technique knows it.
    pub position: DVec3,
    /// Its unit normal, on the side that the photon came from.
    pub normal: DVec3,
    /// The hit of its ray, if it was traced.
    pub hit: Option<Hit>,
}

impl Landing {
    /// The length of all its way from where it entered the volume \[m\].
    pub fn length(&self) -> f64 {
        self.photon.length + self.position.distance(self.photon.ray.origin)
    }
}
