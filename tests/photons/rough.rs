//! Caustics of rough glass and rough metal: beside paths from a camera, and beside what facets themselves do.

use glam::DVec3;
use nephroid::internals::mitsuba;
use nephroid::internals::reference::path::PathSettings;
use nephroid::internals::reference::photons::{PhotonSettings, run};
use nephroid::internals::run::{Budget, Estimate, Layer, LayerName, Progress};
use nephroid::internals::scene::{Scene, Sensor, is_achromatic};
use nephroid::internals::transport::chain::ChainSettings;
use nephroid::internals::transport::path_class::{PathClass, PathClasses};
use nephroid::internals::transport::scatter::ShadingNormals;
use nephroid::internals::transport::signature::Signature;

use crate::support::paths;
use crate::support::student;

/// The chance that a right program fails one of the statistical tests here.
const ALPHA: f64 = 1e-4;

const SIDE: u32 = 6;

/// Albedo of the floor.
const ALBEDO: f64 = 0.5;

/// The floor, 2 m wide each way, with a meter, and a camera that looks straight down from just below the
/// ball: each pixel sees one texel of the meter.
pub fn floor() -> String {
    let film = paths::film(SIDE, SIDE, paths::BOX);
    format!(
        "<shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"2\" y=\"2\"/></transform>\
         <bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"{ALBEDO}\"/></bsdf>\
         <sensor type=\"irradiancemeter\">{film}</sensor></shape>\
         <sensor type=\"orthographic\"><float name=\"near_clip\" value=\"0.5\"/>\
         <transform name=\"to_world\"><scale x=\"2\" y=\"2\"/>\
         <lookat origin=\"0, 0, 0.55\" target=\"0, 0, 0\" up=\"0, 1, 0\"/></transform>{film}</sensor>"
    )
}

fn sensor<'a>(scene: &'a Scene, plugin: &str) -> &'a Sensor {
    let mut sensors = scene.sensors().iter();
    sensors.find(|sensor| sensor.plugin() == plugin).unwrap()
}

pub fn by_photons(scene: &Scene, settings: PhotonSettings, photons: u64) -> Estimate {
    let (budget, progress) = (Budget::work(photons), Progress::default());
    let meter = sensor(scene, "irradiancemeter");
    run(scene, meter, settings, &budget, &progress).unwrap()
}

/// Of paths.
const REPLICATES: u32 = 32;

fn by_paths(scene: &Scene, class: PathClass, samples: u64) -> Estimate {
    let (budget, progress) = (Budget::work(samples), Progress::default());
    let settings = PathSettings {
        rr_depth: 100,
        classes: PathClasses::NONE.with(class),
        replicates: REPLICATES,
        ..PathSettings::default()
    };
    let camera = sensor(scene, "orthographic");
    nephroid::internals::reference::path::run(scene, camera, settings, &budget, &progress)
        .unwrap()
        .0
}

pub const LAMP: &str = "<shape type=\"sphere\"><point name=\"center\" x=\"-1\" y=\"1\" z=\"7\"/>\
    <float name=\"radius\" value=\"3\"/>\
    <emitter type=\"area\"><rgb name=\"radiance\" value=\"1\"/></emitter></shape>";

const SKY: &str = "<emitter type=\"constant\"><rgb name=\"radiance\" value=\"1\"/></emitter>";

pub fn ball(bsdf: &str) -> String {
    format!(
        "<shape type=\"sphere\"><point name=\"center\" x=\"0.2\" y=\"-0.1\" z=\"1.6\"/>{bsdf}</shape>"
    )
}

/// A plate that stands beside the floor, and throws a lamp's light down to it.
pub fn plate(bsdf: &str) -> String {
    format!(
        "<shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"2\" y=\"2\"/>\
         <rotate y=\"1\" angle=\"80\"/><translate x=\"-2\" z=\"2.5\"/></transform>{bsdf}</shape>"
    )
}

