//! Lookups of one photon map at the points that every pixel sees.
//!
//! Let x be a visible point and r a radius. The irradiance is estimated as the flux of the photons within r,
//! divided by the disc's area (Jensen 1996, *Global Illumination using Photon Maps*). So a pixel gains
//!
//! ```text
//! L = w Σ f(ωi, ωo) Φ / (π r²)        over the photons with |x − y| ≤ r
//! ```
//!
//! with w the weight of the chain and of its film point. The same sum is made with √2 r beside it: their
//! difference tells the bias.

use glam::DVec2;
use rayon::prelude::*;

use super::map::PhotonMap;
use super::setup::Setup;
use super::view::{VisiblePoint, follow};
use crate::film::Accumulator;
use crate::geometry::TraversalCounters;
use crate::numeric::{FixedPoint, Stream};
use crate::transport::camera::Camera;

/// The films that lookups are added to: one a layer, and one for its change with √2 times the radius.
#[derive(Debug)]
pub struct Films {
    pub values: Vec<Accumulator>,
    pub differences: Vec<Accumulator>,
}

/// Number of pixels between two questions whether to stop.
const ASK_EVERY: usize = 64;

/// The result of a pass of lookups.
#[derive(Clone, Copy, Debug, Default)]
pub struct Gathered {
    pub counters: TraversalCounters,
    /// Number of contributions that the film cannot hold.
    pub refused: u64,
}

/// One pass over all pixels.
pub struct Pass<'a> {
    pub setup: &'a Setup<'a>,
    pub camera: &'a Camera,
    pub map: &'a PhotonMap,
    /// The stream of the replicate.
    pub stream: Stream,
    /// The number of the pass, from 0.
    pub number: u64,
    /// The radius in pixels, squared.
    pub radius_squared: f64,
    /// The étendue divided by the number of passes over which the sum is averaged.
    pub factor: f64,
}

impl Pass<'_> {
    /// Adds every pixel's lookup to the films. After `stop` asked for an end some are missing.
    pub fn gather(
        &self,
        films: &Films,
        scale: FixedPoint,
        stop: &(dyn Fn() -> bool + Sync),
    ) -> Gathered {
        let rows: Vec<Gathered> = (0..self.camera.height())
            .into_par_iter()
            .map(|row| {
                let mut done = Gathered::default();
                for column in 0..self.camera.width() {
                    if column % ASK_EVERY == 0 && stop() {
                        break;
                    }
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
        let ([x, y], lens) = if self.camera.has_aperture() {
            let [x, y, u, v] = stream.point4(self.number);
            ([x, y], DVec2::new(u, v))
        } else {
            (stream.point2(self.number), DVec2::splat(0.5))
        };
        let (at, weight) = match self.setup.target.filter() {
            Some(filter) => filter.choose([column, row], [x, y]),
            None => (DVec2::new(column as f64 + x, row as f64 + y), 1.0),
        };
        if weight == 0.0 {
            return;
        }
        let settings = &self.setup.settings;
        let mut refused = 0;
        follow(
            self.setup.scene,
            self.camera,
            [at, lens],
            settings.photons.chains.max_depth,
            stream.extras(self.number),
            &mut done.counters,
            |seen, _| {
                if settings.seen.includes(seen.by_specular) {
                    refused += self.look_up(seen, pixel, weight, films, scale);
                }
            },
        );
        done.refused += refused;
    }

    /// Adds the light of the photons around one point, times `weight`, and returns how many contributions the
    /// film cannot hold.
    fn look_up(
        &self,
        seen: &VisiblePoint,
        pixel: usize,
        weight: f64,
        films: &Films,
        scale: FixedPoint,
    ) -> u64 {
        let radius_squared = self.radius_squared * seen.pixel_size * seen.pixel_size;
        let by_area = self.factor * weight / (std::f64::consts::PI * radius_squared);
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
