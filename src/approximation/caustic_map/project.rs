//! Stage `lookup`, exact: a map's texels dealt out to the sensor's, by the area that each of them lights.

use glam::DVec2;
use rayon::prelude::*;

use super::work::Work;
use crate::approximation::{ExactFilm, LightView, Receivers};
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::path_end::End;
use crate::transport::screen::Screen;

/// Flux \[W\] of a map's texels whose centres are not on the sensor: beside it, or on its back.
pub fn flux_beside(
    scene: &Scene,
    receivers: &Receivers,
    view: &LightView,
    flux: &[Rgb],
    screen: &Screen,
) -> Rgb {
    let side = view.side();
    let is_beside = |index: usize| {
        let mut counters = TraversalCounters::default();
        let at = DVec2::new((index % side) as f64, (index / side) as f64) + 0.5;
        let ray = view.ray(at);
        let hit = receivers.first(&ray, &mut counters).map(|(hit, _)| hit);
        match screen.end(scene, &ray, hit.as_ref(), &mut counters) {
            (End::Landed(at), ..) => !screen.is_on_film(at),
            _ => true,
        }
    };
    // Row by row, so that the sum is the same bits on any threads.
    let rows: Vec<Rgb> = flux
        .par_chunks(side)
        .enumerate()
        .map(|(row, texels)| {
            let lit = texels.iter().enumerate().filter(|(_, it)| !it.is_black());
            let beside = lit.filter(|(column, _)| is_beside(row * side + column));
            beside.map(|(_, flux)| *flux).sum()
        })
        .collect();
    rows.into_iter().sum()
}

/// Deals the flux of a map's texels out on a film: each is spread over the surface that the light sees in it.
pub fn deal_texels(
    scene: &Scene,
    receivers: &Receivers,
    view: &LightView,
    flux: &[Rgb],
    screen: &Screen,
    film: &ExactFilm,
) -> Work {
    let side = view.side();
    let corner = |column: usize, row: usize, counters: &mut TraversalCounters| {
        let ray = view.ray(DVec2::new(column as f64, row as f64));
        let hit = receivers.first(&ray, counters).map(|(hit, _)| hit);
        let (end, weight, surface) = screen.end(scene, &ray, hit.as_ref(), counters);
        match end {
            End::Landed(at) => Some((at, weight, surface)),
            _ => None,
        }
    };
    (0..side)
        .into_par_iter()
        .map(|row| {
            let mut counters = TraversalCounters::default();
            let mut work = Work::default();
            // A texel's right corners are its neighbour's left ones.
            let mut known = None;
            for column in 0..side {
                let carried = flux[row * side + column];
                if carried.is_black() {
                    continue;
                }
                work.fetches += 1;
                let (a, c) = match known.take() {
                    Some((next, corners)) if next == column => corners,
                    _ => (
                        corner(column, row, &mut counters),
                        corner(column, row + 1, &mut counters),
                    ),
                };
                let b = corner(column + 1, row, &mut counters);
                let d = corner(column + 1, row + 1, &mut counters);
                known = Some((column + 1, (b, d)));
                let share = |parts: f64, weight: Rgb| carried * weight / parts;
                if let [Some(a), Some(b), Some(c), Some(d)] = [a, b, c, d]
                    && [b.2, c.2, d.2] == [a.2; 3]
                {
                    for triangle in [[a, b, d], [a, d, c]] {
                        let values = triangle.map(|(_, weight, _)| share(2.0, weight));
                        work.fragments += film.deal(triangle.map(|(at, ..)| at), values);
                    }
                } else {
                    // At a surface's border a texel's light is where its corners are: what is between two
                    // surfaces has none.
                    for (at, weight, _) in [a, b, c, d].into_iter().flatten() {
                        film.deposit_at(at, share(4.0, weight));
                        work.fragments += 1;
                    }
                }
            }
            work.add_rays(counters);
            work
        })
        .reduce(Work::default, |a, b| a + b)
}
