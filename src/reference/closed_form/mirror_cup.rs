//! A cup that mirrors inside, in parallel or point light: nephroid, cardioid and their kin.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec2;

use super::quadrature::{parts_of, sign_changes, simpson, simpson_between, windows};
use super::stretch::Stretch;
use super::{KnownPath, TexelGrid, TexelRect};
use crate::numeric::math;
use crate::numeric::rotation;

/// The light over a [`MirrorCup`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum CupLight {
    /// Parallel light that travels along (tan α, 0, −1).
    Parallel {
        /// tan α, with α the light's angle to the vertical; 0 or more.
        tan_angle: f64,
        /// Irradiance across the light [W/m²].
        irradiance: f64,
    },
    /// A point at (−`distance`, 0, `height`).
    Point {
        /// Distance from the cup's axis (m), 0 or more.
        distance: f64,
        /// Height over the bottom (m), more than the cup's.
        height: f64,
        /// Radiant intensity [W/sr].
        intensity: f64,
    },
}

/// An upright cylinder about the z axis, from z = 0 up, mirror inside and black outside: all light on the
/// plane z = 0.
///
/// A vertical wall leaves the vertical part of a direction alone. Seen from above, a ray is a billiard in the
/// circle of radius R. It comes down to the plane after a horizontal length that no reflection changes.
///
/// A ray that travels at the azimuth β₀ and hits the wall at the azimuth a₁ has the (signed) incidence φ = a₁
/// − β₀. All its chords have the length c = 2 R cos φ and all its hits the incidence φ:
///
/// ```text
/// a_j = a₁ + (j − 1)(π + 2φ),     β_j = β₀ + j (π + 2φ)
/// ```
///
/// Light with the same β₀ and a₁ lands along that folded line, with a known flux per length t of it:
///
/// ```text
/// parallel:  dΦ = E cos α · R cos φ dφ dt,   t from l to l + c past the opening's rim,  l = H tan α
/// point:     dΦ = I h t / (h² + t²)^(3/2) dt dψ,   t from s₀ h/(h − H) to s₁ h/(h − H) from the point
/// ```
///
/// (s₀, s₁: where the ray crosses the circle; below that range it meets the outside, above it flies over the
/// cup). So the flux into a texel is an integral over lines of what the texel cuts out of each: one variable,
/// no singularity. The caustic is the curve on which neighbouring lines cross: τ behind the k-th hit with τ =
/// R cos φ (2k − 1)/(2k) in parallel light, the nephroid for k = 1 (see [`MirrorCup::parallel_caustic`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MirrorCup {
    /// Radius R (m).
    pub radius: f64,
    /// Height H (m).
    pub height: f64,
    /// The wall's reflectance (0..=1), the same for all angles.
    pub reflectance: f64,
    /// The light over it.
    pub light: CupLight,
}

/// One ray's path as seen from above, before it is cut by height.
struct CupRay {
    start: DVec2,
    azimuth: f64,
    /// Incidence φ on the wall, signed.
    incidence: f64,
    /// Length t from `start` at which it enters the circle.
    enter: f64,
    /// Length t from `start` at which it first hits the wall.
    hit: f64,
    /// d²Φ / (du dt) over dM/dt.
    density: f64,
}

