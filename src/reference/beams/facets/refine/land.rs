//! Landings of polygons of light that have made all their events, on texels.

use glam::DVec2;

use super::refiner::FacetRefiner;
use crate::film::coverage::deal;
use crate::geometry::TraversalCounters;
use crate::numeric::streams::hash64;
use crate::reference::beams::cell::{BeamCell, BeamNode, CellSummary};
use crate::reference::beams::cut::{CutPiece, whole};
use crate::reference::beams::deposit::{Coarse, Levels, box_round, flux_of, image_of, texels_in};
use crate::reference::beams::facets::leg::rectangular_receiver;
use crate::reference::beams::facets::polygon::LightPolygon;
use crate::reference::beams::film::{BeamFilm, LevelTexel, Sign, TexelSums};
use crate::reference::beams::refine::misplaced;
use crate::transport::facets::path::FacetLight;
use crate::transport::first_surface::Source;
use crate::transport::flux::Flux;
use crate::transport::path_end::End;

/// Size \[texels\] up to which an image has one box for all its borders; the borders of a larger one have
/// boxes of their own.
const SMALL_IMAGE: f64 = 4.0;

/// Area between an arc and its chord, by that of the box round both. Bounds allow for the box.
const OF_ARC: f64 = 2.0 / 3.0;

