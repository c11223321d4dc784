//! Caustics volumes: with all stages exact they are the truth, and each stage does what it says.

use nephroid::internals::approximation::SensorFilm;
use nephroid::internals::run::{Budget, Context, Rendering};
use nephroid::internals::scene::Scene;

use crate::support::approximation::{GLASS, ball, bundled, over_floor, scene_of};
use crate::support::caustics_volume::{count, error, exact_but, rendered, truth, volume};
use crate::support::scenes::meter;

/// Errors of all stages exact, by photons.
fn errors(scene: &Scene, own: f64, photons: &[u32]) -> Vec<f64> {
    let truth = truth(scene, own);
    let one = |photons: &u32| {
        let photons = photons.to_string();
        error(&exact_but(&[("photons", &photons)]), scene, &truth)
    };
    photons.iter().map(one).collect()
}

#[test]
fn with_all_stages_exact_the_error_of_a_ball_falls_by_half_with_each_doubling_of_a_row() {
    let scene = bundled("glass-ball", 128);
    let errors = errors(&scene, 1e-3, &[128 * 128, 256 * 256, 512 * 512]);
    // Linear between photons: a quarter where light is smooth, a half at caustics' edges.
    assert!(
        errors[1] < errors[0] / 2.0 && errors[2] < errors[1] / 2.0,
        "{errors:?}"
    );
    // Five thousandths, with a fifth of that for the truth's own error.
    assert!(errors[2] < 5e-3, "{errors:?}");
}

#[test]
fn with_all_stages_exact_facets_and_mirrors_tend_to_the_truth() {
    // A box under a ball, each met twice, and by light that goes on from one to the other and back.
    let below = r#"<shape type="cube"><transform name="to_world"><scale x="0.5" y="0.5" z="0.1"/>
        <translate x="0.1" z="0.15"/></transform>"#;
    let small = r#"<shape type="sphere"><point name="center" x="0" y="0" z="1.4"/>
        <float name="radius" value="0.6"/>"#;
    let stacked = scene_of(&over_floor(
        &format!("{small}{GLASS}</shape>{below}{GLASS}</shape>"),
        128,
    ));
    let scenes = [
        ("cube", bundled("cube", 128), 0.01),
        ("prism", bundled("prism", 128), 0.01),
        ("coffee-cup", bundled("coffee-cup", 128), 0.015),
        ("water", bundled("water", 128), 0.01),
        ("ball over box", stacked, 0.01),
    ];
    for (name, scene, bar) in scenes {
        let errors = errors(&scene, 1e-3, &[1 << 15, 1 << 17]);
        // The bar is for 2^20 photons. Edges across texels: half with each doubling of a row, so that half is
        // asked of twice as many a row as of the first.
        assert!(errors[1] < bar, "{name}: {errors:?}");
        assert!(errors[1] < 0.71 * errors[0], "{name}: {errors:?}");
    }
}

#[test]
fn what_enters_the_volume_lands_or_is_lost_for_a_reason() {
    for name in ["glass-ball", "mirror-ring", "diamond", "water"] {
        let scene = bundled(name, 32);
        for settings in [
            &[][..],
            &[("interface", "fresnel"), ("sweep", "exact")],
            &[
                ("emission", "exact"),
                ("layers", "exact"),
                ("projector", "exact"),
            ],
            &[
                ("layers", "peel"),
                ("cull", "none"),
                ("projector", "orthographic"),
            ],
            &[
                ("buffers", "exact"),
                ("march", "exact"),
                ("interface", "mirror-total"),
            ],
            &[("march", "steps"), ("buffers", "f16"), ("volume", "light")],
        ] {
            let all = [&[("photons", "4000"), ("g-buffer", "64")], settings].concat();
            let done = rendered(&volume(&all), &scene);
            let begun = done.flux.iter().find(|it| it.reason == "enters the volume");
            let begun = begun.unwrap();
            let lost: u64 = done
                .flux
                .iter()
                .filter(|it| it.reason != "enters the volume")
                .map(|it| it.photons)
                .sum();
            let landed = count(&done, "splat", "splats");
            assert_eq!(begun.photons, lost + landed, "{name} {settings:?}");
            // All entries together are what the meter has, to the rounding of sums of 4000.
            let sum: f64 = done.flux.iter().map(|it| it.flux.mean()).sum();
            let image = image_flux(&scene, &done);
            assert!(
                (sum - image).abs() <= 1e-12 * begun.flux.mean(),
                "{name} {settings:?}: {sum} {image}"
            );
        }
    }
}

