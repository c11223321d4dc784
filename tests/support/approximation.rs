//! Shared parts of the tests of approximations: scenes of one object over a floor, their truth by beams, and
//! errors.

use std::fmt::Write as _;
use std::fs;

use glam::DVec3;
use nephroid::internals::generate::{bumpy_ball, write_ply};
use nephroid::internals::geometry::MeshParts;
use nephroid::internals::method::Method;
use nephroid::internals::mitsuba;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::beams::{BeamSettings, run};
use nephroid::internals::run::{Budget, Progress};
use nephroid::internals::scene::Scene;
use nephroid::internals::study::attribution::Truth;
use nephroid::internals::transport::signature::Signature;

use super::scenes::{bundled_file, meter};
use super::technique::technique;

#[allow(unused_imports, reason = "every test file uses its own part of this")]
pub use super::shared_meshes::shared_mesh;
#[allow(unused_imports, reason = "every program uses its own part of this")]
pub use super::technique::rendered;

/// A bundled scene whose sensors have `side` texels a row.
pub fn bundled(name: &str, side: usize) -> Scene {
    let size = ("size".into(), side.to_string());
    mitsuba::load(&bundled_file(name), &[size]).unwrap()
}

/// A scene file's text as a scene.
pub fn scene_of(xml: &str) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("scene.xml");
    fs::write(&file, xml).unwrap();
    mitsuba::load(&file, &[]).unwrap()
}

/// A point lamp of 100 W/sr at (0, 0, 4), glass `objects`, and a floor of 4 x 4 with `side` x `side` texels.
pub fn over_floor(objects: &str, side: usize) -> String {
    lit_by(
        r#"<emitter type="point"><point name="position" x="0" y="0" z="4"/>
           <rgb name="intensity" value="100, 100, 100"/></emitter>"#,
        objects,
        side,
    )
}

/// Objects over a floor of 4 x 4 with `side` x `side` texels, and emitters.
pub fn lit_by(emitters: &str, objects: &str, side: usize) -> String {
    format!(
        r#"<scene version="3.0.0">
        {emitters}
        {objects}
        <shape type="rectangle">
            <transform name="to_world"><scale x="2" y="2"/></transform>
            <bsdf type="diffuse"/>
            <sensor type="irradiancemeter">
                <film type="hdrfilm">
                    <integer name="width" value="{side}"/><integer name="height" value="{side}"/>
                    <rfilter type="box"/>
                </film>
            </sensor>
        </shape></scene>"#
    )
}

/// Glass.
pub const GLASS: &str = r#"<bsdf type="dielectric"><float name="int_ior" value="1.5"/><float name="ext_ior" value="1"/></bsdf>"#;

/// A ball of glass of radius 1 at height 1.4.
pub fn ball(bsdf: &str) -> String {
    format!(
        r#"<shape type="sphere"><point name="center" x="0" y="0" z="1.4"/><float name="radius" value="1"/>{bsdf}</shape>"#
    )
}

