//! Accuracy of light that is round about an axis.

use glam::DVec2;
use rayon::prelude::*;

use super::plane::FilmGrid;
use crate::reference::closed_form::{RadialSheet, TexelRect};

/// Error of a texel as a part of its value: Gauss's rule, the inverse of the radial map, and an axis that is
/// off by 1e-13 of the scene's size, some 1e-11 of a texel's width on films of 512 texels.
const OF_VALUE: f64 = 1e-10;

/// Error of a texel as a part of the flux of all circles that meet it.
///
/// The fraction of a circle is a difference of two angles, each rounded to some 1e-16 of a turn; 1e-12 is
/// what [`RadialSheet`] states with the quadrature's error, and four times that takes in the place of the
/// axis.
const OF_RING: f64 = 4e-12;

/// Flux of one sheet within each of many radii.
struct RingFlux {
    step: f64,
    /// Flux within a radius of `step` times the index.
    within: Vec<f64>,
}

impl RingFlux {
    fn new(sheet: &RadialSheet, film: &FilmGrid) -> Self {
        let bounds = film.grid.bounds;
        let farthest = bounds.min.abs().max(bounds.max.abs()).length();
        let count = 2 * film.grid.columns.max(film.grid.rows) + 2;
        let step = farthest / (count - 2) as f64;
        let within = (0..=count)
            .into_par_iter()
            .map(|index| sheet.disc_flux(step * index as f64))
            .collect();
        Self { step, within }
    }

    /// Flux of the circles that meet a texel; up to two steps more on either side.
    fn meeting(&self, texel: &TexelRect) -> f64 {
        let nearest = DVec2::ZERO.clamp(texel.min, texel.max).length();
        let farthest = texel.min.abs().max(texel.max.abs()).length();
        let last = self.within.len() - 1;
        let from = ((nearest / self.step).floor() as usize).saturating_sub(1);
        let to = ((farthest / self.step).ceil() as usize + 1).min(last);
        (self.within[to] - self.within[from.min(last)]).max(0.0)
    }
}

/// The texels' irradiance from round sheets about the origin, and its accuracy, both in the film's order.
pub(super) fn radial_maps(sheets: &[RadialSheet], film: &FilmGrid) -> (Vec<f64>, Vec<f64>) {
    let texels = film.grid.columns * film.grid.rows;
    let (mut values, mut accuracy) = (vec![0.0; texels], vec![0.0; texels]);
    for sheet in sheets {
        let rings = RingFlux::new(sheet, film);
        let map = sheet.map(&film.grid);
        let errors = film
            .grid
            .map(|texel| OF_RING * rings.meeting(texel) / texel.area());
        for texel in 0..texels {
            values[texel] += map[texel];
            accuracy[texel] += OF_VALUE * map[texel] + errors[texel];
        }
    }
    (film.in_film_order(&values), film.in_film_order(&accuracy))
}
