//! The runs of a study, one after the other, up to its report.

use std::path::Path;
use std::time::{Duration, Instant};

use super::super::StudyError;
use super::super::attribution::Attribution;
use super::super::plan::{SensorPlan, StudyRun};
use super::super::report::{self, JudgedFilm, SensorFilms, StudyReport, Timings};
use super::super::session::{Obtained, Session};
use super::super::stages::{Attributed, Part, Stages};
use super::super::store::StoredRun;
use super::candidates;
use super::news::{Done, Left, News, Task, Watcher};
use crate::reference::shard::Shard;
use crate::run::Context;

/// Studies under way.
pub struct Course<'a, W> {
    /// What runs have around them.
    pub context: &'a Context,
    /// When the first one began.
    pub start: Instant,
    /// Whoever hears of them.
    pub watcher: &'a mut W,
}

impl<'a, W: Watcher> Course<'a, W> {
    /// Studies that begin now.
    pub fn new(context: &'a Context, watcher: &'a mut W) -> Self {
        Self {
            context,
            start: Instant::now(),
            watcher,
        }
    }

    /// Makes a study, and writes its report; there is none if it was stopped. False if it is not complete.
    ///
    /// # Errors
    ///
    /// If a run cannot be made, or the report not be written.
    pub fn study(
        &mut self,
        session: &Session,
        folder: &Path,
    ) -> Result<(bool, Option<(StudyReport, Timings)>), StudyError> {
        let plan = &session.plan;
        let all = plan.count();
        self.watcher.hear(News::Planned(plan, folder));
        // Before the first run: an image of the wrong size is better known now.
        let mut copies = Vec::new();
        for sensor in &plan.sensors {
            copies.push(candidates::copy(session, sensor)?);
        }
        let mut work = Work::new(session, self, all);
        let mut films = Vec::new();
        for (sensor, copied) in plan.sensors.iter().zip(copies) {
            match work.sensor(sensor, copied)? {
                Filled::All(one) => films.push(*one),
                Filled::TimeOver => (),
                Filled::Stopped => {
                    let done = work.done;
                    self.watcher.hear(News::Stopped(done, all));
                    return Ok((false, None));
                }
            }
        }
        let (done, left) = (work.done, work.left_out);
        let rows: usize = films.iter().map(|one| one.judged.len()).sum();
        let progress = &self.context.progress;
        let built = report::build(session, &films, &mut |i, label| {
            self.watcher.hear(News::Judges(i + 1, rows, label));
            !progress.is_stopped()
        })?;
        // It may have been stopped while the last row was judged.
        let built = built.filter(|_| !progress.is_stopped());
        let Some((mut report, timings)) = built else {
            self.watcher.hear(News::Stopped(done, all));
            return Ok((false, None));
        };
        report.left_out = left;
        if left > 0 {
            report.warnings.push(format!(
                "{left} runs were not made: the study's time was over"
            ));
        }
        report::write(folder, &report, &timings)?;
        self.watcher.hear(News::Judged(&report));
        Ok((left == 0, Some((report, timings))))
    }

    /// Makes one portion of a study, with what it needs and the folder lacks, and no report. False if it was
    /// stopped.
    ///
    /// # Errors
    ///
    /// If a run cannot be made.
    pub fn only(&mut self, session: &Session, portion: Portion) -> Result<bool, StudyError> {
        Work::new(session, self, 1).make(portion)
    }

    /// Makes the runs of a study that are dealt to a shard, and no report. False if it was stopped, or its
    /// time was over.
    ///
    /// # Errors
    ///
    /// If a run cannot be made.
    pub fn share(
        &mut self,
        session: &Session,
        folder: &Path,
        deal: &mut Deal,
    ) -> Result<bool, StudyError> {
        let plan = &session.plan;
        self.watcher.hear(News::Planned(plan, folder));
        for sensor in &plan.sensors {
            candidates::copy(session, sensor)?;
        }
        let mut dealt = portions(session)?;
        dealt.retain(|portion| match portion.make {
            // It is made with the truth.
            Make::Part(..) => false,
            Make::Truth => deal.is_mine(true),
            Make::Run(_) => deal.is_mine(false),
        });
        let all = dealt.iter().map(Portion::count).sum();
        let mut work = Work::new(session, self, all);
        for portion in dealt {
            if work.is_time_over() {
                work.left_out += 1;
                continue;
            }
            if !work.make_dealt(portion)? {
                let done = work.done;
                self.watcher.hear(News::Stopped(done, all));
                return Ok(false);
            }
        }
        let left = work.left_out;
        if left > 0 {
            self.watcher.hear(News::RunsLeft(left, all));
        }
        Ok(left == 0)
    }
}

