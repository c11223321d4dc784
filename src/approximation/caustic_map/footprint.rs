//! Stage `splat`, exact: beams between the corners of the light view's pixels, dealt out to texels by area.
//!
//! Where the corners of a pixel are light of one topology, their landings span two triangles (either way, and
//! both are taken, by half), over which its flux is dealt out. Where they are not, the pixel is divided,
//! `border-levels` times; of what is left then, each corner puts a quarter into its texel.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::hit::Canvas;
use super::loss::Loss;
use super::refraction::Exit;
use super::tally::{Left, Tally};
use super::trace::Tracer;
use super::variants::{BySteps, Step};
use super::work::Work;
use crate::approximation::ExactFilm;
use crate::radiometry::Rgb;

/// What became of the beams between corners.
#[derive(Clone, Copy, Debug, Default)]
pub struct Dealt {
    /// Work by stage.
    pub work: BySteps<Work>,
    /// The flux of their corners on the way, a quarter of a beam's each.
    pub tally: Tally,
}

impl Dealt {
    fn add(mut self, other: &Self) -> Self {
        for (sum, one) in self.work.iter_mut().zip(other.work) {
            *sum += one;
        }
        self.tally += other.tally;
        self
    }

    fn work(&mut self, step: Step) -> &mut Work {
        &mut self.work[step as usize]
    }
}

/// A corner's light on the canvas.
#[derive(Clone, Copy)]
struct Landed {
    at: DVec2,
    /// What is left of a unit of flux, up to the canvas.
    left: Left,
    /// What the canvas multiplies it by.
    canvas: Rgb,
    position: DVec3,
    topology: u64,
}

/// What became of a corner.
#[derive(Clone, Copy)]
enum Corner {
    /// Nothing specular is there.
    Beside,
    /// It came to nothing, with what was left of a unit of flux.
    Lost(Loss, Left),
    Landed(Landed),
}

impl Corner {
    fn landed(&self) -> Option<&Landed> {
        match self {
            Self::Landed(landed) => Some(landed),
            Self::Beside | Self::Lost(..) => None,
        }
    }
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
pub fn deal_beams(tracer: &Tracer, canvas: &Canvas, shift: DVec2, film: &ExactFilm) -> Dealt {
    let beams = Beams {
        tracer,
        canvas,
        film,
    };
    let side = tracer.view.side();
    let trace_row = |row: usize| {
        let mut done = Dealt::default();
        let at = |column: usize| DVec2::new(column as f64, row as f64) + shift;
        let points: Vec<DVec2> = (0..=side).map(at).collect();
        let corners = beams.corners(&points, &mut done);
        (corners, done)
    };
    let tasks: Vec<Dealt> = (0..side.div_ceil(ROWS))
        .into_par_iter()
        .map(|task| {
            let first = task * ROWS;
            let last = (first + ROWS).min(side);
            let (mut above, mut all) = trace_row(first);
            for row in first..last {
                let (below, done) = trace_row(row + 1);
                all = all.add(&done);
                for column in 0..side {
                    let low = DVec2::new(column as f64, row as f64) + shift;
                    let corners = [
                        above[column],
                        above[column + 1],
                        below[column],
                        below[column + 1],
                    ];
                    let levels = tracer.settings.border_levels;
                    beams.pixel(low, 1.0, &corners, levels, &mut all);
                }
                above = below;
            }
            all
        })
        .collect();
    // In the order of rows: sums of flux are the same bits on any threads.
    tasks.iter().fold(Dealt::default(), Dealt::add)
}

impl Beams<'_> {
    /// The corners at these image points, an entry each.
    fn corners(&self, points: &[DVec2], done: &mut Dealt) -> Vec<Corner> {
        let mut corners = vec![Corner::Beside; points.len()];
        let mut arriving = Vec::new();
        let fronts = self.tracer.fronts(points, done.work(Step::View));
        // Of what is under way, which corner it is.
        let mut under_way = Vec::new();
        for (index, front) in fronts.into_iter().enumerate() {
            match front {
                Ok(Some(front)) => {
                    arriving.push((points[index], front));
                    under_way.push(index);
                }
                Ok(None) => {}
                Err(loss) => corners[index] = Corner::Lost(loss, Left::ALL),
            }
        }
        let mut leaving: Vec<Exit> = Vec::new();
        let arriving = arriving.iter().map(|(at, front)| (*at, front));
        let exits = self.tracer.exits(arriving, done.work(Step::Refraction));
        let mut exits = exits.into_iter();
        under_way.retain(|&index| match exits.next() {
            Some(Ok(exit)) => {
                leaving.push(exit);
                true
            }
            Some(Err(loss)) => {
                corners[index] = Corner::Lost(loss, Left::ALL);
                false
            }
            None => false,
        });
        let work = done.work(Step::Hit);
        let landings = self.tracer.landings(leaving.iter(), self.canvas, work);
        for ((index, exit), landing) in under_way.into_iter().zip(&leaving).zip(landings) {
            corners[index] = match landing {
                Ok(landing) => Corner::Landed(Landed {
                    at: landing.at,
                    left: exit.left(),
                    canvas: landing.weight,
                    position: landing.position,
                    topology: exit.topology ^ landing.surface.rotate_left(17),
                }),
                Err(loss) => Corner::Lost(loss, exit.left()),
            };
        }
        corners
    }

