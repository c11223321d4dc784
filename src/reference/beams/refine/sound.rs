//! The work that a division will take, from single ways down.
//!
//! At each division one of the four quarters is drawn, with probability p, and stands for 1/p. The sum of the
//! work along the way, each cell times all of its 1/p, has the work of the whole division as its mean (Knuth
//! 1975, "Estimating the efficiency of backtrack programs"). A way down takes one cell a level.
//!
//! Quarters that a border crosses are likely to be divided often, and are drawn more often. If all were drawn
//! alike, one way of 2ˡ would follow a border over l levels, and few ways would not find it.

use std::time::{Duration, Instant};

use super::refiner::Refiner;
use crate::reference::beams::cell::BeamCell;
use crate::reference::beams::limit::RAYS_A_PLACE;
use crate::transport::first_surface::SurfacePatch;

/// Part of a middle's path that is a cell's own: two cells share each edge.
const OF_EDGE: f64 = 0.5;

/// The likelihood of a quarter that a border crosses, by that of another.
const OF_BORDER: f64 = 4.0;

/// Likely work.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sounding {
    /// Rays.
    pub rays: f64,
    /// Cells and polygons.
    pub places: f64,
    /// Time of one thread \[s\].
    pub seconds: f64,
}

impl Sounding {
    /// Its size, in rays.
    pub fn work(&self) -> f64 {
        self.rays + RAYS_A_PLACE as f64 * self.places
    }

    /// Some rays and places, and the time that they took.
    pub fn new(rays: u64, places: u64, time: Duration) -> Self {
        Self {
            rays: rays as f64,
            places: places as f64,
            seconds: time.as_secs_f64(),
        }
    }
}

impl std::ops::Add for Sounding {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self {
            rays: self.rays + other.rays,
            places: self.places + other.places,
            seconds: self.seconds + other.seconds,
        }
    }
}

impl std::ops::AddAssign for Sounding {
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl std::ops::Mul<f64> for Sounding {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self {
            rays: self.rays * factor,
            places: self.places * factor,
            seconds: self.seconds * factor,
        }
    }
}

impl<const N: usize> Refiner<'_, N> {
    /// The likely work of [`refine`](Self::refine), as a mean over `draw`: evenly spread numbers in \[0, 1).
    /// What it puts on the film is worth nothing.
    pub fn sound(&mut self, patch: &SurfacePatch, draw: impl FnMut() -> f64) -> Sounding {
        self.with_scratch(|refiner| refiner.go_down(patch, draw))
    }

    fn go_down(&mut self, patch: &SurfacePatch, mut draw: impl FnMut() -> f64) -> Sounding {
        let chart = &patch.chart;
        let mut cell = self.whole(patch);
        let (mut all, mut cells) = (Sounding::default(), 1.0);
        while self.may_go_on() {
            let mut clock = (Instant::now(), self.counters().rays);
            let mut lap = |rays: u64, places: u64| {
                let (began, before) = std::mem::replace(&mut clock, (Instant::now(), rays));
                Sounding::new(rays - before, places, clock.0 - began)
            };
            let middles = self.middles(chart, &cell);
            let of_middles = lap(self.counters().rays, 0);
            let quarters = self.place_or_divide(chart, &mut cell, &middles);
            all += of_middles * (OF_EDGE * cells);
            all += lap(self.counters().rays, 1) * cells;
            let Some(quarters) = quarters else {
                break;
            };
            let (quarter, probability) = drawn(&quarters, draw());
            cell = quarters[quarter];
            cells /= probability;
        }
        all
    }
}

/// A quarter by a number in \[0, 1), and its probability.
fn drawn<const N: usize>(quarters: &[BeamCell<N>; 4], number: f64) -> (usize, f64) {
    let likelihoods = quarters.each_ref().map(|quarter| {
        let [a, b, c] = quarter.corners.each_ref().map(|node| node.topology);
        if a == b && b == c { 1.0 } else { OF_BORDER }
    });
    let all: f64 = likelihoods.iter().sum();
    let (mut left, mut last) = (number * all, 0);
    for (quarter, likelihood) in likelihoods.iter().enumerate() {
        last = quarter;
        if left < *likelihood {
            break;
        }
        left -= likelihood;
    }
    (last, likelihoods[last] / all)
}
