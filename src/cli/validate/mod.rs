//! `nephroid validate`: what error costs, as a report.

mod args;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::time::{Duration, Instant};

use anyhow::Context;

use super::Outcome;
use super::progress;
use super::render::set_threads;
use crate::film::atomic;
use crate::film::exr;
use crate::metric::{self, Source};
use crate::reference::Progress;
use crate::study::file::Candidate;
use crate::study::report::{self, GateVerdict, Judged, Report, StageFilms, Timings};
use crate::study::store::Stored;
use crate::study::{Obtained, Run, Session, StageRuns, Store, StudyError, StudyFile};
pub use args::ValidateArgs;

/// Runs the command.
///
/// # Errors
///
/// Where the study cannot be read, a run not be made, or the report not be written.
pub fn validate(args: &ValidateArgs) -> anyhow::Result<Outcome> {
    let start = Instant::now();
    set_threads(args.threads)?;
    let progress = Arc::new(Progress::default());
    progress::stop_on_interrupt(&progress)?;
    let file = study(args)?;
    let folder = folder(args);
    let films = folder.join("runs");
    std::fs::create_dir_all(&folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    atomic::check(&folder.join("index.html"))?;
    let session = Session::new(&file, Store::open(&films)?)?;
    if args.list {
        list(&session)?;
        return Ok(Outcome::Complete);
    }
    let mut work = Work {
        session: &session,
        progress: &progress,
        start,
        fresh: Vec::new(),
        done: 0,
    };
    let plan = &session.plan;
    eprintln!(
        "{}, sensor {}: {} runs, {} candidates; report in {}",
        plan.scene.display(),
        plan.sensor,
        plan.count(),
        plan.candidates.len(),
        folder.display()
    );
    // Before the first run: an image of the wrong size is better known now.
    let candidates = candidates(&session)?;
    let Some(truth) = work.obtain(&plan.truth, "truth, ")? else {
        return Ok(work.stopped());
    };
    let mut judged = Vec::new();
    let mut left = 0;
    for run in &plan.runs {
        if plan.time.is_some_and(|time| start.elapsed() >= time) {
            left += 1;
            continue;
        }
        match work.obtain(run, "")? {
            Some(obtained) => judged.push(Judged::Run(run, Box::new(obtained.stored))),
            None => return Ok(work.stopped()),
        }
    }
    judged.extend(candidates);
    let mut stages = Vec::new();
    for runs in &plan.stages {
        if plan.time.is_some_and(|time| start.elapsed() >= time) {
            left += 1 + 2 * runs.stages.len();
            continue;
        }
        match work.stages(runs)? {
            Some(films) => stages.push(films),
            None => return Ok(work.stopped()),
        }
    }
    let (mut report, timings) = report::build(
        &session,
        &truth.stored,
        &judged,
        &stages,
        &mut |i, label| {
            eprintln!("judging {} of {}: {label}", i + 1, judged.len());
        },
    )?;
    if left > 0 {
        report.warnings.push(format!(
            "{left} runs were not made: the study's time was over"
        ));
    }
    finish(args, &folder, &report, &timings, left)
}

/// The runs of a study under way.
struct Work<'a> {
    session: &'a Session,
    progress: &'a Progress,
    start: Instant,
    /// Seconds of runs that were not in the store.
    fresh: Vec<f64>,
    done: usize,
}

impl Work<'_> {
    /// A run, with a line on how it went; `None` where it was stopped.
    fn obtain(&mut self, run: &Run, what: &str) -> Result<Option<Obtained>, StudyError> {
        let all = self.session.plan.count();
        let place = format!("[{:>2}/{all}] {what}{}", self.done + 1, run.label());
        eprintln!("{place} ...");
        let start = Instant::now();
        let obtained = progress::watch(self.progress, || self.session.obtain(run, self.progress))?;
        if self.progress.stop.load(Ordering::Relaxed) {
            return Ok(None);
        }
        self.done += 1;
        if let Some(obtained) = &obtained {
            let seconds = start.elapsed().as_secs_f64();
            let how = if obtained.was_kept {
                "kept from before".to_owned()
            } else {
                self.fresh.push(seconds);
                format!("{seconds:.1} s")
            };
            eprintln!("{place}: {how}{}", self.left(all - self.done));
        }
        Ok(obtained)
    }

    /// An approximation with its stages exact, one by one; `None` where it was stopped.
    fn stages<'r>(&mut self, runs: &'r StageRuns) -> Result<Option<StageFilms<'r>>, StudyError> {
        let mut film = |run: &Run| -> Result<Option<Stored>, StudyError> {
            let obtained = self.obtain(run, "stages, ")?;
            Ok(obtained.map(|obtained| obtained.stored))
        };
        let Some(all) = film(&runs.all)? else {
            return Ok(None);
        };
        let mut stages = Vec::new();
        for stage in &runs.stages {
            let (Some(alone), Some(cumulative)) = (film(&stage.alone)?, film(&stage.cumulative)?)
            else {
                return Ok(None);
            };
            stages.push([alone, cumulative]);
        }
        Ok(Some(StageFilms { runs, all, stages }))
    }

    /// What is left, by the mean of the runs made so far.
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

