//! Where the part of a line that a texel cuts out is not a smooth function of the line.

use super::{CupRay, MirrorCup};
use crate::numeric::rotation;
use crate::reference::closed_form::TexelRect;

/// Functions of a line, one of which is zero at each kink: of four corners; of five ends of stretches, each
/// beside four sides; and of the order of those that a leg may have.
const MARKS: usize = 4 + ENDS * 4 + 4;

/// Lengths along a line at which a stretch may begin or end.
const ENDS: usize = 5;

impl MirrorCup {
    /// What is zero for a line at which the part that a texel cuts out has a kink: it passes a corner of the
    /// texel, or a stretch on it ends on the texel's border or begins to end otherwise.
    pub(super) fn marks(&self, line: &CupRay, reflections: u32, texel: &TexelRect) -> [f64; MARKS] {
        let (origin, azimuth, start, end) = self.unfolded(line, reflections);
        let direction = rotation::direction(azimuth);
        let (enters, leaves) = self.inside(line);
        // Direct light in front of the cup ends where the line enters the circle.
        let ends: [f64; ENDS] = [start, end, enters, leaves, line.enter];
        let mut marks = [0.0; MARKS];
        for (mark, corner) in marks.iter_mut().zip(texel.corners()) {
            *mark = direction.perp_dot(corner - origin);
        }
        for (marks, along) in marks[4..].chunks_exact_mut(4).zip(ends) {
            let place = origin + direction * along;
            let (low, high) = (place - texel.min, place - texel.max);
            marks.copy_from_slice(&[low.x, low.y, high.x, high.y]);
        }
        marks[MARKS - 4..].copy_from_slice(&[
            enters - start,
            enters - end,
            leaves - start,
            leaves - end,
        ]);
        marks
    }
}