impl<const N: usize> FacetRefiner<'_, '_, '_, N> {
    /// Puts a polygon on the film, given that nothing is in the way of its last leg. If its image is not flat
    /// enough, it is halved. It is given back if the sensor's place for light is not known before a search,
    /// or if lines are not lines there.
    pub(super) fn land(&mut self, polygon: &LightPolygon<N>, area: f64) {
        let place = |light: &FacetLight<N>| self.node(light);
        let corners: Option<Vec<BeamNode<N>>> = if self.bends_lines() {
            None
        } else {
            polygon.corners.iter().map(place).collect()
        };
        let Some(corners) = corners else {
            self.give_back(polygon);
            return;
        };
        let signature = polygon.signatures.start;
        let film = self.cells[signature].film();
        if !is_beside(&corners, film.size()) {
            let fan = (1..corners.len() - 1)
                .map(|index| BeamCell::of_patch([corners[0], corners[index], corners[index + 1]]));
            let received = if matches!(self.paths.source, Source::Parallel { .. }) {
                fan.fold(Flux::BLACK, |sum, cell| sum + land_flat(film, &cell))
            } else {
                let middle = |at: DVec2| self.node(&self.paths.follow(&polygon.chain, at));
                let mut cells: Vec<(BeamCell<N>, [BeamNode<N>; 3])> = Vec::new();
                for cell in fan {
                    let [bc, ca, ab] = cell.middles();
                    // The side that it shares with the triangle before.
                    let shared = cells.last().map(|(_, middles)| middles[1]);
                    let (Some(bc), Some(ca), Some(ab)) =
                        (middle(bc), middle(ca), shared.or_else(|| middle(ab)))
                    else {
                        self.give_back(polygon);
                        return;
                    };
                    let middles = [bc, ca, ab];
                    let look = CellSummary::at(&cell.corners, &middles);
                    let tolerance = self.cells[signature].limits().tolerance;
                    if !look.is_one_topology() || cell.area() * misplaced(&look) > tolerance {
                        self.part(polygon, area);
                        return;
                    }
                    cells.push((cell, middles));
                }
                cells.iter().fold(Flux::BLACK, |sum, (cell, middles)| {
                    sum + self.land_bent(film, cell, middles)
                })
            };
            self.cells[signature].balance.received += received;
            self.mark_uncertain(signature, &corners, polygon.uncertain_area, area);
        }
        self.book(polygon, area);
    }

    /// Books a polygon that does not land, as far as is known. After its last event, its uncertain part may
    /// land.
    pub(super) fn end(&mut self, polygon: &LightPolygon<N>, area: f64) {
        if self.has_all_events(polygon) {
            let nodes = polygon.corners.iter().filter_map(|light| self.node(light));
            let nodes: Vec<_> = nodes.collect();
            self.mark_uncertain(
                polygon.signatures.start,
                &nodes,
                polygon.uncertain_area,
                area,
            );
        }
        self.book(polygon, area);
    }

    /// True if lines may not be lines on the film: on a rectangle they are.
    fn bends_lines(&self) -> bool {
        rectangular_receiver(self.paths, self.screen).is_none()
    }

    /// The node of light on its last leg, at the place where it falls; `None` if it does not land.
    #[inline]
    pub(super) fn node(&self, light: &FacetLight<N>) -> Option<BeamNode<N>> {
        let mut counters = TraversalCounters::default();
        let paths = self.paths;
        let (end, factor, _) = self
            .screen
            .end(paths.scene, &light.ray, None, &mut counters);
        let End::Landed(landing) = end else {
            return None;
        };
        let strength = paths.source.strength();
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

    /// Puts a triangle on the film whose map is nearly affine. Returns the flux \[W\] that the film received.
    fn land_bent(
        &mut self,
        film: &BeamFilm<N>,
        cell: &BeamCell<N>,
        middles: &[BeamNode<N>; 3],
    ) -> Flux<N> {
        let quarters = cell.quarter_corners(middles).into_iter();
        let fine: Vec<CutPiece<N>> = quarters.filter_map(whole).collect();
        let coarse = whole(cell.corners);
        let levels = Levels {
            fine: &fine,
            coarse: coarse.as_slice(),
            coarser: None,
        };
        self.block.gather(film, &levels, &Coarse::NONE, 0.0);
        self.block.deposit(film)
    }

    /// Marks the light of an uncertain part of a polygon's coordinate area: it may be, or not be, at any of
    /// the polygon's borders between its corners' `nodes`. If all of the area is uncertain, it may be
    /// anywhere in the polygon.
    ///
    /// On a polar film it may be anywhere as near to the center as a corner.
    pub(super) fn mark_uncertain(
        &mut self,
        signature: usize,
        nodes: &[BeamNode<N>],
        uncertain_area: f64,
        area: f64,
    ) {
        if uncertain_area <= 0.0 {
            return;
        }
        let bends_lines = self.bends_lines();
        let cells = &mut self.cells[signature];
        let film = cells.film();
        let weight = nodes
            .iter()
            .fold(Flux::<N>::BLACK, |most, node| most.larger(node.weight));
        let uncertain = weight * uncertain_area.min(area);
        cells.balance.uncertain += uncertain;
        // Errors of bent lines are independent from polygon to polygon. Polygons that are uncertain as a
        // whole err like those beside them.
        let bits = |all: u64, node: &BeamNode<N>| {
            let [x, y] = node.landing.unwrap_or_default().to_array();
            hash64(all, x.to_bits() ^ y.to_bits().rotate_left(32), 0)
        };
        let sign = if uncertain_area < area {
            Sign::Drawn {
                bits: nodes.iter().fold(0, bits),
                part: OF_ARC,
            }
        } else {
            Sign::Same
        };
        let mark = |nodes: &[BeamNode<N>]| {
            let [mut low, mut high] = box_of(nodes);
            if bends_lines {
                // A chord of the disc is nearer to its center than its ends are, and a box does not show
                // where a turn begins anew.
                (low, high.y) = (DVec2::ZERO, film.size()[1] as f64);
            }
            if let Some([first, last]) = texels_in([low, high], film.size()) {
                film.add_uncertain(first, last, uncertain, sign);
            }
        };
        let [low, high] = box_of(nodes);
        // A small image has its borders in all of its texels.
        if uncertain_area >= area || (high - low).max_element() <= SMALL_IMAGE {
            mark(nodes);
        } else {
            for (index, node) in nodes.iter().enumerate() {
                mark(&[*node, nodes[(index + 1) % nodes.len()]]);
            }
        }
    }
}

/// True if all of an image is off the film, with as much again to spare for its bend.
fn is_beside<const N: usize>(corners: &[BeamNode<N>], size: [usize; 2]) -> bool {
    let [low, high] = box_of(corners);
    let margin = high - low;
    let end = DVec2::new(size[0] as f64, size[1] as f64);
    (high + margin).cmplt(DVec2::ZERO).any() || (low - margin).cmpgt(end).any()
}

/// The box round the landings of some nodes.
fn box_of<const N: usize>(nodes: &[BeamNode<N>]) -> [DVec2; 2] {
    box_round(nodes.iter().filter_map(|node| node.landing))
}

/// Puts a triangle on the film whose map is affine. Returns the flux \[W\] that the film received.
fn land_flat<const N: usize>(film: &BeamFilm<N>, cell: &BeamCell<N>) -> Flux<N> {
    let mut received = Flux::BLACK;
    if let Some(piece) = whole(cell.corners) {
        deal(image_of(&piece), film.size(), |at, part| {
            let flux = flux_of(&piece, &part);
            received += flux;
            let sums = TexelSums {
                flux,
                ..TexelSums::default()
            };
            film.add(LevelTexel { level: 0, at }, &sums);
        });
    }
    received
}
