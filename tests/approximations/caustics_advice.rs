//! Caustics volumes: advice, warnings, and frames that are stopped.

use std::collections::BTreeMap;

use nephroid::internals::approximation::caustics_volume::advice::Pilot;
use nephroid::internals::approximation::caustics_volume::cuboid::Face;
use nephroid::internals::approximation::caustics_volume::demands::Volume;
use nephroid::internals::approximation::caustics_volume::{CausticsVolume, Settings};
use nephroid::internals::approximation::{Frame, Technique};
use nephroid::internals::run::{Budget, Context};
use nephroid::internals::scene::Scene;
use nephroid::internals::setting::Values;

use crate::support::approximation::{GLASS, ball, over_floor, scene_of};
use crate::support::caustics_volume::{rendered, volume};
use crate::support::scenes::meter;

fn values(given: &[(&str, &str)]) -> Values {
    let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
    let given: BTreeMap<String, String> = given.iter().map(owned).collect();
    let table = CausticsVolume.settings().iter().collect();
    Values::new("caustics-volume", table, &given).unwrap()
}

const MIRROR: &str = r#"<bsdf type="conductor"/>"#;

/// A horizontal rectangle from `x` on, 2 m wide, that looks up or down.
fn sheet(x: f64, z: f64, is_up: bool, bsdf: &str) -> String {
    let turned = if is_up {
        ""
    } else {
        r#"<rotate x="1" angle="180"/>"#
    };
    format!(
        r#"<shape type="rectangle"><transform name="to_world">{turned}<scale x="1" y="2"/>
        <translate x="{}" z="{z}"/></transform>{bsdf}</shape>"#,
        x + 1.0
    )
}

/// A vertical sun on sheets over a floor, or on a plate of glass at some depths.
fn sun_on(sheets: &str) -> Scene {
    scene_of(&format!(
        r#"<scene version="3.0.0">
        <emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/></emitter>{sheets}
        <shape type="rectangle"><bsdf type="diffuse"/><sensor type="irradiancemeter"><film type="hdrfilm">
            <integer name="width" value="8"/><integer name="height" value="8"/>
            <rfilter type="box"/></film></sensor></shape></scene>"#
    ))
}

fn plate(x: f64, above: f64, below: f64) -> String {
    sheet(x, above, true, GLASS) + &sheet(x, below, false, GLASS)
}

fn warnings(scene: &Scene, given: &[(&str, &str)]) -> Vec<String> {
    let common = [("photons", "400"), ("g-buffer", "40")];
    rendered(&volume(&[&common[..], given].concat()), scene).warnings
}

#[test]
fn the_pilot_counts_light_of_more_than_two_surfaces_a_slab_and_what_goes_back() {
    // Of three halves by area: two plates, one plate, a mirror at the height of the lower plate.
    let glass = plate(-2.0, 2.0, 1.8) + &plate(-2.0, 1.2, 1.0) + &plate(0.0, 2.0, 1.8);
    let scenes = [
        sun_on(&glass),
        sun_on(&(glass + &sheet(2.0, 1.1, true, MIRROR))),
    ];
    let third = 1.0 / 3.0;
    for (scene, lost, false_light, faces) in [
        // By one slab light goes from the upper plate's top to the lower one's bottom.
        (&scenes[0], [0.5, 0.0], [0.5, 0.0], [0.0, 1.0]),
        // The mirror is in the lower one of two slabs, and its light goes back into the upper one.
        (
            &scenes[1],
            [third, third],
            [third, 0.0],
            [third, 2.0 * third],
        ),
    ] {
        let given = [("photons", "900"), ("margin", "0"), ("cull", "none")];
        let settings = Settings::of(&values(&given)).unwrap();
        let volume = Volume::new(scene, &settings).unwrap();
        let pilot = Pilot::new(scene, &settings, &volume);
        // Columns of photons that are not divided by three: less than one of thirty is elsewhere.
        let is_near = |found: f64, share: f64| (found - share).abs() < 0.02;
        for slabs in [1, 2] {
            let found = pilot.slabs(slabs);
            assert!(is_near(found.lost, lost[slabs - 1]), "{slabs}: {found:?}");
            let all_false = false_light[slabs - 1];
            assert!(is_near(found.false_light, all_false), "{slabs}: {found:?}");
        }
        let found = pilot.faces();
        for (face, share) in [Face::Entry, Face::Far].into_iter().zip(faces) {
            assert!(is_near(found[face as usize], share), "{face:?}: {found:?}");
        }
    }
    // Advice is given where more than 1 % is wrong, and no other.
    let said = warnings(&scenes[0], &[("slabs", "1")]);
    let expected = "two surfaces a slab lose 50.0 % of the light and make 50.0 % that is not there (slabs=1): slabs=2 \
                    would lose 0.0 % of the light and make 0.0 % that is not there";
    assert_eq!(said, [expected]);
    assert!(warnings(&scenes[0], &[("slabs", "2")]).is_empty());
    assert!(warnings(&scenes[0], &[("slabs", "1"), ("layers", "exact")]).is_empty());
    // What culling faces end is no fault of slabs.
    let says = "leaves by faces that cull (z+): sweep=exact lets it out";
    let said = warnings(&scenes[1], &[("slabs", "2")]);
    assert!(said.len() == 1 && said[0].contains(says), "{said:?}");
    let said = warnings(&scenes[1], &[("slabs", "2"), ("cull", "none")]);
    let says = "and other numbers up to 8 are hardly better";
    assert!(said.len() == 1 && said[0].contains(says), "{said:?}");
    let any = [("slabs", "2"), ("sweep", "exact")];
    assert!(warnings(&scenes[1], &any).is_empty());
}

