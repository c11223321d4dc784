//! A study's course on the terminal.

use std::path::Path;

use crate::cli::progress;
use crate::run::Progress;
use crate::study::StudyPlan;
use crate::study::report::{StudyReport, parameters};
use crate::study::validation::{Done, Left, News, Task, Watcher};

/// Prints a line for each piece of news, and follows each run.
#[derive(Default)]
pub struct Teller {
    /// Hears how far the attribution under way is.
    counts: Option<Box<dyn FnMut(usize, usize)>>,
}

impl Watcher for Teller {
    fn hear(&mut self, news: News) {
        match news {
            News::Pose(number, all, define) => {
                eprintln!("pose {number} of {all}: {}", parameters(define));
            }
            News::PosesLeft(left, all) => {
                eprintln!("{left} of {all} poses were not begun: the study's time was over");
            }
            News::RunsLeft(left, all) => {
                eprintln!("{left} of {all} runs were not made: the study's time was over");
            }
            News::Planned(plan, folder) => planned(plan, folder),
            News::Begins(task) => {
                let place = place(task);
                eprintln!("{place} ...");
                self.counts = Some(Box::new(progress::lines(place)));
            }
            News::Counts(done, all) => {
                if let Some(counts) = &mut self.counts {
                    counts(done, all);
                }
            }
            News::Done(task, how, left) => {
                eprintln!("{}: {}{}", place(task), done(how), rest(left));
            }
            News::Judges(row, rows, label) => eprintln!("judging {row} of {rows}: {label}"),
            News::Judged(report) => warn(report),
            News::Stopped(kept, all) => eprintln!(
                "stopped: {kept} of {all} runs are kept; the same command goes on from there"
            ),
        }
    }

    fn watch<T: Send>(&mut self, progress: &Progress, run: impl FnOnce() -> T + Send) -> T {
        progress::watch(progress, run)
    }
}

fn place(task: &Task) -> String {
    format!("[{:>2}/{}] {}", task.number, task.all, task.name)
}

fn planned(plan: &StudyPlan, folder: &Path) {
    let ids = plan.sensors.iter().map(|one| one.sensor.as_str());
    let candidates = plan.sensors.iter().map(|one| one.candidates.len());
    eprintln!(
        "{}, {} {}: {} runs, {} candidates; report in {}",
        plan.scene.display(),
        if plan.sensors.len() == 1 {
            "sensor"
        } else {
            "sensors"
        },
        ids.collect::<Vec<_>>().join(", "),
        plan.count(),
        candidates.sum::<usize>(),
        folder.display()
    );
}

fn done(how: Done) -> String {
    match how {
        Done::Kept => "kept from before".to_owned(),
        Done::Made(time) => format!("{:.1} s", time.as_secs_f64()),
        Done::Attributed(runs, time) => format!("{runs} runs, {:.1} s", time.as_secs_f64()),
        Done::NotAttributed(reason) => format!("none: {reason}"),
    }
}

fn rest(left: Option<Left>) -> String {
    left.map_or_else(String::new, |time| {
        let [so_far, left] = [time.so_far, time.left].map(|time| time.as_secs());
        format!("; {so_far} s so far, about {left} s left")
    })
}

/// Signs of a mistake, row by row.
fn warn(report: &StudyReport) {
    for row in report.sensors.iter().flat_map(|sensor| &sensor.rows) {
        for check in &row.checks {
            eprintln!("warning: {}: {}", row.label, check.message);
        }
    }
}