/// What is asked for: the file's study, or the default one of a scene, with what the flags say.
fn study(args: &ValidateArgs) -> anyhow::Result<StudyFile> {
    let is_toml = args
        .study
        .extension()
        .is_some_and(|extension| extension == "toml");
    let mut file = if is_toml {
        StudyFile::read(&args.study)?
    } else {
        StudyFile::of_scene(&args.study)
    };
    for (key, value) in &args.define {
        file.define.retain(|(name, _)| name != key);
        file.define.push((key.clone(), value.clone()));
    }
    if args.sensor.is_some() {
        file.sensor.clone_from(&args.sensor);
    }
    file.margin = args.margin.or(file.margin);
    file.repeats = args.repeats.unwrap_or(file.repeats);
    let given = args.candidate.iter().map(|(name, path)| Candidate {
        name: name.clone(),
        file: path.clone(),
        seconds: None,
    });
    file.candidates.extend(given);
    file.max_error.extend(args.max_error.iter().cloned());
    Ok(file)
}

/// Where the report goes.
fn folder(args: &ValidateArgs) -> PathBuf {
    args.output.clone().unwrap_or_else(|| {
        let mut name = args.study.file_stem().unwrap_or_default().to_owned();
        name.push(".report");
        Path::new("out").join(name)
    })
}

/// Copies the candidates into the store, beside the films that they are shown with.
fn candidates(session: &Session) -> anyhow::Result<Vec<Judged<'_>>> {
    let film = &session.sensor()?.film;
    let expected = [film.crop.width as usize, film.crop.height as usize];
    let mut judged = Vec::new();
    for (i, candidate) in session.plan.candidates.iter().enumerate() {
        let image = exr::read(&candidate.file)?;
        let size = [image.width, image.height];
        if size != expected {
            let is_turned = size == [expected[1], expected[0]];
            return Err(StudyError::Size {
                file: candidate.file.display().to_string(),
                size,
                sensor: session.plan.sensor.clone(),
                expected,
                hint: if is_turned {
                    ": are rows and columns exchanged?"
                } else {
                    ""
                }
                .to_owned(),
            }
            .into());
        }
        // With itself: what cannot be compared at all is better known now, too.
        let source = Source::new(candidate.file.display().to_string(), image);
        let quick = metric::Settings {
            pixels_per_degree: None,
            ..metric::Settings::default()
        };
        metric::compare(&source, &source, &quick)?;
        let allowed = |c: char| c.is_ascii_alphanumeric() || "-.".contains(c);
        let plain = candidate
            .name
            .chars()
            .map(|c| if allowed(c) { c } else { '-' });
        let name = format!("candidate-{}-{}.exr", i + 1, plain.collect::<String>());
        let bytes =
            std::fs::read(&candidate.file).with_context(|| candidate.file.display().to_string())?;
        atomic::write(&session.store.path(&name), |file| {
            std::io::Write::write_all(file, &bytes)
        })?;
        judged.push(Judged::Candidate(candidate, name));
    }
    Ok(judged)
}

fn list(session: &Session) -> anyhow::Result<()> {
    let sensor = session.sensor()?;
    for (run, what) in std::iter::once((&session.plan.truth, "truth, "))
        .chain(session.plan.runs.iter().map(|run| (run, "")))
    {
        let kept = session.store.find(&session.scene, sensor, run);
        let state = kept.map_or("to do", |_| "kept");
        say!("{state:<6} {what}{}", run.label());
    }
    Ok(())
}

/// Writes the report, and says what a reader wants to know first.
fn finish(
    args: &ValidateArgs,
    folder: &Path,
    report: &Report,
    timings: &Timings,
    left: usize,
) -> anyhow::Result<Outcome> {
    report::write(folder, report, timings)?;
    if args.json {
        say!("{}", serde_json::to_string_pretty(report)?);
    } else {
        say!("{}", report::markdown(report, timings).trim_end());
        say!("\nwrote {}", folder.join("index.html").display());
    }
    for row in &report.rows {
        for check in &row.checks {
            eprintln!("warning: {}: {}", row.label, check.message);
        }
    }
    let is_kept = report
        .gates
        .iter()
        .all(|gate| gate.verdict == GateVerdict::Kept);
    Ok(match (is_kept, left) {
        (false, _) => Outcome::Apart,
        (true, 0) => Outcome::Complete,
        (true, _) => Outcome::Incomplete,
    })
}