fn glass(alpha: f64, distribution: &str) -> String {
    format!(
        "<bsdf type=\"roughdielectric\"><float name=\"int_ior\" value=\"1.5\"/>\
         <float name=\"ext_ior\" value=\"1\"/><float name=\"alpha\" value=\"{alpha}\"/>\
         <string name=\"distribution\" value=\"{distribution}\"/></bsdf>"
    )
}

fn metal(alpha: f64, distribution: &str) -> String {
    format!(
        "<bsdf type=\"roughconductor\"><string name=\"material\" value=\"none\"/>\
         <rgb name=\"specular_reflectance\" value=\"0.9, 0.6, 0.3\"/><float name=\"alpha\" value=\"{alpha}\"/>\
         <string name=\"distribution\" value=\"{distribution}\"/></bsdf>"
    )
}

/// Photons and paths of a scene beside each other: the irradiance of each texel. `most` is the largest joint
/// bar of all texels together, relative to their light.
pub fn assert_as_paths(name: &str, elements: &str, most: f64) {
    assert_as_paths_of(PathClass::Caustic, name, elements, most);
}

/// The same, if camera paths count the light in another class.
pub fn assert_as_paths_of(class: PathClass, name: &str, elements: &str, most: f64) {
    let scene = paths::scene(&format!("{elements}{}", floor()));
    // Rough glass keeps some light for long.
    let chains = ChainSettings {
        max_depth: 100,
        ..ChainSettings::default()
    };
    let settings = PhotonSettings {
        chains,
        max_layers: 0,
        ..PhotonSettings::default()
    };
    let traced = by_photons(&scene, settings, 1 << 23);
    let seen = by_paths(&scene, class, 1 << 16);
    // All light but the direct one.
    let named = |name: LayerName, of: &Estimate| {
        let found = of.layers.iter().find(|layer| layer.name == name);
        found.unwrap().clone()
    };
    let traced = named(LayerName::Other, &traced);
    let seen = named(LayerName::Class(class), &seen);
    let (side, texels) = (SIDE as usize, (SIDE * SIDE) as usize);
    let channels = if is_achromatic(&scene) { 1 } else { 3 };
    let count = (channels * texels) as f64;
    let freedom = settings.replicates.min(REPLICATES) - 1;
    let limit = student::two_sided_quantile(ALPHA / count, freedom);
    let (mut off, mut variance, mut light, mut squares) = (0.0, 0.0, 0.0, 0.0);
    for texel in 0..texels {
        // The camera's rows run down, the meter's up.
        let pixel = (side - 1 - texel / side) * side + texel % side;
        for c in 0..channels {
            let to_flux = std::f64::consts::PI / ALBEDO;
            let [value, error] = [&traced.values, &traced.standard_error].map(|it| it[texel].0[c]);
            let [truth, bar] =
                [&seen.values, &seen.standard_error].map(|it| it[pixel].0[c] * to_flux);
            let joint = error.hypot(bar);
            assert!(
                (value - truth).abs() <= limit * joint,
                "{name}: texel {texel}, channel {c}: {value} ± {error} by photons, {truth} ± {bar} by paths"
            );
            off += value - truth;
            variance += joint * joint;
            light += truth;
            squares += ((value - truth) / joint).powi(2);
        }
    }
    // Channels are lit by the same photons.
    let deviation = (variance * channels as f64).sqrt();
    println!(
        "{name}: {light:.3} all {:+.4} ± {:.4} %, mean z² {:.3}, joint bars {:.2} %",
        100.0 * off / light,
        100.0 * deviation / light,
        squares / count,
        100.0 * (variance * count).sqrt() / light
    );
    let joint = (variance * count).sqrt() / light;
    assert!(joint < most, "{name}: joint bars of {joint} tell nothing");
    assert!(
        off.abs() <= 4.0 * deviation,
        "{name}: {off} ± {deviation} in all"
    );
}

#[test]
fn rough_glass_sends_a_lamps_light_where_paths_find_it() {
    for (alpha, distribution) in [(0.02, "ggx"), (0.1, "beckmann"), (0.4, "ggx")] {
        let elements = ball(&glass(alpha, distribution)) + LAMP;
        let name = format!("glass {alpha} {distribution}");
        assert_as_paths(&name, &elements, 0.03);
    }
}

