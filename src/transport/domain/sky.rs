//! Light from all round, as far as it meets a ball about the specular geometry.
//!
//! A direction takes two dimensions, its start two more: a place on the ball's disc across the direction,
//! before all geometry. With ω the directions, A = π r² the disc and L the radiance, the flux is
//!
//! ```text
//! Φ = ∫ L(−ω) A dω
//! ```

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::patch::{ChartPatch, Emission};
use super::probe::Probe;
use super::surface::Area;
use crate::geometry::{Bounds, Ray};
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::scene::{Emitter, Envmap, SunDisc};

/// Light from all round that meets a ball.
#[derive(Clone, Debug)]
pub struct Sky {
    radiance: SkyRadiance,
    /// The ball's middle.
    center: DVec3,
    /// Its radius \[m\].
    radius: f64,
    /// From the middle back to where light starts \[m\].
    distance: f64,
}

/// What comes from a direction.
#[derive(Clone, Debug)]
enum SkyRadiance {
    /// The same from everywhere. Coordinates are the azimuth, by a full turn, and the height on a unit ball:
    /// by Archimedes, equal areas have equal solid angles.
    Even(Rgb),
    /// An image. Coordinates are its columns and rows ([`Envmap`]).
    Image(Envmap),
    /// A disc. Coordinates are the two numbers of [`SunDisc::direction`], in 0..=1.
    Disc(SunDisc),
}

impl Sky {
    /// The light of an environment that meets a ball (its middle and radius), that of a sky and of the sun in
    /// it apart; none for other emitters. It starts outside of `scene`.
    pub fn parts(
        emitter: &Emitter,
        (center, radius): (DVec3, f64),
        scene: &Bounds,
    ) -> impl Iterator<Item = Self> + use<> {
        let radiances = match emitter {
            Emitter::Constant { radiance } => [Some(SkyRadiance::Even(*radiance)), None],
            Emitter::Envmap(map) => [Some(SkyRadiance::Image(map.clone())), None],
            Emitter::Sunsky(daylight) => [
                Some(SkyRadiance::Image(daylight.sky.clone())),
                daylight.sun.clone().map(SkyRadiance::Disc),
            ],
            _ => [None, None],
        };
        // A hair more, so that rounding loses nothing.
        let radius = radius * (1.0 + 1e-9);
        let distance = (center.distance(scene.center()) + scene.radius()) * 1.01;
        radiances.into_iter().flatten().map(move |radiance| Self {
            radiance,
            center,
            radius,
            distance,
        })
    }

    /// The patch of all directions.
    pub(super) fn root(&self) -> ChartPatch {
        let (from, to) = match &self.radiance {
            SkyRadiance::Even(_) => (DVec2::new(0.0, -1.0), DVec2::ONE),
            SkyRadiance::Image(map) => {
                let (width, height) = (map.image().width(), map.image().height());
                (DVec2::ZERO, DVec2::new(width as f64, (height - 1) as f64))
            }
            SkyRadiance::Disc(_) => (DVec2::ZERO, DVec2::ONE),
        };
        ChartPatch { from, to }
    }

    /// Radiance [W/m²/sr]; 1 of images and discs, whose light has its own colour.
    pub(super) fn strength(&self) -> Rgb {
        match self.radiance {
            SkyRadiance::Even(radiance) => radiance,
            SkyRadiance::Image(_) | SkyRadiance::Disc(_) => Rgb::WHITE,
        }
    }

    /// True if a patch is more than a texel of an image, which may hold a sun beside the night.
    pub(super) fn is_uneven(&self, patch: &ChartPatch) -> bool {
        let is_image = matches!(self.radiance, SkyRadiance::Image(_));
        is_image && (patch.to - patch.from).max_element() > 1.0
    }

    /// All of space: any direction's light meets the ball.
    pub(super) fn probe(&self) -> Probe {
        Probe::Cone {
            apex: self.center,
            axis: DVec3::Z,
            half_angle: PI,
            apex_radius: self.distance,
        }
    }

    /// The disc's area [m²] by the solid angle [sr] of a patch, and a bound of its radiance.
    pub(super) fn flux_bound(&self, patch: &ChartPatch) -> Rgb {
        let disc = self.disc_area();
        match &self.radiance {
            SkyRadiance::Even(radiance) => *radiance * (disc * TAU * patch.area()),
            SkyRadiance::Image(map) => {
                let (width, rows) = (map.image().width(), map.image().height() - 1);
                let theta = |row: f64| PI * row / rows as f64;
                let (from, to) = (theta(patch.from.y), theta(patch.to.y));
                // cos a − cos b without cancellation.
                let belt = 2.0 * math::sin(0.5 * (from + to)) * math::sin(0.5 * (to - from));
                let turn = TAU * (patch.to.x - patch.from.x) / width as f64;
                brightest(map, patch) * (disc * turn * belt)
            }
            SkyRadiance::Disc(sun) => sun.peak() * (disc * sun.solid_angle() * patch.area()),
        }
    }

    /// The ray of a place on the chart that starts at `start` of the disc, for a patch of chart area `area`.
    #[inline]
    pub(super) fn emit(&self, place: DVec2, area: f64, start: DVec2) -> Emission {
        let (from, solid_angle, color) = match &self.radiance {
            SkyRadiance::Even(_) => {
                let (sin, cos) = math::sin_cos(TAU * place.x);
                let out = (1.0 - place.y * place.y).max(0.0).sqrt();
                let from = DVec3::new(out * cos, out * sin, place.y).normalize();
                (from, TAU, None)
            }
            SkyRadiance::Image(map) => {
                let (width, rows) = (map.image().width(), map.image().height() - 1);
                let (from, sin) = map.direction(place);
                let texel = TAU / width as f64 * (PI / rows as f64);
                (from, texel * sin, Some(map.at(place)))
            }
            SkyRadiance::Disc(sun) => {
                let from = sun.direction([place.x, place.y]);
                (from, sun.solid_angle(), Some(sun.radiance(from)))
            }
        };
        let (x, y) = from.any_orthonormal_pair();
        let disc = Area::Disk {
            center: self.center + from * self.distance,
            axes: [x * self.radius, y * self.radius],
        };
        Emission {
            ray: Ray::new(disc.point(start), -from),
            measure: solid_angle * self.disc_area() * area,
            color,
        }
    }

    /// Area [m²] of the disc that the ball shows to a direction.
    fn disc_area(&self) -> f64 {
        PI * self.radius * self.radius
    }
}

/// At least the radiance [W/m²/sr] in a patch of an image, channel by channel.
fn brightest(map: &Envmap, patch: &ChartPatch) -> Rgb {
    let width = map.image().width();
    let first = map.cell(patch.from);
    let last = |to: f64, from: usize| (to.ceil() as usize).max(from + 1);
    let end = last(patch.to.y, first.rows[0]).min(map.image().height() - 1);
    let mut most = Rgb::BLACK;
    for row in first.rows[0]..=end {
        for column in first.columns[0]..=last(patch.to.x, first.columns[0]) {
            let texel = map.image().texel(column % width, row);
            most = Rgb(std::array::from_fn(|c| most.0[c].max(texel[c])));
        }
    }
    map.bound(most)
}
