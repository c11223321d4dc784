//! The sun as a disc in the sky, as bright everywhere.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::geometry::Frame;
use crate::numeric::math;
use crate::radiometry::Rgb;

/// An even disc of light infinitely far away, cut at the horizon.
#[derive(Clone, Debug, PartialEq)]
pub struct SunDisc {
    /// Its middle is along `n`.
    frame: Frame,
    /// Up: no light comes from below the horizon.
    up: DVec3,
    /// Half the angle that it fills \[rad\], above 0 and below π / 2.
    half_angle: f64,
    /// Radiance [W/m²/sr].
    radiance: Rgb,
}

impl SunDisc {
    /// A disc about a direction (a unit vector) that fills twice `half_angle` (\[rad\], above 0 and below π /
    /// 2), for an observer with the zenith `up`. Its radiance times its solid angle is `fluence` [W/m²]: if
    /// it is small, the irradiance of a surface across it.
    pub fn new(towards: DVec3, half_angle: f64, fluence: Rgb, up: DVec3) -> Self {
        let mut sun = Self {
            frame: Frame::around(towards),
            up,
            half_angle,
            radiance: Rgb::BLACK,
        };
        sun.radiance = fluence / sun.solid_angle();
        sun
    }

    /// Radiance of all of it [W/m²/sr].
    pub fn peak(&self) -> Rgb {
        self.radiance
    }

    /// The solid angle \[sr\] that it fills, below the horizon, too: 4π sin²(half angle / 2).
    pub fn solid_angle(&self) -> f64 {
        TAU * self.height()
    }

    /// True if a direction (a unit vector) is in the disc, above or below the horizon.
    pub fn contains(&self, direction: DVec3) -> bool {
        // The squared chord of angle γ is 2 (1 − cos γ).
        direction.distance_squared(self.frame.n) <= 2.0 * self.height()
    }

    /// Radiance [W/m²/sr] that comes from a direction, a unit vector.
    pub fn radiance(&self, direction: DVec3) -> Rgb {
        if self.contains(direction) && direction.dot(self.up) >= 0.0 {
            self.radiance
        } else {
            Rgb::BLACK
        }
    }

    /// A direction of the disc: equal areas of `u` (in 0..=1) have equal solid angles.
    pub fn direction(&self, u: [f64; 2]) -> DVec3 {
        // 1 − cos γ is even, by Archimedes.
        let below = u[1] * self.height();
        let out = (below * (2.0 - below)).sqrt();
        let (sin, cos) = math::sin_cos(TAU * u[0]);
        let local = DVec3::new(out * cos, out * sin, 1.0 - below);
        self.frame.to_world(local).normalize()
    }

    /// 1 − cos(half angle), without cancellation.
    fn height(&self) -> f64 {
        let sin = math::sin(0.5 * self.half_angle);
        2.0 * sin * sin
    }
}
