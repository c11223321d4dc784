//! Scenes that closed forms are to recognise, and their light beside that of beams.

use std::fs;

use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::beams::BeamSettings;
use nephroid::internals::reference::closed_form::{ClosedFormSettings, solve};
use nephroid::internals::run::{Estimate, Interval, Layer, LayerName, Progress};
use nephroid::internals::scene::{Crop, Scene};
use nephroid::internals::transport::signature::Signature;

use super::beams::beams_to;
use super::scenes::{bundled_file, meter};

/// Error that beams are asked for.
const BEAM_ERROR: f64 = 3e-3;

/// Part of the error asked for that light may have which beams do not follow.
const LEFT_OUT: f64 = 0.25;

/// A part of the brightest texel's direct light that the quadrature of direct light may not see: a corner of
/// a shadow between two of its points, 1/16 of a texel apart, covers up to 1/1024 of a texel; see
/// `tests/photons/closed_forms.rs`.
const HIDDEN_CORNERS: f64 = 1.0 / 1024.0 + 1e-8;

/// A scene file with `(text, replacement)` made in it, on a film of this width and height.
///
/// # Panics
///
/// If a text is not in the file.
pub fn edited(name: &str, changes: &[(&str, &str)], size: [u32; 2]) -> Scene {
    let mut xml = fs::read_to_string(bundled_file(name)).unwrap();
    for (text, replacement) in changes {
        assert!(xml.contains(text), "{name} does not hold {text}");
        xml = xml.replace(text, replacement);
    }
    of_text(&xml, size)
}

/// The scene of a text, whose files are in the folder of the bundled scenes.
pub fn of_text(xml: &str, size: [u32; 2]) -> Scene {
    let scenes = bundled_file("cube").parent().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    for entry in fs::read_dir(scenes).unwrap() {
        let path = entry.unwrap().path();
        if path.extension().is_some_and(|extension| extension == "ply") {
            fs::copy(&path, folder.path().join(path.file_name().unwrap())).unwrap();
        }
    }
    let file = folder.path().join("scene.xml");
    fs::write(&file, xml).unwrap();
    let mut parts = nephroid::internals::mitsuba::load_parts(&file, &[]).unwrap();
    for sensor in &mut parts.sensors {
        (sensor.film.width, sensor.film.height) = (size[0], size[1]);
        sensor.film.crop = Crop {
            offset_x: 0,
            offset_y: 0,
            width: size[0],
            height: size[1],
        };
    }
    Scene::new(parts).unwrap()
}

/// Rounding of beams, as a part of a layer's brightest texel; derived in `tests/beams/flat_facets.rs`.
const BEAM_ROUNDING: f64 = 1e-9;

/// The closed form of a scene's meter.
pub fn known(scene: &Scene, max_depth: u32) -> Estimate {
    solve(
        scene,
        meter(scene),
        ClosedFormSettings { max_depth },
        &Progress::default(),
    )
    .unwrap()
}

/// The layer of a path, if the estimate has one.
pub fn layer_of(estimate: &Estimate, signature: Signature) -> Option<&Layer> {
    let wanted = LayerName::Path(signature);
    estimate.layers.iter().find(|layer| layer.name == wanted)
}

/// Texels of the closed form beside those of beams.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Texels {
    /// Those whose two intervals do not meet.
    pub apart: usize,
    /// Those with light for sure, in any specular layer.
    pub lit: usize,
}

/// Compares two estimates texel by texel and channel by channel: in every layer the two intervals must meet.
/// Direct light is allowed what its quadrature does not see.
///
/// Layers of the closed form that beams do not follow must be too faint for them: a thousandth of all light,
/// times the error, is what they leave out; each of several layers.
pub fn compared(known: &Estimate, beams: &Estimate) -> Texels {
    let mut texels = Texels::default();
    let dark = Layer::bounded(LayerName::Other, known.total.values.len());
    let mut worst = f64::NEG_INFINITY;
    for beam in &beams.layers {
        let LayerName::Path(signature) = beam.name else {
            panic!("every signature has a layer");
        };
        let layer = layer_of(known, signature).unwrap_or(&dark);
        let direct = signature == Signature::DIRECT;
        let (mine, theirs) = (interval(layer), interval(beam));
        let brightest = mine
            .high
            .iter()
            .map(|value| value.max_channel())
            .fold(0.0, f64::max);
        for texel in 0..mine.low.len() {
            let hidden = if direct { HIDDEN_CORNERS } else { 0.0 };
            let meets = (0..3).all(|c| {
                let allowed = (hidden + BEAM_ROUNDING) * brightest;
                let apart = (theirs.low[texel].0[c] - mine.high[texel].0[c])
                    .max(mine.low[texel].0[c] - theirs.high[texel].0[c]);
                worst = worst.max((apart - allowed) / brightest);
                // False for NaN.
                apart <= allowed
            });
            texels.apart += usize::from(!meets);
            texels.lit += usize::from(!direct && mine.low[texel].max_channel() > 0.0);
        }
    }
    println!("the worst texel is {worst:.1e} of its layer's brightest beyond what is allowed");
    let all = sum(&known.total.values);
    for layer in &known.layers {
        let LayerName::Path(signature) = layer.name else {
            panic!("every closed form is one path's");
        };
        if layer_of(beams, signature).is_none() {
            let share = sum(&layer.values) / all;
            assert!(
                share < 2.0 * LEFT_OUT * BEAM_ERROR,
                "{signature}, {share:e} of all light, is not in the beams"
            );
        }
    }
    texels
}

/// The closed form and the beams of a scene to the same depth.
pub fn both(scene: &Scene, depth: u32) -> (Estimate, Estimate) {
    assert!(depth <= BeamSettings::default().max_depth);
    let (beams, _) = beams_to(depth, scene, BEAM_ERROR);
    (known(scene, depth), beams)
}

/// Asserts that every texel of every layer is within the beams' bounds, and that at least `least` texels had
/// light.
pub fn assert_agrees(name: &str, scene: &Scene, depth: u32, least: usize) -> (Estimate, Estimate) {
    let (known, beams) = both(scene, depth);
    let texels = compared(&known, &beams);
    println!("{name}: {texels:?}");
    assert_eq!(texels.apart, 0, "{name}: {texels:?}");
    assert!(texels.lit >= least, "{name}: {texels:?}");
    (known, beams)
}

/// The estimate with every map changed by `change`.
pub fn changed(estimate: &Estimate, change: impl Fn(&[Rgb]) -> Vec<Rgb>) -> Estimate {
    let mut result = estimate.clone();
    for layer in &mut result.layers {
        layer.values = change(&layer.values);
        let bounds = interval(layer);
        layer.interval = Some(Interval {
            low: change(&bounds.low),
            high: change(&bounds.high),
        });
    }
    result
}

fn interval(layer: &Layer) -> &Interval {
    layer.interval.as_ref().unwrap()
}

fn sum(values: &[Rgb]) -> f64 {
    values.iter().map(|value| value.mean()).sum()
}
