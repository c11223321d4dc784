//! A clear sky's radiance by direction.
//!
//! L. Hošek and A. Wilkie, "An Analytic Model for Full Spectral Sky-Dome Radiance", SIGGRAPH 2012. With θ the
//! angle to the zenith, γ that to the sun, and A … I the numbers of a channel, their equations 5 and 8 are
//!
//! ```text
//! L(θ, γ) = M (1 + A exp(B / (cos θ + 0.01)))
//!             (C + D exp(E γ) + F cos²γ + G χ(I, γ) + H √cos θ)
//! χ(I, γ) = (1 + cos²γ) / (1 + I² − 2 I cos γ)^(3/2)
//! ```

use glam::DVec3;

use super::Y_INTEGRAL;
use super::solar_position::elevation;
use super::tables::{SHAPE_NUMBERS, sky_radiance, sky_shape};
use crate::numeric::math;
use crate::radiometry::Rgb;

/// A clear sky above an even ground.
#[derive(Clone, Debug, PartialEq)]
pub struct ClearSky {
    /// Where the sun is, a unit vector; z points up.
    sun: DVec3,
    /// The numbers A … I of each channel.
    shape: [[f64; SHAPE_NUMBERS]; 3],
    /// The factor M of each channel [W/m²/sr/nm].
    radiance: [f64; 3],
}

impl ClearSky {
    /// The sky with the sun in a direction (a unit vector, z up).
    ///
    /// `turbidity` in 1..=10 and `albedo` in 0..=1 are moved into these ranges. If the sun is below the
    /// horizon, the sky is black: the model has no twilight.
    pub fn new(turbidity: f64, albedo: Rgb, sun: DVec3) -> Self {
        let elevation = elevation(sun);
        if elevation < 0.0 {
            return Self {
                sun,
                shape: [[0.0; SHAPE_NUMBERS]; 3],
                radiance: [0.0; 3],
            };
        }
        let x = math::cbrt(elevation / std::f64::consts::FRAC_PI_2).min(1.0);
        Self {
            sun,
            shape: std::array::from_fn(|c| sky_shape(turbidity, albedo.0[c], x, c)),
            radiance: std::array::from_fn(|c| {
                sky_radiance(turbidity, albedo.0[c], x, c) / Y_INTEGRAL
            }),
        }
    }

    /// True if it has a channel below zero in one of 32 x 8 directions, evenly spread over the dome.
    pub fn has_negative_channels(&self) -> bool {
        (0..256).any(|index: u32| {
            let up = (f64::from(index / 32) + 0.5) / 8.0;
            let (sin, cos) = math::sin_cos(std::f64::consts::TAU * f64::from(index % 32) / 32.0);
            let out = (1.0 - up * up).sqrt();
            let direction = DVec3::new(out * cos, out * sin, up).normalize();
            self.radiance(direction).min_channel() < 0.0
        })
    }

    /// Radiance [W/m²/sr/nm] that comes from a direction (a unit vector, z up); zero below the horizon.
    ///
    /// Channels may be negative: sRGB cannot show every colour, and the fit is not exact.
    pub fn radiance(&self, direction: DVec3) -> Rgb {
        let up = direction.z;
        if up < 0.0 {
            return Rgb::BLACK;
        }
        // By the chord: an arc cosine loses half its digits next to the sun.
        let gamma = 2.0 * math::asin((0.5 * direction.distance(self.sun)).min(1.0));
        let cos = math::cos(gamma);
        Rgb(std::array::from_fn(|channel| {
            let [a, b, c, d, e, f, g, h, i] = self.shape[channel];
            let horizon = 1.0 + a * math::exp(b / (up + 0.01));
            let chi = (1.0 + cos * cos) / math::powf(1.0 + i * i - 2.0 * i * cos, 1.5);
            let glow = c + d * math::exp(e * gamma) + f * cos * cos + g * chi + h * up.sqrt();
            horizon * glow * self.radiance[channel]
        }))
    }
}