#[test]
fn what_settings_and_shapes_do_not_do_is_said_by_name() {
    let glass = scene_of(&over_floor(&ball(GLASS), 8));
    for (given, says) in [
        (
            &[("layers", "peel"), ("buffers", "exact")][..],
            "buffers=exact does nothing beside layers=peel",
        ),
        (
            &[("layers", "peel"), ("march", "exact")],
            "march=exact does nothing beside layers=peel",
        ),
        (
            &[("layers", "exact"), ("buffers", "f16")],
            "buffers=f16 does nothing beside layers=exact",
        ),
        (
            &[("steps", "64")],
            "steps=64 does nothing beside a march other than march=steps",
        ),
        (
            &[("smooth", "exact"), ("sigma", "2")],
            "sigma=2 does nothing beside smooth=exact",
        ),
        (
            &[("border-levels", "2")],
            "border-levels=2 does nothing beside a splat other",
        ),
    ] {
        let said = warnings(&glass, given);
        assert!(
            said.iter().any(|it| it.starts_with(says)),
            "{given:?}: {said:?}"
        );
    }
    for given in [
        &[][..],
        &[
            ("layers", "exact"),
            ("buffers", "exact"),
            ("march", "exact"),
        ],
        &[("layers", "peel"), ("peels", "3")],
        &[("march", "steps"), ("steps", "64")],
    ] {
        assert_eq!(warnings(&glass, given), Vec::<String>::new(), "{given:?}");
    }
    // An upright pane beside a plate, and a mirror on its own.
    let pane = r#"<shape type="rectangle" id="pane"><transform name="to_world"><rotate x="1" angle="90"/>
        <translate z="2"/></transform><bsdf type="thindielectric"/></shape>"#;
    let upright = sun_on(&(plate(0.0, 2.0, 1.0) + pane));
    let says = "light does not meet \"pane\": layers=exact does";
    assert!(warnings(&upright, &[]).iter().any(|it| it.contains(says)));
    assert!(warnings(&upright, &[("layers", "exact")]).is_empty());
    let flat = sun_on(&sheet(-1.0, 1.0, true, GLASS));
    // 4 m by a thousandth, and 1 % on both sides.
    let says =
        "what mirrors or refracts is flat: the volume is padded to 4.080e-3 m from face z+ to z-";
    assert!(
        warnings(&flat, &[]).contains(&says.to_owned()),
        "{:?}",
        warnings(&flat, &[])
    );
}

#[test]
fn half_floats_are_refused_for_slabs_deeper_than_they_reach() {
    let deep = sun_on(&plate(0.0, 2e5, 1e3));
    let run = |given: &[(&str, &str)]| {
        let context = Context::default();
        let given = [&[("photons", "9"), ("g-buffer", "4")], given].concat();
        let run = volume(&given).run(&deep, meter(&deep), &Budget::default(), &context);
        run.err().map(|error| error.to_string()).unwrap_or_default()
    };
    // 199 km and 1 % on both sides, in slabs of at most 65.5 km.
    let said = run(&[("buffers", "f16")]);
    assert!(said.contains("half floats end at 65504 m"), "{said}");
    assert!(said.contains("buffers=f32, and 4 slabs or more"), "{said}");
    assert_eq!(run(&[("buffers", "f16"), ("slabs", "4")]), "");
    assert_eq!(run(&[("buffers", "f32")]), "");
}

#[test]
fn a_wish_to_stop_ends_a_frame_before_its_next_pass_and_the_next_frame_is_whole() {
    let scene = scene_of(&over_floor(&ball(GLASS), 8));
    for given in [
        &[][..],
        &[("update", "changed")],
        &[("amortise", "2")],
        &[("splat", "exact")],
    ] {
        let given = [&[("photons", "400"), ("g-buffer", "40")], given].concat();
        let prepare = || {
            let context = Context::default();
            CausticsVolume
                .prepare(&scene, meter(&scene), &values(&given), &context)
                .unwrap()
        };
        let on = |prepared: &mut Box<dyn nephroid::internals::approximation::Prepared>,
                  is_stopped: bool|
         -> Frame {
            let context = Context::default();
            if is_stopped {
                context.progress.stop();
            }
            prepared.frame(&scene, meter(&scene), &context).unwrap()
        };
        let whole = on(&mut prepare(), false);
        let mut prepared = prepare();
        let stopped = on(&mut prepared, true);
        assert!(whole.values.iter().any(|value| !value.is_black()));
        assert_eq!(stopped.counters.get("passes"), 0, "{given:?}");
        assert_eq!(stopped.counters.get("texels"), 0, "{given:?}");
        assert_eq!(
            stopped.warnings[0], "stopped before all passes were made: light is missing",
            "{given:?}"
        );
        assert_eq!(on(&mut prepared, false).values, whole.values, "{given:?}");
    }
    let context = Context::default();
    context.progress.stop();
    let stopped = volume(&[]).run(&scene, meter(&scene), &Budget::default(), &context);
    assert!(stopped.unwrap().estimate.incomplete);
    assert!(!rendered(&volume(&[]), &scene).estimate.incomplete);
}
