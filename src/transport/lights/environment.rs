//! Lights all round, infinitely far away.

use std::f64::consts::{PI, TAU};

use glam::{DVec2, DVec3};

use super::sample::LightSample;
use crate::numeric::WeightedChoice;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::scene::{Daylight, Emitter, Envmap, EnvmapCell, SunDisc, luminance};

/// An environment: it looks the same from every point.
#[derive(Clone, Debug)]
pub(in crate::transport) enum Environment<'a> {
    /// The same radiance [W/m²/sr] from everywhere; directions are uniform.
    Constant(Rgb),
    /// An image.
    Image(ImageLight<'a>),
    /// A sky, and the sun in it.
    Daylight(ImageLight<'a>, &'a SunDisc),
}

impl<'a> Environment<'a> {
    /// An emitter as an environment whose poles are seen; `None` for other emitters.
    pub(in crate::transport) fn of(emitter: &'a Emitter) -> Option<Self> {
        match emitter {
            Emitter::Constant { radiance } => Some(Self::Constant(*radiance)),
            Emitter::Envmap(map) => Some(Self::Image(ImageLight::new(map, Poles::Seen))),
            Emitter::Sunsky(daylight) => Some(Self::daylight(daylight)),
            _ => None,
        }
    }

    /// An image, ready to be sampled as Mitsuba does.
    pub(super) fn image(map: &'a Envmap) -> Self {
        Self::Image(ImageLight::new(map, Poles::Dark))
    }

    /// A sky, with its sun if it shines.
    pub(super) fn daylight(daylight: &'a Daylight) -> Self {
        let sky = ImageLight::new(&daylight.sky, Poles::Seen);
        match &daylight.sun {
            Some(sun) => Self::Daylight(sky, sun),
            None => Self::Image(sky),
        }
    }

    /// True if radiance is the same from everywhere.
    pub(in crate::transport) fn is_even(&self) -> bool {
        matches!(self, Self::Constant(_))
    }

    /// Radiance [W/m²/sr] from a direction.
    pub(in crate::transport) fn radiance(&self, direction: DVec3) -> Rgb {
        match self {
            Self::Constant(radiance) => *radiance,
            Self::Image(light) => light.map.radiance(direction),
            Self::Daylight(sky, sun) => sky.map.radiance(direction) + sun.radiance(direction),
        }
    }

    /// Radiance [W/m²/sr] from a direction, and its density [1/sr] in [`Self::sample`].
    pub(in crate::transport) fn radiance_and_pdf(&self, direction: DVec3) -> (Rgb, f64) {
        match self {
            Self::Constant(radiance) => (*radiance, 1.0 / (4.0 * PI)),
            Self::Image(light) => light.radiance_and_pdf(direction),
            Self::Daylight(sky, sun) => {
                let (of_the_sky, pdf) = sky.radiance_and_pdf(direction);
                let share = sun_share(sky);
                let of_sun = if sun.contains(direction) {
                    1.0 / sun.solid_angle()
                } else {
                    0.0
                };
                let pdf = share * of_sun + (1.0 - share) * pdf;
                (of_the_sky + sun.radiance(direction), pdf)
            }
        }
    }

    /// A direction; `None` if all is black.
    pub(in crate::transport) fn sample(&self, u: [f64; 2]) -> Option<LightSample> {
        let (direction, pdf_solid_angle, radiance) = match self {
            Self::Constant(radiance) => (uniform(u), 1.0 / (4.0 * PI), *radiance),
            Self::Image(light) => light.sample(u)?,
            Self::Daylight(sky, sun) => {
                let share = sun_share(sky);
                let direction = if u[0] < share {
                    sun.direction([u[0] / share, u[1]])
                } else {
                    sky.sample([(u[0] - share) / (1.0 - share), u[1]])?.0
                };
                let (radiance, pdf) = self.radiance_and_pdf(direction);
                (direction, pdf, radiance)
            }
        };
        Some(LightSample {
            direction,
            distance: f64::INFINITY,
            reach: f64::INFINITY,
            radiance_over_pdf: radiance / pdf_solid_angle,
            pdf_solid_angle,
            is_delta: false,
            emitter: 0,
        })
    }
}

/// The share of directions that are chosen for the sun: half, or all if the sky is black.
fn sun_share(sky: &ImageLight) -> f64 {
    if sky.rows.is_some() && sky.map.scale() > 0.0 {
        0.5
    } else {
        1.0
    }
}

/// A direction, all of them as likely as each other.
fn uniform(u: [f64; 2]) -> DVec3 {
    let (sin_phi, cos_phi) = math::sin_cos(TAU * u[1]);
    let height = 1.0 - 2.0 * u[0];
    let radius = 2.0 * (u[0] * (1.0 - u[0])).sqrt();
    DVec3::new(radius * cos_phi, radius * sin_phi, height).normalize()
}

/// The weight of an image's first and last row, whose centers are poles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Poles {
    /// None, as in Mitsuba.
    Dark,
    /// That of their neighbourhood: sin θ a quarter of a row from them, the mean of their half of a cell.
    Seen,
}

