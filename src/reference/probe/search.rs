//! Dividing light space until every chain is away from the target, or meets it once at most.

use std::collections::BTreeMap;

use glam::{DMat2, DVec2, DVec3};
use rayon::prelude::*;

use super::SearchEnd;
use super::map::{LightMap, LightPlace, MapTracer};
use super::newton::{NewtonOutcome, Root, solve};
use super::target::TargetImage;
use crate::geometry::TraversalCounters;
use crate::transport::differentials::{ChainStep, signature};
use crate::transport::domain::chart::Patch;
use crate::transport::signature::Signature;

/// A patch is divided at most so often: 2⁻³⁰ of a cell, where some 2¹⁶ places of a coordinate are left to a patch. Two roots this
/// near each other are as near to a fold as the square of that, far below the rounding of places on the receiver; only
/// light that grazes a surface, whose map has a square root's slope there, is divided so finely in earnest.
pub const MAX_LEVEL: u32 = 30;

/// Up to here a patch whose nodes do not all see the same chains is divided where *any* of them may hide
/// the target: an unseen chain may be between them. Beyond, only where a chain that is seen may.
const MIXED_LEVELS: u32 = 3;

/// Up to here a patch on the outline of a shape, as the emitter sees it, is divided in any case: light that grazes a
/// shape goes where no other does, from a narrow band along the outline that may pass between all nodes.
const OUTLINE_LEVELS: u32 = 4;

/// What is found.
#[derive(Default)]
pub(super) struct SearchResult {
    pub roots: Vec<Root>,
    pub unresolved: u64,
    pub end: SearchEnd,
    pub level: u32,
    pub patches: u64,
    pub counters: TraversalCounters,
}

/// A patch of light space to be looked at.
#[derive(Clone, Copy, Debug)]
pub(super) struct LightPiece {
    chart: usize,
    patch: Patch,
    level: u32,
}

/// What one chain makes of a piece's light.
pub(super) struct Sheet {
    pub chain: Vec<ChainStep>,
    /// At the nodes, in the piece's coordinates (−1..=1).
    nodes: [Option<TargetImage>; NODES],
    /// Whether the scene as it is lets the chain's light through at every node.
    is_visible: bool,
}

/// 3 x 3.
const NODES: usize = 9;
const CENTER: usize = 4;

/// In the piece's coordinates, row by row.
fn node(index: usize) -> DVec2 {
    DVec2::new((index % 3) as f64 - 1.0, (index / 3) as f64 - 1.0)
}

impl LightPiece {
    /// Half its size, in chart coordinates.
    pub fn half(&self) -> DVec2 {
        0.5 * (self.patch.to - self.patch.from)
    }

    /// The place at −1..=1 across it, or a little beyond.
    pub fn place(&self, at: DVec2) -> LightPlace {
        LightPlace {
            chart: self.chart,
            at: 0.5 * (self.patch.from + self.patch.to) + self.half() * at,
        }
    }

    /// An image whose derivatives are by the piece's own coordinates.
    pub fn scaled(&self, image: &TargetImage) -> TargetImage {
        let half = self.half();
        let [x, y] = image.miss_derivatives;
        TargetImage {
            jacobian: image.jacobian * DMat2::from_diagonal(half),
            miss_derivatives: [x * half.x, y * half.y],
            ..*image
        }
    }
}

/// What looking at a piece tells.
#[derive(Default)]
struct PieceResult {
    roots: Vec<Root>,
    /// Something in it is unclear.
    divide: bool,
    counters: TraversalCounters,
}

/// So many pieces are looked at between questions whether to go on: enough for all threads, and no more
/// than some tenths of a second's work.
const PIECES_AT_ONCE: usize = 256;

