//! Work compiled for processors that multiply and add in one instruction.

/// Does `work`, compiled for fused multiply-add where this processor has it.
///
/// [`f64::mul_add`] rounds once on every processor, so the results are the same bits. What differs is the price: without the
/// instruction each is computed from its parts, some hundred times as long.
///
/// `work` must be marked `#[inline(always)]`, and so must be all that it calls: else it is compiled for any processor.
#[inline]
pub(crate) fn with_fused<R>(work: impl FnOnce() -> R) -> R {
    pulp::Arch::new().dispatch(work)
}
