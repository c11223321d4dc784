//! Coats over a matt base, smooth and rough: photons go on from what they reflect.

use nephroid::internals::generate::scene_names;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::run::Estimate;
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::chain::ChainSettings;
use nephroid::internals::transport::domain::LightSpace;
use nephroid::internals::transport::followed::Followed;
use nephroid::internals::transport::path_class::PathClass;
use nephroid::internals::transport::scatter::ShadingNormals;
use nephroid::internals::transport::signature::Signature;

use crate::rough::{LAMP, ball, by_photons, floor, fresnel, plate};
use crate::support::bundled;
use crate::support::paths;

const IOR: &str = "<float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1\"/>";

/// Light along the x-z plane, down to the plate and from there to the floor.
const SUN: &str = "<emitter type=\"directional\"><vector name=\"direction\" x=\"-0.6\" y=\"0\" z=\"-0.8\"/>\
    <rgb name=\"irradiance\" value=\"1, 2, 3\"/></emitter>";

fn plastic(more: &str) -> String {
    format!("<bsdf type=\"plastic\">{IOR}{more}</bsdf>")
}

fn rough_plastic(alpha: f64, distribution: &str, more: &str) -> String {
    format!(
        "<bsdf type=\"roughplastic\">{IOR}<float name=\"alpha\" value=\"{alpha}\"/>\
         <string name=\"distribution\" value=\"{distribution}\"/>{more}</bsdf>"
    )
}

/// The albedo of the base.
fn base(albedo: f64) -> String {
    format!("<rgb name=\"diffuse_reflectance\" value=\"{albedo}\"/>")
}

fn both_sides(bsdf: &str) -> String {
    format!("<bsdf type=\"twosided\">{bsdf}</bsdf>")
}

/// The plate, with its back to the light and to the floor.
fn turned(bsdf: &str) -> String {
    plate(bsdf).replace("angle=\"80\"", "angle=\"-100\"")
}

fn lit(elements: &str) -> Scene {
    paths::scene(&format!("{elements}{}", floor()))
}

fn traced(elements: &str, settings: PhotonSettings) -> Estimate {
    let estimate = by_photons(&lit(elements), settings, 1 << 16);
    assert!(estimate.ledger.closure_error().unwrap() < 1e-12);
    estimate
}

/// The irradiance that one mirror throws on the floor, texel by texel and channel by channel.
fn mirrored(elements: &str) -> Vec<f64> {
    let estimate = traced(elements, PhotonSettings::default());
    let found = estimate
        .layers
        .iter()
        .find(|layer| layer.name.to_string() == "LRD");
    found.map_or(Vec::new(), |layer| {
        layer.values.iter().flat_map(|value| value.0).collect()
    })
}

#[test]
fn a_smooth_coat_mirrors_fresnels_share_of_light() {
    let mirror = mirrored(
        &(SUN.to_owned()
            + &plate("<bsdf type=\"conductor\"><string name=\"material\" value=\"none\"/></bsdf>")),
    );
    // The plate's normal is +z, turned by 80° about y.
    let (sin, cos) = 80f64.to_radians().sin_cos();
    let of_index = |eta: f64| fresnel(0.6 * sin + 0.8 * cos, eta);
    let share = of_index(1.5);
    let thin = plastic("").replace("\"1.5\"", "\"0.8\"");
    let factor = "<rgb name=\"specular_reflectance\" value=\"0.5, 1, 0.25\"/>";
    let texture = "<texture name=\"specular_reflectance\" type=\"checkerboard\"><rgb name=\"color0\" \
        value=\"0.5, 1, 0.25\"/><rgb name=\"color1\" value=\"0.5, 1, 0.25\"/></texture>";
    let half = format!(
        "<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.5\"/>{}</bsdf>",
        plastic("")
    );
    for (name, plate, factor) in [
        ("plain", plate(&plastic("")), [1.0; 3]),
        ("the base's albedo", plate(&plastic(&base(0.9))), [1.0; 3]),
        ("a factor", plate(&plastic(factor)), [0.5, 1.0, 0.25]),
        (
            "a texture of one colour",
            plate(&plastic(texture)),
            [0.5, 1.0, 0.25],
        ),
        ("a mask", plate(&half), [0.5; 3]),
        ("both sides", plate(&both_sides(&plastic(""))), [1.0; 3]),
        ("the back", turned(&both_sides(&plastic(""))), [1.0; 3]),
        ("a thin coat", plate(&thin), [of_index(0.8) / share; 3]),
    ] {
        let found = mirrored(&(SUN.to_owned() + &plate));
        // Sums are exact; flux is rounded to fixed point, photon by photon, and a few times on its way.
        let most = mirror.iter().copied().fold(0.0, f64::max);
        assert!(most > 0.0);
        for (texel, (found, whole)) in found.iter().zip(&mirror).enumerate() {
            let expected = share * factor[texel % 3] * whole;
            assert!(
                (found - expected).abs() <= 1e-9 * most,
                "{name}: {found} of {expected}"
            );
        }
        assert_eq!(found.len(), mirror.len(), "{name}");
    }
    assert!(mirrored(&(SUN.to_owned() + &turned(&plastic("")))).is_empty());
}

