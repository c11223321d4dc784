//! The runs of a study, one after the other, up to its report.

use std::path::Path;
use std::time::{Duration, Instant};

use anyhow::Context as _;

use super::args::ValidateArgs;
use super::candidates;
use crate::cli::outcome::Outcome;
use crate::cli::progress;
use crate::film::atomic;
use crate::run::Context;
use crate::study::attribution;
use crate::study::report::{self, GateVerdict, JudgedFilm, SensorFilms, StudyReport, Timings};
use crate::study::store::StoredRun;
use crate::study::{
    Attributed, Obtained, SensorPlan, Session, Store, StudyError, StudyFile, StudyRun,
};

/// The command under way.
pub struct Command<'a> {
    /// Its arguments.
    pub args: &'a ValidateArgs,
    /// What its runs have around them.
    pub context: &'a Context,
    /// When it began.
    pub start: Instant,
}

impl Command<'_> {
    /// Makes a study, and writes its report; there is none if it was stopped, or if runs were only to be
    /// listed.
    ///
    /// # Errors
    ///
    /// If the study cannot be planned, a run not be made, or the report not be written.
    pub fn study(
        &self,
        file: &StudyFile,
        folder: &Path,
    ) -> anyhow::Result<(Outcome, Option<(StudyReport, Timings)>)> {
        let films = folder.join("runs");
        std::fs::create_dir_all(folder)
            .with_context(|| format!("cannot make the folder {}", folder.display()))?;
        atomic::check(&folder.join("index.html"))?;
        let session = Session::new(file, Store::open(&films)?)?;
        if self.args.list {
            list(&session)?;
            return Ok((Outcome::Complete, None));
        }
        let mut work = Work {
            session: &session,
            context: self.context,
            start: self.start,
            fresh: Vec::new(),
            done: 0,
            left_out: 0,
        };
        let plan = &session.plan;
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
        // Before the first run: an image of the wrong size is better known now.
        let mut copies = Vec::new();
        for sensor in &plan.sensors {
            copies.push(candidates::copy(&session, sensor)?);
        }
        let mut films = Vec::new();
        for (sensor, copied) in plan.sensors.iter().zip(copies) {
            match work.sensor(sensor, copied)? {
                Filled::All(one) => films.push(*one),
                Filled::TimeOver => (),
                Filled::Stopped => return Ok((work.stopped(), None)),
            }
        }
        let rows: usize = films.iter().map(|one| one.judged.len()).sum();
        let (mut report, timings) = report::build(&session, &films, &mut |i, label| {
            eprintln!("judging {} of {rows}: {label}", i + 1);
        })?;
        let left = work.left_out;
        if left > 0 {
            report.warnings.push(format!(
                "{left} runs were not made: the study's time was over"
            ));
        }
        report::write(folder, &report, &timings)?;
        let outcome = judged(&report, left);
        Ok((outcome, Some((report, timings))))
    }
}

/// The runs of a study under way.
struct Work<'a> {
    session: &'a Session,
    context: &'a Context,
    start: Instant,
    /// Seconds of runs that were not in the store, the truths' apart: those take longest.
    fresh: Vec<f64>,
    done: usize,
    /// Runs that the study's time did not suffice for.
    left_out: usize,
}

/// How far a sensor came.
enum Filled<'a> {
    /// As far as the study's time allows.
    All(Box<SensorFilms<'a>>),
    /// Not even to its truth.
    TimeOver,
    /// It was stopped.
    Stopped,
}