impl MirrorCup {
    /// The irradiance [W/m²] averaged over a texel, by one path ([`KnownPath::Direct`] or
    /// [`KnownPath::Reflected`]).
    ///
    /// Adaptive quadrature between kinks, to about 1e-8 of the texel's unshaded irradiance.
    pub fn texel_irradiance(&self, path: KnownPath, texel: &TexelRect) -> f64 {
        let reflections = match path {
            KnownPath::Direct => 0,
            KnownPath::Reflected(count) => count,
            KnownPath::Through(_) => return 0.0,
        };
        let centre = 0.5 * (texel.min + texel.max);
        let reach = 0.5 * (texel.max - texel.min).length();
        let mut flux = 0.0;
        if reflections == 0 {
            flux += self.beside_the_cup(texel);
        }
        let tolerance = TOLERANCE * self.unshaded_irradiance() * texel.area();
        for (from, to) in self.pieces() {
            let cut = |u: f64| self.cut_out(u, reflections, texel);
            let near = |u: f64, half: f64| self.may_meet(u, half, reflections, centre, reach);
            for window in windows(from, to, &near) {
                let marks = |u: f64| self.marks(&self.line(u), reflections, texel);
                let kinks = sign_changes(window, parts_of(window, (from, to)), marks);
                flux += simpson_between(window, &kinks, tolerance, &cut);
            }
        }
        flux * math::powf(self.reflectance, f64::from(reflections)) / texel.area()
    }

    /// The irradiance [W/m²] of every texel of a grid, in the order of [`TexelGrid::map`].
    pub fn map(&self, path: KnownPath, grid: &TexelGrid) -> Vec<f64> {
        grid.map(|texel| self.texel_irradiance(path, texel))
    }

    /// The flux (W) onto the bottom after so many reflections, 0 for direct light inside the cup.
    pub fn bottom_flux(&self, reflections: u32) -> f64 {
        let sum = self.over_lines(|line| {
            self.leg(line, reflections).map_or(0.0, |stretch| {
                self.measure(stretch.to) - self.measure(stretch.from)
            })
        });
        sum * math::powf(self.reflectance, f64::from(reflections))
    }

    /// The flux (W) through the opening.
    pub fn entering_flux(&self) -> f64 {
        match self.light {
            CupLight::Parallel { .. } => {
                PI * self.radius * self.radius * self.unshaded_irradiance()
            }
            CupLight::Point { .. } => self.over_lines(|line| {
                let (from, to) = self.inside(line);
                self.measure(to) - self.measure(from)
            }),
        }
    }

    /// The caustic of k ≥ 1 reflections in parallel light, at the wall azimuth φ of the first: where
    /// neighbouring reflected lines cross. k = 1 is the nephroid
    /// R/4 (3 cos φ − cos 3φ, 3 sin φ − sin 3φ).
    pub fn parallel_caustic(radius: f64, reflections: u32, azimuth: f64) -> DVec2 {
        let k = f64::from(reflections.max(1));
        let turn = PI + 2.0 * azimuth;
        let hit = radius * rotation::direction(azimuth + (k - 1.0) * turn);
        hit + rotation::direction(k * turn)
            * (radius * math::cos(azimuth) * (2.0 * k - 1.0) / (2.0 * k))
    }

    /// The integral over all lines of what `flux` finds on each.
    fn over_lines(&self, flux: impl Fn(&CupRay) -> f64) -> f64 {
        let tolerance = 1e-13 * self.unshaded_irradiance() * self.radius * self.radius;
        let integrand = |u: f64| {
            let line = self.line(u);
            line.density * flux(&line)
        };
        // Near grazing each count of reflections has a narrow range of u of its own: look closely.
        self.pieces()
            .iter()
            .flat_map(|&(from, to)| windows(from, to, &|_, _| true))
            .map(|(a, b)| simpson(a, b, tolerance, &integrand))
            .sum()
    }

    /// On the bottom, were there no cup: at its middle, for a point light.
    fn unshaded_irradiance(&self) -> f64 {
        match self.light {
            CupLight::Parallel {
                tan_angle,
                irradiance,
            } => irradiance / math::hypot(1.0_f64, tan_angle),
            CupLight::Point {
                distance,
                height,
                intensity,
            } => intensity * height / math::powi(math::hypot(distance, height), 3),
        }
    }

    /// The ranges of u whose lines meet the circle (seen from above).
    fn pieces(&self) -> Vec<(f64, f64)> {
        match self.light {
            CupLight::Point { distance, .. } if distance < self.radius => {
                vec![(-PI, 0.0), (0.0, PI)]
            }
            _ => vec![(-FRAC_PI_2, 0.0), (0.0, FRAC_PI_2)],
        }
    }