#[test]
fn a_smooth_coat_sends_a_lamps_light_where_paths_find_it() {
    // A ball throws little light on the floor, and few paths find it.
    for (name, shape, most) in [
        ("plate", plate(&plastic("")), 0.05),
        ("ball", ball(&plastic("")), 0.12),
    ] {
        crate::rough::assert_as_paths(name, &(shape + LAMP), most);
    }
}

#[test]
fn a_rough_coat_sends_a_lamps_light_where_paths_find_it() {
    // To paths both a coat and its base are matt: here the base is black, and what is left is the coat's.
    for (alpha, distribution) in [(0.05, "beckmann"), (0.3, "ggx")] {
        let bsdf = rough_plastic(alpha, distribution, &base(0.0));
        let name = format!("rough coat {alpha} {distribution}");
        let elements = plate(&bsdf) + LAMP;
        crate::rough::assert_as_paths_of(PathClass::Indirect, &name, &elements, 0.05);
    }
}

#[test]
fn a_base_changes_nothing_of_what_its_rough_coat_sends_on() {
    let of = |more: &str| {
        let bsdf = rough_plastic(0.2, "ggx", more);
        paths::bits(&traced(&(plate(&bsdf) + SUN), PhotonSettings::default()))
    };
    let black = of(&base(0.0));
    for more in [
        base(0.9),
        base(0.5) + "<boolean name=\"nonlinear\" value=\"true\"/>",
    ] {
        assert!(of(&more) == black, "{more}");
    }
}

#[test]
fn a_rough_coats_light_tends_to_that_of_a_smooth_one_without_a_threshold() {
    let light = |bsdf: &str, name: &str| {
        let estimate = by_photons(
            &lit(&(plate(bsdf) + SUN)),
            PhotonSettings::default(),
            1 << 18,
        );
        let mut layers = estimate.layers.iter();
        let layer = layers.find(|layer| layer.name.to_string() == name);
        let values = &layer.unwrap().values;
        values.iter().map(|value| value.0[0]).collect::<Vec<f64>>()
    };
    let smooth = light(&plastic(""), "LRD");
    let all: f64 = smooth.iter().sum();
    let mut before = f64::INFINITY;
    for alpha in [0.3, 0.1, 0.03, 0.01, 0.001, 1e-4] {
        let rough = light(&rough_plastic(alpha, "ggx", ""), "LGD");
        let apart = rough.iter().zip(&smooth).map(|(a, b)| (a - b).abs());
        let apart = apart.sum::<f64>() / all;
        println!("{alpha}: {apart:.5} apart");
        assert!(apart < before, "{alpha}: {apart} after {before}");
        before = apart;
    }
    // Photons start at the same places. Facets of α = 1e-4 turn light by some 2e-4, over 3 m: at the border of its
    // patch 6e-4 m of texels of 0.67 m, a thousandth. Tails of GGX double that.
    assert!(before < 2e-3, "{before}");
}

