//! Shared parts of the tests of extremes: scenes put anywhere at any size, runs of them, and the distance of
//! two maps.

pub mod double_double;

use std::path::Path;

use glam::DVec3;
use nephroid::internals::mitsuba;
use nephroid::internals::mitsuba::LoadError;
use nephroid::internals::reference::beams::{BeamSettings, run};
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::photons::run::Setup;
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, Layer, LayerName, Progress};
use nephroid::internals::scene::{Scene, SceneParts, Sensor, SensorKind};
use nephroid::internals::transport::signature::Signature;

use super::scenes::meter;

/// The unit roundoff of `f64`, 2⁻⁵³: half a unit in the last place of 1.
pub const U: f64 = f64::EPSILON / 2.0;

/// A scene file's text in which lengths and places are still to be chosen.
///
/// - `{placed}`: the end of every `to_world`, which scales the scene, then moves it.
/// - `{length 2}`: a length or coordinate, multiplied by the scale.
/// - `{area 100}`: a radiant intensity [W/sr], multiplied by the square of the scale, which keeps irradiance
///   as it is.
/// - `{side}`: texels along each side of the receiver.
#[derive(Clone, Copy, Debug)]
pub struct Template {
    pub name: &'static str,
    pub xml: &'static str,
    /// A mesh of `scenes/` that the text names.
    pub mesh: Option<&'static str>,
}

/// `scenes/glass-ball.xml`: a sphere under a point light.
pub const BALL: Template = Template {
    name: "glass ball",
    mesh: None,
    xml: r#"
<emitter type="point">
  <transform name="to_world"><translate z="4"/>{placed}</transform>
  <rgb name="intensity" value="{area 100}"/>
</emitter>
<shape type="sphere">
  <transform name="to_world"><translate z="1.4"/>{placed}</transform>
  <bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>
</shape>
<shape type="rectangle">
  <transform name="to_world"><scale x="2" y="2"/>{placed}</transform>
  <bsdf type="diffuse"/>{meter}
</shape>"#,
};

/// `scenes/mirror-ring.xml` turned a little and lit by a spot: a tube of metal, so that cylinder, disc and
/// spot are in it.
pub const RING: Template = Template {
    name: "metal ring",
    mesh: None,
    xml: r#"
<emitter type="spot">
  <transform name="to_world"><lookat origin="-1.3, 0.2, 2.1" target="0.4, 0.1, 0" up="0, 0, 1"/>{placed}</transform>
  <rgb name="intensity" value="{area 30}"/>
  <float name="cutoff_angle" value="35"/>
</emitter>
<shape type="cylinder">
  <transform name="to_world"><scale x="0.9" y="0.9" z="0.5"/>{placed}</transform>
  <bsdf type="twosided"><bsdf type="conductor"><string name="material" value="Au"/></bsdf></bsdf>
</shape>
<shape type="disk">
  <transform name="to_world"><scale value="0.2"/><translate x="0.1" y="0.1" z="0.3"/>{placed}</transform>
  <bsdf type="diffuse"/>
</shape>
<shape type="rectangle">
  <transform name="to_world"><scale x="1.1" y="1.1"/>{placed}</transform>
  <bsdf type="diffuse"/>{meter}
</shape>"#,
};

/// `scenes/diamond.xml`: a mesh with flat faces in sunlight.
pub const DIAMOND: Template = Template {
    name: "diamond",
    mesh: Some("diamond.ply"),
    xml: r#"
<emitter type="directional">
  <vector name="direction" x="0.3" y="0.1" z="-1"/>
  <rgb name="irradiance" value="1000"/>
</emitter>
<shape type="ply">
  <string name="filename" value="diamond.ply"/><boolean name="face_normals" value="true"/>
  <transform name="to_world"><rotate y="1" angle="165"/><translate z="0.4"/>{placed}</transform>
  <bsdf type="dielectric"><float name="int_ior" value="2.418"/><float name="ext_ior" value="1"/></bsdf>
</shape>
<shape type="rectangle">
  <transform name="to_world"><scale x="1.2" y="1.2"/>{placed}</transform>
  <bsdf type="diffuse"/>{meter}
</shape>"#,
};

