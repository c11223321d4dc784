//! The library as a program of one's own would use it: by public names alone.
#![allow(
    clippy::disallowed_methods,
    reason = "oracles and figures of a test, no results"
)]

use nephroid::{
    Budget, CompareImage, CompareSettings, Context, Interval, LayerName, Method, Quantity,
    Signature, Verdict, compare, load, read_exr,
};

type Outcome = Result<(), Box<dyn std::error::Error>>;

/// A glass ball over a receiver of 8 x 8 texels.
fn scene() -> Result<nephroid::Scene, nephroid::LoadError> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/scenes/glass-ball.xml");
    load(path.as_ref(), &[("size", "8")])
}

#[test]
fn a_scene_is_measured_written_and_compared() -> Outcome {
    let scene = scene()?;
    let sensor = &scene.sensors()[0];
    let method = Method::new("closed-form", &[("max-depth".into(), "3".into())].into())?;
    method.supports(&scene, sensor)?;
    let rendering = method.run(&scene, sensor, &Budget::default(), &Context::default())?;

    let estimate = &rendering.estimate;
    assert_eq!(estimate.quantity, Quantity::Irradiance);
    assert_eq!([estimate.width, estimate.height], sensor.size());
    let through: Signature = "LTTD".parse()?;
    let mut layers = estimate.layers.iter();
    let caustic = layers.find(|layer| layer.name == LayerName::Path(through));
    let caustic = caustic.ok_or("no light through the ball")?;
    let Interval { low, high } = caustic.interval.as_ref().ok_or("no bounds")?;
    for ((value, low), high) in caustic.values.iter().zip(low).zip(high) {
        assert!(low.mean() <= value.mean() && value.mean() <= high.mean());
    }
    assert!(caustic.range().max > caustic.range().mean);
    assert!(caustic.relative_error().is_some_and(|error| error < 1e-3));

    let folder = tempfile::tempdir()?;
    let path = folder.path().join("truth.exr");
    rendering.write_exr(&scene, &path)?;
    let image = read_exr(&path)?;
    assert_eq!(image.metadata("unit"), Some("W/m²"));
    let written = CompareImage::new("truth.exr", image);
    let measured = CompareImage::new("measured", rendering.image(&scene));
    let comparison = compare(&written, &measured, &CompareSettings::default())?;
    assert_eq!(comparison.verdict, Verdict::Equivalent);
    let difference: &nephroid::Difference = &comparison.layers[0].difference;
    assert_eq!(difference.rmse, 0.0);
    Ok(())
}

#[test]
fn the_scene_chooses_and_photons_account_for_all_flux() -> Outcome {
    let scene = scene()?;
    let sensor = &scene.sensors()[0];
    let choice = Method::choose(&scene, sensor)?;
    assert_eq!(choice.method.name(), "beams");
    assert!(!choice.reason.is_empty());

    let method = Method::new("photons", &Default::default())?.with("seed", "7")?;
    let context = Context::default();
    let rendering = method.run(&scene, sensor, &Budget::work(4096), &context)?;
    assert_eq!(context.progress.done(), 4096);
    let total = &rendering.estimate.total;
    assert!(total.standard_error.iter().any(|error| error.mean() > 0.0));
    let ledger = &rendering.estimate.ledger;
    assert!(ledger.closure_error().is_some_and(|error| error < 1e-12));
    assert!(ledger.rows[&"LTTD".parse()?].received.mean() > 0.0);
    Ok(())
}