/// An image, and the choice of its directions.
///
/// As in Mitsuba 3.9.1, the density over column and row is bilinear between the weights w = luminance · sin θ
/// of texels. In solid angle, with the mean of w over all columns and rows, it is
///
/// ```text
/// pdf = w / (mean(w) 2π² sin θ)
/// ```
///
/// The rows at the poles have no weight there. So a pole that is bright beside a dark row has light at which
/// the density is zero: the other sampling of directions must find it, and seldom does. [`Poles::Seen`] gives
/// these rows a weight.
#[derive(Clone, Debug)]
pub(in crate::transport) struct ImageLight<'a> {
    map: &'a Envmap,
    /// sin θ of each row's center; of both poles as [`Poles`] says.
    sines: Vec<f64>,
    /// Rows of cells by weight; `None` if all is black.
    rows: Option<WeightedChoice>,
    /// The cells of each row, by weight.
    columns: Vec<Option<WeightedChoice>>,
    mean_weight: f64,
}

impl<'a> ImageLight<'a> {
    pub(super) fn new(map: &'a Envmap, poles: Poles) -> Self {
        let (width, height) = (map.image().width(), map.image().height());
        let last = height - 1;
        let at_poles = match poles {
            Poles::Dark => 0.0,
            Poles::Seen => math::sin(0.25 * PI / last as f64),
        };
        let sines: Vec<f64> = (0..height)
            .map(|row| {
                if row == 0 || row == last {
                    at_poles
                } else {
                    math::sin(PI * row as f64 / last as f64)
                }
            })
            .collect();
        let mut light = Self {
            map,
            sines,
            rows: None,
            columns: Vec::with_capacity(last),
            mean_weight: 0.0,
        };
        for row in 0..last {
            // A cell's integral of a bilinear weight is that of its middle.
            let middle = |column: usize| {
                let at = DVec2::new(column as f64 + 0.5, row as f64 + 0.5);
                light.weight(&map.cell(at))
            };
            let columns = WeightedChoice::new((0..width).map(middle));
            light.columns.push(columns);
        }
        let of_row = |row: &Option<WeightedChoice>| row.as_ref().map_or(0.0, WeightedChoice::total);
        light.rows = WeightedChoice::new(light.columns.iter().map(of_row));
        let total = light.rows.as_ref().map_or(0.0, WeightedChoice::total);
        light.mean_weight = total / (width * last) as f64;
        light
    }

    /// Luminance of a texel, as stored in the image, times the sine of its row.
    fn texel_weight(&self, column: usize, row: usize) -> f64 {
        luminance(Rgb(self.map.image().texel(column, row))) * self.sines[row]
    }

    /// The weight at a place.
    fn weight(&self, cell: &EnvmapCell) -> f64 {
        cell.blend(|column, row| self.texel_weight(column, row))
    }

    fn radiance_and_pdf(&self, direction: DVec3) -> (Rgb, f64) {
        let (coordinates, sin) = self.map.coordinates(direction);
        let cell = self.map.cell(coordinates);
        let pdf = self.pdf(self.weight(&cell), sin);
        (self.map.radiance_in(direction, &cell), pdf)
    }

    /// The density [1/sr] where the weight and the sine of the angle to the poles are these.
    fn pdf(&self, weight: f64, sin: f64) -> f64 {
        let pdf = weight / (self.mean_weight * 2.0 * PI * PI * sin);
        // At a pole, and if all is black, this is 0 / 0.
        if pdf.is_finite() { pdf } else { 0.0 }
    }

    /// A direction, its density and radiance.
    fn sample(&self, u: [f64; 2]) -> Option<(DVec3, f64, Rgb)> {
        let row = self.rows.as_ref()?.choose(u[1]);
        let column = self.columns[row.index].as_ref()?.choose(u[0]);
        let corner = DVec2::new(column.index as f64, row.index as f64);
        let cell = self.map.cell(corner);
        let [[a, b], [c, d]] = cell
            .rows
            .map(|row| cell.columns.map(|column| self.texel_weight(column, row)));
        // First down, by the joint weight of both sides, then across, by the weight at that height.
        let down = linear(a + b, c + d, row.rest);
        let across = linear(a + (c - a) * down, b + (d - b) * down, column.rest);
        let coordinates = corner + DVec2::new(across, down);
        let (direction, sin) = self.map.direction(coordinates);
        let along = |left: f64, right: f64| left * (1.0 - across) + right * across;
        let pdf = self.pdf(along(a, b) * (1.0 - down) + along(c, d) * down, sin);
        (pdf > 0.0).then(|| (direction, pdf, self.map.at(coordinates)))
    }
}

/// A number in 0..=1 whose density is proportional to a line from `a` at 0 to `b` at 1, made from a uniform
/// one.
///
/// It is the root of (a t + (b − a) t² / 2) / ((a + b) / 2) = u, written without cancellation.
fn linear(a: f64, b: f64, u: f64) -> f64 {
    let root = (a * a + u * (b * b - a * a)).max(0.0).sqrt();
    let t = u * (a + b) / (a + root);
    // This is 0 / 0 at the start of a line from 0.
    if t.is_finite() { t.min(1.0) } else { 0.0 }
}
