//! Benches that are measured, and those that are only to run.

/// True for `cargo bench`; `cargo test --benches` only checks that benches run.
pub fn is_measured() -> bool {
    std::env::args().any(|argument| argument == "--bench")
}

/// So many times if it is measured, and else once.
pub fn times(many: usize) -> usize {
    if is_measured() { many } else { 1 }
}

/// So long \[s\] if it is measured, and else no longer than once takes.
pub fn long(seconds: f64) -> f64 {
    if is_measured() { seconds } else { 0.0 }
}