/// What is made by itself, on any machine.
#[derive(Clone, Copy)]
pub struct Portion<'a> {
    /// The plan of its sensor.
    pub plan: &'a SensorPlan,
    /// What it makes.
    pub make: Make<'a>,
}

/// What a portion makes.
#[derive(Clone, Copy, PartialEq)]
pub enum Make<'a> {
    /// The truth.
    Truth,
    /// A run that the truth judges.
    Run(&'a StudyRun),
    /// A part of the attribution of a run's error.
    Part(&'a StudyRun, Part),
}

impl Portion<'_> {
    /// Number of its runs, and of the attributions that a shard makes with a truth.
    fn count(&self) -> usize {
        match self.make {
            Make::Truth => 1 + self.plan.attributed.len(),
            Make::Run(_) | Make::Part(..) => 1,
        }
    }
}

/// All portions of a study. What one needs comes before it.
///
/// # Errors
///
/// If the scene does not have a sensor.
pub fn portions(session: &Session) -> Result<Vec<Portion<'_>>, StudyError> {
    let mut all = Vec::new();
    for plan in &session.plan.sensors {
        let mut makes = vec![Make::Truth];
        for run in &plan.attributed {
            let parts = Stages::new(session, plan, run)?.parts().into_iter();
            makes.extend(parts.map(|part| Make::Part(run, part)));
        }
        makes.extend(plan.runs.iter().map(Make::Run));
        all.extend(makes.into_iter().map(|make| Portion { plan, make }));
    }
    Ok(all)
}

/// Deals runs to shards, one after the other. A truth and the attributions that need its film are dealt as
/// one. Truths take longest: they are dealt apart, from the first shard on, and all else from the last.
pub struct Deal {
    shard: Shard,
    /// How many truths were dealt, and how many others.
    dealt: [u32; 2],
}

impl Deal {
    /// Deals to a shard.
    pub fn new(shard: Shard) -> Self {
        let dealt = [0; 2];
        Self { shard, dealt }
    }

    /// True if the next one is this shard's.
    fn is_mine(&mut self, is_truth: bool) -> bool {
        let Shard { index, count } = self.shard;
        let dealt = &mut self.dealt[usize::from(!is_truth)];
        let next = *dealt % count;
        *dealt += 1;
        index == if is_truth { next } else { count - 1 - next }
    }
}

/// A run of an approximation, and the error of its stages.
type RunStages<'a> = (&'a StudyRun, Result<Attribution, String>);

/// The runs of a study under way.
struct Work<'a, 'b, 'c, W> {
    session: &'a Session,
    course: &'c mut Course<'b, W>,
    /// Runs to make.
    all: usize,
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

impl<'a, 'b, 'c, W: Watcher> Work<'a, 'b, 'c, W> {
    fn new(session: &'a Session, course: &'c mut Course<'b, W>, all: usize) -> Self {
        Self {
            session,
            course,
            all,
            fresh: Vec::new(),
            done: 0,
            left_out: 0,
        }
    }

    /// Makes a portion. False if it was stopped.
    fn make(&mut self, Portion { plan, make }: Portion<'a>) -> Result<bool, StudyError> {
        match make {
            Make::Truth => Ok(self.truth(plan)?.is_some()),
            Make::Run(run) => Ok(self.obtain(plan, run, "")?.is_some()),
            Make::Part(run, part) => {
                let Some(truth) = self.truth(plan)? else {
                    return Ok(false);
                };
                let context = self.course.context;
                Stages::new(self.session, plan, run)?.make(part, &truth, context)
            }
        }
    }

    /// Makes a portion, and with a truth the attributions that need its film. False if it was stopped.
    fn make_dealt(&mut self, portion: Portion<'a>) -> Result<bool, StudyError> {
        let Portion { plan, make } = portion;
        if make != Make::Truth {
            return self.make(portion);
        }
        Ok(match self.truth(plan)? {
            Some(truth) => self.all_stages(plan, &truth)?.is_some(),
            None => false,
        })
    }

