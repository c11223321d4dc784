//! Shared parts of the tests of light volumes: water over a floor, and runs with some settings.

use std::fmt::Write as _;

use glam::{DVec2, DVec3};
use nephroid::internals::generate::{Wave, height_field, write_ply};
use nephroid::internals::geometry::MeshParts;
use nephroid::internals::method::Method;
use nephroid::internals::mitsuba;
use nephroid::internals::optics::{dielectric_reflectance, refract};
use nephroid::internals::run::{Budget, Context, Rendering};
use nephroid::internals::scene::{Scene, Sensor};

pub use super::approximation::scene_of;
use super::technique::technique;

/// Water of index 1.33.
pub const WATER: &str = r#"<bsdf type="dielectric"><float name="int_ior" value="1.33"/><float name="ext_ior" value="1"/></bsdf>"#;

/// Flat water of 6 x 6 at height 1.
pub const FLAT: &str = r#"<shape type="rectangle" id="water"><transform name="to_world"><scale x="3" y="3"/><translate z="1"/></transform>"#;

/// Irradiance of all suns here, across their light [W/m²].
pub const SUN: f64 = 1000.0;

/// A sun at `degrees` from the vertical, going towards +x, over `shapes`; a floor of 2 x 2 with `side` x
/// `side` texels.
pub fn pool(degrees: f64, shapes: &str, side: usize) -> String {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let mut xml = String::new();
    write!(
        xml,
        r#"<scene version="3.0.0">
        <emitter type="directional"><vector name="direction" x="{sin}" y="0" z="{}"/>
            <rgb name="irradiance" value="{SUN}, {SUN}, {SUN}"/></emitter>
        {shapes}
        <shape type="rectangle" id="floor"><bsdf type="diffuse"/>
            <sensor type="irradiancemeter" id="meter"><film type="hdrfilm">
                <integer name="width" value="{side}"/><integer name="height" value="{side}"/>
                <rfilter type="box"/></film></sensor>
        </shape></scene>"#,
        -cos
    )
    .unwrap();
    xml
}

/// Flat water in the sun.
pub fn flat_pool(degrees: f64, more: &str, side: usize) -> Scene {
    scene_of(&pool(
        degrees,
        &format!("{FLAT}{WATER}</shape>{more}"),
        side,
    ))
}

/// Waves of `vertices` x `vertices` at height 1, over a floor in the sun.
pub fn sea(waves: &[Wave], vertices: u32, degrees: f64, side: usize) -> Scene {
    with_mesh(
        &height_field(DVec2::splat(2.0), 1.0, waves, vertices),
        degrees,
        side,
    )
}

/// A mesh as water over a floor in the sun.
pub fn with_mesh(mesh: &MeshParts, degrees: f64, side: usize) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = Vec::new();
    write_ply(mesh, "for a test", &mut bytes).unwrap();
    std::fs::write(folder.path().join("water.ply"), bytes).unwrap();
    let water = format!(
        r#"<shape type="ply" id="water"><string name="filename" value="water.ply"/>{WATER}</shape>"#
    );
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, pool(degrees, &water, side)).unwrap();
    mitsuba::load(&file, &[]).unwrap()
}

/// All stages exact.
pub const EXACT: [(&str, &str); 12] = [
    ("surface", "exact"),
    ("flux", "exact"),
    ("fresnel", "exact"),
    ("shadow", "exact"),
    ("shadow-cull", "exact"),
    ("clamp", "exact"),
    ("density", "exact"),
    ("inside", "exact"),
    ("occlusion", "exact"),
    ("cosine", "exact"),
    ("accumulate", "exact"),
    ("lookup", "exact"),
];

/// A light volume with some settings.
pub fn volume(settings: &[(&str, &str)]) -> Method {
    technique("light-volume", settings)
}

/// A light volume with all stages exact but for some settings.
pub fn exact_but(settings: &[(&str, &str)]) -> Method {
    volume(&[&EXACT, settings].concat())
}

/// A sensor of a scene.
pub fn sensor<'a>(scene: &'a Scene, id: &str) -> &'a Sensor {
    scene
        .sensors()
        .iter()
        .find(|sensor| sensor.id == id)
        .unwrap()
}

/// A run on a sensor.
pub fn run_on(method: &Method, scene: &Scene, id: &str) -> Rendering {
    let context = Context::default();
    method
        .run(scene, sensor(scene, id), &Budget::default(), &context)
        .unwrap()
}

/// What each texel of the floor has.
pub fn floor(method: &Method, scene: &Scene) -> Vec<f64> {
    let values = run_on(method, scene, "meter").estimate.total.values;
    values.iter().map(|value| value.mean()).collect()
}

/// A count of a stage.
pub fn count(rendering: &Rendering, stage: &str, counter: &str) -> u64 {
    let found = rendering.stages.iter().find(|one| one.name == stage);
    found.unwrap().work.get(counter)
}

/// Light of a sun at `degrees` in flat water: the cosines above and below, and the share that goes on.
pub fn flat_water(degrees: f64) -> (f64, f64, f64) {
    let (sin, cos) = degrees.to_radians().sin_cos();
    let below = refract(DVec3::new(sin, 0.0, -cos), DVec3::Z, 1.33).unwrap();
    (cos, -below.z, 1.0 - dielectric_reflectance(cos, 1.33))
}
