//! Settings of paths from a file's integrator.

use nephroid::internals::scene::Integrator;

use crate::support::scene_files::{error, scene};

fn read(element: &str) -> Option<Integrator> {
    scene(element).unwrap().integrator
}

fn integrator(
    plugin: &str,
    max_depth: Option<u32>,
    rr_depth: u32,
    hide_emitters: bool,
) -> Integrator {
    Integrator {
        plugin: plugin.to_owned(),
        hide_emitters,
        max_depth,
        rr_depth,
    }
}

#[test]
fn depths_and_hidden_emitters_are_those_of_the_file() {
    let path = "<integrator type=\"path\"><integer name=\"max_depth\" value=\"9\"/>\
        <integer name=\"rr_depth\" value=\"7\"/><boolean name=\"hide_emitters\" value=\"true\"/></integrator>";
    assert_eq!(read(path), Some(integrator("path", Some(9), 7, true)));
    let nested = format!(
        "<integrator type=\"aov\"><string name=\"aovs\" value=\"d:depth\"/>{path}</integrator>"
    );
    assert_eq!(read(&nested), Some(integrator("path", Some(9), 7, true)));
    // Mitsuba's defaults; -1 is no limit.
    for plugin in ["path", "ptracer", "volpath"] {
        let bare = format!("<integrator type=\"{plugin}\"/>");
        assert_eq!(read(&bare), Some(integrator(plugin, None, 5, false)));
    }
    let endless =
        "<integrator type=\"path\"><integer name=\"max_depth\" value=\"-1\"/></integrator>";
    assert_eq!(read(endless), Some(integrator("path", None, 5, false)));
    let direct =
        "<integrator type=\"direct\"><integer name=\"emitter_samples\" value=\"4\"/></integrator>";
    assert_eq!(read(direct), Some(integrator("direct", Some(2), 5, false)));
}

#[test]
fn integrators_that_say_nothing_of_paths_are_ignored_as_all_are_noted() {
    assert_eq!(read(""), None);
    for plugin in ["depth", "prb", "aov"] {
        assert_eq!(
            read(&format!("<integrator type=\"{plugin}\"/>")),
            None,
            "{plugin}"
        );
    }
    let noted = scene("<integrator type=\"path\"/>").unwrap().ignored;
    assert_eq!(noted[0].what, "integrator \"path\"");
    assert!(noted[0].why.contains("max_depth"), "{}", noted[0].why);
}

#[test]
fn depths_that_mitsuba_refuses_are_errors_with_their_place() {
    let of = |parameter: &str| {
        error(&format!(
            "<integrator type=\"path\">\n{parameter}\n</integrator>"
        ))
    };
    assert_eq!(
        of("<integer name=\"rr_depth\" value=\"0\"/>"),
        "scene.xml:3:1: integrator \"path\", parameter \"rr_depth\": must be from 1 to 4294967295, not 0"
    );
    let depth = of("<integer name=\"max_depth\" value=\"-2\"/>");
    assert!(
        depth.contains("max_depth of -1 (no limit) or more, not -2"),
        "{depth}"
    );
}

#[test]
fn a_film_says_whether_its_border_is_sampled() {
    let film = |parameters: &str| {
        let sensor = format!(
            "<sensor type=\"perspective\"><float name=\"fov\" value=\"40\"/>\
            <film type=\"hdrfilm\">{parameters}</film></sensor>"
        );
        scene(&sensor).unwrap().sensors[0].film.sample_border
    };
    assert!(!film(""));
    assert!(film("<boolean name=\"sample_border\" value=\"true\"/>"));
}