/// `scenes/water.xml`: a mesh with interpolated normals in sunlight.
pub const WATER: Template = Template {
    name: "water",
    mesh: Some("water.ply"),
    xml: r#"
<emitter type="directional">
  <vector name="direction" x="0.1" y="0" z="-1"/>
  <rgb name="irradiance" value="1000"/>
</emitter>
<shape type="ply">
  <string name="filename" value="water.ply"/>
  <transform name="to_world">{placed}</transform>
  <bsdf type="dielectric"><float name="int_ior" value="1.33"/><float name="ext_ior" value="1"/></bsdf>
</shape>
<shape type="rectangle">
  <transform name="to_world"><scale x="0.8" y="0.8"/>{placed}</transform>
  <bsdf type="diffuse"/>{meter}
</shape>"#,
};

/// Place and size of a scene: p ↦ `scale` · p + `offset`.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    pub scale: f64,
    pub offset: DVec3,
}

impl Placement {
    /// As the template has it.
    pub const HOME: Self = Self {
        scale: 1.0,
        offset: DVec3::ZERO,
    };

    pub fn scaled(scale: f64) -> Self {
        Self {
            scale,
            ..Self::HOME
        }
    }

    pub fn moved(offset: DVec3) -> Self {
        Self {
            offset,
            ..Self::HOME
        }
    }
}

impl Template {
    /// The scene read from a file, its receiver with `side` x `side` texels.
    pub fn scene(&self, place: Placement, side: usize) -> Scene {
        scene(&self.placed(place), self.mesh, side)
    }

    /// Why the scene cannot be read.
    pub fn error(&self, place: Placement) -> String {
        match load(&self.placed(place), self.mesh, 1) {
            Ok(_) => panic!("{} can be read", self.name),
            Err(error) => error.to_string(),
        }
    }

    /// The text with all numbers in it.
    ///
    /// They are written with as many digits as tell them apart: the file says exactly what is meant.
    pub fn placed(&self, place: Placement) -> String {
        let Placement { scale, offset } = place;
        let placed = format!(
            r#"<scale value="{scale:?}"/><translate x="{:?}" y="{:?}" z="{:?}"/>"#,
            offset.x, offset.y, offset.z
        );
        let mut xml = self.xml.replace("{placed}", &placed);
        for (name, factor) in [("{length ", scale), ("{area ", scale * scale)] {
            while let Some(from) = xml.find(name) {
                let to = from + xml[from..].find('}').expect("a closing brace");
                let number: f64 = xml[from + name.len()..to].parse().expect("a number");
                xml.replace_range(from..=to, &format!("{:?}", number * factor));
            }
        }
        xml
    }
}

/// A scene of shapes and emitters, read from a file; `{meter}` stands for a meter of `side` x `side` texels,
/// `{film}` for a camera's film of as many pixels.
pub fn scene(things: &str, mesh: Option<&str>, side: usize) -> Scene {
    let parts = load(things, mesh, side).expect("a scene that can be read");
    Scene::new(parts).expect("a valid scene")
}

/// The same with a mesh file, by name and content.
pub fn scene_with(things: &str, (name, content): (&str, &str), side: usize) -> Scene {
    let folder = tempfile::tempdir().expect("a folder for the scene");
    std::fs::write(folder.path().join(name), content).expect("the mesh");
    let parts = load_in(folder.path(), things, side).expect("a scene that can be read");
    Scene::new(parts).expect("a valid scene")
}

fn load(things: &str, mesh: Option<&str>, side: usize) -> Result<SceneParts, LoadError> {
    let folder = tempfile::tempdir().expect("a folder for the scene");
    if let Some(mesh) = mesh {
        let from = Path::new(env!("CARGO_MANIFEST_DIR"))
            .join("scenes")
            .join(mesh);
        std::fs::copy(from, folder.path().join(mesh)).expect("a mesh of the shipped scenes");
    }
    load_in(folder.path(), things, side)
}

