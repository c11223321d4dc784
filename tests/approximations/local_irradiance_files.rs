//! Tables of local precomputed irradiance in files: the same bits as in memory, whatever becomes of files.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::Duration;

use glam::{DMat3, DVec3};
use nephroid::internals::approximation::local_irradiance::LocalIrradiance;
use nephroid::internals::approximation::{SensorFilm, Technique};
use nephroid::internals::geometry::TraversalCounters;
use nephroid::internals::method::Method;
use nephroid::internals::mitsuba;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::{Budget, Context, Rendering};
use nephroid::internals::scene::Scene;
use serde_json::Value;

use crate::support::approximation::{GLASS, ball, lit_by, over_floor, scene_of};
use crate::support::local_irradiance::{rendered, sun, tables};
use crate::support::scenes::meter;

/// Tables that take a blink: 12 light directions.
const SMALL: [(&str, &str); 5] = [
    ("cells", "16"),
    ("shells", "3"),
    ("photons", "4096"),
    ("frequency", "1"),
    ("tables", "all"),
];

fn method(more: &[(&str, &str)]) -> Method {
    tables(&[&SMALL, more].concat())
}

fn run_in(context: &Context, more: &[(&str, &str)], scene: &Scene) -> Rendering {
    let method = method(more);
    method
        .run(scene, meter(scene), &Budget::default(), context)
        .unwrap()
}

fn kept_in(folder: &Path) -> Context {
    Context {
        cache: Some(folder.to_owned()),
        ..Context::default()
    }
}

fn run(folder: &Path, more: &[(&str, &str)], scene: &Scene) -> Rendering {
    run_in(&kept_in(folder), more, scene)
}

fn in_memory(more: &[(&str, &str)], scene: &Scene) -> Vec<Rgb> {
    values(&run_in(&Context::default(), more, scene))
}

fn values(rendering: &Rendering) -> Vec<Rgb> {
    assert!(
        rendering
            .estimate
            .total
            .values
            .iter()
            .any(|value| !value.is_black())
    );
    rendering.estimate.total.values.clone()
}

/// The work of a name over all stages of the preparation.
fn work(rendering: &Rendering, name: &str) -> u64 {
    let stages = rendering.preparation.iter();
    stages.map(|stage| stage.work.get(name)).sum()
}

/// All files of a folder and those in it, by their paths below it.
fn files(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    fn walk(root: &Path, folder: &Path, into: &mut BTreeMap<PathBuf, Vec<u8>>) {
        for entry in fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            if path.is_dir() {
                walk(root, &path, into);
            } else {
                let name = path.strip_prefix(root).unwrap().to_owned();
                into.insert(name, fs::read(&path).unwrap());
            }
        }
    }
    let mut all = BTreeMap::new();
    walk(folder, folder, &mut all);
    all
}

fn glass_ball() -> Scene {
    scene_of(&over_floor(&ball(GLASS), 16))
}

/// Settings of each form of table.
const FORMS: [&[(&str, &str)]; 9] = [
    &[],
    &[
        ("space", "shells"),
        ("shell-level", "2"),
        ("storage", "f16"),
    ],
    &[("space", "multi-resolution"), ("shell-level", "2")],
    &[
        ("space", "multi-resolution"),
        ("tree", "grid"),
        ("storage", "f32"),
    ],
    &[
        ("space", "shell-harmonics"),
        ("shell-level", "2"),
        ("order", "3"),
        ("storage", "exact"),
    ],
    &[
        ("directions", "harmonics"),
        ("order", "2"),
        ("storage", "f32"),
    ],
    &[("storage", "rgb9e5")],
    &[("normal", "vector"), ("storage", "f16")],
    &[
        ("normal", "vector"),
        ("space", "shells"),
        ("shell-level", "2"),
        ("storage", "f32"),
    ],
];