#[test]
fn rough_metal_sends_a_lamps_light_where_paths_find_it() {
    for (alpha, distribution) in [(0.02, "beckmann"), (0.1, "ggx"), (0.4, "beckmann")] {
        let elements = plate(&metal(alpha, distribution)) + LAMP;
        let name = format!("metal {alpha} {distribution}");
        assert_as_paths(&name, &elements, 0.04);
    }
}

#[test]
fn a_sky_shines_through_rough_glass_as_on_paths() {
    for (name, bsdf) in [("glass", glass(0.1, "ggx")), ("metal", metal(0.2, "ggx"))] {
        let elements = ball(&bsdf) + SKY;
        assert_as_paths(name, &elements, 0.03);
    }
}

/// A plate of rough glass or rough metal in parallel light, with nothing else in its way.
fn lit_plate(bsdf: &str, towards: [f64; 3]) -> Scene {
    let [x, y, z] = towards;
    paths::scene(&format!(
        "<emitter type=\"directional\"><vector name=\"direction\" x=\"{x}\" y=\"{y}\" z=\"{z}\"/>\
         <rgb name=\"irradiance\" value=\"1\"/></emitter>\
         <shape type=\"rectangle\"><transform name=\"to_world\"><translate x=\"40\" z=\"9\"/></transform>{bsdf}</shape>{}",
        floor()
    ))
}

/// Smith's G1 of Walter et al. 2007, Beckmann's by their fit (equations 27 and 34).
fn shadowing(distribution: &str, alpha: f64, v: DVec3) -> f64 {
    let tan = (1.0 - v.z * v.z).max(0.0).sqrt() / v.z.abs();
    if distribution == "ggx" {
        return 2.0 / (1.0 + (1.0 + (alpha * tan).powi(2)).sqrt());
    }
    let a = 1.0 / (alpha * tan);
    if a < 1.6 {
        (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a)
    } else {
        1.0
    }
}

/// Fresnel's reflectance, for cosine and `eta` = n_transmitted / n_incident.
pub fn fresnel(cos: f64, eta: f64) -> f64 {
    let sin_squared = (1.0 - cos * cos) / (eta * eta);
    if sin_squared >= 1.0 {
        return 1.0;
    }
    let inside = (1.0 - sin_squared).sqrt();
    let s = (cos - eta * inside) / (cos + eta * inside);
    let p = (eta * cos - inside) / (eta * cos + inside);
    0.5 * (s * s + p * p)
}

/// The share of light from `wi` that facets of unit reflectance, or of glass, send on, by a sum over the slopes
/// of facets. A facet gets D |wi·m| / |wi_z| G1(wi) of it, and G1(wo) of what it sends on gets away.
fn sent_on(distribution: &str, alpha: f64, wi: DVec3, eta: Option<f64>) -> f64 {
    const STEPS: usize = 1200;
    let node = |i: usize| {
        let t = std::f64::consts::PI * ((i as f64 + 0.5) / STEPS as f64 - 0.5);
        (t.tan(), 1.0 / t.cos().powi(2))
    };
    let nodes: Vec<(f64, f64)> = (0..STEPS).map(node).collect();
    let step = std::f64::consts::PI / STEPS as f64;
    let mut sum = 0.0;
    for &(x, of_x) in &nodes {
        for &(y, of_y) in &nodes {
            // Slopes in units of alpha; their density is 1/π exp(-r²), or 1/π (1 + r²)^-2.
            let squared = x * x + y * y;
            let density = std::f64::consts::FRAC_1_PI
                * if distribution == "ggx" {
                    (1.0 + squared).powi(-2)
                } else {
                    (-squared).exp()
                };
            let slope = DVec3::new(-alpha * x, -alpha * y, 1.0);
            let m = slope.normalize();
            let cos = wi.dot(m);
            if cos <= 0.0 || density == 0.0 {
                continue;
            }
            // D m_z dω is the slopes' density: D |wi·m| dω = density |wi·m| / m_z.
            let got =
                density * of_x * of_y * cos / (m.z * wi.z) * shadowing(distribution, alpha, wi);
            let mirrored = m * (2.0 * cos) - wi;
            let mut away = 0.0;
            let reflectance = eta.map_or(1.0, |eta| fresnel(cos, eta));
            if mirrored.z > 0.0 {
                away += reflectance * shadowing(distribution, alpha, mirrored);
            }
            if let Some(eta) = eta.filter(|_| reflectance < 1.0) {
                let inside = (1.0 - (1.0 - cos * cos) / (eta * eta)).sqrt();
                let bent = (m * cos - wi) / eta - m * inside;
                if bent.z < 0.0 {
                    away += (1.0 - reflectance) * shadowing(distribution, alpha, bent);
                }
            }
            sum += got * away * step * step;
        }
    }
    sum
}