/// Writes the scene beside its mesh, and reads it.
fn load_in(folder: &Path, things: &str, side: usize) -> Result<SceneParts, LoadError> {
    let film = format!(
        r#"<film type="hdrfilm"><integer name="width" value="{side}"/>
        <integer name="height" value="{side}"/><rfilter type="box"/></film>"#
    );
    let meter = format!(r#"<sensor type="irradiancemeter">{film}</sensor>"#);
    let xml = format!(
        r#"<scene version="3.0.0">{}</scene>"#,
        things.replace("{meter}", &meter).replace("{film}", &film)
    );
    let file = folder.join("scene.xml");
    std::fs::write(&file, xml).expect("the scene's file");
    mitsuba::load_parts(&file, &[])
}

/// The scene's camera.
pub fn camera(scene: &Scene) -> &Sensor {
    scene
        .sensors()
        .iter()
        .find(|sensor| !matches!(sensor.kind, SensorKind::IrradianceMeter { .. }))
        .expect("a camera")
}

/// The map by beams, to a relative error, after at most `depth` events.
///
/// The run is finished, and says that it has reached what it was asked for. Only where no specular light
/// falls on the meter is there no error to say.
pub fn beams(scene: &Scene, relative_error: f64, depth: u32) -> Estimate {
    beams_to(scene, meter(scene), relative_error, depth)
}

/// Estimate of any sensor by beams, see [`beams`].
pub fn beams_to(scene: &Scene, sensor: &Sensor, relative_error: f64, depth: u32) -> Estimate {
    let settings = BeamSettings {
        max_depth: depth,
        max_layers: 64,
        ..BeamSettings::default()
    };
    let budget = Budget {
        relative_error: Some(relative_error),
        ..Budget::default()
    };
    let estimate = run(scene, sensor, settings, &budget, &Progress::default())
        .expect("beams start")
        .0;
    assert!(!estimate.incomplete, "beams asked for {relative_error:e}");
    if let Some(reached) = estimate.relative_error {
        assert!(reached <= relative_error, "{reached:e}");
    } else {
        assert!(specular(&estimate).iter().all(|light| *light == 0.0));
    }
    estimate
}

/// The map by photons, after at most `depth` events.
pub fn photons(scene: &Scene, count: u64, depth: u32) -> Estimate {
    photons_to(scene, meter(scene), count, depth)
}

/// Estimate of any sensor by photons.
pub fn photons_to(scene: &Scene, sensor: &Sensor, count: u64, depth: u32) -> Estimate {
    let mut settings = PhotonSettings {
        max_layers: 64,
        ..PhotonSettings::default()
    };
    settings.chains.max_depth = depth;
    let budget = Budget {
        work: Some(count),
        ..Budget::default()
    };
    Setup::new(scene, sensor, settings, &Progress::default())
        .and_then(|setup| setup.run(&budget))
        .expect("photons start")
}

/// The layer of a signature, if the run found such light.
pub fn layer<'a>(estimate: &'a Estimate, signature: &str) -> Option<&'a Layer> {
    let wanted = LayerName::Path(signature.parse().expect("a signature"));
    estimate.layers.iter().find(|layer| layer.name == wanted)
}

/// One channel of a layer [W/m²].
pub fn red(layer: &Layer) -> Vec<f64> {
    layer.values.iter().map(|value| value.0[0]).collect()
}

/// One channel of all light but `LD` [W/m²].
pub fn specular(estimate: &Estimate) -> Vec<f64> {
    let direct = LayerName::Path(Signature::DIRECT);
    let mut sum = vec![0.0; estimate.total.values.len()];
    for layer in estimate.layers.iter().filter(|layer| layer.name != direct) {
        for (sum, value) in sum.iter_mut().zip(red(layer)) {
            *sum += value;
        }
    }
    sum
}

/// By how much a layer's bounds miss the truth at worst, and how far its values are off: relative to the
/// brightest texel.
///
/// NaN where a texel is not known.
pub fn judged(layer: &Layer, truth: &[f64]) -> (f64, f64) {
    let bounds = layer.interval.as_ref().expect("beams have bounds");
    let brightest = truth.iter().copied().fold(0.0, f64::max);
    let missed = truth.iter().enumerate().map(|(texel, truth)| {
        (bounds.low[texel].0[0] - truth).max(truth - bounds.high[texel].0[0])
    });
    (worst(missed) / brightest, distance(truth, &red(layer)))
}

