//! Division of light space until every chain is away from the target, or meets it once at most.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::found::SearchEnd;
use super::map::{LightMap, MapTracer};
use super::newton::{NewtonOutcome, Root, solve};
use super::sheet::{LightPiece, MIXED_LEVELS, NODES, Sheet, node};
use super::target::TargetImage;
use crate::geometry::TraversalCounters;
use crate::transport::differentials::{ChainStep, signature};
use crate::transport::signature::Signature;

/// Most divisions of a patch: to 2⁻³⁰ of a cell, so that some 2¹⁶ places of a coordinate are left to a patch.
/// Two roots this near each other are as near to a fold as the square of that: far below the rounding of
/// receiver places. Only light that grazes a surface, whose map has a square root's slope there, needs so
/// many divisions.
pub const MAX_LEVEL: u32 = 30;

/// Level up to which a patch on the outline of a shape, as the emitter sees it, is divided in any case. Light
/// that grazes a shape goes where no other light does, from a narrow band along the outline that may pass
/// between all nodes.
const OUTLINE_LEVELS: u32 = 4;

/// Result of a search.
#[derive(Default)]
pub(super) struct SearchResult {
    pub roots: Vec<Root>,
    pub unresolved: u64,
    pub end: SearchEnd,
    pub level: u32,
    pub patches: u64,
    pub counters: TraversalCounters,
}

/// Result for one piece.
#[derive(Default)]
struct PieceResult {
    roots: Vec<Root>,
    /// True if something in it is unclear.
    divide: bool,
    counters: TraversalCounters,
}

/// Number of pieces between two questions whether to go on: enough for all threads, and at most some tenths
/// of a second's work.
const PIECES_AT_ONCE: usize = 256;

/// Searches for all roots, level by level: the pieces of a level are independent of each other.
///
/// The search may be as large as its budget. On the axis of a ball, for example, light of a whole curve in
/// light space meets the point. Then each level has twice the pieces of the one before, to the last.
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
                // None of these was traced.
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

/// True if the nodes' rays do not all meet the same shape first.
fn is_on_an_outline(tracer: &mut MapTracer, piece: &LightPiece) -> bool {
    let first = tracer.first_shape(piece.place(node(0)));
    (1..NODES).any(|index| tracer.first_shape(piece.place(node(index))) != first)
}

/// Traces the nodes of a piece. A chain that only some of them show is followed at the others whatever is in
/// the way.
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

/// Bound of |J(center)⁻¹ f(center)| for a sheet that meets the target inside the piece: (1 + 1/2) √2, by the
/// argument of `MOST_VARIATION`.
const FARTHEST_START: f64 = 2.2;

/// True if chains of one signature break within the piece, and the target lies among their misses, or half as
/// far beside them.
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
