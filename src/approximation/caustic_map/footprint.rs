//! Stage `splat`, exact: beams between the corners of the light view's pixels, dealt out to texels by area.
//!
//! Where the corners of a pixel are light of one topology, their landings span two triangles (either way, and
//! both are taken, by half), over which its flux is dealt out. Where they are not, the pixel is divided,
//! `border-levels` times; of what is left then, each corner puts a quarter into its texel.

use glam::DVec2;
use rayon::prelude::*;

use super::hit::Canvas;
use super::trace::Tracer;
use super::work::Work;
use crate::approximation::ExactFilm;
use crate::radiometry::Rgb;

/// Work of the four stages that a beam's corners and image take.
#[derive(Clone, Copy, Debug, Default)]
pub struct BeamWork {
    /// Stage `view`.
    pub view: Work,
    /// Stage `refraction`.
    pub refraction: Work,
    /// Stage `hit`.
    pub hit: Work,
    /// Stage `splat`.
    pub splat: Work,
}

impl BeamWork {
    fn add(mut self, other: Self) -> Self {
        self.view += other.view;
        self.refraction += other.refraction;
        self.hit += other.hit;
        self.splat += other.splat;
        self
    }
}

/// A corner's light on the canvas.
#[derive(Clone, Copy)]
struct Corner {
    at: DVec2,
    /// What is left of a unit of flux.
    weight: Rgb,
    topology: u64,
}

struct Beams<'a> {
    tracer: &'a Tracer<'a>,
    canvas: &'a Canvas<'a>,
    film: &'a ExactFilm,
}

/// Rows of pixels that share their lines of corners, as one task.
const ROWS: usize = 8;

/// Traces the corners of all pixels, their lattice shifted by `shift` pixels, and deals the beams out on a
/// film.
pub fn deal_beams(tracer: &Tracer, canvas: &Canvas, shift: DVec2, film: &ExactFilm) -> BeamWork {
    let beams = Beams {
        tracer,
        canvas,
        film,
    };
    let side = tracer.view.side();
    let trace_row = |row: usize| {
        let mut work = BeamWork::default();
        let corners: Vec<Option<Corner>> = (0..=side)
            .map(|column| {
                let at = DVec2::new(column as f64, row as f64) + shift;
                beams.corner(at, &mut work)
            })
            .collect();
        (corners, work)
    };
    (0..side.div_ceil(ROWS))
        .into_par_iter()
        .map(|task| {
            let first = task * ROWS;
            let last = (first + ROWS).min(side);
            let (mut above, mut work) = trace_row(first);
            for row in first..last {
                let (below, done) = trace_row(row + 1);
                work = work.add(done);
                for column in 0..side {
                    let low = DVec2::new(column as f64, row as f64) + shift;
                    let corners = [
                        above[column],
                        above[column + 1],
                        below[column],
                        below[column + 1],
                    ];
                    let levels = tracer.settings.border_levels;
                    beams.pixel(low, 1.0, corners, levels, &mut work);
                }
                above = below;
            }
            work
        })
        .reduce(BeamWork::default, BeamWork::add)
}

impl Beams<'_> {
    fn corner(&self, at: DVec2, work: &mut BeamWork) -> Option<Corner> {
        let front = self.tracer.front(at, &mut work.view)?;
        let exit = self.tracer.exit(at, &front, &mut work.refraction)?;
        let landing = self.tracer.landing(&exit, self.canvas, &mut work.hit)?;
        Some(Corner {
            at: landing.at,
            weight: exit.throughput * landing.weight,
            topology: exit.topology ^ landing.surface.rotate_left(17),
        })
    }

    /// Deals out what a square of the image with its lower corner at `low` carries.
    fn pixel(
        &self,
        low: DVec2,
        size: f64,
        corners: [Option<Corner>; 4],
        levels: u32,
        work: &mut BeamWork,
    ) {
        if corners.iter().all(Option::is_none) {
            return;
        }
        let emitted = || self.tracer.emitted(low + 0.5 * size, low, low + size);
        if let [Some(a), Some(b), Some(c), Some(d)] = corners
            && [b, c, d].iter().all(|corner| corner.topology == a.topology)
        {
            let quarter = emitted() * 0.25;
            for [p, q, r] in [[a, b, d], [a, d, c], [a, b, c], [b, d, c]] {
                let flux = [p, q, r].map(|corner| quarter * corner.weight);
                work.splat.fragments += self.film.deal([p.at, q.at, r.at], flux);
                work.splat.splats += 1;
            }
            return;
        }
        if levels == 0 {
            for corner in corners.into_iter().flatten() {
                self.film
                    .deposit_at(corner.at, emitted() * corner.weight * 0.25);
                work.splat.splats += 1;
                work.splat.fragments += 1;
            }
            return;
        }
        let half = 0.5 * size;
        let mut at = |x: f64, y: f64| self.corner(low + DVec2::new(x, y), work);
        let (top, left, middle) = (at(half, 0.0), at(0.0, half), at(half, half));
        let (right, bottom) = (at(size, half), at(half, size));
        let [a, b, c, d] = corners;
        let quarters = [
            (DVec2::ZERO, [a, top, left, middle]),
            (DVec2::new(half, 0.0), [top, b, middle, right]),
            (DVec2::new(0.0, half), [left, middle, c, bottom]),
            (DVec2::splat(half), [middle, right, bottom, d]),
        ];
        for (offset, corners) in quarters {
            self.pixel(low + offset, half, corners, levels - 1, work);
        }
    }
}
