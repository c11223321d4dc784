//! Newton's method with the exact Jacobian.

use glam::DVec2;

use super::map::{LightPlace, MapTracer};
use super::sheet::{LightPiece, Sheet};
use super::target::TargetImage;
use crate::transport::differentials::ChainStep;

/// A place whose light lands on the target.
#[derive(Clone, Debug)]
pub(super) struct Root {
    pub place: LightPlace,
    /// Half the size of the patch in which it is the only one of its chain, in chart coordinates.
    pub half: DVec2,
    pub chain: Vec<ChainStep>,
}

/// Quadratic convergence takes half a dozen steps; a sheet with kinks some more.
const MOST_STEPS: u32 = 60;

/// A step is halved at most so often before the search stands still.
const MOST_HALVINGS: u32 = 24;

/// The last step must be smaller than this part of the patch's half size.
///
/// Convergence is quadratic, so the step after it would be the square of that. The smallest patches are 2⁻³⁶ of the chart
/// (cells are about 2⁻⁶ of it), and 2⁻³⁶ · 2⁻¹⁴ is still above the 2⁻⁵² of coordinates.
const SMALL_STEP: f64 = 1.0 / (1 << 14) as f64;

/// Roots this far outside their patch (in half sizes) still count: a neighbour may leave it to this one,
/// by rounding or by a sheet that is not quite linear. Who is found twice is counted once.
const REACH: f64 = 1.25;

/// What became of the search.
pub(super) enum NewtonOutcome {
    /// A root of this chain in this patch.
    Root(Root),
    /// The root, if any, is not in this patch.
    Elsewhere,
    /// No convergence: look closer.
    Stuck,
}

/// Looks for the root of a sheet, from `start` in the piece's own coordinates (−1..=1).
///
/// Steps −J⁻¹ f, halved until |f| shrinks (Armijo's rule with a factor 1/4), along the chain whatever is in the way.
pub(super) fn solve(
    tracer: &mut MapTracer,
    piece: &LightPiece,
    sheet: &Sheet,
    start: DVec2,
) -> NewtonOutcome {
    let mut at = start;
    let Some(mut image) = tracer.image_along(piece.place(at), &sheet.chain) else {
        return NewtonOutcome::Stuck;
    };
    let mut last_step = f64::INFINITY;
    for _ in 0..MOST_STEPS {
        let Some(step) = newton_step(piece, &image) else {
            return NewtonOutcome::Stuck;
        };
        last_step = step.abs().max_element();
        if at.abs().max_element() > 4.0 * REACH {
            return NewtonOutcome::Elsewhere;
        }
        let Some((next, landed)) = shorter(tracer, piece, sheet, at, step, &image) else {
            break;
        };
        at = next;
        image = landed;
    }
    if last_step > SMALL_STEP {
        return NewtonOutcome::Stuck;
    }
    if at.abs().max_element() > REACH {
        return NewtonOutcome::Elsewhere;
    }
    NewtonOutcome::Root(Root {
        place: piece.place(at),
        half: piece.half(),
        chain: sheet.chain.clone(),
    })
}

/// −J⁻¹ f in the piece's coordinates.
pub(super) fn newton_step(piece: &LightPiece, image: &TargetImage) -> Option<DVec2> {
    let step = -(piece.scaled(image).jacobian.inverse() * image.offset);
    step.is_finite().then_some(step)
}

/// The longest of step, step/2, step/4, ... that brings the image nearer; `None` where none does: at the
/// limit of rounding, or stuck.
fn shorter(
    tracer: &mut MapTracer,
    piece: &LightPiece,
    sheet: &Sheet,
    at: DVec2,
    step: DVec2,
    image: &TargetImage,
) -> Option<(DVec2, TargetImage)> {
    let mut part = 1.0;
    for _ in 0..MOST_HALVINGS {
        let next = at + step * part;
        if next == at {
            return None;
        }
        if let Some(landed) = tracer.image_along(piece.place(next), &sheet.chain)
            && landed.offset.length() < image.offset.length() * (1.0 - 0.25 * part)
        {
            return Some((next, landed));
        }
        // So near the root a full step that fails does so by rounding.
        if step.abs().max_element() * part < f64::EPSILON {
            return None;
        }
        part *= 0.5;
    }
    None
}