#[test]
fn past_the_depth_of_splitting_a_coat_sends_on_as_much_by_lot() {
    for (name, bsdf) in [
        ("smooth", plastic("")),
        ("rough", rough_plastic(0.2, "ggx", "")),
    ] {
        let elements = plate(&bsdf) + SUN;
        let sent = |split_depth: u32| {
            let settings = PhotonSettings {
                chains: ChainSettings {
                    split_depth,
                    ..ChainSettings::default()
                },
                ..PhotonSettings::default()
            };
            let estimate = traced(&elements, settings);
            let direct = estimate.ledger.rows[&Signature::DIRECT].total().0[0];
            let all = estimate.ledger.sum().total().0[0];
            (all - direct) / all
        };
        let (split, drawn) = (sent(2), sent(0));
        // By lot the share's variance is at most that of a coin.
        let deviation = (split * (1.0 - split) / f64::from(1 << 16)).sqrt();
        println!("{name}: {drawn} of {split} ± {deviation}");
        assert!(
            split > 0.01 && (drawn - split).abs() <= 4.0 * deviation,
            "{name}: {drawn} of {split} ± {deviation}"
        );
    }
}

#[test]
fn what_a_coated_receiver_does_not_mirror_is_received() {
    // Behind a pane, so that all light has an event: what the coat of the floor mirrors goes up and escapes.
    let pane = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"3\" y=\"3\"/>\
        <translate z=\"3\"/></transform><bsdf type=\"thindielectric\"/></shape>";
    let sun = "<emitter type=\"directional\"><vector name=\"direction\" x=\"0\" y=\"0.6\" z=\"-0.8\"/></emitter>";
    let of = |bsdf: &str, chains: ChainSettings| {
        let floor = floor().replace(
            "<bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.5\"/></bsdf>",
            bsdf,
        );
        let scene = paths::scene(&format!("{pane}{sun}{floor}"));
        let settings = PhotonSettings {
            chains,
            ..PhotonSettings::default()
        };
        by_photons(&scene, settings, 1 << 14)
    };
    let mirrored = fresnel(0.8, 1.5);
    let smooth = plastic("");
    let rough = rough_plastic(0.05, "ggx", "");
    for (bsdf, shading_normals, max_depth, split_depth, share, room) in [
        (
            "<bsdf type=\"diffuse\"/>",
            ShadingNormals::Flux,
            16,
            2,
            1.0,
            1e-9,
        ),
        // Split, it is Fresnel's share but for the rounding of flux; cut off at the end of chains, too.
        (&smooth, ShadingNormals::Flux, 16, 2, 1.0 - mirrored, 1e-9),
        (
            &smooth,
            ShadingNormals::Adjoint,
            16,
            2,
            1.0 - mirrored,
            1e-9,
        ),
        (&smooth, ShadingNormals::Flux, 1, 2, 1.0 - mirrored, 1e-9),
        // By lot: the standard deviation of some 10⁴ photons is 2e-3.
        (&smooth, ShadingNormals::Flux, 16, 1, 1.0 - mirrored, 8e-3),
        // Facets of α = 0.05 lean by some 3°, where Fresnel's share differs by a tenth: 0.004 of the light.
        (&rough, ShadingNormals::Flux, 16, 2, 1.0 - mirrored, 4e-3),
        (&rough, ShadingNormals::Adjoint, 16, 2, 1.0 - mirrored, 4e-3),
        (&rough, ShadingNormals::Flux, 16, 1, 1.0 - mirrored, 1.2e-2),
        (
            &rough,
            ShadingNormals::Adjoint,
            16,
            1,
            1.0 - mirrored,
            1.2e-2,
        ),
        (&rough, ShadingNormals::Flux, 1, 2, 1.0, 1e-9),
    ] {
        let chains = ChainSettings {
            max_depth,
            split_depth,
            shading_normals,
            ..ChainSettings::default()
        };
        let estimate = of(bsdf, chains);
        let name: Signature = "LTD".parse().unwrap();
        let received = estimate.ledger.rows[&name].received.0[0];
        let mut layers = estimate.layers.iter();
        let layer = layers.find(|it| it.name.to_string() == "LTD").unwrap();
        let light: f64 = layer.values.iter().map(|it| it.0[0]).sum();
        // The floor's 16 m² in 36 texels.
        let found = received / (light * 16.0 / 36.0);
        let case = format!("{bsdf} {shading_normals:?} {max_depth} {split_depth}");
        println!("{case}: {found} of {share}");
        assert!((found - share).abs() < room, "{case}: {found} of {share}");
        assert!(estimate.ledger.closure_error().unwrap() < 1e-12, "{case}");
        assert!(estimate.ledger.shading_gain.is_black(), "{case}");
    }
}

