//! Photons of a scene with dispersion: the same light as without where the index is constant, all energy
//! accounted for, the same bits, and refusals.

use std::path::Path;

use glam::DVec3;
use nephroid::internals::geometry::{Ray, TraversalCounters};
use nephroid::internals::mitsuba;
use nephroid::internals::numeric::StreamKind;
use nephroid::internals::reference::parts::Divided;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::photons::run::Setup;
use nephroid::internals::reference::shard::Shard;
use nephroid::internals::run::{Budget, Estimate, Progress};
use nephroid::internals::scene::{Material, MaterialsAtWavelength, Scene, requirements};
use nephroid::internals::spectrum::Wavelengths;
use nephroid::internals::transport::scatter::{Interaction, ShadingNormals, Way};
use nephroid::{Context, Method};

use crate::support::parts;
use crate::support::scenes::{bundled_file, layer, meter, over_floor};
use crate::support::student::two_sided_quantile;
use crate::support::{Photons, bundled, loaded};

/// The chance that a right program fails one of the statistical tests here.
const ALPHA: f64 = 1e-4;

fn dispersed(name: &str, side: usize, id: &str, glass: &str) -> Scene {
    let scene = bundled(name, side);
    scene.with_dispersion(&[(id, glass)]).unwrap()
}

/// The scene `rainbow` in coloured sunlight.
fn in_coloured_light(folder: &Path, side: usize) -> Scene {
    let file = bundled_file("rainbow");
    let text = std::fs::read_to_string(&file).unwrap();
    let coloured = text.replace("1000, 1000, 1000", "1000, 600, 200");
    assert_ne!(coloured, text);
    std::fs::write(folder.join("rainbow.xml"), coloured).unwrap();
    std::fs::copy(file.with_extension("ply"), folder.join("rainbow.ply")).unwrap();
    loaded(&folder.join("rainbow.xml"), side)
}

/// Two runs of independent seeds whose layer is the same light: the larger joint bar relative to the light.
fn assert_same_light(case: &str, [one, other]: [&Estimate; 2], name: &str) -> f64 {
    let freedom = PhotonSettings::default().replicates - 1;
    let texels = one.width * one.height;
    let limit = two_sided_quantile(ALPHA / (3 * texels) as f64, freedom);
    let (mut bar, mut light, mut judged) = (0.0, 0.0, 0);
    for c in 0..3 {
        let [(a, bar_a), (b, bar_b)] = [one, other].map(|estimate| layer(estimate, name, c));
        for texel in 0..texels {
            if one.counts[texel].min(other.counts[texel]) < 300 {
                continue;
            }
            let joint = bar_a[texel].hypot(bar_b[texel]);
            let off = (a[texel] - b[texel]).abs();
            assert!(
                off <= limit * joint,
                "{case}: texel {texel}, channel {c}: {} and {} differ by more than {limit} of {joint}",
                a[texel],
                b[texel]
            );
            judged += 1;
            bar += joint * joint;
            light += b[texel] * b[texel];
        }
    }
    assert!(judged > 0, "{case}: nothing is lit");
    println!("{case}: {judged} values, bar {:.2e}", (bar / light).sqrt());
    (bar / light).sqrt()
}

#[test]
fn an_index_that_does_not_depend_on_the_wavelength_is_the_plain_index() {
    let folder = tempfile::tempdir().unwrap();
    // A point without area and of colour, and an area light, whose photons take four dimensions.
    let cases = [
        (
            "coloured sun",
            in_coloured_light(folder.path(), 10),
            "glass",
            "cauchy:1.785214",
            23,
        ),
        (
            "area light",
            bundled("cornell-glass", 10),
            "ball",
            "cauchy:1.5",
            21,
        ),
    ];
    for (case, plain, id, glass, bits) in cases {
        let truth = Photons::new(1 << bits).seed(1).estimate(&plain);
        let scene = plain.with_dispersion(&[(id, glass)]).unwrap();
        let found = Photons::new(1 << bits).seed(2).estimate(&scene);
        let bar = assert_same_light(case, [&found, &truth], "LTTD");
        assert!(bar < 0.05, "{case}: {bar}");
    }
}