#[test]
fn facets_lose_what_the_model_loses_and_nothing_else() {
    let perfect = |alpha: f64, distribution: &str| {
        metal(alpha, distribution).replace("0.9, 0.6, 0.3", "1, 1, 1")
    };
    for distribution in ["ggx", "beckmann"] {
        for alpha in [0.02, 0.5] {
            for (tilt, side) in [
                (0.0, 1.0),
                (0.8, 1.0),
                (1.3, 1.0),
                (0.4, -1.0),
                (0.75, -1.0),
            ] {
                let (sin, cos) = f64::sin_cos(tilt);
                // Light comes from wi, above the plate, or from inside of the glass below it.
                let wi = DVec3::new(sin * 0.8, sin * 0.6, cos);
                for is_glass in [true, false] {
                    if !is_glass && side < 0.0 {
                        continue;
                    }
                    let bsdf = if is_glass {
                        glass(alpha, distribution)
                    } else {
                        perfect(alpha, distribution)
                    };
                    let scene = lit_plate(&bsdf, (-wi * DVec3::new(1.0, 1.0, side)).to_array());
                    let eta = if side > 0.0 { 1.5 } else { 1.0 / 1.5 };
                    let truth = sent_on(distribution, alpha, wi, is_glass.then_some(eta));
                    let photons = 1 << 20;
                    let estimate = by_photons(&scene, PhotonSettings::default(), photons);
                    let ledger = &estimate.ledger;
                    let case = format!("{distribution} {alpha} {tilt} {side} {is_glass}");
                    assert!(ledger.closure_error().unwrap() < 1e-12, "{case}");
                    assert!(ledger.shading_gain.is_black(), "{case}");
                    let lost = ledger.rows[&Signature::DIRECT].absorbed.0[0];
                    let sent =
                        ledger.sum().total().0[0] - ledger.rows[&Signature::DIRECT].total().0[0];
                    let share = sent / (sent + lost);
                    // Weights are in 0..=1: their variance is at most that of zeros and ones. Beckmann's fit
                    // lets them exceed 1 by 0.35 %. Photons that pass the plate by do not count.
                    let met = photons as f64 * (sent + lost) / ledger.emitted.0[0];
                    let deviation = ((1.0 - truth).max(1e-4) / met).sqrt();
                    println!("{case}: {share} {truth} ± {deviation}");
                    assert!(
                        (share - truth).abs() <= 4.0 * deviation,
                        "{case}: {share}, {truth}"
                    );
                }
            }
        }
    }
}

#[test]
fn all_light_of_a_rough_ball_lands_escapes_or_is_lost_between_facets() {
    let mut before = 0.0;
    for alpha in [0.02, 0.1, 0.4] {
        let lamp =
            "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"6\"/></emitter>";
        let scene = paths::scene(&(ball(&glass(alpha, "ggx")) + lamp + &floor()));
        let estimate = by_photons(&scene, PhotonSettings::default(), 1 << 18);
        let ledger = &estimate.ledger;
        assert!(ledger.closure_error().unwrap() < 1e-12);
        let sum = ledger.sum();
        let lost = sum.absorbed.0[0] / ledger.emitted.0[0];
        // Facets of a rougher surface hide each other more. The rest leaves the ball, but for what goes round in
        // it until the end.
        assert!(before < lost && lost < 0.8 * alpha, "{alpha}: {lost}");
        assert!(sum.cut_off.0[0] < 0.02 * ledger.emitted.0[0], "{alpha}");
        before = lost;
    }
}

