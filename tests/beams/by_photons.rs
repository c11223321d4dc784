//! Light of chaotic chains: beams would not end, and photons measure it in their place.

use nephroid::internals::reference::beams::{BeamReport, BeamSettings, Chaotic, run};
use nephroid::internals::run::{Budget, Estimate, Layer, LayerName, Progress};
use nephroid::internals::scene::Scene;

use crate::support::Photons;
use crate::support::scenes::{below_bumps, meter};
use crate::support::student::two_sided_quantile;

const SIDE: usize = 32;

/// A bumpy ball of 5,120 triangles with interpolated normals below a lamp on its axis.
fn bumps() -> Scene {
    below_bumps(16, true, [0.0, 0.0, 4.0], SIDE)
}

fn measured(scene: &Scene, budget: &Budget, chaotic: Chaotic, seed: u64) -> (Estimate, BeamReport) {
    let settings = BeamSettings {
        chaotic,
        seed,
        max_layers: 6,
        ..BeamSettings::default()
    };
    run(scene, meter(scene), settings, budget, &Progress::default()).unwrap()
}

/// The sum of a map.
fn total(estimate: &Estimate) -> f64 {
    estimate.total.values.iter().map(|one| one.0[0]).sum()
}

/// The number of texels on which a layer has noise.
fn noisy(layer: &Layer) -> usize {
    let errors = layer.standard_error.iter();
    errors.filter(|error| !error.is_black()).count()
}

#[test]
fn beams_end_below_a_bumpy_ball_and_agree_with_photons_in_all_light() {
    let scene = bumps();
    let (estimate, report) = measured(&scene, &Budget::error(0.05), Chaotic::Photons, 0);
    assert!(!estimate.incomplete);
    assert!(estimate.relative_error.unwrap() <= 0.05);
    let rest = report.by_photons.unwrap();
    assert!(
        rest.signatures.iter().any(|one| one == "LTRRRRTD"),
        "{:?}",
        rest.signatures
    );
    // Nothing is left out.
    assert_eq!(report.not_followed, 0.0);
    let named = |name: &str| {
        let layers = estimate.layers.iter();
        layers
            .filter(|one| one.name.to_string() == name)
            .collect::<Vec<_>>()
    };
    // Each light has one layer: by beams without noise, by photons with it.
    assert_eq!((named("LTTD").len(), noisy(named("LTTD")[0])), (1, 0));
    assert_eq!(named("LTRRRRTD").len(), 1);
    assert!(noisy(named("LTRRRRTD")[0]) > SIDE * SIDE / 10);
    let most: usize = estimate
        .layers
        .iter()
        .filter(|one| one.name != LayerName::Other)
        .count();
    // Six, and LD.
    assert!(most <= 7, "{most} layers");
    // The ledger has the light of both: 4 m x 4 m, in equal texels.
    let texel = 16.0 / (SIDE * SIDE) as f64;
    let direct: f64 = named("LD")[0].values.iter().map(|one| one.0[0]).sum();
    let received = estimate.ledger.sum().received.0[0];
    let specular = (total(&estimate) - direct) * texel;
    assert!(
        (received / specular - 1.0).abs() < 1e-9,
        "{received} beside {specular}"
    );
    assert!(estimate.ledger.elsewhere.unwrap() > 0.0);
    // The flux of each light is that of independent photons. Both have 31 degrees of freedom.
    let photons = Photons::new(1 << 20).seed(9).estimate(&scene);
    let error = |estimate: &Estimate| {
        let errors = estimate.total.standard_error.iter();
        errors.map(|one| one.0[0] * one.0[0]).sum::<f64>().sqrt()
    };
    let t = two_sided_quantile(1e-6, 31);
    // Errors of texels add up by squares, of random photons: those of Sobol' points are no larger, and beams are
    // known to 3 % of their own light, which texels share at random.
    let beams = 0.05 * total(&estimate) / SIDE as f64;
    let joint = error(&estimate).hypot(error(&photons)).hypot(beams);
    let distance = (total(&estimate) - total(&photons)).abs();
    assert!(distance < t * joint, "{distance:e} beside {joint:e}");
    // And texel by texel: 1,024 of them, all at once at 1 in 10^4.
    let t = two_sided_quantile(1e-4 / (SIDE * SIDE) as f64, 31);
    let interval = estimate.total.interval.as_ref().unwrap();
    for texel in 0..SIDE * SIDE {
        let value = |estimate: &Estimate| estimate.total.values[texel].0[0];
        let error = |estimate: &Estimate| estimate.total.standard_error[texel].0[0];
        // The bounds have beams' bars beside those of photons.
        let bar = 0.5 * (interval.high[texel].0[0] - interval.low[texel].0[0]);
        let joint = t * error(&estimate).hypot(error(&photons)) + bar;
        let distance = (value(&estimate) - value(&photons)).abs();
        assert!(
            distance <= joint,
            "texel {texel}: {distance:e} beside {joint:e}"
        );
    }
}