#[test]
fn light_that_meets_coats_only_has_a_sixteenth_of_the_samples_for_its_flux() {
    let floor = plastic("");
    let scene = paths::scene(&format!(
        "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"6\"/></emitter>\
         <shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"5\" y=\"5\"/></transform>{floor}</shape>{}",
        ball("<bsdf type=\"dielectric\"/>")
    ));
    let all = LightSpace::aimed(&scene, Followed::All).unwrap();
    let bare = LightSpace::new(&scene).unwrap();
    let is_bare = |cell: usize| {
        let cell = &all.cells()[cell];
        let middle = 0.5 * (cell.patch().from + cell.patch().to);
        bare.holds(cell.chart(), middle)
    };
    let per_flux = |cell: usize| {
        let patch = all.cells()[cell].patch();
        all.share(cell) / all.chart(cell).flux_bound(patch).mean()
    };
    let cells = 0..all.cells().len();
    let most = cells.clone().map(per_flux).fold(0.0, f64::max);
    let (mut of_glass, mut of_coats, mut of_outline) = (0, 0, 0);
    for cell in cells {
        let part = per_flux(cell) / most;
        // Cells are compared by their middles: at the outline the two spaces' cells differ.
        if is_bare(cell) {
            assert!((part - 1.0).abs() < 1e-9, "{part}");
            of_glass += 1;
        } else if (part - 1.0 / 16.0).abs() < 1e-9 {
            of_coats += 1;
        } else {
            assert!((part - 1.0).abs() < 1e-9, "{part}");
            of_outline += 1;
        }
    }
    // Either kind is divided until it has enough cells; a tenth of those of a ball are at its outline.
    assert!(of_glass > 1000 && of_coats > 1000, "{of_glass} {of_coats}");
    assert!(of_outline < of_glass / 5, "{of_outline} of {of_glass}");
}

#[test]
fn a_small_ball_has_half_of_the_samples_over_a_coated_floor_and_cells_of_its_own() {
    let scene = paths::scene(&format!(
        "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"6\"/></emitter>\
         <shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"9\" y=\"9\"/></transform>{}</shape>\
         <shape type=\"sphere\"><point name=\"center\" x=\"1\" y=\"0\" z=\"2\"/><float name=\"radius\" value=\"0.1\"/>\
         <bsdf type=\"dielectric\"/></shape>",
        plastic("")
    ));
    let all = LightSpace::aimed(&scene, Followed::All).unwrap();
    let bare = LightSpace::new(&scene).unwrap();
    let is_bare = |cell: &usize| {
        let cell = &all.cells()[*cell];
        let middle = 0.5 * (cell.patch().from + cell.patch().to);
        bare.holds(cell.chart(), middle)
    };
    let cells: Vec<usize> = (0..all.cells().len()).filter(is_bare).collect();
    let share: f64 = cells.iter().map(|cell| all.share(*cell)).sum();
    // Its outline's cells have some of that half, and miss it by their middles.
    println!("{share} of the samples in {} cells", cells.len());
    assert!((0.4..0.5 + 1e-9).contains(&share), "{share}");
    assert!(cells.len() > bare.cells().len() / 2, "{}", cells.len());
}

#[test]
fn where_nothing_is_rough_or_coated_photons_aim_at_mirrors_and_glass() {
    for name in scene_names() {
        let scene = bundled(name, 16);
        let [one, other] = [Followed::Smooth, Followed::All].map(|followed| {
            let light = LightSpace::aimed(&scene, followed).unwrap();
            let shares = (0..light.cells().len()).map(|cell| light.share(cell).to_bits());
            shares.collect::<Vec<u64>>()
        });
        assert!(one == other, "{name}");
    }
}