/// The layer of a signature.
fn layer<'a>(estimate: &'a Estimate, name: &str) -> &'a Layer {
    let wanted = LayerName::Path(name.parse().unwrap());
    let found = estimate.layers.iter().find(|layer| layer.name == wanted);
    found.unwrap_or_else(|| panic!("no {name}"))
}

fn light(layer: &Layer) -> f64 {
    layer.values.iter().map(|value| value.0[0]).sum()
}

const POINT: &str =
    "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"1\" z=\"6\"/></emitter>";

#[test]
fn a_rough_balls_caustic_tends_to_that_of_a_smooth_one_without_a_threshold() {
    let smooth = glass(0.0, "ggx").replace("roughdielectric", "dielectric");
    let smooth = smooth.replace(
        "<float name=\"alpha\" value=\"0\"/><string name=\"distribution\" value=\"ggx\"/>",
        "",
    );
    let caustic = |bsdf: &str, seed: u64| {
        let scene = paths::scene(&(ball(bsdf) + POINT + &floor()));
        let settings = PhotonSettings {
            seed,
            ..PhotonSettings::default()
        };
        by_photons(&scene, settings, 1 << 20)
    };
    let smooth = caustic(&smooth, 1);
    let smooth = layer(&smooth, "LTTD");
    let mut before = f64::INFINITY;
    for alpha in [0.3, 0.1, 0.03, 0.01, 0.003, 0.001, 1e-4, 0.0] {
        let rough = caustic(&glass(alpha, "ggx"), 2);
        let rough = layer(&rough, "LGGD");
        let apart: f64 = rough
            .values
            .iter()
            .zip(&smooth.values)
            .map(|(a, b)| (a.0[0] - b.0[0]).abs())
            .sum();
        let apart = apart / light(smooth);
        let kept = light(rough) / light(smooth);
        println!("{alpha}: {apart:.5} apart, {kept:.5} of the light");
        // Photons alone are a thousandth apart.
        assert!(apart < before + 2e-3, "{alpha}: {apart} after {before}");
        if alpha <= 0.01 {
            assert!((kept - 1.0).abs() < 0.01, "{alpha}: {kept}");
        }
        before = apart;
    }
    assert!(before < 4e-3, "{before}");
}

#[test]
fn signatures_name_rough_events_in_their_order() {
    let pane = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"3\" y=\"3\"/><translate z=\"3\"/>\
        </transform><bsdf type=\"thindielectric\"/></shape>";
    let scene = paths::scene(&(ball(&glass(0.05, "ggx")) + POINT + pane + &floor()));
    let estimate = by_photons(&scene, PhotonSettings::default(), 1 << 18);
    for name in ["LTD", "LTGD", "LTGGD"] {
        assert!(light(layer(&estimate, name)) > 0.0, "{name}");
    }
    assert!(light(layer(&estimate, "LTGGD")) > 10.0 * light(layer(&estimate, "LTGD")));
}

#[test]
fn a_rough_mask_and_a_rough_back_take_their_share() {
    // Half of the light passes the mask straight on, and half meets the mirror on either side.
    let both = |inner: &str| {
        format!(
            "<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.25\"/><bsdf type=\"twosided\">{inner}</bsdf></bsdf>"
        )
    };
    let bsdf = both(&metal(0.1, "ggx").replace("0.9, 0.6, 0.3", "1, 1, 1"));
    for side in [1.0, -1.0] {
        let scene = lit_plate(&bsdf, [0.0, 0.1, -side]);
        let photons = 1 << 18;
        let ledger = by_photons(&scene, PhotonSettings::default(), photons).ledger;
        assert!(ledger.closure_error().unwrap() < 1e-12);
        let mirrored = ledger.sum().total().0[0] - ledger.rows[&Signature::DIRECT].total().0[0];
        let met = mirrored + ledger.rows[&Signature::DIRECT].absorbed.0[0];
        // The plate's 4 m² as the light sees them.
        let arriving = 4.0 / 1.01f64.sqrt();
        let deviation = (0.25 * 0.75 / photons as f64 * 2.0).sqrt();
        assert!(
            (met / arriving - 0.25).abs() < 5.0 * deviation,
            "{side}: {}",
            met / arriving
        );
        assert!(mirrored > 0.95 * met);
    }
}