    /// The line of u: u = φ for lights outside the circle (seen from above), else the azimuth ψ at the light.
    fn line(&self, u: f64) -> CupRay {
        let radius = self.radius;
        match self.light {
            CupLight::Parallel { .. } => CupRay {
                start: radius * DVec2::new(-math::cos(u), math::sin(u)),
                azimuth: 0.0,
                incidence: u,
                enter: 0.0,
                hit: 2.0 * radius * math::cos(u),
                density: radius * math::cos(u),
            },
            CupLight::Point { distance, .. } => {
                let (azimuth, incidence, density) = if distance <= radius {
                    (u, math::asin(distance / radius * math::sin(u)), 1.0)
                } else {
                    let azimuth = math::asin(radius / distance * math::sin(u));
                    (
                        azimuth,
                        u,
                        radius / distance * math::cos(u) / math::cos(azimuth),
                    )
                };
                let (middle, half) = (distance * math::cos(azimuth), radius * math::cos(incidence));
                CupRay {
                    start: DVec2::new(-distance, 0.0),
                    azimuth,
                    incidence,
                    enter: (middle - half).max(0.0),
                    hit: (middle + half).max(0.0),
                    density,
                }
            }
        }
    }

    /// The range of t in which a line's light has come through the opening.
    fn inside(&self, line: &CupRay) -> (f64, f64) {
        match self.light {
            CupLight::Parallel { tan_angle, .. } => {
                let shift = self.height * tan_angle;
                (line.enter + shift, line.hit + shift)
            }
            CupLight::Point { height, .. } => {
                let factor = height / (height - self.height);
                (line.enter * factor, line.hit * factor)
            }
        }
    }

    /// A line after so many reflections, unfolded: its point at t = 0, its azimuth, and the lengths t of the
    /// last hit and of the next.
    fn unfolded(&self, line: &CupRay, reflections: u32) -> (DVec2, f64, f64, f64) {
        if reflections == 0 {
            return (line.start, line.azimuth, 0.0, line.hit);
        }
        let chord = 2.0 * self.radius * math::cos(line.incidence);
        let k = f64::from(reflections);
        let turn = PI + 2.0 * line.incidence;
        let hit = line.hit + (k - 1.0) * chord;
        let wall =
            self.radius * rotation::direction(line.azimuth + line.incidence + (k - 1.0) * turn);
        let azimuth = line.azimuth + k * turn;
        (
            wall - rotation::direction(azimuth) * hit,
            azimuth,
            hit,
            hit + chord,
        )
    }

    /// The stretch on which a line's light lands after so many reflections.
    fn leg(&self, line: &CupRay, reflections: u32) -> Option<Stretch> {
        let (origin, azimuth, start, end) = self.unfolded(line, reflections);
        let (from, to) = self.inside(line);
        let (from, to) = (from.max(start), to.min(end));
        (from < to).then(|| Stretch {
            origin,
            direction: rotation::direction(azimuth),
            from,
            to,
        })
    }

    /// M(t), whose difference is the flux between two t of a line of density 1.
    fn measure(&self, t: f64) -> f64 {
        match self.light {
            CupLight::Parallel { .. } => self.unshaded_irradiance() * t,
            CupLight::Point {
                height, intensity, ..
            } => {
                // 1 − h/√(h² + t²), written so that nothing cancels for small t.
                if t == f64::INFINITY {
                    return intensity;
                }
                let distance = math::hypot(height, t);
                intensity * (t / distance) * (t / (distance + height))
            }
        }
    }