/// Looks for all roots, level by level: the pieces of a level are independent of each other.
///
/// The search may be as large as its budget: where light of a curve in light space meets the point, as on
/// the axis of a ball, each level has twice the pieces of the one before, to the last.
pub(super) fn search(map: &LightMap, stop: &(dyn Fn() -> bool + Sync)) -> SearchResult {
    let mut found = SearchResult::default();
    let mut pieces: Vec<LightPiece> = map
        .light
        .cells()
        .iter()
        .map(|cell| LightPiece {
            chart: cell.chart(),
            patch: *cell.patch(),
            level: 0,
        })
        .collect();
    for _ in 0..map.settings.first_level {
        pieces = pieces.iter().flat_map(LightPiece::quarters).collect();
    }
    while !pieces.is_empty() {
        found.level = pieces.iter().map(|piece| piece.level).max().unwrap_or(0);
        let mut unclear = Vec::new();
        for some in pieces.chunks(PIECES_AT_ONCE) {
            found.end = if found.counters.rays >= map.settings.max_rays {
                SearchEnd::OutOfRays
            } else if stop() {
                SearchEnd::Stopped
            } else {
                SearchEnd::Complete
            };
            if found.end != SearchEnd::Complete {
                // None of these was looked at.
                unclear.extend_from_slice(some);
                continue;
            }
            // An indexed parallel map: the order does not depend on the number of threads.
            let looks: Vec<PieceResult> = some.par_iter().map(|piece| look(map, piece)).collect();
            found.patches += some.len() as u64;
            for (piece, look) in some.iter().zip(looks) {
                found.counters += look.counters;
                found.roots.extend(look.roots);
                if look.divide {
                    unclear.push(*piece);
                }
            }
        }
        if found.end != SearchEnd::Complete {
            found.unresolved += unclear.len() as u64;
            break;
        }
        pieces.clear();
        for piece in &unclear {
            if piece.level < MAX_LEVEL {
                pieces.extend(piece.quarters());
            } else {
                found.unresolved += 1;
            }
        }
    }
    found
}

impl LightPiece {
    fn quarters(&self) -> [Self; 4] {
        self.patch.quarters().map(|patch| Self {
            chart: self.chart,
            patch,
            level: self.level + 1,
        })
    }
}

fn look(map: &LightMap, piece: &LightPiece) -> PieceResult {
    let mut tracer = map.tracer();
    let mut look = PieceResult::default();
    let sheets = sheets(&mut tracer, piece);
    look.divide = piece.level < MIXED_LEVELS && may_hide_a_chain(&sheets)
        || piece.level < OUTLINE_LEVELS && is_on_an_outline(&mut tracer, piece);
    for sheet in &sheets {
        let Some(start) = sheet.regular_start() else {
            look.divide |= sheet.may_hold_target(piece.level);
            continue;
        };
        if start.length() > FARTHEST_START {
            continue;
        }
        let inside = start.clamp(DVec2::NEG_ONE, DVec2::ONE);
        match solve(&mut tracer, piece, sheet, inside) {
            NewtonOutcome::Root(root) => look.roots.push(root),
            NewtonOutcome::Elsewhere => {}
            NewtonOutcome::Stuck => look.divide = true,
        }
    }
    look.counters = tracer.counters();
    look
}

/// Whether the nodes' rays do not all meet the same shape first.
fn is_on_an_outline(tracer: &mut MapTracer, piece: &LightPiece) -> bool {
    let first = tracer.first_shape(piece.place(node(0)));
    (1..NODES).any(|index| tracer.first_shape(piece.place(node(index))) != first)
}

/// Traces the nodes of a piece. A chain that is seen at some of them only is followed at the others whatever is in the way.
fn sheets(tracer: &mut MapTracer, piece: &LightPiece) -> Vec<Sheet> {
    let mut seen: BTreeMap<Vec<ChainStep>, [Option<TargetImage>; NODES]> = BTreeMap::new();
    for index in 0..NODES {
        tracer.images(piece.place(node(index)), |chain, image, _| {
            // Direct light needs no search.
            if signature(chain).is_empty() {
                return;
            }
            let image = Some(piece.scaled(&image));
            if let Some(nodes) = seen.get_mut(chain) {
                nodes[index] = image;
            } else {
                let mut nodes = [None; NODES];
                nodes[index] = image;
                seen.insert(chain.to_vec(), nodes);
            }
        });
    }
    seen.into_iter()
        .map(|(chain, mut nodes)| {
            let is_visible = nodes.iter().all(Option::is_some);
            for (index, image) in nodes.iter_mut().enumerate() {
                if image.is_none() {
                    *image = tracer
                        .image_along(piece.place(node(index)), &chain)
                        .map(|image| piece.scaled(&image));
                }
            }
            Sheet {
                chain,
                nodes,
                is_visible,
            }
        })
        .collect()
}

/// How much J may vary over a piece: ‖J(center)⁻¹ J(node) − 1‖ (Frobenius) at all nodes.
///
/// If it held everywhere and were below 1, the sheet would meet a point once at most (for x ≠ y in a convex set,
/// J(center)⁻¹ (f(x) − f(y)) differs from x − y by less than |x − y|). Half of that leaves the rest for what the sheet does between nodes.
const MOST_VARIATION: f64 = 0.5;

