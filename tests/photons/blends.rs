//! Photons at blends: they go on from mirrors and glass in their shares, and are connected from matt parts.

use nephroid::Method;
use nephroid::internals::reference::photons::{PhotonSettings, run};
use nephroid::internals::run::{Budget, Estimate, Progress};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::chain::ChainSettings;

use crate::support::paths;
use crate::support::scenes::{Photons, layer, over_floor};

const SIDE: usize = 4;

const LAMP: &str = "<emitter type=\"point\"><point name=\"position\" value=\"0.7, 0.1, 2\"/>\
    <rgb name=\"intensity\" value=\"3, 2, 1\"/></emitter>";
const MATT: &str = "<bsdf type=\"diffuse\"/>";
const GOLD: &str = "<bsdf type=\"conductor\"><string name=\"material\" value=\"Au\"/></bsdf>";
const TINTED: &str =
    "<bsdf type=\"conductor\"><rgb name=\"specular_reflectance\" value=\"0.2, 0.5, 0.9\"/></bsdf>";
const GLASS: &str = "<bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1.5\"/>\
    <float name=\"ext_ior\" value=\"1\"/><rgb name=\"specular_transmittance\" value=\"0.9, 0.8, 0.7\"/></bsdf>";

fn blend(weight: f64, first: &str, second: &str) -> String {
    format!(
        "<bsdf type=\"blendbsdf\"><float name=\"weight\" value=\"{weight}\"/>{first}{second}</bsdf>"
    )
}

fn both_sides(bsdf: &str) -> String {
    format!("<bsdf type=\"twosided\">{bsdf}</bsdf>")
}

/// A mirror that stands beside the floor and faces it.
fn plate(bsdf: &str) -> String {
    format!(
        "{LAMP}<shape type=\"rectangle\" id=\"plate\"><transform name=\"to_world\"><rotate y=\"1\" angle=\"80\"/>\
         <translate x=\"-1.1\" z=\"1\"/></transform>{bsdf}</shape>"
    )
}

fn ball(bsdf: &str) -> String {
    format!(
        "{LAMP}<shape type=\"sphere\" id=\"ball\"><float name=\"radius\" value=\"0.4\"/>\
         <point name=\"center\" value=\"0.1, 0, 0.9\"/>{bsdf}</shape>"
    )
}

/// The irradiance of one layer on the floor, texel by texel and channel by channel.
fn light(things: &str, name: &str) -> Vec<f64> {
    let folder = tempfile::tempdir().unwrap();
    let scene = over_floor(folder.path(), things, SIDE);
    let mut photons = Photons::new(1 << 14).replicates(2);
    // Every branch is followed: nothing is chosen by lot.
    photons.settings.chains = ChainSettings {
        split_depth: 16,
        ..ChainSettings::default()
    };
    let found = photons.estimate(&scene);
    (0..3).flat_map(|c| layer(&found, name, c).0).collect()
}

/// Sums are exact; flux is rounded to fixed point, photon by photon, and a few times on its way.
fn assert_light(what: &str, found: &[f64], expected: impl Iterator<Item = f64>) {
    let most = found.iter().copied().fold(0.0, f64::max);
    assert!(most > 0.0, "{what} is dark");
    for (found, expected) in found.iter().zip(expected) {
        assert!(
            (found - expected).abs() <= 1e-9 * most,
            "{what}: {found} {expected}"
        );
    }
}

#[test]
fn mirrors_and_glass_of_a_blend_send_on_their_share_of_the_light() {
    let weight = 0.3;
    let gold = light(&plate(GOLD), "LRD");
    for blend in [
        blend(1.0 - weight, GOLD, MATT),
        blend(weight, MATT, GOLD),
        both_sides(&blend(weight, MATT, GOLD)),
        blend(weight, &both_sides(MATT), &both_sides(GOLD)),
        // Nested: 0.6 of a half.
        blend(0.6, MATT, &blend(0.5, MATT, GOLD)),
        format!(
            "<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.5\"/>{}</bsdf>",
            blend(0.6, MATT, GOLD)
        ),
    ] {
        let found = light(&plate(&blend), "LRD");
        assert_light(&blend, &found, gold.iter().map(|all| weight * all));
    }
    // Two mirrors reflect along one direction, each with its colour.
    let tinted = light(&plate(TINTED), "LRD");
    let found = light(&plate(&blend(weight, GOLD, TINTED)), "LRD");
    let expected = gold.iter().zip(&tinted);
    let expected = expected.map(|(gold, tinted)| (1.0 - weight) * gold + weight * tinted);
    assert_light("two mirrors", &found, expected);
    // Into glass and out of it, its share twice; a mirror about it changes nothing of that.
    let glass = light(&ball(GLASS), "LTTD");
    for other in [MATT, TINTED] {
        let found = light(&ball(&blend(weight, GLASS, other)), "LTTD");
        let share = (1.0 - weight) * (1.0 - weight);
        assert_light(other, &found, glass.iter().map(|all| share * all));
    }
}