/// The emitted flux of RGB light keeps its three channels. What the quadrature over wavelengths leaves is a
/// part of what independent wavelengths would; of an area light a thousandth.
#[test]
fn white_and_coloured_light_keep_their_channels() {
    let folder = tempfile::tempdir().unwrap();
    let all = Wavelengths::get();
    let draws = 1 << 12;
    let variance_of = |c: usize| {
        let at = |k: i32| all.at((f64::from(k) + 0.5) / f64::from(draws)).weights[c];
        (0..draws).map(|k| (at(k) - 1.0).powi(2)).sum::<f64>() / f64::from(draws)
    };
    let count = 1 << 18;
    for (name, plain, id, part) in [
        (
            "coloured sun",
            in_coloured_light(folder.path(), 4),
            "glass",
            0.5,
        ),
        ("area light", bundled("cornell-glass", 4), "ball", 1e-3),
    ] {
        let emitted = |scene: &Scene, seed: u64| {
            let photons = Photons::new(count).replicates(4).seed(seed);
            photons.estimate(scene).ledger.emitted
        };
        let expected = emitted(&plain, 0);
        let scene = plain.with_dispersion(&[(id, "sf11")]).unwrap();
        let found: Vec<_> = (0..16).map(|seed| emitted(&scene, seed)).collect();
        for c in 0..3 {
            // χ² with 16 degrees of freedom is below a quarter of them once in 2000 times, were wavelengths
            // independent.
            let random = variance_of(c) / count as f64;
            let off = found
                .iter()
                .map(|it| (it.0[c] / expected.0[c] - 1.0).powi(2));
            let ratio = (off.sum::<f64>() / (16.0 * random)).sqrt();
            let mean = found
                .iter()
                .map(|it| it.0[c] / expected.0[c] - 1.0)
                .sum::<f64>()
                / 16.0;
            println!(
                "{name}, channel {c}: {ratio:.1e} of independent wavelengths', mean {mean:.1e}"
            );
            assert!(ratio < part, "{name}, channel {c}: {ratio}");
        }
    }
}

#[test]
fn all_energy_over_wavelengths_is_accounted_for() {
    for (scene, count) in [
        (dispersed("rainbow", 16, "glass", "sf11"), 1 << 18),
        (dispersed("cornell-glass", 16, "ball", "diamond"), 1 << 16),
        (dispersed("diamond", 16, "diamond", "diamond"), 1 << 16),
    ] {
        for kind in [StreamKind::Sobol, StreamKind::Random] {
            let estimate = Photons::new(count).stream(kind).estimate(&scene);
            let error = estimate.ledger.closure_error().unwrap();
            println!("{}: {error:.1e}", scene.path().display());
            assert!(error < 1e-12, "{}: {error}", scene.path().display());
            // Bounds of few photons take contributions for positive.
            assert!(estimate.total.sampling.is_none());
        }
    }
}

/// Every bit of an estimate.
fn bits(estimate: &Estimate) -> Vec<u64> {
    let layers = std::iter::once(&estimate.total).chain(&estimate.layers);
    let values = layers.flat_map(|layer| layer.values.iter().chain(&layer.standard_error));
    let ledger = estimate.ledger.sum();
    let sums = [
        estimate.ledger.emitted,
        ledger.received,
        ledger.absorbed,
        ledger.escaped,
    ];
    let all = values
        .chain(&sums)
        .flat_map(|value| value.0.map(f64::to_bits));
    all.chain(estimate.counts.iter().copied()).collect()
}

#[test]
fn one_two_and_five_threads_and_shards_give_the_same_bits() {
    for scene in [
        dispersed("rainbow", 16, "glass", "sf11"),
        dispersed("cornell-glass", 16, "ball", "bk7"),
    ] {
        let (settings, progress) = (Photons::new(0).replicates(5).settings, Progress::default());
        let budget = Budget::work(60_000);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| {
                let setup = Setup::new(&scene, meter(&scene), settings, &progress).unwrap();
                bits(&setup.run(&budget).unwrap())
            })
        };
        let alone = on(1);
        assert!(alone == on(2) && alone == on(5));
        let setup = Setup::new(&scene, meter(&scene), settings, &progress).unwrap();
        let merged = parts::merged(&setup, "meter", &budget, 2);
        assert!(alone == bits(&merged), "shards");
    }
}