/// |J(center)⁻¹ f(center)| of a sheet that meets the target inside the piece is at most (1 + 1/2) √2, by the same token.
const FARTHEST_START: f64 = 2.2;

impl Sheet {
    /// Newton's first step from the center, where J varies so little that there is one root at most.
    fn regular_start(&self) -> Option<DVec2> {
        let center = self.nodes[CENTER]?;
        let inverse = center.jacobian.inverse();
        for image in &self.nodes {
            let variation = inverse * (*image)?.jacobian - DMat2::IDENTITY;
            let squares = variation.x_axis.length_squared() + variation.y_axis.length_squared();
            // False for NaN, of a singular J.
            let is_steady = squares <= MOST_VARIATION * MOST_VARIATION;
            if !is_steady {
                return None;
            }
        }
        Some(-(inverse * center.offset))
    }

    /// Whether light of the piece may meet the target: around each node, a linear map says by how much it misses, with a margin
    /// of what the nodes' linear maps get wrong at each other.
    ///
    /// A piece's nodes stand 1 apart, so where all see the chain each speaks for half of that; the margin is what they get
    /// wrong at their neighbours, four times what a quadratic map makes of half that step. Where some do not see the
    /// chain, the nearest that do speak for them. Sheets of meshes may jump (at creases), which no margin would
    /// ever allow for: past [`MIXED_LEVELS`] it is at most the linear map's own reach.
    fn may_hold_target(&self, level: u32) -> bool {
        let seen: Vec<(DVec2, f64, TargetImage)> = self
            .nodes
            .iter()
            .enumerate()
            .filter_map(|(index, image)| Some((node(index), self.reach(index), (*image)?)))
            .collect();
        let extent = |reach: f64, image: &TargetImage| {
            let [x, y] = image.miss_derivatives;
            (x.abs() + y.abs()) * reach
        };
        let largest = seen
            .iter()
            .map(|(_, reach, image)| extent(*reach, image).max_element())
            .fold(0.0, f64::max);
        let neighbourhood = if seen.len() == NODES { 1.0 } else { 2.0 };
        let mut error: f64 = 0.0;
        for (from, _, image) in &seen {
            for (to, _, other) in &seen {
                let step = *to - *from;
                if step.abs().max_element() <= neighbourhood {
                    let [x, y] = image.miss_derivatives;
                    let predicted = image.miss + x * step.x + y * step.y;
                    error = error.max((other.miss - predicted).abs().max_element());
                }
            }
        }
        let margin = if seen.len() == 1 {
            largest
        } else if level < MIXED_LEVELS {
            error
        } else {
            error.min(largest)
        };
        seen.iter().any(|(_, reach, image)| {
            let room = extent(*reach, image) + margin;
            image.miss.abs().cmple(room).all()
        })
    }

    /// How far (in the piece's coordinates) a node speaks for the piece: to the farthest of 5 x 5 points that no other node
    /// which sees the chain is nearer to, and half their spacing more.
    fn reach(&self, index: usize) -> f64 {
        const SPACING: f64 = 0.5;
        let distance = |index: usize, point: DVec2| (point - node(index)).abs().max_element();
        let mut reach: f64 = 0.0;
        for i in 0..25 {
            let point = DVec2::new((i % 5) as f64, (i / 5) as f64) * SPACING - 1.0;
            let own = distance(index, point);
            let is_nearest = (0..NODES)
                .filter(|other| self.nodes[*other].is_some())
                .all(|other| distance(other, point) >= own);
            if is_nearest {
                reach = reach.max(own);
            }
        }
        reach + 0.5 * SPACING
    }
}

/// Whether chains of one signature break within the piece, and the target lies among (or half as far beside) where they miss it.
fn may_hide_a_chain(sheets: &[Sheet]) -> bool {
    let mut hulls: BTreeMap<Signature, (DVec3, DVec3, bool)> = BTreeMap::new();
    for sheet in sheets {
        let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY, false);
        let hull = hulls.entry(signature(&sheet.chain)).or_insert(nothing);
        for image in sheet.nodes.iter().flatten() {
            let [x, y] = image.miss_derivatives;
            let extent = x.abs() + y.abs();
            hull.0 = hull.0.min(image.miss - extent);
            hull.1 = hull.1.max(image.miss + extent);
        }
        hull.2 |= !sheet.is_visible;
    }
    hulls.values().any(|(low, high, breaks)| {
        let room = 0.25 * (*high - *low);
        *breaks && (*low - room).cmple(DVec3::ZERO).all() && (*high + room).cmpge(DVec3::ZERO).all()
    })
}
