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
    /// Half the size, in chart coordinates, of the patch that holds no other root of the chain.
    pub half: DVec2,
    pub chain: Vec<ChainStep>,
}

/// Most steps of one solution. Quadratic convergence takes half a dozen; a sheet with kinks takes some more.
const MOST_STEPS: u32 = 60;

/// Most halvings of a step before the solver gives up.
const MOST_HALVINGS: u32 = 24;

/// Part of the patch's half size that the last step must be smaller than.
///
/// Convergence is quadratic, so the step after it would be the square of that. The smallest patches are 2⁻³⁶
/// of the chart (cells are about 2⁻⁶ of it), and 2⁻³⁶ · 2⁻¹⁴ is still above the 2⁻⁵² of coordinates.
const SMALL_STEP: f64 = 1.0 / (1 << 14) as f64;

/// Distance of a root from its patch's middle, in half sizes, up to which it counts. A neighbour may leave a
/// root beyond its border to this patch, by rounding or because a sheet is not quite linear. A root that is
/// found twice is counted once.
const REACH: f64 = 1.25;

/// The end of a search for a root.
pub(super) enum NewtonOutcome {
    /// A root of this chain in this patch.
    Root(Root),
    /// The root, if any, is not in this patch.
    Elsewhere,
    /// No convergence: the patch must be divided.
    Stuck,
}

/// Solves for the root of a sheet, from `start` in the piece's own coordinates (−1..=1).
///
/// Each step is −J⁻¹ f, halved until |f| shrinks (Armijo's rule with a factor 1/4), along the chain whatever
/// is in the way.
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

/// The longest of step, step/2, step/4, ... that brings the image nearer; `None` if none does: at the limit
/// of rounding, or stuck.
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
        // So near the root, a full step fails by rounding.
        if step.abs().max_element() * part < f64::EPSILON {
            return None;
        }
        part *= 0.5;
    }
    None
}
