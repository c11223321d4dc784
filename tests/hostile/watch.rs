//! A watch over reads: the heap that they take, their time, and whether they panic.

use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError, mpsc};
use std::time::{Duration, Instant};

use nephroid::internals::mitsuba;
use nephroid::internals::scene::Scene;
use peak_alloc::PeakAlloc;
use tempfile::TempDir;

#[global_allocator]
static HEAP: PeakAlloc = PeakAlloc;

/// Longest time that any read may take.
const LONGEST: Duration = Duration::from_secs(10);

/// Most heap that a hostile file may take, as a multiple of what an honest one takes.
pub const TIMES_HONEST: f64 = 4.0;

/// A lock that lets one test run at a time: all of this program share one heap.
pub fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Result of a read, with its time and heap.
pub struct Outcome<T> {
    pub result: Result<T, String>,
    pub seconds: f64,
    /// The most that the heap grew by, bytes.
    pub peak: usize,
}

impl<T> Outcome<T> {
    /// The error of what must not be read.
    pub fn refusal(self, case: &str) -> String {
        match self.result {
            Err(error) => error,
            Ok(_) => panic!("{case} is read"),
        }
    }
}

/// Runs `read` under a watch.
///
/// # Panics
///
/// If it panics, or takes longer than [`LONGEST`].
pub fn watched<T: Send + 'static>(
    case: &str,
    read: impl FnOnce() -> Result<T, String> + Send + 'static,
) -> Outcome<T> {
    let (sender, receiver) = mpsc::channel();
    HEAP.reset_peak_usage();
    let before = HEAP.current_usage();
    let start = Instant::now();
    // Tests have stacks of 2 MB, and so has this.
    let reader = std::thread::spawn(move || drop(sender.send(read())));
    let result = match receiver.recv_timeout(LONGEST) {
        Ok(result) => result,
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("{case} takes more than {LONGEST:?}"),
        Err(mpsc::RecvTimeoutError::Disconnected) => panic!("{case} makes the reader panic"),
    };
    // What a thread gives back as it ends would else be taken off what the next one takes.
    reader.join().expect("it has sent its result");
    Outcome {
        result,
        seconds: start.elapsed().as_secs_f64(),
        peak: HEAP.peak_usage().saturating_sub(before),
    }
}

pub fn load(path: &Path) -> Outcome<Scene> {
    let case = path.display().to_string();
    let path = path.to_owned();
    watched(&case, move || {
        mitsuba::load(&path, &[]).map_err(|error| error.to_string())
    })
}

pub fn scene_of(elements: &str) -> String {
    format!("<scene version=\"3.0.0\">\n{elements}\n</scene>\n")
}

/// A folder with a scene file of these elements.
pub fn folder_with(elements: &str) -> (TempDir, PathBuf) {
    let folder = TempDir::new().unwrap();
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, scene_of(elements)).unwrap();
    (folder, file)
}

pub fn load_elements(elements: &str) -> Outcome<Scene> {
    let (_folder, file) = folder_with(elements);
    load(&file)
}
