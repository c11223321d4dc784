//! A line on the terminal that shows how far a run has come.

use std::io::IsTerminal;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};

use crate::run::Progress;
use crate::run::format::time;

/// Time between two drawings of the line, and before the first: short runs are not to wait for it.
const PERIOD: Duration = Duration::from_millis(100);
const FIRST_PAUSE: Duration = Duration::from_millis(1);

/// Time between two lines.
const BETWEEN_LINES: Duration = Duration::from_secs(5);

/// Time of a run from which on it is told beforehand.
const LONG: Duration = Duration::from_secs(10);

/// Runs `work` while a line on the terminal follows `progress`. Without a terminal, one line tells how long a
/// long run will take, if it is known.
pub fn watch<T: Send>(progress: &Progress, work: impl FnOnce() -> T + Send) -> T {
    let is_terminal = std::io::stderr().is_terminal();
    let bar = if is_terminal {
        ProgressBar::new(1)
    } else {
        ProgressBar::hidden()
    };
    bar.set_style(
        // The template is a constant: a mistake in it shows in the first run.
        ProgressStyle::with_template("{bar:30} {msg}")
            .unwrap_or_else(|_| ProgressStyle::default_bar()),
    );
    bar.set_message("setting up");
    bar.tick();
    let start = Instant::now();
    let mut is_told = false;
    let result = thread::scope(|scope| {
        let worker = scope.spawn(work);
        let mut pause = FIRST_PAUSE;
        while !worker.is_finished() {
            thread::sleep(pause);
            pause = (2 * pause).min(PERIOD);
            draw(&bar, progress, start.elapsed());
            let forecast = progress.forecast().filter(|forecast| *forecast >= LONG);
            if let Some(forecast) = forecast.filter(|_| !is_told) {
                is_told = true;
                bar.suspend(|| eprintln!("note: {}", foretold(forecast)));
            }
        }
        worker.join()
    });
    bar.finish_and_clear();
    match result {
        Ok(result) => result,
        Err(panic) => std::panic::resume_unwind(panic),
    }
}

/// The time that a run is likely to take, in a sentence.
fn foretold(forecast: Duration) -> String {
    format!(
        "this will take about {}; Ctrl-C ends it with what is known by then, and --time or a larger --error beforehand",
        time(forecast),
    )
}

/// A listener that prints now and then how many of some runs are done, and how long the others will take.
pub fn lines(what: String) -> impl FnMut(usize, usize) {
    // The first run may have waited for a truth: time counts from its end.
    let mut first: Option<(Instant, usize)> = None;
    let mut heard = Instant::now();
    move |done, all| {
        let (start, before) = *first.get_or_insert((Instant::now(), done));
        if heard.elapsed() > BETWEEN_LINES && done < all && done > before {
            heard = Instant::now();
            let each = start.elapsed().as_secs_f64() / (done - before) as f64;
            let left = each * (all - done) as f64;
            eprintln!("{what}: {done} of {all} runs, about {left:.0} s left");
        }
    }
}

fn draw(bar: &ProgressBar, progress: &Progress, elapsed: Duration) {
    if let Some(expected) = progress.expected() {
        bar.set_length(expected);
        bar.set_position(progress.done());
    }
    bar.set_message(message(progress, elapsed));
    bar.tick();
}

/// The text of the line.
fn message(progress: &Progress, elapsed: Duration) -> String {
    let done = progress.done();
    let Some(expected) = progress.expected() else {
        return "setting up".to_owned();
    };
    let unit = progress.unit();
    let error = progress.relative_error().map(|error| 100.0 * error);
    if let Some(pass) = progress.pass() {
        // Patches are of very different work: no time left can be told from their number.
        let error = error.map_or_else(String::new, |error| {
            format!("; likely error of the pass before {error:.2} %")
        });
        return format!("pass {pass}: {done} of {expected} {unit}{error}");
    }
    let rate = done as f64 / elapsed.as_secs_f64();
    let left = expected.saturating_sub(done) as f64 / rate.max(1.0);
    let error = error.map_or_else(String::new, |error| format!(", error {error:.2} %"));
    format!(
        "{:.1} of {:.1} M {unit}, {:.2} M/s{error}, {left:.0} s left",
        done as f64 / 1e6,
        expected as f64 / 1e6,
        rate / 1e6,
    )
}

/// Lets the first Ctrl-C end the run with what there is, and the second end the program.
///
/// # Errors
///
/// If the system does not let the program listen.
pub fn stop_on_interrupt(progress: &Arc<Progress>) -> anyhow::Result<()> {
    let progress = Arc::clone(progress);
    ctrlc::set_handler(move || {
        if progress.stop() {
            std::process::exit(130);
        }
        eprintln!("\nstopping; once more to stop at once");
    })?;
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    const SECOND: Duration = Duration::from_secs(1);

    #[test]
    fn photons_are_counted_in_millions() {
        let progress = Progress::default();
        assert_eq!(message(&progress, SECOND), "setting up");
        progress.expect(4_000_000);
        progress.add(1_000_000);
        assert_eq!(
            message(&progress, SECOND),
            "1.0 of 4.0 M photons, 1.00 M/s, 3 s left"
        );
    }

    #[test]
    fn a_long_run_is_told_beforehand() {
        let told = foretold(Duration::from_secs(5430));
        assert!(told.starts_with("this will take about 2 h;"), "{told}");
    }

    #[test]
    fn beams_are_told_by_pass_and_patch() {
        let progress = Progress::default();
        progress.begin_pass(640);
        progress.add(16);
        assert_eq!(message(&progress, SECOND), "pass 1: 16 of 640 patches");
        progress.set_relative_error(Some(0.0123));
        progress.begin_pass(640);
        assert_eq!(
            message(&progress, SECOND),
            "pass 2: 0 of 640 patches; likely error of the pass before 1.23 %"
        );
    }
}
