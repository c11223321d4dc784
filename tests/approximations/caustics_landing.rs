//! Caustics volumes: shares of flux at interfaces, places where photons land, splats, and level of detail.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use nephroid::internals::approximation::Technique;
use nephroid::internals::approximation::caustics_volume::cuboid::Face;
use nephroid::internals::approximation::caustics_volume::demands::Volume;
use nephroid::internals::approximation::caustics_volume::photon::{Landing, Photon};
use nephroid::internals::approximation::caustics_volume::projector::Projectors;
use nephroid::internals::approximation::caustics_volume::splat::{Disc, discs};
use nephroid::internals::approximation::caustics_volume::work::Work;
use nephroid::internals::approximation::caustics_volume::{CausticsVolume, Settings};
use nephroid::internals::geometry::Ray;
use nephroid::internals::optics::dielectric_reflectance;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::run::{Budget, Context};
use nephroid::internals::scene::Scene;
use nephroid::internals::setting::Values;
use nephroid::internals::transport::signature::{Event, Signature};

use crate::support::approximation::{GLASS, over_floor, scene_of};
use crate::support::caustics_volume::{count, texels, volume};

fn settings(given: &[(&str, &str)]) -> Settings {
    let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
    let given: BTreeMap<String, String> = given.iter().map(owned).collect();
    let table = CausticsVolume.settings().iter().collect();
    Settings::of(&Values::new("caustics-volume", table, &given).unwrap()).unwrap()
}

/// A sun of 1 W/m² along (x, 0, z) on a plate of glass, 1 m thick and 4 x 4 m, over a floor of 2 x 2 m.
fn plate(x: f64, z: f64, more: &str) -> Scene {
    scene_of(&format!(
        r#"<scene version="3.0.0">
        <emitter type="directional"><vector name="direction" x="{x}" y="0" z="{z}"/></emitter>
        <shape type="rectangle"><transform name="to_world"><scale value="2"/><translate z="1.5"/></transform>
            {GLASS}</shape>
        <shape type="rectangle"><transform name="to_world"><rotate x="1" angle="180"/><scale value="2"/>
            <translate z="0.5"/></transform>{GLASS}</shape>{more}
        <shape type="rectangle"><bsdf type="diffuse"/><sensor type="irradiancemeter"><film type="hdrfilm">
            <integer name="width" value="16"/><integer name="height" value="16"/>
            <rfilter type="box"/></film></sensor></shape></scene>"#
    ))
}

/// The least and the largest value of texels below the middle of the plate.
fn below(settings: &[(&str, &str)], scene: &Scene) -> [f64; 2] {
    let common = [
        ("splat", "exact"),
        ("smooth", "exact"),
        ("photons", "400"),
        ("g-buffer", "100"),
    ];
    let values = texels(&volume(&[&common[..], settings].concat()), scene);
    let inner = (0..36).map(|index| values[(5 + index / 6) * 16 + 5 + index % 6]);
    inner.fold([f64::INFINITY, 0.0], |[low, high], it| {
        [low.min(it), high.max(it)]
    })
}

#[test]
fn a_plate_lets_through_what_each_model_of_its_interfaces_says() {
    let scene = plate(0.0, -1.0, "");
    let reflected = dielectric_reflectance(1.0, 1.5);
    let through = 1.0 - reflected;
    // Light that goes back and forth in the plate: a geometric series.
    let series = through * through / (1.0 - reflected * reflected);
    let cases: [(&[(&str, &str)], f64); 6] = [
        (&[("interface", "refract")], 1.0),
        (&[("interface", "fresnel")], through * through),
        // At right angles Schlick's approximation is none.
        (&[("interface", "schlick")], through * through),
        (&[("interface", "exact"), ("layers", "exact")], series),
        (
            &[("interface", "exact"), ("layers", "near-far")],
            through * through,
        ),
        (
            &[
                ("interface", "exact"),
                ("layers", "exact"),
                ("slabs", "1"),
                ("sweep", "exact"),
            ],
            series,
        ),
    ];
    for (settings, expected) in cases {
        for emission in ["parallel", "exact"] {
            let all = [settings, &[("emission", emission)]].concat();
            for value in below(&all, &scene) {
                // Of three slabs, one pass forwards loses what was reflected into the slab before; the rest of
                // the series after one round trip is 0.0016 of it.
                let is_whole = settings.len() != 2 || settings[1].1 != "exact";
                let tolerance = if is_whole { 1e-9 } else { 2e-3 };
                // Events below 1e-6 of a beam's light are left out.
                let tolerance = if settings.len() == 4 { 1e-5 } else { tolerance };
                assert!(
                    (value / expected - 1.0).abs() < tolerance,
                    "{all:?}: {value} instead of {expected}"
                );
            }
        }
    }
}

