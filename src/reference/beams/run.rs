//! One pass over light space.

use rayon::prelude::*;

use super::facets::{FacetRefiner, part_roots};
use super::film::BeamFilm;
use super::refine::{Balance, Refiner};
use crate::geometry::TraversalCounters;
use crate::scene::Scene;
use crate::transport::facets::path::FacetPaths;
use crate::transport::facets::table::Facets;
use crate::transport::first_surface::{Root, Source, roots};
use crate::transport::flux::Flux;
use crate::transport::prescribed::PathFollower;
use crate::transport::scatter::ShadingNormals;
use crate::transport::screen::Screen;
use crate::transport::signature::Signature;

/// Deposits a signature.
pub fn pass<const N: usize>(
    scene: &Scene,
    source: &Source,
    roots: &[Root],
    screen: &Screen,
    signature: Signature,
    tolerance: f64,
    film: &BeamFilm<N>,
) -> (Vec<Balance<N>>, TraversalCounters) {
    let facets = Facets::new(scene);
    let (flat, roots) = part_roots(&facets, roots);
    let paths = FacetPaths::new(scene, source, &facets, signature, ShadingNormals::Flux);
    let flat: Vec<(Balance<N>, TraversalCounters)> = flat
        .par_chunks(64)
        .flat_map_iter(|flat| {
            let mut follower = PathFollower::<N>::new(scene, source, screen, signature, ShadingNormals::Flux);
            let mut generic = Refiner::new(&mut follower, film, tolerance);
            let mut refiner = FacetRefiner::new(&paths, screen, film, tolerance);
            for facet in flat {
                refiner.refine(*facet, &mut generic);
            }
            let balance = generic.balance;
            [(refiner.balance, refiner.counters), (balance, follower.counters)]
        })
        .collect();
    let chunk = 16;
    let all: Vec<(Balance<N>, TraversalCounters)> = roots
        .par_chunks(chunk)
        .map(|roots| {
            let mut follower = PathFollower::<N>::new(scene, source, screen, signature, ShadingNormals::Flux);
            let mut refiner = Refiner::new(&mut follower, film, tolerance);
            for root in roots {
                refiner.refine(root);
            }
            let balance = refiner.balance;
            (balance, follower.counters)
        })
        .collect();
    let all = [flat, all].concat();
    let mut counters = TraversalCounters::default();
    for one in &all {
        counters += one.1;
    }
    (all.into_iter().map(|one| one.0).collect(), counters)
}

/// Roots of a source.
pub fn roots_of(scene: &Scene, source: &Source) -> Vec<Root> {
    roots(scene, source)
}

/// Sum.
pub fn sum<const N: usize>(all: &[Balance<N>]) -> (f64, Flux<N>, u64, u64) {
    let mut e = 0.0;
    let mut r = Flux::BLACK;
    let (mut c, mut m) = (0, 0);
    for b in all {
        e += b.emitted;
        r += b.received;
        c += b.cells;
        m += b.mixed_cells;
    }
    (e, r, c, m)
}
