//! Showing how far a run has come.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::reference::Progress;

/// How often the line is drawn.
const PERIOD: Duration = Duration::from_millis(100);

/// Runs `work` while a line on the terminal follows `progress`; without a terminal, silently.
pub fn watch<T: Send>(progress: &Progress, work: impl FnOnce() -> T + Send) -> T {
    if !std::io::stderr().is_terminal() {
        return work();
    }
    let bar = ProgressBar::new(1);
    bar.set_style(
        // The template is a constant: a mistake in it shows in the first run.
        ProgressStyle::with_template("{bar:30} {msg}")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    bar.set_message("setting up");
    bar.tick();
    let start = Instant::now();
    let result = thread::scope(|scope| {
        let worker = scope.spawn(work);
        while !worker.is_finished() {
            thread::sleep(PERIOD);
            draw(&bar, progress, start.elapsed());
        }
        worker.join()
    });
    bar.finish_and_clear();
    match result {
        Ok(result) => result,
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

fn draw(bar: &ProgressBar, progress: &Progress, elapsed: Duration) {
    let photons = progress.paths.load(Ordering::Relaxed);
    let expected = progress.expected_paths.load(Ordering::Relaxed);
    if expected == 0 {
        bar.set_message("setting up");
        bar.tick();
        return;
    }
    bar.set_length(expected);
    bar.set_position(photons);
    let rate = photons as f64 / elapsed.as_secs_f64();
    let left = (expected.saturating_sub(photons)) as f64 / rate.max(1.0);
    let error = progress.relative_error().map_or_else(String::new, |error| {
        format!(", error {:.2} %", 100.0 * error)
    });
    bar.set_message(format!(
        "{:.1} of {:.1} M photons, {:.2} M/s{error}, {left:.0} s left",
        photons as f64 / 1e6,
        expected as f64 / 1e6,
        rate / 1e6,
    ));
}

/// Lets the first Ctrl-C end the run with what there is, and the second end the program.
///
/// # Errors
///
/// Where the system does not let the program listen.
pub fn stop_on_interrupt(progress: &Arc<Progress>) -> anyhow::Result<()> {
    let progress = Arc::clone(progress);
    ctrlc::set_handler(move || {
        if progress.stop.swap(true, Ordering::Relaxed) {
            std::process::exit(130);
        }
        eprintln!("\nstopping; once more to stop at once");
    })?;
    Ok(())
}
