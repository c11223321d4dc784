//! Work compiled for processors that multiply and add in one instruction.

/// Does `work`, compiled for fused multiply-add where this processor has it.
///
/// [`f64::mul_add`] rounds once on every processor, so the results are the same bits. What differs is the price: without
/// the instruction each is a call of the system's library.
#[inline]
pub(crate) fn with_fused<R>(work: impl FnOnce() -> R) -> R {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("fma") {
        // SAFETY: the processor has the feature.
        #[allow(unsafe_code)]
        return unsafe { fused(work) };
    }
    work()
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "fma")]
fn fused<R>(work: impl FnOnce() -> R) -> R {
    work()
}