    /// A sensor's truth; `None` if it was stopped.
    fn truth(&mut self, plan: &'a SensorPlan) -> Result<Option<StoredRun>, StudyError> {
        let truth = self.obtain(plan, &plan.truth, "truth, ")?;
        Ok(truth.map(|truth| truth.stored))
    }

    /// The attributions that need the film of a sensor's truth, as far as the study's time allows; `None`
    /// if it was stopped.
    fn all_stages(
        &mut self,
        plan: &'a SensorPlan,
        truth: &StoredRun,
    ) -> Result<Option<Vec<RunStages<'a>>>, StudyError> {
        let mut all = Vec::new();
        for run in &plan.attributed {
            if self.is_time_over() {
                self.left_out += 1;
                continue;
            }
            let found = self.stages(plan, run, truth)?;
            if self.is_stopped() {
                return Ok(None);
            }
            all.extend(found.map(|found| (run, found.found)));
        }
        Ok(Some(all))
    }

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
        let Some(truth) = self.truth(plan)? else {
            return Ok(Filled::Stopped);
        };
        let mut films = SensorFilms {
            plan,
            truth,
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
        match self.all_stages(plan, &films.truth)? {
            Some(stages) => films.stages = stages,
            None => return Ok(Filled::Stopped),
        }
        Ok(Filled::All(Box::new(films.distinct())))
    }

    fn is_time_over(&self) -> bool {
        let time = self.session.plan.time;
        time.is_some_and(|time| self.course.start.elapsed() >= time)
    }

    fn is_stopped(&self) -> bool {
        self.course.context.progress.is_stopped()
    }

    /// The next run, of which is told that it begins.
    fn begin(&mut self, name: String) -> Task {
        let task = Task {
            number: self.done + 1,
            all: self.all,
            name,
        };
        self.course.watcher.hear(News::Begins(&task));
        task
    }

    /// A run; `None` where it was stopped.
    fn obtain(
        &mut self,
        plan: &SensorPlan,
        run: &StudyRun,
        what: &str,
    ) -> Result<Option<Obtained>, StudyError> {
        let on = if self.session.plan.sensors.len() > 1 {
            format!("{}: ", plan.sensor)
        } else {
            String::new()
        };
        let task = self.begin(format!("{on}{what}{}", run.label()));
        let start = Instant::now();
        let (session, context) = (self.session, self.course.context);
        let sensor = session.sensor(plan)?;
        let obtained = self
            .course
            .watcher
            .watch(&context.progress, || session.obtain(sensor, run, context))?;
        if self.is_stopped() {
            return Ok(None);
        }
        self.done += 1;
        if let Some(obtained) = &obtained {
            let time = start.elapsed();
            let how = if obtained.was_kept {
                Done::Kept
            } else {
                if *run != plan.truth {
                    self.fresh.push(time.as_secs_f64());
                }
                Done::Made(time)
            };
            let left = self.left(task.all - self.done);
            self.course.watcher.hear(News::Done(&task, how, left));
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
        let task = self.begin(format!("stages of {}", run.label()));
        let start = Instant::now();
        let (session, context) = (self.session, self.course.context);
        let watcher = &mut *self.course.watcher;
        let listen = &mut |done, all| watcher.hear(News::Counts(done, all));
        let found = Stages::new(session, plan, run)?.attribute(truth, context, listen)?;
        if self.is_stopped() {
            return Ok(None);
        }
        self.done += 1;
        let how = found.as_ref().map(|found| match found {
            found if found.was_kept => Done::Kept,
            Attributed {
                found: Ok(found), ..
            } => Done::Attributed(found.runs, start.elapsed()),
            Attributed {
                found: Err(reason), ..
            } => Done::NotAttributed(reason),
        });
        if let Some(how) = how {
            self.course.watcher.hear(News::Done(&task, how, None));
        }
        Ok(found)
    }

    /// What is left if so many runs are.
    fn left(&self, runs: usize) -> Option<Left> {
        let mean = self.fresh.iter().sum::<f64>() / self.fresh.len() as f64;
        (runs > 0 && !self.fresh.is_empty()).then(|| Left {
            so_far: self.course.start.elapsed(),
            left: Duration::from_secs_f64(mean * runs as f64),
        })
    }
}
