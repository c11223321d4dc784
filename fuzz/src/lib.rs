//! Long runs on new inputs. Each target reads bytes as one kind of file, by the entry points that
//! `tests/hostile/replay.rs` shares; inputs that are worth keeping are in `tests/hostile/corpus/`.
//!
//! A stable toolchain will do, in the folder above (`cargo install cargo-fuzz` before):
//!
//! ```text
//! RUSTC_BOOTSTRAP=1 cargo fuzz build -s none -O
//! RUSTC_BOOTSTRAP=1 cargo fuzz run -s none -O ply fuzz/corpus/ply tests/hostile/corpus/ply -- \
//!     -max_len=65536 -timeout=10 -rss_limit_mb=2048
//! ```
//!
//! `-timeout` is the bar of time of `tests/hostile/`.

#[path = "../../tests/support/entries.rs"]
mod entries;

pub use entries::enter;
