//! Names of files in scenes: which file is read, and that none is written.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::SystemTime;

use flate2::Compression;
use tempfile::TempDir;

use super::honest::{Kind, noise};
use super::watch::{alone, load, load_elements, scene_of};
use crate::support::geometry::icosphere;
use crate::support::mutation::{obj, ply, serialized, serialized_contents};

#[cfg(unix)]
#[test]
fn devices_and_pipes_are_no_files() {
    let _alone = alone();
    let pipe = TempDir::new().unwrap();
    let pipe = pipe.path().join("pipe");
    let folder = pipe.parent().unwrap();
    std::fs::create_dir_all(folder).unwrap();
    let made = std::process::Command::new("mkfifo").arg(&pipe).status();
    let mut names = vec![PathBuf::from("/dev/zero"), folder.to_owned()];
    if made.is_ok_and(|status| status.success()) {
        names.push(pipe.clone());
    }
    for name in names {
        let name = name.display();
        for elements in [
            format!("<shape type=\"obj\"><string name=\"filename\" value=\"{name}\"/></shape>"),
            format!("<shape type=\"ply\"><string name=\"filename\" value=\"{name}\"/></shape>"),
            format!(
                "<shape type=\"serialized\"><string name=\"filename\" value=\"{name}\"/></shape>"
            ),
            format!(
                "<emitter type=\"envmap\"><string name=\"filename\" value=\"{name}\"/></emitter>"
            ),
            format!("<include filename=\"{name}\"/>"),
            Kind::Exr
                .elements()
                .replace("\"it\"", &format!("\"{name}\"")),
        ] {
            let outcome = load_elements(&elements);
            assert!(
                outcome.peak < 1 << 20,
                "{elements}: {} bytes of heap",
                outcome.peak
            );
            let said = match outcome.result {
                Err(error) => error,
                // An image that no irradiance depends on may be missing.
                Ok(scene) => scene.warnings().iter().map(ToString::to_string).collect(),
            };
            let is_meant = ["cannot be read", "there is no file", "there is no image"];
            assert!(
                is_meant.iter().any(|text| said.contains(text)),
                "{elements}: {said}"
            );
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}

#[test]
fn only_what_the_file_names_is_read_and_nothing_is_written() {
    let _alone = alone();
    let root = TempDir::new().unwrap();
    let write = |name: &str, contents: &str| {
        let path = root.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, contents).unwrap();
    };
    let triangle = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    let shape = |name: &str| {
        format!("<shape type=\"obj\"><string name=\"filename\" value=\"{name}\"/></shape>")
    };
    write("above.obj", triangle);
    write("scene/parts/below.obj", triangle);
    write(
        "scene/parts/part.xml",
        &scene_of("<path value=\"deeper\"/>"),
    );
    write("scene/parts/deeper/deep.obj", triangle);
    // What mesh files name is not read: neither materials nor textures.
    write("scene/plain.obj", triangle);
    write(
        "scene/names.obj",
        &format!(
            "mtllib /dev/zero\nmtllib ../above.obj\nusemtl x\nmap_Kd ../above.png\n{triangle}"
        ),
    );
    write("above.png", "no image");
    let named = String::from_utf8(ply(&icosphere(0), "ascii")).unwrap();
    let comment = "format ascii 1.0\ncomment TextureFile ../above.png\nobj_info /dev/zero";
    write(
        "scene/names.ply",
        &named.replacen("format ascii 1.0", comment, 1),
    );
    let load = |elements: &str| {
        write("scene/scene.xml", &scene_of(elements));
        load(&root.path().join("scene/scene.xml")).result
    };
    assert!(load(&shape("plain.obj")).is_ok());
    // Were they read, the hash over all that is read would change with them.
    let names_others = format!(
        "{}<shape type=\"ply\"><string name=\"filename\" value=\"names.ply\"/></shape>",
        shape("names.obj")
    );
    let hash = || load(&names_others).unwrap().content_hash().to_owned();
    let with_them = hash();
    write("above.png", "no image any more");
    write("above.obj", "no mesh any more");
    assert_eq!(hash(), with_them);
    write("above.obj", triangle);
    // What is named with its way is found, ...
    assert!(load(&shape("../above.obj")).is_ok());
    assert!(load(&shape("parts/below.obj")).is_ok());
    // ... what is not is not looked for: neither above nor below, nor where an include looked.
    for missing in ["above.obj", "below.obj", "deep.obj"] {
        let error = load(&format!(
            "<include filename=\"parts/part.xml\"/>{}",
            shape(missing)
        ))
        .unwrap_err();
        assert!(error.contains("cannot be read"), "{error}");
    }
    // Where an old file says that its image belongs, none is put.
    let film = r#"<sensor type="perspective"><film type="hdrfilm"><string name="filename" value="../image.exr"/></film></sensor>"#;
    let old = scene_of(film).replace("3.0.0", "0.6.0");
    write("scene/scene.xml", &old);
    let before = snapshot(root.path());
    let file = root.path().join("scene/scene.xml");
    self::load(&file).result.unwrap();
    assert!(snapshot(root.path()) == before, "something is written");
}

/// A way for a scene to name a file.
struct Naming {
    what: &'static str,
    /// The elements, but for the name, which is `NAME` there.
    elements: &'static str,
    /// A file that is read.
    sound: Vec<u8>,
    /// Message about a file that is not there.
    missing: &'static str,
}

impl Naming {
    fn of(&self, name: &str) -> String {
        scene_of(&self.elements.replace("NAME", name))
    }
}

/// Every way.
fn namings() -> Vec<Naming> {
    let ball = icosphere(0);
    let naming = |what, elements, sound, missing| Naming {
        what,
        elements,
        sound,
        missing,
    };
    vec![
        naming(
            "obj",
            r#"<shape type="obj"><string name="filename" value="NAME"/></shape>"#,
            obj(&ball),
            "cannot be read",
        ),
        naming(
            "ply",
            r#"<shape type="ply"><string name="filename" value="NAME"/></shape>"#,
            ply(&ball, "ascii"),
            "cannot be read",
        ),
        naming(
            "serialized",
            r#"<shape type="serialized"><string name="filename" value="NAME"/></shape>"#,
            serialized(&serialized_contents(&ball), Compression::fast()),
            "cannot be read",
        ),
        naming(
            "a texture that irradiance does not depend on",
            r#"<shape type="sphere"><bsdf type="diffuse"><texture type="bitmap" name="reflectance"><string name="filename" value="NAME"/></texture></bsdf></shape>"#,
            noise(8, 4),
            "there is no image",
        ),
        naming(
            "a texture that shines",
            r#"<shape type="rectangle"><emitter type="area"><texture type="bitmap" name="radiance"><string name="filename" value="NAME"/></texture></emitter></shape>"#,
            noise(8, 4),
            "there is no image",
        ),
        naming(
            "envmap",
            r#"<shape type="sphere"/><emitter type="envmap"><string name="filename" value="NAME"/></emitter>"#,
            noise(8, 4),
            "cannot be read",
        ),
        naming(
            "include",
            r#"<include filename="NAME"/>"#,
            scene_of(r#"<shape type="sphere"/>"#).into_bytes(),
            "there is no file",
        ),
    ]
}

/// All that is in a folder, without following links: names, what they are and hold, and when they were
/// written.
fn snapshot(folder: &Path) -> BTreeMap<PathBuf, (SystemTime, String, Vec<u8>)> {
    let mut found = BTreeMap::new();
    let mut folders = vec![folder.to_owned()];
    while let Some(folder) = folders.pop() {
        let about = std::fs::metadata(&folder).unwrap();
        found.insert(
            folder.clone(),
            (about.modified().unwrap(), "folder".to_owned(), Vec::new()),
        );
        for entry in std::fs::read_dir(&folder).unwrap() {
            let path = entry.unwrap().path();
            let about = std::fs::symlink_metadata(&path).unwrap();
            if about.is_dir() {
                folders.push(path);
                continue;
            }
            let (kind, contents) = if about.is_symlink() {
                let target = std::fs::read_link(&path).unwrap();
                (format!("link to {}", target.display()), Vec::new())
            } else {
                ("file".to_owned(), std::fs::read(&path).unwrap())
            };
            found.insert(path, (about.modified().unwrap(), kind, contents));
        }
    }
    found
}

#[cfg(unix)]
#[test]
fn every_way_to_name_a_file_reads_that_file_or_none_and_nothing_is_written() {
    let _alone = alone();
    let (mut read, mut refused) = (0, 0);
    for naming in namings() {
        let root = TempDir::new().unwrap();
        let at = |name: &str| root.path().join(name);
        let write = |name: &str, contents: &[u8]| {
            std::fs::create_dir_all(at(name).parent().unwrap()).unwrap();
            std::fs::write(at(name), contents).unwrap();
        };
        // The file that is meant has another of its name in every folder that could be taken for its own.
        let garbage = b"garbage\n".as_slice();
        for name in ["scene/it", "scene/parts/it", "scene/parts/deeper/it"] {
            write(name, garbage);
        }
        write("it", &naming.sound);
        write("beside/it", &naming.sound);
        // These are nowhere but where no name below leads.
        write("above", &naming.sound);
        write("scene/parts/below", &naming.sound);
        write("beside/other", &naming.sound);
        for (link, target) in [
            ("scene/link", PathBuf::from("../it")),
            ("scene/absolute", at("beside/it")),
            ("scene/chain", PathBuf::from("link")),
            ("scene/up", PathBuf::from("../beside")),
            ("scene/broken", PathBuf::from("../nothing")),
            ("scene/round", PathBuf::from("round")),
            ("scene/device", PathBuf::from("/dev/zero")),
            ("scene/folder", PathBuf::from("parts")),
        ] {
            std::os::unix::fs::symlink(target, at(link)).unwrap();
        }
        let absolute = at("it").display().to_string();
        let nowhere = at("nothing").display().to_string();
        let sound = [
            "../it",
            "../beside/it",
            "parts/../../it",
            "./.././it",
            &absolute,
            "link",
            "absolute",
            "chain",
            "up/it",
            // A link is followed before `..` is: this is not `scene/it`.
            "up/../it",
        ];
        let damaged = ["it", "./it", "parts/it", "../scene/it", "folder/it"];
        let missing = [
            "above",
            "below",
            "other",
            "../parts/below",
            &nowhere,
            "broken",
            "round",
            "it/",
            "it/../../it",
            "",
        ];
        let devices = ["device", "/dev/zero", "up", "parts", "..", "."];
        let cases = [sound.as_slice(), &damaged, &missing, &devices];
        for (group, names) in cases.iter().enumerate() {
            for name in *names {
                write("scene/scene.xml", naming.of(name).as_bytes());
                let before = snapshot(root.path());
                let outcome = load(&at("scene/scene.xml"));
                let case = format!("{} by the name {name:?}", naming.what);
                let said = match outcome.result {
                    Ok(scene) => {
                        let warnings = scene.warnings().iter();
                        warnings.map(ToString::to_string).collect()
                    }
                    Err(error) => format!("error: {error}"),
                };
                let is_there = !["cannot be read", "there is no file", "there is no image"]
                    .iter()
                    .any(|text| said.contains(text));
                match group {
                    0 => assert!(is_there && !said.contains("error"), "{case}: {said}"),
                    1 => assert!(is_there && said.contains("error"), "{case}: {said}"),
                    2 => assert!(said.contains(naming.missing), "{case}: {said}"),
                    _ => assert!(!is_there, "{case}: {said}"),
                }
                *(if group == 0 { &mut read } else { &mut refused }) += 1;
                assert!(outcome.peak < 1 << 20, "{case}: {} bytes", outcome.peak);
                assert!(snapshot(root.path()) == before, "{case} writes something");
            }
        }
        // A `<path>` is one more folder to look in, and no way into those beside it.
        for (folder, name, is_found) in [
            ("../beside", "other", true),
            ("parts", "below", true),
            ("parts/..", "below", false),
            ("parts/deeper", "below", false),
            ("parts/deeper", "../below", true),
        ] {
            let elements = naming.elements.replace("NAME", name);
            let text = scene_of(&format!("<path value=\"{folder}\"/>{elements}"));
            write("scene/scene.xml", text.as_bytes());
            let before = snapshot(root.path());
            let outcome = load(&at("scene/scene.xml")).result;
            let said = match outcome {
                Ok(scene) => {
                    let warnings = scene.warnings().iter();
                    warnings.map(ToString::to_string).collect()
                }
                Err(error) => format!("error: {error}"),
            };
            let case = format!("{} by {name:?} in {folder:?}", naming.what);
            if is_found {
                assert!(said.is_empty(), "{case}: {said}");
            } else {
                assert!(said.contains(naming.missing), "{case}: {said}");
            }
            assert!(snapshot(root.path()) == before, "{case} writes something");
        }
    }
    println!(
        "{read} names lead to their files, {refused} to none or to what is refused; nothing is written"
    );
}
