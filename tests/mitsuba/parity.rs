//! Images by `reference::path` are Mitsuba's, plugin by plugin.
//!
//! `tests/mitsuba/parity` has a small scene for every bsdf, emitter, sensor and filter that both programs
//! know, written by `scenes.py`, and Mitsuba 3.9.1's image of each with its standard error, written by
//! `render.py`. Here each is rendered anew and compared. No Python is needed. `docs/mitsuba.md` has the
//! figures, and what differs and why.

use nephroid::internals::metric::Verdict;
use nephroid::internals::mitsuba::load;
use nephroid::internals::reference::path::PathSettings;
use nephroid::internals::scene::Scene;

use crate::support::parity::{
    Outcome, folder, mitsuba_image, names, outcome, render, samples_of, scene,
};

/// Our samples a pixel and replicate for one of Mitsuba's samples and seeds: Sobol' points make at most as
/// much noise as four times the independent ones, and both images then have noise σ of some 1 % of a pixel.
///
/// Of N pixels of three channels, the bound on what noise does not explain is some (1.64 √(18 N) / 3 N)^½ σ =
/// 0.3 σ for N = 1024 (`metric::equivalence`): a margin of 1 % can be shown.
const SHARE: u64 = 4;

/// The significance level of the suite: how often it may fail where all is right.
const LEVEL: f64 = 0.01;

/// The one scene that is not shown to be the same within 1 %: steps of Mitsuba's table for this filter are
/// 3/31 of a pixel wide, and what that changes is near the margin (docs/mitsuba.md). It must not be shown to
/// be further apart.
const COARSE_TABLE: &str = "filter-lanczos";

/// Our image of a scene, and the suite's of the same name.
fn compare(name: &str, scene: &Scene) -> Outcome {
    let mitsuba = mitsuba_image(&folder().join(format!("{name}.exr")));
    let sensor = &scene.sensors()[0];
    let settings = PathSettings::default().of_integrator(scene.integrator());
    let ours = render(scene, sensor, settings, samples_of(&mitsuba) / SHARE);
    outcome(name, &ours, &mitsuba, sensor.film.filter.radius())
}

#[test]
fn every_plugin_makes_mitsubas_image() {
    let outcomes: Vec<Outcome> = names()
        .iter()
        .map(|name| compare(name, &scene(name)))
        .collect();
    for outcome in &outcomes {
        println!("{outcome}");
    }
    let different: Vec<&Outcome> = (outcomes.iter())
        .filter(|outcome| match outcome.name.as_str() {
            COARSE_TABLE => outcome.verdict == Verdict::Different,
            _ => outcome.verdict != Verdict::Equivalent,
        })
        .collect();
    assert!(
        different.is_empty(),
        "not shown to be equivalent: {different:#?}"
    );

    // Mitsuba's scalar variants look filters up in a table of 31 steps, all but the box: their images are
    // shown to be the same within 1 % above, but are others, as p-values would say with enough samples
    // (docs/mitsuba.md has the proof).
    let outcomes: Vec<Outcome> = outcomes
        .into_iter()
        .filter(|it| !it.name.starts_with("filter-") || it.name == "filter-box")
        .collect();

    // Šidák: the smallest of all p-values of all scenes, two tests each.
    let p_values =
        || (outcomes.iter()).flat_map(|it| it.uniformity.into_iter().chain([it.extreme]));
    let threshold = 1.0 - (1.0 - LEVEL).powf(1.0 / p_values().count() as f64);
    let unlikely: Vec<&Outcome> = (outcomes.iter())
        .filter(|it| it.uniformity.unwrap_or(1.0).min(it.extreme) < threshold)
        .collect();
    assert!(unlikely.is_empty(), "p below {threshold}: {unlikely:#?}");

    // And small p-values are no more than chance makes: many scenes a little off are seen, too.
    let low = outcomes
        .iter()
        .filter(|it| it.uniformity.is_some_and(|p| p < LEVEL))
        .count();
    let scenes = outcomes.iter().filter(|it| it.uniformity.is_some()).count();
    assert!(
        binomial_tail(low, scenes, LEVEL) >= LEVEL,
        "{low} of {scenes} scenes have p-values that are not uniform at {LEVEL}"
    );
}

