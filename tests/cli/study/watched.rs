//! A study as a caller of the library watches and stops it.

use std::path::Path;
use std::sync::Arc;

use nephroid::Context;
use nephroid::internals::mitsuba;
use nephroid::internals::study::StudyFile;
use nephroid::internals::study::file::StudyWishes;
use nephroid::internals::study::validation::{
    Done, News, Report, Watcher, validate, validate_scene,
};

use super::folder::{Folder, scene};

/// Notes what it hears, and stops the study at one piece of news.
#[derive(Default)]
struct Listener {
    context: Context,
    heard: Vec<String>,
    stops_at: &'static str,
}

impl Watcher for Listener {
    fn hear(&mut self, news: News) {
        let line = match news {
            News::Planned(plan, _) => format!("planned {}", plan.count()),
            News::Begins(task) => format!("begins {}", task.number),
            News::Done(task, Done::Kept, _) => format!("kept {}", task.number),
            News::Done(task, ..) => format!("made {}", task.number),
            News::Judges(row, rows, label) => format!("judges {row} of {rows}: {label}"),
            News::Judged(report) => format!("judged {}", report.sensors[0].rows.len()),
            News::Stopped(kept, all) => format!("stopped {kept} of {all}"),
            other => format!("{other:?}"),
        };
        if line == self.stops_at {
            self.context.progress.stop();
        }
        self.heard.push(line);
    }
}

fn study(folder: &Folder) -> StudyFile {
    StudyFile::wanted(&folder.path("a.toml"), &StudyWishes::default()).unwrap()
}

#[test]
fn a_study_tells_its_course_and_returns_what_it_writes() {
    let folder = Folder::with_films();
    let mut listener = Listener::default();
    let context = listener.context.clone();
    let to = folder.path("r");
    let validated = validate(&study(&folder), &to, &context, &mut listener).unwrap();
    let runs = (1..=5).flat_map(|run| [format!("begins {run}"), format!("kept {run}")]);
    let labels = [
        "beams error=10%",
        "photons=4096",
        "photons=16384",
        "photons=65536",
    ];
    let judges = (1..).zip(labels);
    let judges = judges.map(|(row, label)| format!("judges {row} of 4: {label}"));
    let expected = std::iter::once("planned 5".to_owned())
        .chain(runs)
        .chain(judges);
    let expected: Vec<String> = expected.chain(["judged 4".to_owned()]).collect();
    assert_eq!(listener.heard, expected);
    assert!(validated.is_complete && validated.is_kept);
    let Some(Report::One(found)) = validated.report else {
        panic!("a study without poses has one report");
    };
    let written = std::fs::read_to_string(to.join("report.json")).unwrap();
    let returned = serde_json::to_string_pretty(&found.0).unwrap();
    assert_eq!(written.trim_end(), returned);
}

#[test]
fn a_study_that_is_stopped_while_it_is_judged_writes_nothing_and_goes_on_later() {
    let folder = Folder::with_films();
    let mut listener = Listener {
        stops_at: "judges 2 of 4: photons=4096",
        ..Listener::default()
    };
    let context = listener.context.clone();
    let to = folder.path("r");
    let validated = validate(&study(&folder), &to, &context, &mut listener).unwrap();
    assert!(validated.report.is_none() && !validated.is_complete);
    assert_eq!(listener.heard.last().unwrap(), "stopped 5 of 5");
    // What comes after is not judged any more.
    let judged = |line: &&String| line.starts_with("judges");
    assert_eq!(listener.heard.iter().filter(judged).count(), 2);
    assert!(!to.join("report.json").exists() && !to.join("index.html").exists());
    let mut again = Listener::default();
    let context = again.context.clone();
    let validated = validate(&study(&folder), &to, &context, &mut again).unwrap();
    assert!(validated.report.is_some() && validated.is_complete);
}

#[test]
fn a_study_that_is_stopped_while_its_last_row_is_judged_writes_nothing() {
    let folder = Folder::with_films();
    let mut listener = Listener::default();
    let context = listener.context.clone();
    let to = folder.path("r");
    let run = |listener: &mut Listener, context| {
        validate(&study(&folder), &to, context, listener).unwrap()
    };
    run(&mut listener, &context);
    let judged = |line: &&String| line.starts_with("judges");
    let last = listener.heard.iter().rfind(judged).unwrap().clone();
    std::fs::remove_file(to.join("report.json")).unwrap();
    let mut listener = Listener {
        stops_at: last.leak(),
        ..Listener::default()
    };
    let context = listener.context.clone();
    let validated = run(&mut listener, &context);
    assert!(validated.report.is_none() && !validated.is_complete);
    assert_eq!(listener.heard.last().unwrap(), "stopped 5 of 5");
    assert!(!to.join("report.json").exists());
}

#[test]
fn a_scene_that_is_read_already_has_the_films_of_its_file() {
    let folder = Folder::with_films();
    let file = study(&folder);
    let scene = Arc::new(mitsuba::load(&scene(), &file.define).unwrap());
    let mut listener = Listener::default();
    let context = listener.context.clone();
    // The file is not read again.
    let unread = StudyFile {
        scene: Path::new("<memory>").to_owned(),
        ..file
    };
    let to = folder.path("r");
    let validated = validate_scene(scene, &unread, &to, &context, &mut listener).unwrap();
    assert!(validated.report.is_some());
    let kept = listener
        .heard
        .iter()
        .filter(|line| line.starts_with("kept"));
    assert_eq!(kept.count(), 5, "{:?}", listener.heard);
}