/// The largest of some numbers and 0; NaN where any is.
fn worst(numbers: impl Iterator<Item = f64>) -> f64 {
    numbers.fold(
        0.0,
        |worst: f64, one| {
            if one.is_nan() { one } else { worst.max(one) }
        },
    )
}

/// Distance of two maps: the largest difference of a texel, relative to the first map's brightest
/// texel.
///
/// NaN where anything is, so that no comparison with it holds.
pub fn distance(first: &[f64], second: &[f64]) -> f64 {
    let brightest = first.iter().copied().fold(0.0, f64::max);
    let apart = worst(first.iter().zip(second).map(|(a, b)| (a - b).abs()));
    if apart == 0.0 { 0.0 } else { apart / brightest }
}

/// √(mean squared error) over the texels that have light, relative to their mean truth: of all specular
/// light, this is what beams are asked for.
///
/// NaN where anything is.
pub fn rmse(truth: &[f64], map: &[f64]) -> f64 {
    let lit = truth.iter().filter(|truth| **truth > 0.0).count() as f64;
    let mean = truth.iter().sum::<f64>() / lit;
    let squares: f64 = truth.iter().zip(map).map(|(a, b)| (a - b) * (a - b)).sum();
    (squares / lit).sqrt() / mean
}

/// The error of a map, which is some or all of the specular light of a run by beams: √(mean squared error)
/// over the texels that have specular light, relative to its mean there.
///
/// For all specular light, such runs are asked for this error. For one layer, it is that layer's part of it.
pub fn error_as_asked(estimate: &Estimate, truth: &[f64], map: &[f64]) -> f64 {
    let all = specular(estimate);
    let lit = all.iter().filter(|light| **light > 0.0).count() as f64;
    let squares: f64 = truth.iter().zip(map).map(|(a, b)| (a - b) * (a - b)).sum();
    (squares * lit).sqrt() / all.iter().sum::<f64>()
}

/// Most that the bars of a map may be wider than the error asked for: a ratio of root mean squares.
///
/// A bar is to hold in its texel for sure. It has the largest |q| of nine texels, where the likely error is a
/// quarter of |q|: root mean square, that is 4 · √9 times as much at most (`reference/beams/bars.rs`). On top
/// comes what may cancel in q, which no formula ties to the likely error: as much again is allowed for it.
const WIDEST_BARS: f64 = 2.0 * 4.0 * 3.0;

/// Asserts that a layer of specular light is what a run by beams was asked for: every texel's truth is in its
/// bounds, the error is no larger than asked, and the bounds are no wider than what that is worth. Returns
/// its largest error, relative to its brightest texel, and [`error_as_asked`].
pub fn assert_as_asked(
    name: &str,
    estimate: &Estimate,
    signature: &str,
    truth: &[f64],
    asked: f64,
) -> [f64; 2] {
    let found = layer(estimate, signature).unwrap_or_else(|| panic!("{name}: no {signature}"));
    let (missed, off) = judged(found, truth);
    assert!(missed <= ORACLE, "{name}, {signature}: {missed:e}");
    let map = red(found);
    let error = error_as_asked(estimate, truth, &map);
    assert!(error <= asked, "{name}, {signature}: off by {error:e}");
    let bounds = found.interval.as_ref().expect("beams have bounds");
    let half = |texel: usize| 0.5 * (bounds.high[texel].0[0] - bounds.low[texel].0[0]);
    let beside: Vec<f64> = (0..map.len())
        .map(|texel| map[texel] + half(texel))
        .collect();
    let bars = error_as_asked(estimate, &map, &beside);
    assert!(
        bars <= WIDEST_BARS * asked,
        "{name}, {signature}: bars of {bars:e}"
    );
    [off, error]
}

/// The closed forms of round scenes know a texel to 1e-12 of the flux of the circles that meet it; a circle
/// is no longer than some hundred texels, and a texel is 1e-1 of the brightest: 1e-9 of the brightest texel.
pub const ORACLE: f64 = 1e-9;