/// The probability of at least `k` of `n` events of probability p each.
fn binomial_tail(k: usize, n: usize, p: f64) -> f64 {
    let mut term = (1.0 - p).powi(n as i32);
    let mut below = 0.0;
    for i in 0..k {
        below += term;
        term *= (n - i) as f64 / (i + 1) as f64 * p / (1.0 - p);
    }
    1.0 - below
}

#[test]
fn references_were_rendered_from_the_scenes_as_they_are() {
    for name in names() {
        let file = folder().join(format!("{name}.xml"));
        let mut crc = flate2::Crc::new();
        crc.update(&std::fs::read(file).unwrap());
        let image = mitsuba_image(&folder().join(format!("{name}.exr")));
        assert_eq!(
            image.metadata("scene-crc32"),
            Some(format!("{:08x}", crc.sum()).as_str()),
            "{name}: run tests/mitsuba/parity/render.py {name}"
        );
        assert_eq!(
            image.metadata("renderer"),
            Some("Mitsuba 3.9.1, scalar_rgb"),
            "{name}"
        );
    }
}

#[test]
fn the_suite_has_every_plugin_that_a_camera_can_meet() {
    let text: String = names()
        .iter()
        .map(|name| std::fs::read_to_string(folder().join(format!("{name}.xml"))).unwrap())
        .collect();
    let plugins = [
        // bsdfs
        "blendbsdf",
        "bumpmap",
        "conductor",
        "dielectric",
        "diffuse",
        "mask",
        "normalmap",
        "null",
        "plastic",
        "principled",
        "principledthin",
        "roughconductor",
        "roughdielectric",
        "roughplastic",
        "thindielectric",
        "twosided",
        // textures
        "bitmap",
        "checkerboard",
        "mesh_attribute",
        // emitters
        "area",
        "constant",
        "directional",
        "envmap",
        "point",
        "spot",
        "sunsky",
        // sensors
        "orthographic",
        "perspective",
        "thinlens",
        // filters
        "box",
        "catmullrom",
        "gaussian",
        "lanczos",
        "mitchell",
        "tent",
        // integrators; ptracer in shipped.rs
        "aov",
        "direct",
        "path",
        "volpath",
    ];
    for plugin in plugins {
        assert!(text.contains(&format!("type=\"{plugin}\"")), "{plugin}");
    }
}

#[test]
fn another_index_of_refraction_another_roughness_and_two_percent_more_light_are_found() {
    let changes = [
        (
            "bsdf-dielectric-tinted",
            "name=\"int_ior\" value=\"1.2\"",
            "name=\"int_ior\" value=\"1.22\"",
        ),
        (
            "bsdf-roughconductor-ggx",
            "name=\"alpha\" value=\"0.3\"",
            "name=\"alpha\" value=\"0.33\"",
        ),
        (
            "emitter-constant",
            "value=\"0.6, 0.7, 0.9\"",
            "value=\"0.612, 0.714, 0.918\"",
        ),
    ];
    let temporary = tempfile::tempdir().unwrap();
    for (name, from, to) in changes {
        let text = std::fs::read_to_string(folder().join(format!("{name}.xml"))).unwrap();
        assert_eq!(text.matches(from).count(), 1, "{name}");
        let file = temporary.path().join("changed.xml");
        std::fs::write(&file, text.replace(from, to)).unwrap();
        let found = compare(name, &load(&file, &[]).unwrap());
        println!("{found}");
        let p = found.uniformity.unwrap().min(found.extreme);
        assert!(
            found.verdict == Verdict::Different || p < 1e-4,
            "{from} and {to} look the same: {found}"
        );
    }
}
