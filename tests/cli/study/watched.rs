//! A study as a caller of the library watches and stops it.

use std::collections::BTreeSet;
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
            News::Counts(done, all) => format!("counts {done} of {all}"),
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

/// The numbers in news that begin so.
fn counts(listener: &Listener) -> Vec<usize> {
    let counts = listener
        .heard
        .iter()
        .filter_map(|line| line.strip_prefix("counts "));
    counts
        .map(|line| line.split(' ').next().unwrap().parse().unwrap())
        .collect()
}

fn names(folder: &Path) -> BTreeSet<String> {
    let files = std::fs::read_dir(folder).unwrap();
    files
        .map(|file| file.unwrap().file_name().into_string().unwrap())
        .collect()
}

/// An attribution is its first run and parts of four others. Two parts are there once nine runs are done.
#[test]
fn an_attribution_that_is_stopped_goes_on_after_its_parts_that_are_done() {
    let folder = Folder::new();
    folder.study(
        "s.toml",
        "[truth]\nmethod = \"beams\"\nerror = \"3%\"\n[[method]]\nmethod = \"caustic-map\"\nphotons = 64\nmap = 64\n",
    );
    let file = StudyFile::wanted(&folder.path("s.toml"), &StudyWishes::default()).unwrap();
    let run = |to: &str, stops_at: &'static str| {
        let mut listener = Listener {
            stops_at,
            ..Listener::default()
        };
        let context = listener.context.clone();
        validate(&file, &folder.path(to), &context, &mut listener).unwrap();
        counts(&listener)
    };
    let whole = run("whole", "");
    let all = whole.len();
    assert!(all > 13, "{whole:?}");
    assert_eq!(whole, (1..=all).collect::<Vec<_>>());
    let said = format!("counts 9 of {all}").leak();
    assert_eq!(run("parts", said), (1..=9).collect::<Vec<_>>());
    let kept = names(&folder.path("parts/runs"));
    let of_parts: Vec<&String> = kept
        .iter()
        .filter(|name| name.contains("-stages"))
        .collect();
    assert_eq!(of_parts.len(), 3, "{of_parts:?}");
    let place = |to: &str, of: &str| {
        let name = of_parts.iter().find(|name| name.contains(of)).unwrap();
        folder.path(to).join("runs").join(name)
    };
    // What is kept is not made again: another name of the light gets into the report.
    std::fs::create_dir_all(folder.path("altered/runs")).unwrap();
    for name in &kept {
        let [from, to] = ["parts/runs", "altered/runs"].map(|at| folder.path(at).join(name));
        std::fs::copy(from, to).unwrap();
    }
    let begun = place("altered", "-stages-begun-");
    let text = std::fs::read_to_string(&begun).unwrap();
    let altered = text.replace("\"layer\": \"LTTD\"", "\"layer\": \"light\"");
    assert_ne!(text, altered);
    std::fs::write(begun, altered).unwrap();
    assert_eq!(run("altered", ""), (9..=all).collect::<Vec<_>>());
    let report = |to: &str| std::fs::read_to_string(folder.path(to).join("report.json")).unwrap();
    assert!(report("altered").contains("\"light\": \"light\""));
    // One of the two parts is damaged, and made again.
    std::fs::write(place("parts", "-stages-1-of-"), "{").unwrap();
    assert_eq!(run("parts", ""), (5..=all).collect::<Vec<_>>());
    assert_eq!(report("whole"), report("parts"));
    // Parts that are not needed any more are gone.
    let [whole, parts] = ["whole", "parts"].map(|to| names(&folder.path(to).join("runs")));
    assert_eq!(whole, parts);
    let of_stages = whole.iter().filter(|name| name.contains("-stages"));
    assert_eq!(of_stages.count(), 1, "{whole:?}");
}
