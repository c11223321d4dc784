//! Looking up one photon map at what every pixel sees.
//!
//! At a visible point x with radius r the irradiance is estimated as the flux of the photons within r by the
//! disc's area (Jensen 1996, *Global Illumination using Photon Maps*), so that a pixel gains
//!
//! ```text
//! L = w Σ f(ωi, ωo) Φ / (π r²)        over the photons with |x − y| ≤ r
//! ```
//!
//! with w the chain's weight. The same sum with √2 r is made beside it: their difference tells the bias.

use rayon::prelude::*;

use super::map::PhotonMap;
use super::setup::Setup;
use super::view::{VisiblePoint, follow};
use crate::film::Accumulator;
use crate::geometry::TraversalCounters;
use crate::numeric::{FixedPoint, Stream};
use crate::transport::camera::Camera;

/// The films that lookups are added to: a layer each, and what √2 times the radius changes of it.
pub struct Films {
    pub values: Vec<Accumulator>,
    pub differences: Vec<Accumulator>,
}

/// What a pass of lookups did.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gathered {
    pub counters: TraversalCounters,
    /// Contributions that the film cannot hold.
    pub refused: u64,
}

/// One pass over all pixels.
pub struct Pass<'a> {
    pub setup: &'a Setup<'a>,
    pub camera: &'a Camera,
    pub map: &'a PhotonMap,
    /// Of the replicate.
    pub stream: Stream,
    /// Its number, from 0.
    pub number: u64,
    /// The radius in pixels, squared.
    pub radius_squared: f64,
    /// The étendue by one over the number of passes that the sum is divided by.
    pub factor: f64,
}

impl Pass<'_> {
    /// Adds every pixel's lookup to the films.
    pub fn gather(&self, films: &Films, scale: FixedPoint) -> Gathered {
        let rows: Vec<Gathered> = (0..self.camera.height())
            .into_par_iter()
            .map(|row| {
                let mut done = Gathered::default();
                for column in 0..self.camera.width() {
                    self.pixel(column, row, films, scale, &mut done);
                }
                done
            })
            .collect();
        rows.into_iter().fold(Gathered::default(), |mut sum, row| {
            sum.counters += row.counters;
            sum.refused += row.refused;
            sum
        })
    }

    fn pixel(
        &self,
        column: usize,
        row: usize,
        films: &Films,
        scale: FixedPoint,
        done: &mut Gathered,
    ) {
        let pixel = row * self.camera.width() + column;
        let stream = self.stream.split(pixel as u64);
        let [x, y] = stream.point2(self.number);
        let at = glam::DVec2::new(column as f64 + x, row as f64 + y);
        let settings = &self.setup.settings;
        let mut refused = 0;
        follow(
            self.setup.scene,
            self.camera,
            at,
            settings.photons.chains.max_depth,
            stream.extras(self.number),
            &mut done.counters,
            |seen, _| {
                if settings.seen.includes(seen.by_specular) {
                    refused += self.look_up(seen, pixel, films, scale);
                }
            },
        );
        done.refused += refused;
    }

    /// Adds what the photons about one point make of it; how many of them the film cannot hold.
    fn look_up(&self, seen: &VisiblePoint, pixel: usize, films: &Films, scale: FixedPoint) -> u64 {
        let radius_squared = self.radius_squared * seen.pixel_size * seen.pixel_size;
        let by_area = self.factor / (std::f64::consts::PI * radius_squared);
        if !by_area.is_finite() {
            // The camera touches the surface.
            return 1;
        }
        let shading_normals = self.setup.settings.photons.chains.shading_normals;
        let mut refused = 0;
        self.map.within(
            seen.point.position,
            2.0 * radius_squared,
            |photon, squared| {
                if photon.shape != seen.shape {
                    return;
                }
                let radiance = seen.radiance(photon.direction, shading_normals);
                if radiance.is_black() {
                    return;
                }
                let whole = seen.weight * radiance * photon.flux * by_area;
                let layer = photon.layer as usize + self.setup.first_layer(seen.by_specular);
                let mut add = |film: &Accumulator, share: f64| {
                    let quanta = whole.0.map(|channel| scale.quantise(channel * share));
                    let [Some(red), Some(green), Some(blue)] = quanta else {
                        refused += 1;
                        return;
                    };
                    refused += u64::from(!film.deposit(pixel, [red, green, blue]));
                };
                if squared <= radius_squared {
                    add(&films.values[layer], 1.0);
                    add(&films.differences[layer], -0.5);
                } else {
                    add(&films.differences[layer], 0.5);
                }
            },
        );
        refused
    }
}