/// A glass mesh over the floor, moved and scaled into the place of the ball; its y axis upward.
pub fn mesh_over_floor(mut mesh: MeshParts, side: usize) -> Scene {
    let fold = |f: fn(DVec3, DVec3) -> DVec3| mesh.positions.iter().copied().reduce(f).unwrap();
    let (low, high) = (fold(DVec3::min), fold(DVec3::max));
    let scale = 2.0 / (high - low).max_element();
    let upright = |p: DVec3| DVec3::new(p.x, -p.z, p.y);
    for position in &mut mesh.positions {
        *position = upright((*position - 0.5 * (low + high)) * scale) + DVec3::Z * 1.4;
    }
    for normal in mesh.normals.iter_mut().flatten() {
        *normal = upright(*normal);
    }
    let folder = tempfile::tempdir().unwrap();
    let mut bytes = Vec::new();
    write_ply(&mesh, "for a test", &mut bytes).unwrap();
    fs::write(folder.path().join("mesh.ply"), bytes).unwrap();
    let shape =
        format!(r#"<shape type="ply"><string name="filename" value="mesh.ply"/>{GLASS}</shape>"#);
    let file = folder.path().join("scene.xml");
    fs::write(&file, over_floor(&shape, side)).unwrap();
    mitsuba::load(&file, &[]).unwrap()
}

/// The stand-in for scanned meshes: 82,000 triangles of a ball with smooth bumps.
pub fn bumpy_ball_over_floor(side: usize) -> Scene {
    mesh_over_floor(bumpy_ball(1.0, 64), side)
}

/// A caustic map with some settings.
pub fn caustic_map(settings: &[(&str, &str)]) -> Method {
    technique("caustic-map", settings)
}

/// All stages exact.
pub const EXACT: [(&str, &str); 7] = [
    ("view", "exact"),
    ("refraction", "exact"),
    ("hit", "exact"),
    ("flux", "exact"),
    ("fresnel", "exact"),
    ("splat", "exact"),
    ("lookup", "exact"),
];

/// A caustic map with all stages exact but for some settings.
pub fn exact_but(settings: &[(&str, &str)]) -> Method {
    caustic_map(&[&EXACT, settings].concat())
}

/// The map of the report's claims on splats: all else exact, 512² texels, averaged over texels of the meter.
pub fn with_splat(splat: &str, kernel: &str, photons: &str) -> Method {
    exact_but(&[
        ("photons", photons),
        ("map", "512"),
        ("splat", splat),
        ("kernel", kernel),
        ("lookup", "bilinear"),
    ])
}

/// Splats whose frames are timed.
pub const TIMED_SPLATS: [&str; 6] = [
    "fixed",
    "multi-resolution",
    "thin-lens",
    "thick-lens",
    "two-curvatures",
    "mip",
];

/// The map of a timed frame: exact refraction and hits, read once a texel.
pub fn timed_map(splat: &str) -> Method {
    caustic_map(&[
        ("refraction", "exact"),
        ("hit", "exact"),
        ("splat", splat),
        ("samples", "1"),
    ])
}

/// The truth by beams of a scene's meter, of one signature.
pub fn truth(scene: &Scene, signature: &str, error: f64) -> Truth {
    let signature: Signature = signature.parse().unwrap();
    let settings = BeamSettings {
        max_depth: signature.len() as u32,
        max_layers: 16,
        ..BeamSettings::default()
    };
    let budget = Budget {
        relative_error: Some(error),
        ..Budget::default()
    };
    let (estimate, _) = run(scene, meter(scene), settings, &budget, &Progress::default()).unwrap();
    let name = signature.to_string();
    let layer = estimate
        .layers
        .iter()
        .find(|layer| layer.name.to_string() == name);
    Truth {
        modelled: layer.expect("the light that is asked for").values.clone(),
        not_modelled: f64::NAN,
        relative_error: estimate.relative_error,
        is_resolved: !estimate.incomplete,
    }
}

/// The root mean square difference over all texels, relative to the truth's mean over those that it lights.
pub fn relative_rmse(values: &[Rgb], truth: &[Rgb]) -> Option<f64> {
    let (mut squares, mut sum, mut lit) = (0.0, 0.0, 0_u64);
    for (value, truth) in values.iter().zip(truth) {
        squares += (value.mean() - truth.mean()).powi(2);
        sum += truth.mean();
        lit += u64::from(truth.mean() > 0.0);
    }
    let lit = lit as f64;
    (sum > 0.0).then(|| (squares / lit).sqrt() / (sum / lit))
}

/// Relative RMSE of a caustic map.
pub fn error(map: &Method, scene: &Scene, truth: &Truth) -> f64 {
    relative_rmse(&rendered(map, scene).estimate.total.values, &truth.modelled).unwrap()
}

/// A table row.
pub fn row(name: &str, values: &[f64]) -> String {
    let mut line = format!("| {name} |");
    for value in values {
        write!(line, " {value:.3} |").unwrap();
    }
    line
}
