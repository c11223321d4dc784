//! Scenes in a few lines, and images of them by paths.

use nephroid::internals::mitsuba::load;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::path::{PathSettings, run};
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, Layer, LayerName, Progress};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::path_class::PathClass;

/// A scene of these elements.
pub fn scene(elements: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.xml");
    std::fs::write(
        &path,
        format!("<scene version=\"3.0.0\">{elements}</scene>"),
    )
    .unwrap();
    load(&path, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// A film of these many pixels, with a filter.
pub fn film(width: u32, height: u32, filter: &str) -> String {
    format!(
        "<film type=\"hdrfilm\"><integer name=\"width\" value=\"{width}\"/>\
         <integer name=\"height\" value=\"{height}\"/>{filter}</film>"
    )
}

/// The box filter.
pub const BOX: &str = "<rfilter type=\"box\"/>";

/// A perspective camera that looks along +y from `y` = -3.
pub fn camera(fov: f64, film: &str) -> String {
    format!(
        "<sensor type=\"perspective\"><float name=\"fov\" value=\"{fov}\"/>\
         <transform name=\"to_world\"><lookat origin=\"0, -3, 0\" target=\"0, 0, 0\" up=\"0, 0, 1\"/>\
         </transform>{film}</sensor>"
    )
}

/// The default settings, but for 32 replicates: scores against their bars are nearly normal. Of 8 they are
/// beyond three once in fifty times.
pub fn with_32_replicates() -> PathSettings {
    PathSettings {
        replicates: 32,
        ..PathSettings::default()
    }
}

/// An image of the scene's first sensor, `samples` a pixel.
pub fn image(scene: &Scene, settings: PathSettings, samples: u64) -> Estimate {
    let budget = Budget {
        work: Some(samples),
        ..Budget::default()
    };
    run(
        scene,
        &scene.sensors()[0],
        settings,
        &budget,
        &Progress::default(),
    )
    .unwrap()
    .0
}

/// The layer of a class; `None` where it is black.
pub fn class(estimate: &Estimate, class: PathClass) -> Option<&Layer> {
    let layers = &estimate.layers;
    layers
        .iter()
        .find(|layer| layer.name == LayerName::Class(class))
}

/// The mean of one channel over all pixels, and its standard error, pixels taken as independent: with a box
/// filter they are.
pub fn mean(layer: &Layer, channel: usize) -> (f64, f64) {
    let pixels = layer.values.len() as f64;
    let value = layer.values.iter().map(|value| value.0[channel]);
    let variance = layer
        .standard_error
        .iter()
        .map(|error| error.0[channel].powi(2));
    (
        value.sum::<f64>() / pixels,
        variance.sum::<f64>().sqrt() / pixels,
    )
}

/// Asserts that a mean is the truth to four of its standard errors, and that those are small enough to mean
/// something.
pub fn assert_mean(claim: &str, layer: &Layer, truth: f64, largest_error: f64) {
    let (value, error) = mean(layer, 0);
    assert!(
        error <= largest_error * truth,
        "{claim}: {value} ± {error}, too uncertain"
    );
    // A million roundings at most, where there is no error at all.
    let rounding = 1e-10 * truth;
    assert!(
        (value - truth).abs() <= 4.0 * error + rounding,
        "{claim}: {value} ± {error} is not {truth}"
    );
}

/// All bits of an image.
pub fn bits(estimate: &Estimate) -> Vec<u64> {
    let mut bits = vec![estimate.paths, estimate.counters.rays];
    for layer in std::iter::once(&estimate.total).chain(&estimate.layers) {
        bits.extend(layer_bits(layer));
    }
    bits
}

/// Panics if a run has other bits on other numbers of threads than on one.
pub fn assert_same_on_threads(others: &[usize], run: impl Fn() -> Estimate + Sync) {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        bits(&pool.unwrap().install(&run))
    };
    let one = on(1);
    for &threads in others {
        assert!(on(threads) == one, "{threads} threads");
    }
}

/// All bits of a layer.
pub fn layer_bits(layer: &Layer) -> Vec<u64> {
    let values = layer.values.iter().chain(&layer.standard_error);
    values
        .flat_map(|value: &Rgb| value.0.map(f64::to_bits))
        .collect()
}