    /// Flux \[W\] that a square of the image stands for, by each corner as if all of it landed there; black
    /// where it does not, or on no map.
    fn drawn(&self, low: DVec2, size: f64, corners: &[Corner; 4]) -> [Rgb; 4] {
        let strength = self.tracer.strength(low + 0.5 * size);
        let even = self.tracer.carried_anywhere(low, low + size);
        corners.each_ref().map(|corner| {
            let measure = corner.landed().and_then(|landed| {
                even.or_else(|| self.tracer.carried(low, low + size, landed.position))
            });
            strength * measure.unwrap_or(0.0)
        })
    }

    /// Books a quarter of a square's light at each of its corners.
    fn book(&self, low: DVec2, size: f64, corners: [(&Corner, Rgb); 4], tally: &mut Tally) {
        let sent = self.tracer.sent(low, low + size);
        let quarter = self.tracer.strength(low + 0.5 * size) * (0.25 * sent);
        for (corner, drawn) in corners {
            match corner {
                Corner::Beside => {}
                Corner::Lost(loss, left) => tally.lose(*loss, quarter, *left),
                Corner::Landed(landed) => tally.land(quarter, landed.left, drawn * 0.25),
            }
        }
    }

    /// Deals out what a square of the image with its lower corner at `low` carries.
    fn pixel(&self, low: DVec2, size: f64, corners: &[Corner; 4], levels: u32, done: &mut Dealt) {
        if corners.iter().all(|it| matches!(it, Corner::Beside)) {
            return;
        }
        let landed = corners.each_ref().map(Corner::landed);
        let is_dark = landed.iter().all(Option::is_none);
        let is_whole = matches!(landed, [Some(a), Some(b), Some(c), Some(d)]
            if [b, c, d].iter().all(|corner| corner.topology == a.topology));
        if is_dark || is_whole || levels == 0 {
            let drawn = self.drawn(low, size, corners);
            let [a, b, c, d] = corners.each_ref();
            let [e, f, g, h] = drawn;
            self.book(low, size, [(a, e), (b, f), (c, g), (d, h)], &mut done.tally);
            let flux = landed.iter().zip(drawn).map(|(corner, drawn)| {
                let corner = (*corner)?;
                let flux = drawn * corner.left.throughput * corner.canvas * 0.25;
                Some((corner.at, flux))
            });
            self.deal(&flux.collect::<Vec<_>>(), is_whole, done.work(Step::Splat));
            return;
        }
        let half = 0.5 * size;
        let between = [
            (half, 0.0),
            (0.0, half),
            (half, half),
            (size, half),
            (half, size),
        ];
        let points = between.map(|(x, y)| low + DVec2::new(x, y));
        let found = self.corners(&points, done);
        let [top, left, middle, right, bottom] = std::array::from_fn(|i| found[i]);
        let [a, b, c, d] = *corners;
        let quarters = [
            (DVec2::ZERO, [a, top, left, middle]),
            (DVec2::new(half, 0.0), [top, b, middle, right]),
            (DVec2::new(0.0, half), [left, middle, c, bottom]),
            (DVec2::splat(half), [middle, right, bottom, d]),
        ];
        for (offset, corners) in quarters {
            self.pixel(low + offset, half, &corners, levels - 1, done);
        }
    }

    /// Deals out the light of a square's corners: as two triangles, either way and both by half, or each
    /// where it is.
    fn deal(&self, corners: &[Option<(DVec2, Rgb)>], is_whole: bool, work: &mut Work) {
        if is_whole && let [Some(a), Some(b), Some(c), Some(d)] = *corners {
            for triangle in [[a, b, d], [a, d, c], [a, b, c], [b, d, c]] {
                let (places, values) = (triangle.map(|it| it.0), triangle.map(|it| it.1));
                work.fragments += self.film.deal(places, values);
                work.splats += 1;
            }
            return;
        }
        for (at, flux) in corners.iter().copied().flatten() {
            self.film.deposit_at(at, flux);
            work.splats += 1;
            work.fragments += 1;
        }
    }
}
