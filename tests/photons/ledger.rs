//! All light is accounted for: emitted = received + direct + escaped + absorbed + cut off.

use std::path::PathBuf;

use nephroid::internals::generate::scene_names;
use nephroid::internals::mitsuba;
use nephroid::internals::numeric::StreamKind;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::photons::run::Setup;
use nephroid::internals::run::Budget;
use nephroid::internals::run::Progress;
use nephroid::internals::transport::chain::ChainSettings;
use nephroid::internals::transport::followed::Followed;
use nephroid::internals::transport::scatter::ShadingNormals;

use crate::support::bundled_file;

/// The bar. Rounding leaves less: an emitted photon, its received, escaped and absorbed
/// parts are each rounded to 2⁻⁶⁰ of the light's flux, which for 10⁵ photons sums to 1e-13 at worst.
const CLOSES: f64 = 1e-12;

fn shipped_scenes() -> Vec<PathBuf> {
    // By name: the folder also has files that scenes include.
    let scenes = scene_names().map(bundled_file);
    scenes.collect()
}

#[test]
fn the_ledger_closes_on_every_scene_with_every_setting() {
    let settings = [
        (StreamKind::Sobol, 2, 16, ShadingNormals::Flux),
        (StreamKind::Random, 0, 3, ShadingNormals::Flux),
        (StreamKind::Sobol, 4, 0, ShadingNormals::Flux),
        (StreamKind::Random, 1, 31, ShadingNormals::Adjoint),
    ];
    for path in shipped_scenes() {
        let scene = mitsuba::load(&path, &[("size".into(), "16".into())]).unwrap();
        let sensor = scene
            .sensors()
            .iter()
            .find(|sensor| sensor.plugin() == "irradiancemeter")
            .unwrap();
        for (stream, split_depth, max_depth, shading_normals) in settings {
            let settings = PhotonSettings {
                stream,
                replicates: 3,
                chains: ChainSettings {
                    max_depth,
                    split_depth,
                    shading_normals,
                    followed: Followed::All,
                },
                ..PhotonSettings::default()
            };
            let progress = Progress::default();
            let setup = Setup::new(&scene, sensor, settings, &progress).unwrap();
            let budget = Budget {
                work: Some(60_000),
                ..Budget::default()
            };
            let estimate = setup.run(&budget).unwrap();
            let name = path.file_name().unwrap().to_string_lossy();
            let case = format!("{name} {settings:?}");
            let ledger = &estimate.ledger;
            assert!(
                ledger.closure_error().unwrap() < CLOSES,
                "{case}: {ledger:?}"
            );
            // No more leaves than the cells can hold; most of it where they are tight.
            let bound = setup.light().flux_bound();
            assert!(
                ledger.emitted.max_channel() <= bound.max_channel() * 1.01,
                "{case}"
            );
            assert!(
                ledger.emitted.max_channel() >= bound.max_channel() * 0.3,
                "{case}"
            );
            // Nothing is received that the map does not hold, and the other way round.
            let target = setup.target();
            let mut on_map = Rgb::BLACK;
            for layer in &estimate.layers[1..] {
                for (texel, value) in layer.values.iter().enumerate() {
                    on_map += *value * target.measure(texel);
                }
            }
            let received = ledger.sum().received;
            let scale = ledger.emitted.max_channel();
            assert!(
                (on_map - received).map(f64::abs).max_channel() < CLOSES * scale,
                "{case}: {on_map:?} on the map, {received:?} in the ledger"
            );
            if shading_normals == ShadingNormals::Flux {
                assert!(ledger.shading_gain.is_black(), "{case}");
            }
            if max_depth == 0 {
                assert!(received.is_black(), "{case}");
                assert!(!ledger.sum().cut_off.is_black(), "{case}");
            }
        }
    }
}

#[test]
fn the_flux_of_the_cells_is_what_photons_start_with() {
    // A point light's cells have exact solid angles: the photons' mean must find the same.
    let path = bundled_file("glass-ball");
    let scene = mitsuba::load(&path, &[("size".into(), "16".into())]).unwrap();
    let progress = Progress::default();
    let setup = Setup::new(
        &scene,
        &scene.sensors()[0],
        PhotonSettings::default(),
        &progress,
    );
    let setup = setup.unwrap();
    let estimate = setup
        .run(&Budget {
            work: Some(1 << 20),
            ..Budget::default()
        })
        .unwrap();
    let expected = setup.light().flux_bound().mean();
    let found = estimate.ledger.emitted.mean();
    // Cells are 2⁻⁷ wide, and the density (1 + x² + y²)^(-3/2) changes by at most 1.5 times that
    // a unit: by 1.7 % over a cell's diagonal, a standard deviation below 0.85 % (Popoviciu). Plain
    // random sampling would leave 0.85 % / √2²⁰ of the sum, and stratification no more; five times that.
    assert!(
        (found / expected - 1.0).abs() < 4.2e-5,
        "{found} {expected}"
    );
}
