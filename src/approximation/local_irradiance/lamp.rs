//! The light of a sample: where its photons start.
//!
//! It is white, and its irradiance at the object's centre is 1 W/m²; a frame scales what it makes.

use glam::{DMat3, DVec3};

use super::settings::Settings;
use super::variants::Light;
use crate::geometry::Ray;
use crate::numeric::math;
use crate::numeric::rotation;
use crate::radiometry::Rgb;
use crate::transport::domain::chart::Falloff;
use crate::transport::first_surface::Source;

/// A light as an object sees it.
#[derive(Clone, Copy, Debug)]
pub struct SeenLight {
    /// The unit direction from the object's centre to it.
    pub towards: DVec3,
    /// Irradiance [W/m²] across the light at the centre, by which a table counts.
    pub irradiance: Rgb,
    /// Its distance \[m\] from the centre; infinite for parallel light.
    pub distance: f64,
}

impl SeenLight {
    /// A light as seen from a place; `None` from within the light itself.
    pub fn new(source: &Source, center: DVec3, settings: &Settings) -> Option<Self> {
        match *source {
            Source::Parallel {
                direction,
                irradiance,
                ..
            } => Some(Self {
                towards: -direction,
                irradiance,
                distance: f64::INFINITY,
            }),
            Source::Point {
                origin,
                intensity,
                falloff,
            } => {
                let towards = (origin - center).try_normalize()?;
                let distance = origin.distance(center);
                let factor = match settings.light {
                    Light::Directional => falloff.factor(-towards),
                    // Each photon has its own.
                    Light::Exact => 1.0,
                };
                Some(Self {
                    towards,
                    irradiance: intensity * (factor / (distance * distance)),
                    distance,
                })
            }
        }
    }
}

/// Photons towards the ball around an object.
#[derive(Clone, Copy, Debug)]
pub enum Lamp {
    /// Parallel light.
    Parallel {
        /// The unit direction to the light.
        towards: DVec3,
        /// The distance \[m\] ahead of the centre at which photons start.
        ahead: f64,
    },
    /// Light from a point.
    Point {
        /// The unit direction to the light.
        towards: DVec3,
        /// Its distance \[m\].
        distance: f64,
        /// Its dependence on direction.
        falloff: Falloff,
        /// The rotation that gives the direction of a photon's own light back.
        unturned: DMat3,
    },
}

impl Lamp {
    /// A photon of the unit square: its start relative to the centre, with its flux \[W\] if it stands for
    /// all light.
    ///
    /// Parallel light fills the disc of the ball across it evenly. A point's light fills the cone around the
    /// ball evenly by solid angle.
    #[inline]
    pub fn photon(&self, radius: f64, [u, v]: [f64; 2]) -> (Ray, f64) {
        let (sine, cosine) = math::sin_cos(std::f64::consts::TAU * v);
        match *self {
            Self::Parallel { towards, ahead } => {
                let (x, y) = towards.any_orthonormal_pair();
                let across = (x * cosine + y * sine) * (radius * u.sqrt());
                let ray = Ray::new(towards * ahead + across, -towards);
                (ray, std::f64::consts::PI * radius * radius)
            }
            Self::Point {
                towards,
                distance,
                falloff,
                unturned,
            } => {
                let (x, y) = towards.any_orthonormal_pair();
                let sine_of_cone = (radius / distance).min(1.0);
                // 1 − cos without the loss of digits of small angles.
                let height = sine_of_cone * sine_of_cone
                    / (1.0 + (1.0 - sine_of_cone * sine_of_cone).sqrt());
                let lost = height * u;
                let off = (lost * (2.0 - lost)).sqrt();
                let direction = (x * cosine + y * sine) * off - towards * (1.0 - lost);
                let solid_angle = std::f64::consts::TAU * height;
                let factor = falloff.factor(unturned * direction);
                // Intensity |L|²: the irradiance at the centre is 1.
                let flux = distance * distance * solid_angle * factor;
                (Ray::new(towards * distance, direction), flux)
            }
        }
    }

    /// The flux \[W\] of all photons, or a little more.
    pub fn flux_bound(&self, radius: f64) -> f64 {
        match *self {
            Self::Parallel { .. } => std::f64::consts::PI * radius * radius,
            Self::Point { distance, .. } => {
                std::f64::consts::TAU
                    * distance
                    * distance
                    * math::powi((radius / distance).min(1.0), 2)
            }
        }
    }
}

/// The least rotation that takes one unit direction to another.
pub fn least_rotation(from: DVec3, to: DVec3) -> DMat3 {
    let cross = from.cross(to);
    let sine = cross.length();
    let cosine = from.dot(to);
    if sine == 0.0 {
        if cosine > 0.0 {
            return DMat3::IDENTITY;
        }
        return rotation::about(from.any_orthonormal_vector(), std::f64::consts::PI);
    }
    rotation::about(cross / sine, math::atan2(sine, cosine))
}