/// Flux \[W\] on the meter, by its texels.
fn image_flux(scene: &Scene, done: &Rendering) -> f64 {
    let film = SensorFilm::new(scene, meter(scene)).unwrap();
    let texels = done.estimate.total.values.iter().enumerate();
    texels
        .map(|(texel, value)| value.mean() * film.measure(texel))
        .sum()
}

#[test]
fn a_frame_has_a_pass_a_slab_and_one_more_and_draws_two_pictures_a_slab_and_one_an_exit() {
    let scene = scene_of(&over_floor(&ball(GLASS), 16));
    for slabs in [1_u64, 2, 5] {
        for (cull, exits) in [("entry", 5), ("entry,z-", 4), ("none", 6)] {
            let done = rendered(
                &volume(&[
                    ("slabs", &slabs.to_string()),
                    ("cull", cull),
                    ("g-buffer", "40"),
                    ("photons", "500"),
                ]),
                &scene,
            );
            let of = |name: &str| {
                let found = done.counters.iter().find(|one| one.name == name);
                found.map_or(0, |one| one.count)
            };
            assert_eq!(of("passes"), slabs + 1);
            assert_eq!(of("texels"), 40 * 40 * (2 * slabs + exits));
        }
    }
}

#[test]
fn what_a_volume_cannot_do_is_refused_with_what_is_allowed() {
    let glass = scene_of(&over_floor(&ball(GLASS), 8));
    let half = scene_of(&over_floor(
        &ball(&format!(
            r#"<bsdf type="mask"><float name="opacity" value="0.5"/>{GLASS}</bsdf>"#
        )),
        8,
    ));
    let none = scene_of(&over_floor(&ball(r#"<bsdf type="diffuse"/>"#), 8));
    let inside = scene_of(&over_floor(&ball(GLASS), 8).replace(r#"z="4""#, r#"z="1.4""#));
    let mirror = scene_of(&over_floor(&ball(GLASS), 8).replace("diffuse", "conductor"));
    let refused = |scene: &Scene, settings: &[(&str, &str)]| {
        let context = Context::default();
        let run = volume(settings).run(scene, meter(scene), &Budget::default(), &context);
        run.err().map(|error| error.to_string()).unwrap_or_default()
    };
    for (scene, settings, says) in [
        (&half, &[][..], "a mask that is partly open"),
        (&none, &[], "no shape mirrors or refracts"),
        (&inside, &[], "is in the volume"),
        (&mirror, &[], "which mirrors or refracts: photons land on"),
        (&glass, &[("entry", "z-")], "entry=z+ is before it"),
        (
            &glass,
            &[("cull", "up")],
            "allowed are none, or some of entry, x-",
        ),
        (
            &glass,
            &[("cull", "x-,x+,y-,y+,z-,z+")],
            "cull has all six faces",
        ),
        (&glass, &[("lod-distance", "3")], "the sensor is a meter"),
        (
            &glass,
            &[("shares", "2"), ("amortise", "1")],
            "allowed is one of shares",
        ),
        (
            &glass,
            &[("amortise", "1"), ("splat", "exact")],
            "allowed are splat=quads",
        ),
        (
            &glass,
            &[("amortise", "1"), ("sweep", "exact")],
            "allowed is sweep=once",
        ),
    ] {
        let said = refused(scene, settings);
        assert!(said.contains(says), "{settings:?}: {said}");
    }
    // What is small or much is done.
    for settings in [
        &[("g-buffer", "1"), ("slabs", "64"), ("photons", "1")][..],
        &[("layers", "peel"), ("peels", "16"), ("photons", "7")],
        &[("emission", "exact"), ("entry", "z-"), ("photons", "50")],
    ] {
        assert_eq!(refused(&glass, settings), "");
    }
}

#[test]
fn images_are_the_same_bits_on_any_number_of_threads() {
    let scene = bundled("glass-ball", 48);
    for settings in [
        &[][..],
        &[("splat", "exact"), ("interface", "exact")],
        &[
            ("interface", "exact"),
            ("layers", "exact"),
            ("sweep", "exact"),
        ],
    ] {
        let all = [&[("photons", "3000"), ("g-buffer", "100")], settings].concat();
        let method = volume(&all);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build()
                .unwrap()
                .install(|| rendered(&method, &scene).estimate.total.values)
        };
        let one = on(1);
        assert!(one.iter().any(|value| !value.is_black()));
        assert_eq!(one, on(2));
        assert_eq!(one, on(64));
    }
}