#[test]
fn chaotic_light_is_the_same_on_any_threads_and_another_with_another_seed() {
    let scene = bumps();
    let on = |threads: usize, seed: u64| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        let pool = pool.build().unwrap();
        pool.install(|| measured(&scene, &Budget::error(0.05), Chaotic::Photons, seed).0)
    };
    let (one, three, other) = (on(1, 0), on(3, 0), on(2, 1));
    assert!(one.total.values == three.total.values);
    assert!(one.total.standard_error == three.total.standard_error);
    let layer = |estimate: &Estimate, name: &str| {
        let layers = estimate.layers.iter();
        layers
            .clone()
            .find(|one| one.name.to_string() == name)
            .unwrap()
            .values
            .clone()
    };
    assert!(layer(&one, "LTTD") == layer(&other, "LTTD"));
    assert!(one.total.values != other.total.values);
}

#[test]
fn the_error_of_photons_that_is_said_is_that_between_seeds() {
    let scene = bumps();
    let runs = [0, 1, 2, 3];
    let runs = runs.map(|seed| measured(&scene, &Budget::error(0.05), Chaotic::Photons, seed));
    let mut direct = runs[0].0.layers.iter();
    let direct = direct.find(|one| one.name.to_string() == "LD").unwrap();
    let light =
        |run: &Estimate, texel: usize| run.total.values[texel].0[0] - direct.values[texel].0[0];
    let (mut all, mut lit, mut squares) = (0.0, 0.0, 0.0);
    for texel in 0..SIDE * SIDE {
        let mean = runs.iter().map(|(run, _)| light(run, texel)).sum::<f64>() / 4.0;
        let apart = runs
            .iter()
            .map(|(run, _)| (light(run, texel) - mean).powi(2));
        // The variance of one run, from four. Beams have the same part of it in all.
        squares += apart.sum::<f64>() / 3.0;
        all += mean;
        lit += if mean > 0.0 { 1.0 } else { 0.0 };
    }
    let found = (squares / lit).sqrt() / (all / lit);
    for (_, report) in &runs {
        let said = report.by_photons.as_ref().unwrap().relative_error.unwrap();
        println!("{said} said, {found} between seeds");
        // Four runs have three degrees of freedom a texel. With a hundred texels that matter, the error is known
        // to 1 / √600, and five times that is a fifth.
        assert!(
            (found / said - 1.0).abs() < 0.2,
            "{said} said, {found} between seeds"
        );
    }
}

#[test]
fn beams_that_are_to_follow_chaotic_light_leave_none_to_photons() {
    let scene = bumps();
    let budget = Budget::work(1 << 20);
    // Rays are beams': photons have none of them.
    for chaotic in [Chaotic::Photons, Chaotic::Beams] {
        let (estimate, report) = measured(&scene, &budget, chaotic, 0);
        assert!(report.by_photons.is_none() && report.not_followed > 0.0);
        assert_eq!(noisy(&estimate.total), 0);
    }
    let time = Budget::time(std::time::Duration::from_secs(1));
    let (_, report) = measured(&scene, &time, Chaotic::Beams, 0);
    assert!(report.by_photons.is_none());
}

#[test]
fn photons_have_the_time_that_beams_leave_them() {
    let scene = bumps();
    let began = std::time::Instant::now();
    let budget = Budget::time(std::time::Duration::from_secs(8));
    let (estimate, report) = measured(&scene, &budget, Chaotic::Photons, 0);
    // Beams alone would take minutes, on whatever machine.
    assert!(began.elapsed().as_secs() < 60);
    assert!(!estimate.total.is_unknown() && report.by_photons.is_some());
    assert_eq!(report.not_followed, 0.0);
}