#[test]
fn shards_of_another_glass_are_of_another_run() {
    let shard_of = |scene: &Scene| {
        let progress = Progress::default();
        let setup = Setup::new(scene, meter(scene), PhotonSettings::default(), &progress).unwrap();
        let shard = Shard { index: 0, count: 1 };
        let file = setup.run_shard("meter", &Budget::work(64), shard);
        parts::opened([&file.unwrap().unwrap()[..]]).unwrap()
    };
    let scene = dispersed("prism", 4, "prism", "bk7");
    let progress = Progress::default();
    let setup = Setup::new(&scene, meter(&scene), PhotonSettings::default(), &progress).unwrap();
    assert!(setup.merge("meter", &mut shard_of(&scene)).is_ok());
    let other = dispersed("prism", 4, "prism", "f2");
    assert!(setup.merge("meter", &mut shard_of(&other)).is_err());
    assert!(
        setup
            .merge("meter", &mut shard_of(&bundled("prism", 4)))
            .is_err()
    );
}

#[test]
fn every_other_method_refuses_dispersion_by_name() {
    let scene = dispersed("glass-ball", 4, "ball", "bk7");
    for name in Method::names() {
        let method = Method::new(name, &Default::default()).unwrap();
        for sensor in scene.sensors() {
            let supported = method.supports(&scene, sensor);
            if name == "photons" {
                supported.unwrap();
                continue;
            }
            let run = method.run(&scene, sensor, &Budget::work(1), &Context::default());
            for error in [
                supported.unwrap_err().to_string(),
                run.unwrap_err().to_string(),
            ] {
                let expected =
                    format!("has dispersion (bk7), and the method {name} knows one index");
                assert!(error.contains(&expected), "{name}: {error}");
            }
        }
    }
    for sensor in scene.sensors() {
        let choice = Method::choose(&scene, sensor).unwrap();
        assert_eq!(choice.method.name(), "photons");
    }
}

#[test]
fn what_a_scene_requires_names_the_glass_and_its_price() {
    let of = |scene: &Scene| {
        let all = requirements(scene);
        all.into_iter()
            .find(|it| it.feature == "dispersion")
            .unwrap()
    };
    assert!(!of(&bundled("prism", 4)).needed);
    let needed = of(&dispersed("prism", 4, "prism", "sf11"));
    assert!(needed.needed);
    let expected = "prism is sf11 (n_d 1.78472, Abbe number 25.76): each photon has one wavelength";
    assert!(needed.reason.starts_with(expected), "{}", needed.reason);
}

/// Two balls of one glass, and one behind a mask.
fn balls(folder: &Path) -> Scene {
    let ball = |id: &str, x: f64, bsdf: &str| {
        format!(
            "<shape type=\"sphere\" id=\"{id}\"><point name=\"center\" x=\"{x}\" y=\"0\" z=\"1\"/>\
             <float name=\"radius\" value=\"0.2\"/>{bsdf}</shape>"
        )
    };
    let glass = "<ref id=\"glass\"/>";
    let masked = "<bsdf type=\"mask\" id=\"veil\"><float name=\"opacity\" value=\"0.5\"/><ref id=\"glass\"/></bsdf>";
    let mirror = "<bsdf type=\"conductor\" id=\"silver\"/>";
    let all = ball("left", -0.7, glass)
        + &ball("right", 0.7, glass)
        + &ball("veiled", 0.0, masked)
        + &ball("mirror", 2.0, mirror)
        + "<emitter type=\"directional\"><vector name=\"direction\" x=\"0\" y=\"0\" z=\"-1\"/></emitter>";
    over_floor(folder, &all, 4)
}

/// The indices of the left, the right and the veiled ball inside, at a wavelength [nm].
fn indices(scene: &Scene, wavelength: f64) -> [f64; 3] {
    let plain = scene.materials().to_vec();
    let mut spectral = MaterialsAtWavelength::new(scene);
    let all = spectral.as_mut().map_or(&plain[..], |it| it.at(wavelength));
    ["left", "right", "veiled"].map(|id| {
        let object = scene
            .objects()
            .iter()
            .find(|object| object.id == id)
            .unwrap();
        let mut material = &all[object.material.0 as usize];
        while let Some(nested) = material.nested().next() {
            material = &all[nested.0 as usize];
        }
        match material {
            Material::Dielectric { interior_ior, .. } => *interior_ior,
            other => panic!("{other:?}"),
        }
    })
}

