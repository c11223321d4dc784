//! Mesh files rendered by photons: the flux of the ledger by what it met, and meshes to put in.

use glam::DVec3;
use nephroid::internals::geometry::MeshParts;
use nephroid::internals::mitsuba;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::photons::run::Setup;
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, Progress};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::chain::ChainSettings;
use nephroid::internals::transport::ledger::FluxByFate;
use nephroid::internals::transport::signature::Signature;
use tempfile::TempDir;

/// The index of the glass.
pub const IOR: f64 = 1.5;

/// Flux is rounded to 2⁻⁶⁰ of the light's at every step of a photon: 10⁵ of them sum to 1e-13 at worst (see
/// `tests/photons/ledger.rs`).
pub const ROUNDING: f64 = 1e-12;

/// Loads a glass mesh over a floor of 4 x 4; see [`load_over`].
pub fn load(name: &str, mesh: &[u8], more: &str, sun: DVec3) -> Result<Scene, String> {
    load_over(2.0, name, mesh, more, sun)
}

/// Loads a glass mesh over a floor of half width `half` in the light of a sun that shines along `sun`.
/// `name`: of the mesh file, whose ending is its plugin; `more`: of the shape's element.
pub fn load_over(
    half: f64,
    name: &str,
    mesh: &[u8],
    more: &str,
    sun: DVec3,
) -> Result<Scene, String> {
    let folder = TempDir::new().unwrap();
    std::fs::write(folder.path().join(name), mesh).unwrap();
    let plugin = name.rsplit('.').next().unwrap();
    let xml = format!(
        r#"<scene version="3.0.0">
<emitter type="directional"><vector name="direction" x="{}" y="{}" z="{}"/><rgb name="irradiance" value="1"/></emitter>
<shape type="{plugin}"><string name="filename" value="{name}"/>{more}
<bsdf type="dielectric"><float name="int_ior" value="{IOR}"/><float name="ext_ior" value="1"/></bsdf></shape>
<shape type="rectangle"><transform name="to_world"><scale value="{half}"/></transform>
<sensor type="irradiancemeter"><film type="hdrfilm"><integer name="width" value="16"/><integer name="height" value="16"/><rfilter type="box"/></film></sensor></shape>
</scene>"#,
        sun.x, sun.y, sun.z
    );
    let file = folder.path().join("scene.xml");
    std::fs::write(&file, xml).unwrap();
    mitsuba::load(&file, &[]).map_err(|error| error.to_string())
}

pub const FLAT: &str = r#"<boolean name="face_normals" value="true"/>"#;

/// A photon run whose photons split at each of the first six events, so that the flux of each signature is
/// its share by Fresnel to rounding, however few photons there are.
pub fn photons(scene: &Scene) -> Estimate {
    let settings = PhotonSettings {
        chains: ChainSettings {
            split_depth: 6,
            ..ChainSettings::default()
        },
        ..PhotonSettings::default()
    };
    let budget = Budget {
        work: Some(1 << 14),
        ..Budget::default()
    };
    let progress = Progress::default();
    let setup = Setup::new(scene, &scene.sensors()[0], settings, &progress).unwrap();
    let estimate = setup.run(&budget).unwrap();
    assert!(estimate.ledger.closure_error().unwrap() < ROUNDING);
    estimate
}

pub fn row(estimate: &Estimate, signature: &str) -> FluxByFate {
    let signature: Signature = signature.parse().unwrap();
    estimate
        .ledger
        .rows
        .get(&signature)
        .copied()
        .unwrap_or_default()
}

/// All flux that met glass: what has an event behind it, and what ended there without one.
pub fn met(estimate: &Estimate) -> f64 {
    let direct = row(estimate, "LD");
    let all = estimate.ledger.sum().total() - direct.total() + direct.absorbed;
    let all = all.mean();
    assert!(all > 0.0, "no photon meets the mesh");
    all
}

/// The share of the flux that met glass which ended with these events behind it.
pub fn share(estimate: &Estimate, signature: &str) -> f64 {
    row(estimate, signature).total().mean() / met(estimate)
}

/// The share that ended with events behind it of which the floor saw nothing: the ledger has them together.
pub fn unseen(estimate: &Estimate) -> f64 {
    estimate.ledger.other.total().mean() / met(estimate)
}

/// The share that the floor received with these events behind it.
pub fn received(estimate: &Estimate, signature: &str) -> f64 {
    row(estimate, signature).received.mean() / met(estimate)
}

pub fn assert_share(found: f64, expected: f64, case: &str) {
    assert!(
        (found - expected).abs() < ROUNDING,
        "{case}: {found}, not {expected}"
    );
}

pub fn says(scene: &Scene, what: &str) -> bool {
    scene
        .warnings()
        .iter()
        .any(|warning| warning.message.contains(what))
}

/// The box from `low` to `high`, the floor's side last.
pub fn block(low: DVec3, high: DVec3) -> MeshParts {
    let corner = |i: u32| {
        let pick = |bit: u32, low: f64, high: f64| if i >> bit & 1 == 0 { low } else { high };
        DVec3::new(
            pick(0, low.x, high.x),
            pick(1, low.y, high.y),
            pick(2, low.z, high.z),
        )
    };
    let sides = [
        [0, 4, 6, 2],
        [1, 3, 7, 5],
        [0, 1, 5, 4],
        [2, 6, 7, 3],
        [4, 5, 7, 6],
        [0, 2, 3, 1],
    ];
    MeshParts {
        positions: (0..8).map(corner).collect(),
        triangles: sides
            .iter()
            .flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]])
            .collect(),
        ..MeshParts::default()
    }
}

pub fn cube() -> MeshParts {
    block(DVec3::new(-0.5, -0.5, 1.0), DVec3::new(0.5, 0.5, 2.0))
}

pub fn together(one: &MeshParts, other: &MeshParts) -> MeshParts {
    let first = one.positions.len() as u32;
    let mut both = one.clone();
    both.positions.extend(&other.positions);
    both.triangles.extend(
        other
            .triangles
            .iter()
            .map(|face| face.map(|vertex| vertex + first)),
    );
    both
}

pub fn inside_out(mut parts: MeshParts) -> MeshParts {
    parts.triangles.iter_mut().for_each(|face| face.swap(1, 2));
    parts
}
