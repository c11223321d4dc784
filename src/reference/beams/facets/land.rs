//! From a polygon of light that has made all its events to texels.

use glam::DVec2;

use super::polygon::Polygon;
use crate::film::coverage::deal;
use crate::geometry::TraversalCounters;
use crate::reference::beams::cell::{Cell, Look, Node, Smooth, look};
use crate::reference::beams::deposit::{Patch, deposit_smooth, flux_of};
use crate::reference::beams::film::{BeamFilm, TexelSums};
use crate::reference::beams::refine::misplaced;
use crate::transport::facets::path::{FacetLight, FacetPaths};
use crate::transport::first_surface::Source;
use crate::transport::flux::Flux;
use crate::transport::prescribed::{End, PathEnd};
use crate::transport::screen::Screen;

/// What became of a polygon at the sensor.
pub(super) enum Landing<const N: usize> {
    /// It is on the film, or beside it.
    Done {
        /// On the film \[W\].
        received: Flux<N>,
    },
    /// Its image is not flat enough.
    TooBent,
    /// The sensor's place for light is not known before a search.
    NotForced,
}

/// Puts a polygon on the film, whose last leg nothing is in the way of.
pub(super) fn land<const N: usize>(
    paths: &FacetPaths,
    screen: Screen,
    film: &BeamFilm<N>,
    patch: &mut Patch<N>,
    polygon: &Polygon<N>,
    tolerance: f64,
) -> Landing<N> {
    let place = |light: &FacetLight<N>| node(paths, screen, light);
    let Some(corners) = polygon
        .corners
        .iter()
        .map(place)
        .collect::<Option<Vec<Node<N>>>>()
    else {
        return Landing::NotForced;
    };
    if is_beside(&corners, film.size()) {
        return Landing::Done {
            received: Flux::BLACK,
        };
    }
    let fan = (1..corners.len() - 1).map(|index| Cell {
        corners: [corners[0], corners[index], corners[index + 1]],
        level: 0,
    });
    if matches!(paths.source(), Source::Parallel { .. }) {
        let received = fan.fold(Flux::BLACK, |sum, cell| sum + land_flat(film, &cell));
        return Landing::Done { received };
    }
    let middle = |at: DVec2| place(&paths.follow(&polygon.chain, polygon.events, at));
    let mut cells: Vec<(Cell<N>, [Node<N>; 3], Smooth)> = Vec::with_capacity(corners.len() - 2);
    for cell in fan {
        let [bc, ca, ab] = cell.middles();
        // The side that it shares with the triangle before.
        let shared = cells.last().map(|(_, middles, _)| middles[1]);
        let (Some(bc), Some(ca), Some(ab)) =
            (middle(bc), middle(ca), shared.or_else(|| middle(ab)))
        else {
            return Landing::NotForced;
        };
        let middles = [bc, ca, ab];
        let Look::Smooth(smooth) = look(&cell, &middles) else {
            return Landing::TooBent;
        };
        let weight = middles
            .iter()
            .fold(0.0, |sum, node| sum + node.path.weight.max_magnitude())
            / 3.0;
        if cell.area() * misplaced(&smooth, weight) > tolerance {
            return Landing::TooBent;
        }
        cells.push((cell, middles, smooth));
    }
    let mut received = Flux::BLACK;
    for (cell, middles, smooth) in &cells {
        received += deposit_smooth(film, patch, cell, middles, smooth);
    }
    if polygon.astray > 0.0 {
        spread_astray(film, &corners, polygon.astray);
    }
    Landing::Done { received }
}

/// Light on its last leg, where it falls.
#[inline]
fn node<const N: usize>(
    paths: &FacetPaths,
    screen: Screen,
    light: &FacetLight<N>,
) -> Option<Node<N>> {
    let mut counters = TraversalCounters::default();
    let (end, factor, _) = screen.end(paths.scene(), &light.ray, None, &mut counters);
    matches!(end, End::Landed(_)).then(|| Node {
        at: light.at,
        path: PathEnd {
            end,
            weight: light.throughput * Flux::of(paths.source().strength() * factor) * light.emitted,
            emitted: light.emitted,
            family: light.state,
        },
    })
}

/// Whether all of an image is off the film, with as much again to spare for its bend.
fn is_beside<const N: usize>(corners: &[Node<N>], size: [usize; 2]) -> bool {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for at in corners.iter().filter_map(Node::landing) {
        low = low.min(at);
        high = high.max(at);
    }
    let margin = high - low;
    let end = DVec2::new(size[0] as f64, size[1] as f64);
    (high + margin).cmplt(DVec2::ZERO).any() || (low - margin).cmpgt(end).any()
}

/// A triangle whose map is affine, as it is.
fn land_flat<const N: usize>(film: &BeamFilm<N>, cell: &Cell<N>) -> Flux<N> {
    let [Some(a), Some(b), Some(c)] = cell.corners.map(|corner| corner.landing()) else {
        return Flux::BLACK;
    };
    let area = cell.area();
    let weights = cell.corners.map(|corner| corner.path.weight);
    let mut received = Flux::BLACK;
    deal([a, b, c], film.size(), |texel, part| {
        let flux = flux_of(area, weights, &part);
        received += flux;
        film.add(
            texel,
            &TexelSums {
                flux,
                ..TexelSums::default()
            },
        );
    });
    received
}

/// Light near a bent cut may belong to the polygon on the other side: at the borders' texels.
fn spread_astray<const N: usize>(film: &BeamFilm<N>, corners: &[Node<N>], area: f64) {
    let [columns, rows] = film.size();
    for corner in corners {
        if let Some(at) = corner.landing()
            && at.cmpge(DVec2::ZERO).all()
            && at.x < columns as f64
            && at.y < rows as f64
        {
            film.add(
                [at.x as usize, at.y as usize],
                &TexelSums {
                    slack: corner.path.weight * (area / corners.len() as f64),
                    ..TexelSums::default()
                },
            );
        }
    }
}