impl<'a> Work<'a> {
    /// All runs of a sensor, with the candidates that are there already.
    fn sensor(
        &mut self,
        plan: &'a SensorPlan,
        candidates: Vec<JudgedFilm<'a>>,
    ) -> Result<Filled<'a>, StudyError> {
        let is_first = self.done == 0;
        // The first truth is computed in any case: without any film there is no report.
        if !is_first && self.is_time_over() {
            self.left_out += plan.count();
            return Ok(Filled::TimeOver);
        }
        let Some(truth) = self.obtain(plan, &plan.truth, "truth, ")? else {
            return Ok(Filled::Stopped);
        };
        let mut films = SensorFilms {
            plan,
            truth: truth.stored,
            judged: Vec::new(),
            same: Vec::new(),
            stages: Vec::new(),
        };
        for run in &plan.runs {
            if self.is_time_over() {
                self.left_out += 1;
                continue;
            }
            match self.obtain(plan, run, "")? {
                Some(obtained) => films
                    .judged
                    .push(JudgedFilm::Run(run, Box::new(obtained.stored))),
                None => return Ok(Filled::Stopped),
            }
        }
        films.judged.extend(candidates);
        for run in &plan.attributed {
            if self.is_time_over() {
                self.left_out += 1;
                continue;
            }
            let found = self.stages(plan, run, &films.truth)?;
            if self.context.progress.is_stopped() {
                return Ok(Filled::Stopped);
            }
            films.stages.extend(found.map(|found| (run, found.found)));
        }
        Ok(Filled::All(Box::new(films.distinct())))
    }

    fn is_time_over(&self) -> bool {
        let time = self.session.plan.time;
        time.is_some_and(|time| self.start.elapsed() >= time)
    }

    /// A run, with a line on how it went; `None` where it was stopped.
    fn obtain(
        &mut self,
        plan: &SensorPlan,
        run: &StudyRun,
        what: &str,
    ) -> Result<Option<Obtained>, StudyError> {
        let all = self.session.plan.count();
        let on = if self.session.plan.sensors.len() > 1 {
            format!("{}: ", plan.sensor)
        } else {
            String::new()
        };
        let place = format!("[{:>2}/{all}] {on}{what}{}", self.done + 1, run.label());
        eprintln!("{place} ...");
        let start = Instant::now();
        let sensor = self.session.sensor(plan)?;
        let obtained = progress::watch(&self.context.progress, || {
            self.session.obtain(sensor, run, self.context)
        })?;
        if self.context.progress.is_stopped() {
            return Ok(None);
        }
        self.done += 1;
        if let Some(obtained) = &obtained {
            let seconds = start.elapsed().as_secs_f64();
            let how = if obtained.was_kept {
                "kept from before".to_owned()
            } else {
                if *run != plan.truth {
                    self.fresh.push(seconds);
                }
                format!("{seconds:.1} s")
            };
            eprintln!("{place}: {how}{}", self.left(all - self.done));
        }
        Ok(obtained)
    }

    /// The error of an approximation, stage by stage; `None` if it was stopped.
    fn stages(
        &mut self,
        plan: &SensorPlan,
        run: &StudyRun,
        truth: &StoredRun,
    ) -> Result<Option<Attributed>, StudyError> {
        let all = self.session.plan.count();
        let place = format!("[{:>2}/{all}] stages of {}", self.done + 1, run.label());
        eprintln!("{place} ...");
        let start = Instant::now();
        let listen = &mut progress::lines(&place);
        let found = self
            .session
            .attribution(plan, run, truth, self.context, listen)?;
        if self.context.progress.is_stopped() {
            return Ok(None);
        }
        self.done += 1;
        match &found {
            Some(found) if found.was_kept => eprintln!("{place}: kept from before"),
            Some(Attributed {
                found: Ok(found), ..
            }) => eprintln!(
                "{place}: {} runs, {:.1} s",
                found.runs,
                start.elapsed().as_secs_f64()
            ),
            Some(Attributed {
                found: Err(reason), ..
            }) => eprintln!("{place}: none: {reason}"),
            None => (),
        }
        Ok(found)
    }

    /// What is left, by the mean of the runs made so far, the truths apart.
    fn left(&self, runs: usize) -> String {
        let mean = self.fresh.iter().sum::<f64>() / self.fresh.len() as f64;
        if runs == 0 || self.fresh.is_empty() {
            return String::new();
        }
        let left = Duration::from_secs_f64(mean * runs as f64).as_secs();
        format!(
            "; {} s so far, about {left} s left",
            self.start.elapsed().as_secs()
        )
    }

    fn stopped(&self) -> Outcome {
        let all = self.session.plan.count();
        eprintln!(
            "stopped: {} of {all} runs are kept; the same command goes on from there",
            self.done
        );
        Outcome::Incomplete
    }
}

fn list(session: &Session) -> anyhow::Result<()> {
    for plan in &session.plan.sensors {
        let sensor = session.sensor(plan)?;
        let all = [(&plan.truth, "truth, ")]
            .into_iter()
            .chain(plan.runs.iter().map(|run| (run, "")));
        for (run, what) in all {
            let kept = session.store.find(&session.scene, sensor, run);
            let state = kept.map_or("to do", |_| "kept");
            say!("{state:<6} {}: {what}{}", plan.sensor, run.label());
        }
        for run in &plan.attributed {
            let kept = session.kept_attribution(plan, run)?;
            let state = kept.map_or("to do", |_| "kept");
            let runs = attribution::count(&run.method);
            say!(
                "{state:<6} {}: stages of {}, {runs} runs",
                plan.sensor,
                run.label()
            );
        }
    }
    Ok(())
}

/// The outcome of a report that lacks some runs, with its warnings.
fn judged(report: &StudyReport, left: usize) -> Outcome {
    for row in report.sensors.iter().flat_map(|sensor| &sensor.rows) {
        for check in &row.checks {
            eprintln!("warning: {}: {}", row.label, check.message);
        }
    }
    let mut gates = report.sensors.iter().flat_map(|sensor| &sensor.gates);
    let is_kept = gates.all(|gate| gate.verdict == GateVerdict::Kept);
    match (is_kept, left) {
        (false, _) => Outcome::Apart,
        (true, 0) => Outcome::Complete,
        (true, _) => Outcome::Incomplete,
    }
}
