//! The surroundings of a run: nothing here changes a result.

use std::path::PathBuf;
use std::sync::Arc;

use super::{Error, Progress};
#[cfg(feature = "cli")]
use crate::scene::Scene;

/// The surroundings of a run: progress and stop, threads, cache folder, memory limit. None of them changes a
/// result.
///
/// # Example: two threads, and at most a gigabyte
///
/// ```
/// let context = nephroid::Context {
///     threads: Some(2),
///     memory_limit: Some(1_000_000_000),
///     ..nephroid::Context::default()
/// };
/// assert!(!context.progress.is_stopped());
/// ```
#[derive(Clone, Debug, Default)]
pub struct Context {
    /// How far the run is; [`Progress::stop`] ends it soon, with the result so far.
    pub progress: Arc<Progress>,
    /// Threads of the run; without a number those of rayon's current pool.
    pub threads: Option<usize>,
    /// Folder for what later runs can use again, for methods that prepare anything worth keeping.
    pub cache: Option<PathBuf>,
    /// Memory \[bytes\] that the run may take; without a number the system's free memory.
    pub memory_limit: Option<u64>,
}

impl Context {
    /// Runs `work` on the threads asked for.
    pub(crate) fn install<T: Send>(
        &self,
        work: impl FnOnce() -> Result<T, Error> + Send,
    ) -> Result<T, Error> {
        let Some(threads) = self.threads else {
            return work();
        };
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        pool.map_err(|error| Error::Threads(error.to_string()))?
            .install(work)
    }

    /// The same with what a limit on memory leaves beside a scene.
    #[cfg(feature = "cli")]
    pub(crate) fn beside(&self, scene: &Scene) -> Self {
        let of_scene = scene.world().memory_bytes() as u64;
        let left = |bytes: u64| bytes.saturating_sub(of_scene);
        Self {
            memory_limit: self.memory_limit.map(left),
            ..self.clone()
        }
    }

    /// Memory \[bytes\] that can be had: the limit, or the free memory where the system says (Linux).
    pub(crate) fn available_bytes(&self) -> Option<u64> {
        self.memory_limit
            .or_else(|| parse_available(&std::fs::read_to_string("/proc/meminfo").ok()?))
    }
}

/// The system's word on memory that can be had without swapping.
fn parse_available(meminfo: &str) -> Option<u64> {
    let line = meminfo
        .lines()
        .find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kilobytes: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kilobytes.checked_mul(1024)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_systems_word_on_free_memory_is_understood() {
        let text = "MemTotal:       16000000 kB\nMemAvailable:    8000000 kB\n";
        assert_eq!(parse_available(text), Some(8_000_000 * 1024));
        for text in ["", "MemAvailable: x kB", "MemAvailable: 5", "MemFree: 1 kB"] {
            assert_eq!(parse_available(text), None, "{text}");
        }
    }

    #[test]
    fn a_run_has_the_threads_asked_for() {
        let context = Context {
            threads: Some(3),
            ..Context::default()
        };
        let threads = context.install(|| Ok(rayon::current_num_threads()));
        assert_eq!(threads.unwrap(), 3);
    }
}