/// A square of perfect rough metal whose normals all lean by `lean`, in light straight from above.
fn leaning(lean: f64) -> Scene {
    let folder = tempfile::tempdir().unwrap();
    let (sin, cos) = lean.sin_cos();
    let corners = [[-1, -1], [1, -1], [1, 1], [-1, 1]];
    let rows = corners.map(|[x, y]| format!("{x} {y} 0 {sin} 0 {cos}\n"));
    let head = "ply\nformat ascii 1.0\nelement vertex 4\nproperty float x\nproperty float y\nproperty float z\n\
        property float nx\nproperty float ny\nproperty float nz\nelement face 2\n\
        property list uchar int vertex_indices\nend_header\n";
    let mesh = format!("{head}{}3 0 1 2\n3 0 2 3\n", rows.concat());
    std::fs::write(folder.path().join("leaning.ply"), mesh).unwrap();
    let bsdf = metal(0.02, "beckmann").replace("0.9, 0.6, 0.3", "1, 1, 1");
    let xml = format!(
        "<scene version=\"3.0.0\"><emitter type=\"directional\"><vector name=\"direction\" x=\"0\" y=\"0\" z=\"-1\"/>\
         </emitter><shape type=\"ply\"><string name=\"filename\" value=\"leaning.ply\"/>\
         <transform name=\"to_world\"><translate x=\"40\" z=\"9\"/></transform>{bsdf}</shape>{}</scene>",
        floor()
    );
    let path = folder.path().join("scene.xml");
    std::fs::write(&path, xml).unwrap();
    mitsuba::load(&path, &[]).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn interpolated_normals_change_no_flux_unless_asked_to() {
    const LEAN: f64 = 0.3;
    let scene = leaning(LEAN);
    let photons = 1 << 20;
    let share = |shading_normals: ShadingNormals| {
        let chains = ChainSettings {
            shading_normals,
            ..ChainSettings::default()
        };
        let settings = PhotonSettings {
            chains,
            ..PhotonSettings::default()
        };
        let ledger = by_photons(&scene, settings, photons).ledger;
        assert!(ledger.closure_error().unwrap() < 1e-12);
        let direct = &ledger.rows[&Signature::DIRECT];
        let sent = ledger.sum().total().0[0] - direct.total().0[0];
        // Light that passes by leaves the scene: nothing else is there.
        let met = ledger.emitted.0[0] - direct.escaped.0[0];
        (sent / met, ledger.shading_gain.0[0] / met)
    };
    let (sent, gain) = share(ShadingNormals::Flux);
    assert_eq!(gain, 0.0);
    // Beckmann's slopes of α = 0.02 have no tails: nothing is hidden, and nothing is sent below the surface.
    assert!((sent - 1.0).abs() < 1e-9, "{sent}");
    // Veach's factor: light comes along the true normal, and leaves at twice the lean off it. The slopes of
    // α = 0.02 change its mean by some thousandths.
    let (sent, gain) = share(ShadingNormals::Adjoint);
    let factor = (2.0 * LEAN).cos();
    assert!((sent - factor).abs() < 5e-3, "{sent} of {factor}");
    assert!((sent - 1.0 - gain).abs() < 1e-9, "{sent} of {gain}");
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    let scene = paths::scene(&(ball(&glass(0.1, "beckmann")) + LAMP + &floor()));
    paths::assert_same_on_threads(&[3, 8], || {
        by_photons(&scene, PhotonSettings::default(), 1 << 16)
    });
}