#[test]
fn light_is_refracted_in_the_middle_of_a_slab_and_at_its_borders_alike() {
    let (sin, cos) = 30.0_f64.to_radians().sin_cos();
    let scene = plate(sin, -cos, "");
    let text = |slabs: &str| below(&[("slabs", slabs), ("interface", "fresnel")], &scene);
    let through = 1.0 - dielectric_reflectance(cos, 1.5);
    let expected = cos * through * through;
    for slabs in ["1", "2", "3", "7"] {
        for value in text(slabs) {
            // Positions have the depths of texels: places are shifted, and a shift of an even light is none.
            assert!(
                (value / expected - 1.0).abs() < 1e-9,
                "{slabs}: {value} {expected}"
            );
        }
    }
}

fn photon(origin: DVec3, direction: DVec3) -> Photon {
    Photon {
        ray: Ray::new(origin, direction.normalize()),
        flux: Rgb::WHITE,
        length: 0.0,
        is_inside: false,
        signature: Signature::DIRECT.then(Event::Reflection),
        last: 0,
        path: 0,
        index: 0,
    }
}

#[test]
fn projectors_lead_photons_to_within_texels_of_where_rays_do() {
    // A mirror ball in a room of boxes, balls and a tube.
    let room = r#"<shape type="sphere"><point name="center" x="0" y="0" z="1.2"/><float name="radius" value="0.3"/>
            <bsdf type="conductor"/></shape>
        <shape type="cube"><transform name="to_world"><scale value="2.5"/></transform>
            <bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>
        <shape type="sphere"><point name="center" x="1.4" y="0.2" z="1.5"/><float name="radius" value="0.5"/>
            <bsdf type="diffuse"/></shape>
        <shape type="cylinder"><point name="p0" x="-1" y="-1.5" z="0.8"/><point name="p1" x="-1" y="1" z="0.6"/>
            <float name="radius" value="0.3"/><bsdf type="twosided"><bsdf type="diffuse"/></bsdf></shape>"#;
    let scene = scene_of(&over_floor(room, 8).replace(r#"z="4""#, r#"z="2""#));
    let given = |projector: &'static str| {
        settings(&[
            ("projector", projector),
            ("g-buffer", "400"),
            ("cull", "none"),
        ])
    };
    let (marched, traced) = (given("cube"), given("exact"));
    let volume = Volume::new(&scene, &marched).unwrap();
    let mut work = Work::default();
    let pictures = Projectors::new(&scene, &volume, &marched, &mut work);
    let none = Projectors::new(&scene, &volume, &traced, &mut work);
    let cuboid = &volume.cuboid;
    let (mut near, mut all) = (0, 0);
    for face in Face::ALL {
        for index in 0..900 {
            let at = DVec2::new(f64::from(index % 30), f64::from(index / 30)) / 30.0 + 0.02;
            let place = cuboid.face_point(face, at);
            // All around the outward normal, up to 80° from it.
            let turn = f64::from(index) * 2.4;
            let lean = f64::from(index % 7) / 7.0 * 1.4;
            let (s, t) = cuboid.outward(face).any_orthonormal_pair();
            let direction =
                cuboid.outward(face) * lean.cos() + (s * turn.cos() + t * turn.sin()) * lean.sin();
            let one = photon(place, direction);
            let landed = |projectors: &Projectors, settings: &Settings| {
                let mut work = Work::default();
                projectors.land(&scene, cuboid, settings, &one, &mut work)
            };
            let exact = landed(&none, &traced).unwrap();
            all += 1;
            if let Ok(found) = landed(&pictures, &marched) {
                // Texels of a face are seen under 1.4 of its 400, at most.
                let distance = exact.position.distance(cuboid.middle());
                let texel = 2.0 * 1.4 * distance / 400.0;
                let apart = found.position.distance(exact.position);
                near += i32::from(apart < 2.0 * texel);
            }
        }
    }
    // Photons that pass behind what the middle sees land on it: 2.6 % of these.
    assert!(near * 100 >= all * 96, "{near} of {all}");
}

#[test]
fn a_disc_spreads_all_of_its_flux_over_its_ellipse() {
    let direction = DVec3::new(0.6, 0.0, -0.8);
    let landing = Landing {
        photon: photon(DVec3::new(-3.0, 0.0, 4.0), direction),
        position: DVec3::ZERO,
        normal: DVec3::Z,
        hit: None,
    };
    let disc = Disc::new(&landing, 0.1, 2.0);
    let mut sum = 0.0;
    let mut reach = DVec2::ZERO;
    const PARTS: i32 = 1000;
    for index in 0..PARTS * PARTS {
        let at = DVec2::new(f64::from(index % PARTS), f64::from(index / PARTS)) + 0.5;
        let at = (at / f64::from(PARTS) - 0.5) * 0.4;
        if disc.holds(at.extend(0.0), DVec3::Z) {
            sum += disc.irradiance.mean() * 0.4 * 0.4 / f64::from(PARTS * PARTS);
            reach = reach.max(at.abs());
        }
    }
    // Cells on the border, of 0.0004: their share is perimeter by side by area, averaged over hundreds.
    assert!((sum - 1.0).abs() < 1e-3, "{sum}");
    // Stretched by 1 / 0.8 along the light.
    assert!(
        (reach.x - 0.125).abs() < 5e-4 && (reach.y - 0.1).abs() < 5e-4,
        "{reach}"
    );
    // Neither points off its plane nor on the other side are lit.
    assert!(disc.holds(DVec3::Z * 0.19, DVec3::Z) && !disc.holds(DVec3::Z * 0.21, DVec3::Z));
    assert!(!disc.holds(DVec3::ZERO, DVec3::NEG_Z));
}

#[test]
fn a_splat_is_as_large_as_its_share_of_its_tile() {
    let scene = scene_of(&over_floor(
        r#"<shape type="cube"><transform name="to_world"><scale value="0.5"/><translate z="2"/></transform>
        <bsdf type="conductor"/></shape>"#,
        8,
    ));
    let given = settings(&[
        ("g-buffer", "100"),
        ("tile", "10"),
        ("margin", "0"),
        ("splat-max", "100"),
    ]);
    let volume = Volume::new(&scene, &given).unwrap();
    // The floor is 2 m below the middle of a cube of half a metre: a tile of 10 of 100 texels is 0.4 m wide.
    let at = |x: f64, y: f64, length: f64| Landing {
        photon: Photon {
            length,
            ..photon(DVec3::new(x, y, 1.0), DVec3::NEG_Z)
        },
        position: DVec3::new(x, y, 0.0),
        normal: DVec3::Z,
        hit: None,
    };
    let landed = [
        at(0.05, 0.05, 1.0),
        at(0.1, 0.3, 1.0),
        at(0.2, 0.2, 1.0),
        at(0.3, 0.1, 0.0),
        at(-0.1, 0.1, 1.0),
    ];
    let found = discs(&volume.cuboid, &given, &landed, 0.0);
    let radius = |photons: f64| 0.4 / (std::f64::consts::PI * photons).sqrt();
    for (disc, expected) in found.iter().zip([
        radius(4.0),
        radius(4.0),
        radius(4.0),
        // Half as long a way as the longest.
        0.5 * radius(4.0),
        radius(1.0),
    ]) {
        assert!(
            (disc.reach - expected).abs() < 1e-12,
            "{} {expected}",
            disc.reach
        );
    }
    // Points of a film would miss splats smaller than half its diagonal.
    let wide = discs(&volume.cuboid, &given, &landed, 0.3);
    assert!((wide[3].reach - 0.3).abs() < 1e-12);
}

#[test]
fn level_of_detail_has_fewer_slabs_from_afar_and_no_photons_out_of_view() {
    let camera = |z: f64, turned: &str| {
        let sensor = format!(
            r#"<sensor type="perspective" id="eye"><float name="fov" value="40"/><transform name="to_world">
            <lookat origin="3, 0, {z}" target="{turned}" up="0, 1, 0"/></transform><film type="hdrfilm">
            <integer name="width" value="16"/><integer name="height" value="16"/><rfilter type="box"/></film></sensor>"#
        );
        plate(0.0, -1.0, &sensor)
    };
    let run = |scene: &Scene, given: &[(&str, &str)]| {
        let all = [
            &[("photons", "100"), ("g-buffer", "20"), ("slabs", "6")],
            given,
        ]
        .concat();
        let eye = scene.sensors().iter().find(|one| one.id == "eye").unwrap();
        volume(&all)
            .run(scene, eye, &Budget::default(), &Context::default())
            .unwrap()
    };
    // 3 and 4 of the plate's middle: 5 m from it.
    let near = camera(5.0, "0, 0, 1");
    for (distance, slabs) in [("0", 6), ("5", 6), ("2.5", 3), ("2.4", 3), ("0.1", 1)] {
        let done = run(&near, &[("lod-distance", distance)]);
        assert_eq!(count(&done, "sweep", "passes"), slabs + 1, "{distance}");
    }
    let away = camera(5.0, "6, 0, 9");
    let done = run(&away, &[("frustum", "true")]);
    assert!(done.warnings[0].starts_with("the volume is out of the camera's view"));
    assert_eq!(count(&done, "sweep", "passes"), 0);
    assert_eq!(
        count(&run(&near, &[("frustum", "true")]), "sweep", "passes"),
        7
    );
}
