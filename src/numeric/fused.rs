//! Code compiled for processors that multiply and add in one instruction.

/// Runs `work`, compiled for fused multiply-add if this processor has it.
///
/// [`f64::mul_add`] rounds once on every processor, so the results are the same bits. Only the cost differs:
/// without the instruction, each operation is computed from its parts and takes some hundred times as long.
///
/// `work` and all functions that it calls must be marked `#[inline(always)]`; otherwise they are compiled for
/// any processor.
#[inline]
pub(crate) fn with_fused<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}
