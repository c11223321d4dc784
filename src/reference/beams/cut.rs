//! Triangles of light space cut along the border between two topologies.
//!
//! If a silhouette, a shadow's edge or the onset of total reflection crosses a cell, the topology changes
//! along two of its edges. Both crossings are found by bisection, and the triangle is cut along the straight
//! line between them. The error from the border's curvature is of second order in the cell's size, as is the
//! bend of a smooth cell. It is extrapolated the same way.

use glam::DVec2;

use super::cell::{BeamNode, triangle_area};

/// A triangle of one topology that lands: its corners with their landings and weights, and its area in light
/// space.
#[derive(Clone, Copy, Debug)]
pub struct CutPiece<const N: usize> {
    /// The corners; those on a border have the values of the nearest path of the topology.
    pub corners: [BeamNode<N>; 3],
    /// Area in chart coordinates.
    pub area: f64,
}

/// Number of halvings of an edge to find the border on it: to a thousandth of its length.
const BISECTIONS: u32 = 10;

/// Relative error of a piece's area that the bisections leave.
pub const CUT_ERROR: f64 = 1.0 / (1 << BISECTIONS) as f64;

/// The ends of a bisected edge, on both sides of a border and close to each other.
#[derive(Clone, Copy, Debug)]
struct BorderCrossing<const N: usize> {
    /// The end with the topology of the edge's first end.
    before: BeamNode<N>,
    /// The end with the topology of the edge's second end.
    after: BeamNode<N>,
}

/// Up to three pieces.
#[derive(Clone, Copy, Debug)]
pub struct Pieces<const N: usize> {
    pieces: [Option<CutPiece<N>>; 3],
}

impl<const N: usize> Pieces<N> {
    /// The pieces.
    pub fn iter(&self) -> impl Iterator<Item = &CutPiece<N>> {
        self.pieces.iter().flatten()
    }
}

/// A triangle that lands, as one piece; `None` if it does not land, or has no area.
pub fn whole<const N: usize>(corners: [BeamNode<N>; 3]) -> Option<CutPiece<N>> {
    let area = triangle_area(&corners);
    let lands = corners.iter().all(|node| node.landing.is_some());
    (lands && area > 0.0).then_some(CutPiece { corners, area })
}

/// Cuts a triangle into pieces of one topology each, with `follow` for the path at chart coordinates. `None`
/// if one line cannot cut it: there are more than two topologies, or one in between.
pub fn cut<const N: usize>(
    corners: &[BeamNode<N>; 3],
    mut follow: impl FnMut(DVec2) -> BeamNode<N>,
) -> Option<Pieces<N>> {
    let [a, b, c] = corners.map(|node| node.topology);
    // The corner whose topology is not that of the other two.
    let odd = match (a == b, b == c, c == a) {
        (true, true, _) => {
            let pieces = [whole(*corners), None, None];
            return Some(Pieces { pieces });
        }
        (_, true, _) => 0,
        (_, _, true) => 1,
        (true, _, _) => 2,
        (false, false, false) => return None,
    };
    let [apex, left, right] = [odd, (odd + 1) % 3, (odd + 2) % 3].map(|index| corners[index]);
    let mut border = |end: &BeamNode<N>| crossing(&apex, end, &mut follow);
    let (on_left, on_right) = (border(&left)?, border(&right)?);
    let near = |crossing: &BorderCrossing<N>| on_border(crossing, &crossing.before);
    let far = |crossing: &BorderCrossing<N>| on_border(crossing, &crossing.after);
    let pieces = [
        whole([apex, near(&on_left), near(&on_right)]),
        whole([far(&on_left), left, right]),
        whole([far(&on_left), right, far(&on_right)]),
    ];
    Some(Pieces { pieces })
}

/// The values of a path, placed halfway between the two sides of a border.
fn on_border<const N: usize>(crossing: &BorderCrossing<N>, values: &BeamNode<N>) -> BeamNode<N> {
    BeamNode {
        at: 0.5 * (crossing.before.at + crossing.after.at),
        ..*values
    }
}

fn crossing<const N: usize>(
    from: &BeamNode<N>,
    to: &BeamNode<N>,
    follow: &mut impl FnMut(DVec2) -> BeamNode<N>,
) -> Option<BorderCrossing<N>> {
    let (mut before, mut after) = (*from, *to);
    for _ in 0..BISECTIONS {
        let middle = follow(0.5 * (before.at + after.at));
        if middle.topology == before.topology {
            before = middle;
        } else if middle.topology == after.topology {
            after = middle;
        } else {
            return None;
        }
    }
    Some(BorderCrossing { before, after })
}

/// True if a path that lands is found next to the border of the first node's topology, on the way to a node
/// of another.
pub fn lands_between<const N: usize>(
    from: &BeamNode<N>,
    to: &BeamNode<N>,
    mut follow: impl FnMut(DVec2) -> BeamNode<N>,
) -> bool {
    let (mut before, mut after) = (from.at, *to);
    if after.topology == from.topology {
        return false;
    }
    for _ in 0..BISECTIONS {
        let middle = follow(0.5 * (before + after.at));
        if middle.landing.is_some() {
            return true;
        }
        if middle.topology == from.topology {
            before = middle.at;
        } else {
            after = middle;
        }
    }
    false
}
