//! Landings of polygons of light that have made all their events, on texels.

use glam::DVec2;

use super::leg::rectangular_receiver;
use super::polygon::LightPolygon;
use crate::film::coverage::deal;
use crate::geometry::TraversalCounters;
use crate::reference::beams::cell::{BeamCell, BeamNode, CellSummary};
use crate::reference::beams::cut::{CutPiece, whole};
use crate::reference::beams::deposit::{Levels, TexelBlock, flux_of, image_of};
use crate::reference::beams::film::{BeamFilm, LevelTexel, TexelSums};
use crate::reference::beams::refine::misplaced;
use crate::transport::clearance::CellClearance;
use crate::transport::facets::path::{FacetLight, FacetPaths};
use crate::transport::first_surface::Source;
use crate::transport::flux::Flux;
use crate::transport::path_end::End;
use crate::transport::screen::Screen;

/// Size \[texels\] up to which an image has one box for all its borders; the borders of a larger one have
/// boxes of their own.
const SMALL_IMAGE: f64 = 4.0;

/// The result of a polygon at the sensor.
pub(super) enum PolygonLanding<const N: usize> {
    /// It is on the film, or beside it.
    Done {
        /// Flux \[W\] on the film.
        received: Flux<N>,
        /// Uncertain flux \[W\]: it may be elsewhere.
        uncertain: Flux<N>,
    },
    /// Its image is not flat enough.
    TooBent,
    /// It must be searched for: the sensor's place for light is not known before a search, or lines are not
    /// lines there.
    NotForced,
}

/// Puts a polygon on the film if nothing is in the way of its last leg.
pub(super) fn land<const N: usize>(
    paths: &FacetPaths,
    screen: Screen,
    film: &BeamFilm<N>,
    block: &mut TexelBlock<N>,
    polygon: &LightPolygon<N>,
    tolerance: f64,
) -> PolygonLanding<N> {
    if rectangular_receiver(paths, &screen).is_none() {
        return PolygonLanding::NotForced;
    }
    let place = |light: &FacetLight<N>| node(paths, screen, light);
    let Some(corners) = polygon
        .corners
        .iter()
        .map(place)
        .collect::<Option<Vec<BeamNode<N>>>>()
    else {
        return PolygonLanding::NotForced;
    };
    if is_beside(&corners, film.size()) {
        return PolygonLanding::Done {
            received: Flux::BLACK,
            uncertain: Flux::BLACK,
        };
    }
    let area = polygon.area_and_middle().0;
    let uncertain = || deposit_uncertain_area(film, false, &corners, polygon.uncertain_area, area);
    let fan = (1..corners.len() - 1).map(|index| BeamCell {
        corners: [corners[0], corners[index], corners[index + 1]],
        level: 0,
        clearance: CellClearance::default(),
        noted_bend: 0.0,
        coarser: None,
        outer_bend: 0.0,
    });
    if matches!(paths.source(), Source::Parallel { .. }) {
        let received = fan.fold(Flux::BLACK, |sum, cell| sum + land_flat(film, &cell));
        return PolygonLanding::Done {
            received,
            uncertain: uncertain(),
        };
    }
    let middle = |at: DVec2| place(&paths.follow(&polygon.chain, at));
    let mut cells: Vec<(BeamCell<N>, [BeamNode<N>; 3], CellSummary<N>)> =
        Vec::with_capacity(corners.len() - 2);
    for cell in fan {
        let [bc, ca, ab] = cell.middles();
        // The side that it shares with the triangle before.
        let shared = cells.last().map(|(_, middles, _)| middles[1]);
        let (Some(bc), Some(ca), Some(ab)) =
            (middle(bc), middle(ca), shared.or_else(|| middle(ab)))
        else {
            return PolygonLanding::NotForced;
        };
        let middles = [bc, ca, ab];
        let look = CellSummary::at(&cell.corners, &middles);
        if !look.is_one_topology() || cell.area() * misplaced(&look) > tolerance {
            return PolygonLanding::TooBent;
        }
        cells.push((cell, middles, look));
    }
    let mut received = Flux::BLACK;
    for (cell, middles, _) in &cells {
        let fine: Vec<CutPiece<N>> = cell
            .quarter_corners(middles)
            .into_iter()
            .filter_map(whole)
            .collect();
        let coarse = whole(cell.corners);
        let levels = Levels {
            fine: &fine,
            coarse: coarse.as_slice(),
            coarser: None,
        };
        block.gather(film, &levels, 0, 0.0);
        received += block.deposit(film);
    }
    PolygonLanding::Done {
        received,
        uncertain: uncertain(),
    }
}