/// The whole image of photons on a camera over a floor that a mirror lights.
fn seen(floor: &str) -> Estimate {
    let scene = paths::scene(&format!(
        "{}<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"3\"/><translate z=\"-1\"/>\
         </transform>{floor}</shape>{LAMP}<shape type=\"sphere\"><point name=\"center\" value=\"0, 1, 0\"/>\
         <float name=\"radius\" value=\"0.6\"/>{GOLD}</shape>",
        paths::camera(60.0, &paths::film(4, 4, paths::BOX))
    ));
    let (budget, progress) = (Budget::work(1 << 16), Progress::default());
    let settings = PhotonSettings::default();
    run(&scene, &scene.sensors()[0], settings, &budget, &progress).unwrap()
}

#[test]
fn a_camera_sees_what_the_matt_parts_of_a_blend_reflect() {
    let matt = |color: &str| {
        format!("<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"{color}\"/></bsdf>")
    };
    // 0.75 of the one and a quarter of the other.
    let (one, other) = (matt("0.8, 0.4, 0.2"), matt("0.4, 0.8, 0"));
    let mixed = seen(&matt("0.7, 0.5, 0.15"));
    let all = |image: &Estimate| -> Vec<f64> {
        image
            .total
            .values
            .iter()
            .flat_map(|value| value.0)
            .collect()
    };
    for floor in [
        blend(0.25, &one, &other),
        blend(0.75, &other, &one),
        blend(0.25, &both_sides(&one), &other),
    ] {
        assert_light(&floor, &all(&seen(&floor)), all(&mixed).into_iter());
    }
    // Beside a mirror there is its share. Photons start towards the floor, too: this is another estimate, of which
    // 2¹⁶ photons know some per cent.
    let found = all(&seen(&blend(0.25, &one, TINTED)));
    let three_quarters = all(&seen(&matt("0.6, 0.3, 0.15")));
    let lit: f64 = found.iter().sum();
    let expected: f64 = three_quarters.iter().sum();
    assert!((lit / expected - 1.0).abs() < 0.1, "{lit} {expected}");
}

fn refusal(scene: &Scene, method: &str) -> Option<String> {
    let method = Method::new(method, &Default::default()).unwrap();
    let refusal = method.supports(scene, &scene.sensors()[0]);
    refusal.err().map(|refusal| refusal.to_string())
}

#[test]
fn blends_that_light_cannot_follow_are_refused_or_warned_of_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let checkerboard = "<texture type=\"checkerboard\" name=\"weight\"/>";
    let painted = |first: &str, second: &str| {
        format!("<bsdf type=\"blendbsdf\">{checkerboard}{first}{second}</bsdf>")
    };
    let pane = "<bsdf type=\"thindielectric\"/>";
    let mixed = blend(0.3, MATT, GOLD);
    for (bsdf, method, says) in [
        (mixed.clone(), "photons", None),
        (
            mixed.clone(),
            "beams",
            Some("\"plate\" has a blendbsdf with a mirror"),
        ),
        (
            mixed,
            "caustics-volume",
            Some("\"plate\" has a blendbsdf with a mirror"),
        ),
        (
            painted(MATT, GOLD),
            "photons",
            Some("whose weight or factor is a texture"),
        ),
        (
            painted(MATT, TINTED),
            "beams",
            Some("whose weight or factor is a texture"),
        ),
        // Nothing goes on from these.
        (painted(MATT, MATT), "photons", None),
        (painted(MATT, MATT), "beams", None),
        (
            blend(0.3, GLASS, pane),
            "photons",
            Some("several materials that transmit"),
        ),
        (blend(0.3, GLASS, GOLD), "photons", None),
    ] {
        let scene = over_floor(folder.path(), &plate(&bsdf), SIDE);
        let found = refusal(&scene, method);
        match says {
            None => assert_eq!(found, None, "{bsdf}"),
            Some(words) => {
                let found = found.unwrap_or_else(|| panic!("{method} takes {bsdf}"));
                assert!(found.contains(words), "{found}");
            }
        }
    }
    let rough = "<bsdf type=\"roughconductor\"/>";
    let coat = "<bsdf type=\"plastic\"/>";
    for (bsdf, is_left_out) in [
        (blend(0.3, MATT, rough), true),
        (both_sides(&blend(0.3, MATT, rough)), true),
        (blend(0.3, MATT, &both_sides(rough)), true),
        (blend(0.3, MATT, GOLD), false),
        (rough.to_owned(), false),
        (blend(0.3, MATT, coat), true),
        (blend(0.3, &both_sides(coat), GOLD), true),
        (coat.to_owned(), false),
    ] {
        let scene = over_floor(folder.path(), &plate(&bsdf), SIDE);
        let method = Method::new("photons", &Default::default()).unwrap();
        let none = Default::default();
        let sensor = &scene.sensors()[0];
        let found = method
            .run(&scene, sensor, &Budget::work(1 << 10), &none)
            .unwrap();
        let warnings = found.all_warnings(&scene).join("\n");
        let says = "photons do not go on from the rough parts and coats of a blendbsdf";
        assert_eq!(warnings.contains(says), is_left_out, "{bsdf}: {warnings}");
    }
}