    /// The flux density in u that the texel cuts out of line u.
    fn cut_out(&self, u: f64, reflections: u32, texel: &TexelRect) -> f64 {
        let line = self.line(u);
        let flux = |stretch: &Stretch| {
            stretch
                .clipped(texel)
                .map_or(0.0, |(from, to)| self.measure(to) - self.measure(from))
        };
        let mut sum = self
            .leg(&line, reflections)
            .map_or(0.0, |stretch| flux(&stretch));
        if reflections == 0 {
            let (_, over) = self.inside(&line);
            // In front of the cup, and over it.
            let ends = match self.light {
                CupLight::Parallel { .. } => {
                    [(f64::NEG_INFINITY, line.enter), (over, f64::INFINITY)]
                }
                CupLight::Point { .. } => [(0.0, line.enter), (over.max(line.hit), f64::INFINITY)],
            };
            for (from, to) in ends {
                if from < to {
                    let direction = rotation::direction(line.azimuth);
                    sum += flux(&Stretch {
                        origin: line.start,
                        direction,
                        from,
                        to,
                    });
                }
            }
        }
        sum * line.density
    }

    /// Direct flux along lines that do not meet the circle.
    fn beside_the_cup(&self, texel: &TexelRect) -> f64 {
        match self.light {
            CupLight::Parallel { .. } => {
                let above = (texel.max.y - texel.min.y.max(self.radius)).max(0.0);
                let below = (texel.max.y.min(-self.radius) - texel.min.y).max(0.0);
                (above + below) * (texel.max.x - texel.min.x) * self.unshaded_irradiance()
            }
            CupLight::Point { distance, .. } if distance < self.radius => 0.0,
            CupLight::Point { distance, .. } => {
                let origin = DVec2::new(-distance, 0.0);
                let widest = math::asin(self.radius / distance);
                let centre = 0.5 * (texel.min + texel.max);
                let reach = 0.5 * (texel.max - texel.min).length();
                let to_centre = centre - origin;
                let cut = |u: f64| {
                    let stretch = Stretch {
                        origin,
                        direction: rotation::direction(u),
                        from: 0.0,
                        to: f64::INFINITY,
                    };
                    stretch
                        .clipped(texel)
                        .map_or(0.0, |(from, to)| self.measure(to) - self.measure(from))
                };
                let near = |u: f64, half: f64| {
                    to_centre.perp_dot(rotation::direction(u)).abs()
                        <= reach + half * to_centre.length()
                };
                let tolerance = TOLERANCE * self.unshaded_irradiance() * texel.area();
                let passed = |u: f64| {
                    let direction = rotation::direction(u);
                    texel.corners().map(|it| direction.perp_dot(it - origin))
                };
                let mut flux = 0.0;
                for (from, to) in [(widest, PI), (-PI, -widest)] {
                    for window in windows(from, to, &near) {
                        let kinks = sign_changes(window, parts_of(window, (from, to)), passed);
                        flux += simpson_between(window, &kinks, tolerance, &cut);
                    }
                }
                flux
            }
        }
    }

    /// True if a line within `half` of u may come within `reach` of `centre`, by a bound on the rate at which
    /// their distance changes with u.
    fn may_meet(&self, u: f64, half: f64, reflections: u32, centre: DVec2, reach: f64) -> bool {
        let line = self.line(u);
        let k = f64::from(reflections);
        let azimuth = line.azimuth + k * (PI + 2.0 * line.incidence);
        // The line passes the cup's axis at R sin φ, with the sign that each reflection keeps.
        let distance =
            centre.perp_dot(rotation::direction(azimuth)) + self.radius * math::sin(line.incidence);
        // |dβ₀/du| and |dφ/du| are at most 1 for all three kinds of light (asin(q sin u) has slope below 1
        // for q ≤ 1), so the line turns by at most 1 + 2k per unit of u and R sin φ changes by at most R.
        let rate = centre.length() * (1.0 + 2.0 * k) + self.radius;
        distance.abs() <= reach + rate * half
    }
}

/// Relative to the texel's unshaded irradiance.
const TOLERANCE: f64 = 1e-8;

mod kinks;
#[cfg(test)]
mod tests;