/// The node of light on its last leg, at the place where it falls.
#[inline]
pub(super) fn node<const N: usize>(
    paths: &FacetPaths,
    screen: Screen,
    light: &FacetLight<N>,
) -> Option<BeamNode<N>> {
    let mut counters = TraversalCounters::default();
    let (end, factor, _) = screen.end(paths.scene(), &light.ray, None, &mut counters);
    let End::Landed(landing) = end else {
        return None;
    };
    let strength = paths.source().strength();
    Some(BeamNode {
        at: light.at,
        landing: Some(landing),
        turned_back: false,
        weight: light.throughput * Flux::of(strength * factor) * light.emitted,
        emitted: light.emitted * strength.mean(),
        topology: light.topology(),
        faces: 0,
    })
}

/// True if all of an image is off the film, with as much again to spare for its bend.
fn is_beside<const N: usize>(corners: &[BeamNode<N>], size: [usize; 2]) -> bool {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for at in corners.iter().filter_map(|node| node.landing) {
        low = low.min(at);
        high = high.max(at);
    }
    let margin = high - low;
    let end = DVec2::new(size[0] as f64, size[1] as f64);
    (high + margin).cmplt(DVec2::ZERO).any() || (low - margin).cmpgt(end).any()
}

/// Puts a triangle on the film whose map is affine. Returns the flux \[W\] that the film received.
fn land_flat<const N: usize>(film: &BeamFilm<N>, cell: &BeamCell<N>) -> Flux<N> {
    let Some(piece) = whole(cell.corners) else {
        return Flux::BLACK;
    };
    let mut received = Flux::BLACK;
    deal(image_of(&piece), film.size(), |texel, part| {
        let flux = flux_of(&piece, &part);
        received += flux;
        film.add(
            LevelTexel {
                level: 0,
                at: texel,
            },
            &TexelSums {
                flux,
                ..TexelSums::default()
            },
        );
    });
    received
}

/// Marks the light of an uncertain part of a polygon's coordinate area: it may be, or not be, at any of the
/// polygon's borders. If all of the area is uncertain, it may be anywhere in the polygon. Returns the flux
/// \[W\] of that light.
///
/// On a polar film it may be anywhere as near to the center as a corner.
pub(super) fn deposit_uncertain_area<const N: usize>(
    film: &BeamFilm<N>,
    bends_lines: bool,
    corners: &[BeamNode<N>],
    uncertain_area: f64,
    area: f64,
) -> Flux<N> {
    if uncertain_area <= 0.0 {
        return Flux::BLACK;
    }
    let mut weight = Flux::<N>::BLACK;
    for node in corners {
        for (largest, channel) in weight.0.iter_mut().zip(node.weight.0) {
            *largest = largest.max(channel);
        }
    }
    let uncertain = weight * uncertain_area.min(area);
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for at in corners.iter().filter_map(|node| node.landing) {
        (low, high) = (low.min(at), high.max(at));
    }
    // A small image has its borders in all of its texels.
    if uncertain_area >= area || (high - low).max_element() <= SMALL_IMAGE {
        add_uncertain(film, bends_lines, corners, uncertain);
    } else {
        for (index, corner) in corners.iter().enumerate() {
            let next = &corners[(index + 1) % corners.len()];
            add_uncertain(film, bends_lines, &[*corner, *next], uncertain);
        }
    }
    uncertain
}

/// Marks uncertain flux on the texels of a box round landings, as far as they are on the film.
fn add_uncertain<const N: usize>(
    film: &BeamFilm<N>,
    bends_lines: bool,
    nodes: &[BeamNode<N>],
    uncertain: Flux<N>,
) {
    let (mut low, mut high) = (DVec2::INFINITY, DVec2::NEG_INFINITY);
    for at in nodes.iter().filter_map(|node| node.landing) {
        low = low.min(at);
        high = high.max(at);
    }
    let [columns, rows] = film.size();
    if bends_lines {
        // A chord of the disc is nearer to its center than its ends are, and a box does not show where a turn
        // begins anew.
        (low, high.y) = (DVec2::ZERO, rows as f64);
    }
    let last = DVec2::new(columns as f64, rows as f64) - 1.0;
    let low = low.floor().max(DVec2::ZERO);
    let high = high.floor().min(last);
    // False for NaN, too.
    if low.cmple(high).all() {
        let texel = |at: DVec2| [at.x as usize, at.y as usize];
        film.add_uncertain(texel(low), texel(high), uncertain);
    }
}