#[test]
fn images_have_the_same_bits_from_memory_from_files_and_after_some_files_are_gone() {
    let scene = glass_ball();
    for settings in FORMS {
        let folder = tempfile::tempdir().unwrap();
        let wanted = in_memory(settings, &scene);
        let made = run(folder.path(), settings, &scene);
        assert_eq!(values(&made), wanted, "{settings:?}");
        assert!(work(&made, "photons") > 0);
        assert_eq!(
            made.warnings,
            run_in(&Context::default(), settings, &scene).warnings
        );
        let there = files(folder.path());

        let read = run(folder.path(), settings, &scene);
        assert_eq!(values(&read), wanted, "{settings:?}");
        assert_eq!(work(&read, "photons"), 0, "{settings:?}");
        let is_table = |name: &&PathBuf| !name.ends_with("shells.table");
        let tables = there.keys().filter(is_table).count() as u64;
        assert_eq!(work(&read, "loaded"), tables, "{settings:?}");
        assert_eq!(
            tables,
            if settings.contains(&("directions", "harmonics")) {
                1
            } else {
                12
            }
        );
        assert_eq!(files(folder.path()), there);

        for (number, name) in there.keys().enumerate() {
            if number % 3 != 1 {
                fs::remove_file(folder.path().join(name)).unwrap();
            }
        }
        let resumed = run(folder.path(), settings, &scene);
        assert_eq!(values(&resumed), wanted, "{settings:?}");
        assert_eq!(files(folder.path()), there, "{settings:?}");
    }
}

#[test]
fn files_have_the_same_bytes_on_any_number_of_threads() {
    let scene = glass_ball();
    for settings in FORMS {
        let mut first = None;
        for threads in [1, 2, 5] {
            let folder = tempfile::tempdir().unwrap();
            let context = Context {
                threads: Some(threads),
                ..kept_in(folder.path())
            };
            let image = values(&run_in(&context, settings, &scene));
            let found = (image, files(folder.path()));
            let first = first.get_or_insert_with(|| found.clone());
            assert!(*first == found, "{settings:?} on {threads} threads");
        }
    }
}

/// A crystal: six corners, no two edges alike.
const CRYSTAL: &str = "v 0.9 0 0\nv -0.7 0.1 0\nv 0 0.8 0.1\nv 0 -0.6 0\nv 0.1 0 1\nv 0 0.1 -0.9\n\
    f 1 3 5\nf 3 2 5\nf 2 4 5\nf 4 1 5\nf 3 1 6\nf 2 3 6\nf 4 2 6\nf 1 4 6\n";