#[test]
fn a_bsdfs_glass_is_that_of_all_its_shapes_and_a_shapes_own_comes_before_it() {
    let folder = tempfile::tempdir().unwrap();
    let with = |glasses: &[(&str, &str)]| balls(folder.path()).with_dispersion(glasses).unwrap();
    let (one, two) = ("cauchy:1.5,0.01", "cauchy:1.7,0.02");
    // At 500 nm, λ² is 1/4 µm².
    let close = |found: [f64; 3], expected: [f64; 3]| {
        let off = (0..3)
            .map(|k| (found[k] - expected[k]).abs())
            .fold(0.0, f64::max);
        assert!(off < 1e-12, "{found:?} are not {expected:?}");
    };
    close(indices(&with(&[]), 500.0), [1.5; 3]);
    close(indices(&with(&[("glass", one)]), 500.0), [1.54; 3]);
    close(indices(&with(&[("left", two)]), 500.0), [1.78, 1.5, 1.5]);
    close(indices(&with(&[("veiled", two)]), 500.0), [1.5, 1.5, 1.78]);
    // What wraps a bsdf does not give its glass to other shapes of that bsdf, and may have another.
    close(indices(&with(&[("veil", two)]), 500.0), [1.5, 1.5, 1.78]);
    let both = [("glass", one), ("veil", two)];
    close(indices(&with(&both), 500.0), [1.54, 1.54, 1.78]);
    close(
        indices(&with(&[both[1], both[0]]), 500.0),
        [1.54, 1.54, 1.78],
    );
    let (first, second) = (("glass", one), ("right", two));
    let [a, b] = [[first, second], [second, first]].map(|glasses| with(&glasses));
    close(indices(&a, 500.0), [1.54, 1.78, 1.54]);
    close(indices(&b, 500.0), [1.54, 1.78, 1.54]);
    // The same wish is the same scene, and any other is another.
    assert_eq!(a.content_hash(), b.content_hash());
    let others = [
        with(&[]),
        with(&[first]),
        with(&[second]),
        with(&[("glass", two)]),
    ];
    assert!(
        others
            .iter()
            .all(|other| other.content_hash() != a.content_hash())
    );
    let plain = mitsuba::load(&folder.path().join("scene.xml"), &[]).unwrap();
    assert_eq!(plain.content_hash(), with(&[]).content_hash());
}

#[test]
fn wishes_that_cannot_be_are_refused_with_what_can() {
    let folder = tempfile::tempdir().unwrap();
    for (glasses, expected) in [
        (vec![("rigth", "bk7")], "did you mean \"right\"?"),
        (
            vec![("nothing", "bk7")],
            "smooth interfaces are glass, veil, left, right, veiled",
        ),
        (vec![("silver", "bk7")], "\"silver\" is of plugin conductor"),
        (vec![("floor", "bk7")], "\"floor\" is of plugin diffuse"),
        (vec![("glass", "bk9")], "no glass is called \"bk9\""),
        (
            vec![("glass", "bk7"), ("glass", "f2")],
            "\"glass\" has been given a glass already",
        ),
    ] {
        let error = balls(folder.path())
            .with_dispersion(&glasses)
            .unwrap_err()
            .to_string();
        assert!(error.contains(expected), "{glasses:?}: {error}");
    }
}

/// Light through one interface below a mask at a wavelength: the share that passes it, as Fresnel has it.
#[test]
fn light_by_way_of_a_masked_interface_is_dispersed() {
    let folder = tempfile::tempdir().unwrap();
    // Its mask of opacity 0.5 lets half of the light pass.
    let scene = balls(folder.path());
    let scene = scene
        .with_dispersion(&[("veiled", "cauchy:1.3,0.3")])
        .unwrap();
    let mut spectral = MaterialsAtWavelength::new(&scene).unwrap();
    let shape = scene
        .objects()
        .iter()
        .position(|object| object.id == "veiled")
        .unwrap();
    let down = DVec3::NEG_Z;
    let ray = Ray {
        origin: DVec3::new(0.0, 0.0, 2.0),
        direction: down,
    };
    let mut counters = TraversalCounters::default();
    let hit = scene
        .world()
        .closest_hit(&ray, f64::INFINITY, &mut counters)
        .unwrap();
    assert_eq!(hit.shape as usize, shape);
    let point = scene.world().bounce_point(&ray, &hit);
    for wavelength in [400.0, 700.0] {
        let materials = spectral.at(wavelength);
        let material = &materials[scene.objects()[shape].material.0 as usize];
        let normals = ShadingNormals::Flux;
        let met = Interaction::among((&scene, materials), material, &point, down, normals);
        let n = 1.3 + 0.3 / (wavelength / 1000.0f64).powi(2);
        let reflected = 0.5 * ((n - 1.0) / (n + 1.0)).powi(2);
        let share = met.share_of(Way::Reflected);
        assert!(
            (share - reflected).abs() < 1e-12,
            "{wavelength} nm: {share}, not {reflected}"
        );
    }
}