#[test]
fn files_have_the_same_bytes_however_the_object_is_turned_and_wherever_it_is() {
    let source = tempfile::tempdir().unwrap();
    fs::write(source.path().join("crystal.obj"), CRYSTAL).unwrap();
    let crystal = source.path().join("crystal.obj").display().to_string();
    let poses = [
        "",
        r#"<rotate x="0.6" y="0.64" z="-0.48" angle="37"/>"#,
        r#"<rotate z="1" angle="90"/><rotate x="1" angle="-71.3"/><translate x="0.2" y="-0.13" z="0.31"/>"#,
    ];
    let shapes = [
        r#"<shape type="sphere"><float name="radius" value="0.8"/>"#.to_owned(),
        format!(
            r#"<shape type="obj"><string name="filename" value="{crystal}"/>
               <boolean name="face_normals" value="true"/>"#
        ),
    ];
    for shape in shapes {
        let mut first = None;
        for pose in poses {
            let to_world =
                format!(r#"<transform name="to_world">{pose}<translate z="1.3"/></transform>"#);
            let scene = scene_of(&over_floor(&format!("{shape}{to_world}{GLASS}</shape>"), 8));
            let folder = tempfile::tempdir().unwrap();
            for settings in &FORMS[..3] {
                run(folder.path(), settings, &scene);
            }
            let found = files(folder.path());
            assert_eq!(found.len(), 3 * 12 + 2);
            let first = first.get_or_insert_with(|| found.clone());
            assert!(first.keys().eq(found.keys()), "another form: {pose}");
            assert!(*first == found, "other bytes: {pose}");
        }
    }
}

/// A file's bytes after a change, and what a warning says of it.
type Spoiled = (Vec<u8>, &'static str);

fn resealed(mut bytes: Vec<u8>) -> Vec<u8> {
    let end = bytes.len() - 32;
    let hash = blake3::hash(&bytes[..end]);
    bytes[end..].copy_from_slice(hash.as_bytes());
    bytes
}

fn changed(bytes: &[u8], place: usize, to: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    bytes[place..place + to.len()].copy_from_slice(to);
    bytes
}

#[test]
fn a_spoiled_file_is_made_anew_with_a_warning_that_names_it() {
    let scene = glass_ball();
    for settings in &FORMS[..3] {
        let folder = tempfile::tempdir().unwrap();
        let wanted = values(&run(folder.path(), settings, &scene));
        let there = files(folder.path());
        let tables: Vec<&PathBuf> = there
            .keys()
            .filter(|it| !it.ends_with("shells.table"))
            .collect();
        // Shells that are spoiled need their pilot again: once is enough.
        let is_first = *settings == FORMS[1];
        let shells = there
            .keys()
            .filter(|it| is_first && it.ends_with("shells.table"));
        for name in [tables[0]].into_iter().chain(shells) {
            let good = &there[name];
            let length = good.len();
            let is_shells = name.ends_with("shells.table");
            // The header has 92 bytes; then come a tally, 8 bytes of a count, the kind and the form of trees.
            let mut spoiled: Vec<Spoiled> = vec![
                (Vec::new(), "cut off"),
                (good[..40].to_vec(), "cut off"),
                (good[..length - 1].to_vec(), "cut off"),
                (good[..length / 2].to_vec(), "cut off"),
                (changed(good, 0, b"x"), "no table"),
                (changed(good, 8, &[9]), "version 9"),
                (
                    changed(good, 12, &[!good[12]]),
                    "another version of the program",
                ),
                (
                    changed(good, 44, &[!good[44]]),
                    "another object or other settings",
                ),
                (changed(good, 76, &[!good[76]]), "not "),
                (changed(good, 84, &[!good[84]]), "cut off or too long"),
                (changed(good, 91, &[0xff]), "cut off or too long"),
                (
                    changed(good, length / 2 + 20, &[!good[length / 2 + 20]]),
                    "checksum",
                ),
                (changed(good, length - 1, &[!good[length - 1]]), "checksum"),
                ([&good[..], &vec![0; 4 << 20]].concat(), "at most"),
            ];
            if is_shells {
                spoiled.push((resealed(changed(good, 92, &[3])), "3 borders"));
                spoiled.push((
                    resealed(changed(good, 108, &[0xff; 8])),
                    "borders do not grow",
                ));
            } else {
                let kind = 92 + 128 + 8;
                spoiled.push((resealed(changed(good, kind, &[7])), "another kind"));
                // More photons than were asked for, flux without end, more cut off than there is.
                for place in [92, 100, kind - 8] {
                    let to = if place == 100 {
                        f64::INFINITY.to_le_bytes()
                    } else {
                        [0xff; 8]
                    };
                    spoiled.push((resealed(changed(good, place, &to)), "cannot be"));
                }
                let is_tree = good[kind] == 1;
                if is_tree {
                    spoiled.push((
                        resealed(changed(good, kind + 9, &[0xff; 8])),
                        "which is not what",
                    ));
                    spoiled.push((
                        resealed(changed(good, kind + 17, &[0xff; 8])),
                        "which is not what",
                    ));
                    spoiled.push((
                        resealed(changed(good, kind + 25, &[5])),
                        "do not hang together",
                    ));
                } else {
                    spoiled.push((resealed(changed(good, kind + 1, &[9])), "in another way"));
                    spoiled.push((
                        resealed(changed(good, kind + 10, &[0xff; 8])),
                        "numbers, and should have",
                    ));
                }
            }
            for (bytes, said) in spoiled {
                fs::write(folder.path().join(name), bytes).unwrap();
                let again = run(folder.path(), settings, &scene);
                assert_eq!(values(&again), wanted, "{settings:?} {said}");
                let path = folder.path().join(name).display().to_string();
                let is_said = |text: &String| text.contains(&path) && text.contains(said);
                assert!(
                    again.warnings.iter().any(is_said),
                    "{said}: {:?}",
                    again.warnings
                );
                assert!(files(folder.path()) == there, "{settings:?} {said}");
            }
        }
        // A whole file of another sample.
        if tables.len() > 1 {
            fs::write(folder.path().join(tables[0]), &there[tables[1]]).unwrap();
            let again = run(folder.path(), settings, &scene);
            assert_eq!(values(&again), wanted);
            assert!(
                again
                    .warnings
                    .iter()
                    .any(|text| text.contains("it has sample"))
            );
            assert!(files(folder.path()) == there);
        }
    }
}

#[test]
fn a_folder_that_cannot_be_written_gives_a_warning_and_the_same_image() {
    let scene = glass_ball();
    let settings = FORMS[1];
    let wanted = in_memory(settings, &scene);
    let folder = tempfile::tempdir().unwrap();
    // Rights do not stop the system's administrator; a file in the place of a folder does.
    let blocked = folder.path().join("file");
    fs::write(&blocked, "in the way").unwrap();
    let rendering = run(&blocked.join("cache"), settings, &scene);
    assert_eq!(values(&rendering), wanted);
    let said =
        |text: &String| text.contains("13 table files are not written") && text.contains("file");
    assert!(
        rendering.warnings.iter().any(said),
        "{:?}",
        rendering.warnings
    );
    assert_eq!(files(folder.path()).len(), 1);

    // A file that cannot be replaced: a folder is in its place.
    let cache = folder.path().join("cache");
    run(&cache, settings, &scene);
    let there = files(&cache);
    let first = cache.join(there.keys().next().unwrap());
    fs::remove_file(&first).unwrap();
    fs::create_dir(&first).unwrap();
    let rendering = run(&cache, settings, &scene);
    assert_eq!(values(&rendering), wanted);
    let said = |text: &String| text.contains(&first.display().to_string());
    assert!(
        rendering.warnings.iter().any(said),
        "{:?}",
        rendering.warnings
    );
    assert_eq!(files(&cache).len(), there.len() - 1);
}

#[test]
fn a_stopped_run_leaves_whole_files_alone_and_the_next_one_goes_on() {
    let scene = glass_ball();
    let settings: &[(&str, &str)] = &[("photons", "400000")];
    let whole = tempfile::tempdir().unwrap();
    let wanted = values(&run(whole.path(), settings, &scene));
    let all = files(whole.path());
    let folder = tempfile::tempdir().unwrap();
    let context = Context {
        threads: Some(2),
        ..kept_in(folder.path())
    };
    let progress = context.progress.clone();
    let stopper = std::thread::spawn(move || {
        while progress.done() < 800_000 {
            std::thread::sleep(Duration::from_millis(1));
        }
        assert_eq!(progress.expected(), Some(12 * 400_000));
        progress.stop();
    });
    let stopped = run_in(&context, settings, &scene);
    stopper.join().unwrap();
    assert!(stopped.warnings.iter().any(|text| text.contains("stopped")));
    let left = files(folder.path());
    assert!((2..12).contains(&left.len()), "{} files", left.len());
    assert!(
        left.iter()
            .all(|(name, bytes)| all.get(name) == Some(bytes))
    );
    let resumed = run(folder.path(), settings, &scene);
    assert_eq!(work(&resumed, "loaded"), left.len() as u64);
    assert_eq!(values(&resumed), wanted);
    assert!(files(folder.path()) == all);
}

#[test]
fn tables_of_earlier_frames_go_if_they_no_longer_fit_and_come_back_with_the_same_bits() {
    let method = tables(&[
        ("photons", "1024"),
        ("frequency", "1"),
        ("cells", "24"),
        ("directions", "nearest"),
    ]);
    let scenes = ["0", "90", "180", "0"].map(|azimuth| {
        let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes/turntable-ball.xml");
        let given = [("azimuth", azimuth), ("elevation", "20"), ("size", "16")];
        mitsuba::load(&path, &given.map(|(a, b)| (a.to_owned(), b.to_owned()))).unwrap()
    });
    // A table of 24³ cells takes 3 bytes a cell; each sun has its own.
    let table = 3 * 24 * 24 * 24;
    let needed = method.cost(&scenes[0], meter(&scenes[0])).bytes;
    // Beside a frame there is room for one table and a half, and for many.
    for (room, photons_of_the_last) in [(3 * table / 2, 1024), (100 * table, 0)] {
        let context = Context {
            memory_limit: Some(needed + room),
            ..Context::default()
        };
        let mut frames = method.frames();
        let found = scenes.each_ref().map(|scene| {
            let budget = Budget::default();
            frames
                .frame(scene, meter(scene), &budget, &context)
                .unwrap()
        });
        assert_eq!(values(&found[3]), values(&found[0]));
        // The first frame's are those of its preparation.
        assert_eq!(work(&found[0], "photons"), 1024);
        let photons = |frame: &Rendering| -> u64 {
            let stages = frame.stages.iter();
            stages.map(|stage| stage.work.get("photons")).sum()
        };
        assert_eq!(photons(&found[2]), 1024, "{room}");
        assert_eq!(photons(&found[3]), photons_of_the_last, "{room}");
    }
}

#[test]
fn tables_of_one_frame_have_no_files() {
    let scene = glass_ball();
    for (key, value) in [("light", "exact"), ("normal", "exact"), ("region", "exact")] {
        let folder = tempfile::tempdir().unwrap();
        let settings = [("space", "shells"), ("shell-level", "2"), (key, value)];
        assert_eq!(
            values(&run(folder.path(), &settings, &scene)),
            in_memory(&settings, &scene)
        );
        assert!(files(folder.path()).is_empty(), "{key}");
    }
}

#[test]
fn tables_beyond_the_memory_limit_are_refused_with_what_would_fit() {
    let scene = glass_ball();
    let cost = method(&[]).cost(&scene, meter(&scene)).bytes;
    let context = Context {
        memory_limit: Some(cost),
        ..Context::default()
    };
    let refusal = |settings: &[(&str, &str)]| {
        let ran = method(settings).run(&scene, meter(&scene), &Budget::default(), &context);
        ran.map(drop).unwrap_err().to_string()
    };
    assert!(
        method(&[])
            .run(&scene, meter(&scene), &Budget::default(), &context)
            .is_ok()
    );
    let said = refusal(&[("cells", "18")]);
    for words in [
        "12 light directions",
        "sums",
        "resident",
        "what would fit: cells=16",
    ] {
        assert!(said.contains(words), "{said}");
    }
    let said = refusal(&[("frequency", "8")]);
    assert!(
        said.contains("642 light directions") && said.contains("frequency=1"),
        "{said}"
    );
    assert!(said.contains("tables=needed"), "{said}");
}

#[test]
fn exported_volumes_are_read_as_their_description_says() {
    // A box turned every way, so that no axis is another; light and floor aslant.
    let shapes = format!(
        r#"<shape type="cube"><transform name="to_world"><scale x="1" y="0.7" z="0.4"/>
           <rotate x="0.36" y="0.48" z="0.8" angle="77"/><translate x="0.1" y="-0.2" z="1.4"/></transform>{GLASS}</shape>"#
    );
    let scene = scene_of(&lit_by(&sun([0.4, 0.2, -0.9]), &shapes, 8));
    let to_light = -DVec3::new(0.4, 0.2, -0.9).normalize();
    for (space, storage, normal) in [
        ("grid", "u8", "fixed"),
        ("grid", "rgb9e5", "fixed"),
        ("grid", "f32", "vector"),
        ("shells", "f32", "fixed"),
    ] {
        let given = [
            ("space", space),
            ("storage", storage),
            ("normal", normal),
            ("directions", "nearest"),
            ("interpolation", "nearest"),
            ("shell-level", "2"),
            ("samples", "1"),
            ("reach", "2"),
        ];
        let folder = tempfile::tempdir().unwrap();
        let method = method(&given);
        let values =
            crate::support::technique::values(&LocalIrradiance, &[&SMALL[..], &given].concat());
        let context = Context::default();
        let prepared = LocalIrradiance.prepare(&scene, meter(&scene), &values, &context);
        prepared.unwrap().export(&scene, folder.path()).unwrap();
        let json = fs::read(folder.path().join("tables.json")).unwrap();
        let all: Value = serde_json::from_slice(&json).unwrap();
        let object = &all["objects"][0];
        let vector = |value: &Value| -> DVec3 {
            DVec3::from_array(std::array::from_fn(|k| value[k].as_f64().unwrap()))
        };
        let axes = ["x", "y", "z"].map(|axis| vector(&object["axes_in_world"][axis]));
        let own = |v: DVec3| DVec3::from_array(axes.map(|axis| axis.dot(v)));
        let towards = own(to_light);
        let tables = object["tables"].as_array().unwrap();
        let toward = |table: &Value| vector(&table["direction_to_light"]).dot(towards);
        let nearest = tables.iter().max_by(|a, b| toward(a).total_cmp(&toward(b)));
        let file = nearest.unwrap()["file"].as_str().unwrap();
        let raw = fs::read(folder.path().join(file)).unwrap();
        let number = |index: usize| match storage {
            "u8" => {
                f64::from(raw[3 * index]) / 255.0 * all["numbers"]["range"][1].as_f64().unwrap()
            }
            "rgb9e5" => {
                let bytes = &raw[4 * index..4 * index + 4];
                let word = u32::from_le_bytes(bytes.try_into().unwrap());
                f64::from(word & 511) * 2.0_f64.powi((word >> 27) as i32 - 24)
            }
            _ => {
                let bytes = &raw[12 * index..12 * index + 4];
                f64::from(f32::from_le_bytes(bytes.try_into().unwrap()))
            }
        };
        let layout = &object["layout"];
        let film = SensorFilm::new(&scene, meter(&scene)).unwrap();
        let mut counters = TraversalCounters::default();
        let points = film.points(&scene, 0..64, 1, &mut counters).points;
        let rendered = rendered(&method, &scene).estimate.total.values;
        let mut lit = 0;
        for point in points {
            let away = own(point.point.position - vector(&object["centre"]));
            let distance = away.length();
            let held = away * (object["region_radius"].as_f64().unwrap() / distance).min(1.0);
            let index = match space {
                "grid" => in_cubes(layout, held),
                _ => in_shells(layout, held),
            };
            let own_normal = own(point.normal);
            let expected = if normal == "vector" {
                let along = [0, 1, 2].map(|axis| number(3 * index + axis));
                (-own_normal.dot(DVec3::from_array(along))).max(0.0)
            } else {
                number(index) * (-own_normal.dot(away) / distance).max(0.0)
            };
            lit += u32::from(expected > 0.0);
            let found = rendered[point.texel].mean();
            // Numbers are the same; a step of bytes by range/255 is rounded once more.
            assert!(
                (found - expected).abs() < 1e-12,
                "{space} {}: {found} {expected}",
                point.texel
            );
        }
        assert!(lit > 10, "{space}: {lit}");
    }
}

/// The cell of a place, as the description of a grid has it.
fn in_cubes(layout: &Value, place: DVec3) -> usize {
    let side = layout["cells_a_side"].as_u64().unwrap() as usize;
    let half = layout["half_edge"].as_f64().unwrap();
    let at = ((place + half) / (2.0 * half / side as f64)).to_array();
    let [x, y, z] = at.map(|x| (x as usize).min(side - 1));
    (z * side + y) * side + x
}

/// The cell of a place, as the description of shells has it.
fn in_shells(layout: &Value, place: DVec3) -> usize {
    let floats = |value: &Value| -> Vec<f64> {
        let all = value.as_array().unwrap();
        all.iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let radii = floats(&layout["radii"]);
    let shells = radii.len() - 1;
    let inside = |shell: &usize| place.length() <= radii[*shell + 1];
    let shell = (0..shells).find(inside).unwrap_or(shells - 1);
    let faces = layout["face_corners"].as_array().unwrap();
    let corners = |face: usize| -> DMat3 {
        let corner = |k: usize| DVec3::from_slice(&floats(&faces[face][k]));
        DMat3::from_cols(corner(0), corner(1), corner(2))
    };
    let middle = |face: usize| (corners(face) * DVec3::ONE).normalize();
    let face = (0..20)
        .max_by(|a, b| middle(*a).dot(place).total_cmp(&middle(*b).dot(place)))
        .unwrap();
    let f = layout["frequency"].as_u64().unwrap() as usize;
    let weights = corners(face).inverse() * place;
    let scaled = weights * (f as f64 / weights.element_sum());
    let [a, b, c] = scaled.to_array().map(|w| (w as usize).min(f - 1));
    let triangle = if a + b + c + 1 >= f {
        face * f * f + a * f - a * a.saturating_sub(1) / 2 + b
    } else {
        face * f * f + f * (f + 1) / 2 + a * (f - 1) - a * a.saturating_sub(1) / 2 + b
    };
    shell * layout["triangles_a_shell"].as_u64().unwrap() as usize + triangle
}
