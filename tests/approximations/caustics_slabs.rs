//! Caustics volumes by their parts: pictures against rays, marches against traced surfaces, and updates.

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};
use nephroid::internals::approximation::Technique;
use nephroid::internals::approximation::caustics_volume::advice::Pilot;
use nephroid::internals::approximation::caustics_volume::buffers::{Pictures, Slab};
use nephroid::internals::approximation::caustics_volume::demands::Volume;
use nephroid::internals::approximation::caustics_volume::emission::lattices;
use nephroid::internals::approximation::caustics_volume::march::{Against, Marcher};
use nephroid::internals::approximation::caustics_volume::meeting::Optics;
use nephroid::internals::approximation::caustics_volume::photon::Photon;
use nephroid::internals::approximation::caustics_volume::projector::Projectors;
use nephroid::internals::approximation::caustics_volume::slab::Passed;
use nephroid::internals::approximation::caustics_volume::sweep::Tracer;
use nephroid::internals::approximation::caustics_volume::work::Work;
use nephroid::internals::approximation::caustics_volume::{CausticsVolume, Settings};
use nephroid::internals::geometry::Ray;
use nephroid::internals::run::Context;
use nephroid::internals::scene::Scene;
use nephroid::internals::setting::Values;

use crate::support::approximation::{GLASS, bumpy_ball_over_floor, over_floor, scene_of};
use crate::support::scenes::meter;

fn values(given: &[(&str, &str)]) -> Values {
    let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
    let given: BTreeMap<String, String> = given.iter().map(owned).collect();
    let table = CausticsVolume.settings().iter().collect();
    Values::new("caustics-volume", table, &given).unwrap()
}

fn settings(given: &[(&str, &str)]) -> Settings {
    Settings::of(&values(given)).unwrap()
}

/// The slabs of a volume.
fn slabs<'a>(scene: &'a Scene, volume: &'a Volume, settings: &Settings) -> Vec<Slab<'a>> {
    let count = settings.slabs as usize;
    (0..count)
        .map(|slab| Slab {
            scene,
            cuboid: &volume.cuboid,
            depths: volume.cuboid.slab(slab, count),
            side: settings.g_buffer as usize,
        })
        .collect()
}

/// All photons that leave the volume with an event behind them, by their numbers.
fn leaving(scene: &Scene, given: &[(&str, &str)]) -> BTreeMap<u64, Photon> {
    let settings = settings(given);
    let volume = Volume::new(scene, &settings).unwrap();
    let slabs = slabs(scene, &volume, &settings);
    let mut work = Work::default();
    let pictures: Vec<Pictures> = slabs
        .iter()
        .map(|slab| Pictures::new(slab, &settings, &mut work))
        .collect();
    let projectors = Projectors::new(scene, &volume, &settings, &mut work);
    let tracer = Tracer {
        scene,
        settings: &settings,
        volume: &volume,
        slabs: &slabs,
        pictures: &pictures,
        projectors: &projectors,
    };
    let mut found = BTreeMap::new();
    for lattice in lattices(scene, &settings, &volume) {
        for cell in 0..lattice.cells() {
            if let Some(photon) = lattice.cell(cell, &mut work) {
                let mut passed = Passed::default();
                tracer.follow(&photon, &mut passed);
                for (_, photon) in passed.out {
                    assert!(found.insert(photon.index, photon).is_none());
                }
            }
        }
    }
    found
}

/// The largest distance between photons that leave, and between their directions; and how many leave only
/// one way.
fn apart(a: &BTreeMap<u64, Photon>, b: &BTreeMap<u64, Photon>) -> (f64, usize) {
    let mut most = 0.0_f64;
    let mut alone = a.len().abs_diff(b.len());
    for (index, photon) in a {
        match b.get(index) {
            Some(other) => {
                let place = photon.ray.origin.distance(other.ray.origin);
                let direction = photon.ray.direction.distance(other.ray.direction);
                most = most.max(place).max(direction);
            }
            None => alone += 1,
        }
    }
    (most, alone)
}

/// Own directions, and one way at each surface.
const ONE_WAY: [(&str, &str); 4] = [
    ("emission", "exact"),
    ("interface", "mirror-total"),
    ("photons", "2000"),
    ("projector", "exact"),
];

#[test]
fn near_and_far_surfaces_as_they_are_lead_photons_as_rays_do_where_two_suffice() {
    let small = |z: f64| {
        format!(
            r#"<shape type="sphere"><point name="center" x="0.1" y="0" z="{z}"/>
            <float name="radius" value="0.4"/>{GLASS}</shape>"#
        )
    };
    let one = scene_of(&over_floor(&small(1.4), 8));
    let two = scene_of(&over_floor(&format!("{}{}", small(0.7), small(1.9)), 8));
    for (scene, slabs) in [(&one, "1"), (&one, "2"), (&two, "2"), (&two, "4")] {
        let with = |more: &[(&str, &str)]| {
            let given = [&ONE_WAY[..], &[("slabs", slabs), ("g-buffer", "64")], more].concat();
            leaving(scene, &given)
        };
        let traced = with(&[("layers", "exact")]);
        let marched = with(&[("buffers", "exact"), ("march", "exact")]);
        let (most, alone) = apart(&traced, &marched);
        // Places are those of the same surfaces, found by the same rays: 1e-9 of a volume a metre large.
        assert!(traced.len() > 500);
        assert_eq!(alone, 0, "{slabs} slabs");
        assert!(most < 1e-9, "{slabs} slabs: {most}");
        // Pictures of 64 texels are off by a part of a texel, and that is seen.
        let (coarse, _) = apart(&traced, &with(&[]));
        assert!(coarse > 1e-3, "{slabs} slabs: {coarse}");
    }
}

#[test]
fn the_pilot_says_what_two_surfaces_a_slab_lose() {
    let objects = |box_at: f64| {
        format!(
            r#"<shape type="sphere"><point name="center" x="0" y="0" z="2"/><float name="radius" value="0.5"/>{GLASS}
            </shape><shape type="cube"><transform name="to_world"><scale x="0.7" y="0.7" z="0.2"/>
            <translate z="{box_at}"/></transform>{GLASS}</shape>"#
        )
    };
    let text = over_floor(&objects(1.0), 8).replace(r#"z="4""#, r#"z="9""#);
    let scene = scene_of(&text);
    for slabs in ["1", "2", "3", "4"] {
        let common = [("photons", "1000"), ("slabs", slabs), ("g-buffer", "64")];
        let given = [&ONE_WAY[..], &common].concat();
        let with = |more: &[(&str, &str)]| leaving(&scene, &[&given[..], more].concat());
        let traced = with(&[("layers", "exact"), ("sweep", "exact")]);
        let marched = with(&[("buffers", "exact"), ("march", "exact")]);
        let is_lost = |(index, photon): &(&u64, &Photon)| {
            marched.get(index).is_none_or(|other| {
                other.ray.origin.distance(photon.ray.origin) > 1e-6
                    || other.ray.direction.distance(photon.ray.direction) > 1e-6
            })
        };
        let flux = |photon: &Photon| photon.flux.mean();
        let lost: f64 = traced.iter().filter(is_lost).map(|it| flux(it.1)).sum();
        let all: f64 = traced.values().map(flux).sum();
        let settings = settings(&given);
        let volume = Volume::new(&scene, &settings).unwrap();
        let pilot = Pilot::new(&scene, &settings, &volume);
        let said = pilot.slabs(settings.slabs as usize).lost;
        // The same photons in sums of two orders. Half of them meet ball and box, four surfaces.
        assert!(
            (said - lost / all).abs() < 1e-12,
            "{slabs} slabs: {said} {}",
            lost / all
        );
        assert_eq!(said > 0.4, slabs < "3", "{slabs} slabs: {said}");
    }
}

#[test]
fn photons_that_pass_behind_a_ball_do_not_meet_it() {
    // A slanting sun: photons enter beside the ball, and pass below it.
    let scene = scene_of(&over_floor(
        &format!(
            r#"<emitter type="directional"><vector name="direction" x="1" y="0.3" z="-1"/></emitter>
            <shape type="sphere"><point name="center" x="0.1" y="0" z="1.4"/><float name="radius" value="0.4"/>
            {GLASS}</shape>"#
        ),
        8,
    )
    .replace(r#"value="100, 100, 100""#, r#"value="0, 0, 0""#));
    let with = |more: &[(&str, &str)]| {
        let given = [&ONE_WAY[..], &[("slabs", "1"), ("g-buffer", "200")], more].concat();
        leaving(&scene, &given)
    };
    let (traced, marched) = (with(&[("layers", "exact")]), with(&[]));
    assert!(traced.len() > 500);
    // Photons within a texel of the ball's silhouette: 2 / 80 of those that meet it, a half of them beside it.
    let (_, alone) = apart(&traced, &marched);
    assert!(alone * 40 < traced.len(), "{alone} of {}", traced.len());
}

#[test]
fn a_crossing_is_where_the_photon_is_as_deep_as_the_picture() {
    let pane = format!(
        r#"<shape type="rectangle"><transform name="to_world"><translate z="1.5"/></transform>{GLASS}</shape>
        <shape type="rectangle"><transform name="to_world"><translate z="0.5"/></transform>{GLASS}</shape>"#
    );
    let scene = scene_of(&over_floor(&pane, 8));
    let settings = settings(&[("slabs", "1"), ("g-buffer", "10")]);
    let volume = Volume::new(&scene, &settings).unwrap();
    let slabs = slabs(&scene, &volume, &settings);
    let mut work = Work::default();
    let pictures = Pictures::new(&slabs[0], &settings, &mut work);
    let optics = Optics {
        scene: &scene,
        settings: &settings,
    };
    let marcher = Marcher {
        slab: &slabs[0],
        pictures: &pictures,
        settings: &settings,
        optics: &optics,
    };
    let given = [("photons", "100"), ("emission", "exact")];
    for photon in leaving(&scene, &given).values() {
        // From the upper pane's height on, downwards.
        let start = photon.ray.origin - photon.ray.direction * (1.52 - photon.ray.origin.z).abs();
        let ray = Ray::new(
            DVec3::new(start.x.clamp(-0.9, 0.9), start.y.clamp(-0.9, 0.9), 1.515),
            DVec3::new(0.1, 0.2, -0.9).normalize(),
        );
        let photon = Photon {
            ray,
            is_inside: false,
            ..*photon
        };
        let met = marcher.first(&photon, Against::Near, &mut work).unwrap();
        // Depths are floats of a metre.
        assert!(
            (met.point.position.z - 1.5).abs() < 1e-6,
            "{}",
            met.point.position
        );
    }
}

#[test]
fn pictures_of_floats_lead_vertical_light_through_an_upright_cube_as_rays_do() {
    let scene = scene_of(
        r#"<scene version="3.0.0">
        <emitter type="directional"><vector name="direction" x="0" y="0" z="-1"/></emitter>
        <shape type="cube"><transform name="to_world"><scale value="0.5"/><translate z="1"/></transform>
            <bsdf type="dielectric"/></shape>
        <shape type="rectangle"><bsdf type="diffuse"/><sensor type="irradiancemeter"><film type="hdrfilm">
            <rfilter type="box"/></film></sensor></shape></scene>"#,
    );
    let common = [
        ("emission", "parallel"),
        ("g-buffer", "100"),
        ("photons", "2500"),
        ("slabs", "1"),
    ];
    let with = |more: &[(&str, &str)]| leaving(&scene, &[&common[..], more].concat());
    let traced = with(&[("layers", "exact")]);
    let marched = with(&[]);
    // A texel off the cube's silhouette: its sides are at 1/1.02 of the volume's.
    let texel = 0.0102;
    let inner = |photons: &BTreeMap<u64, Photon>| -> BTreeMap<u64, Photon> {
        let is_inner =
            |photon: &Photon| photon.ray.origin.truncate().abs().max_element() < 0.5 - texel;
        let photons = photons.iter().filter(|(_, photon)| is_inner(photon));
        photons.map(|(index, photon)| (*index, *photon)).collect()
    };
    let (most, alone) = apart(&inner(&traced), &inner(&marched));
    assert!(inner(&traced).len() > 2000);
    // Depths are floats of a metre: 6e-8.
    assert!(most < 1e-6 && alone == 0, "{most} {alone}");
}

#[test]
fn the_rasteriser_finds_what_rays_find_in_each_texel() {
    // 82,000 triangles, some smaller than a texel; and round shapes, which are sampled.
    let balls = scene_of(&over_floor(
        &format!(
            r#"<shape type="sphere"><point name="center" x="0.1" y="0" z="1.4"/>
            <float name="radius" value="0.4"/>{GLASS}</shape>
            <shape type="rectangle"><transform name="to_world"><rotate x="1" y="0.3" angle="40"/>
            <translate z="1.2"/></transform>{GLASS}</shape>
            <shape type="cylinder"><point name="p0" x="-1" y="0.2" z="1"/><point name="p1" x="1" y="0.4" z="1.1"/>
            <float name="radius" value="0.3"/>{GLASS}</shape>"#
        ),
        8,
    ));
    for scene in [bumpy_ball_over_floor(8), balls] {
        let settings = settings(&[("g-buffer", "150"), ("slabs", "2")]);
        let volume = Volume::new(&scene, &settings).unwrap();
        let mut work = Work::default();
        for slab in slabs(&scene, &volume, &settings) {
            let pictures = Pictures::new(&slab, &settings, &mut work);
            let (mut same, mut other) = (0, 0);
            for texel in 0..150 * 150 {
                let at = DVec2::new(f64::from(texel % 150), f64::from(texel / 150)) + 0.5;
                for layer in [0, 1] {
                    let drawn = pictures.surface(&slab, &settings, layer, at, &mut work);
                    let asked = slab.asked(at, layer == 1, &mut work);
                    let is_same = match (drawn, asked) {
                        (Some(drawn), Some(asked)) => {
                            let normals =
                                drawn.point.shading_normal.dot(asked.point.shading_normal);
                            // Depths are floats of up to 2 m.
                            (drawn.depth - asked.depth).abs() < 1e-6
                                && drawn.hit.shape == asked.hit.shape
                                && normals > 1.0 - 1e-6
                        }
                        (None, None) => true,
                        _ => false,
                    };
                    *(if is_same { &mut same } else { &mut other }) += 1;
                }
            }
            // Centres on edges, silhouettes and the border between slabs, to rounding: none or a few.
            assert!(same > 40_000 && other <= 4, "{same} {other}");
        }
    }
}

/// A lamp over two balls of glass, one above the other, beside a post, on a floor.
fn stage(upper: DVec3, lower: DVec3, post: f64, lamp: f64) -> Scene {
    let glass = |center: DVec3| {
        format!(
            r#"<shape type="sphere"><point name="center" x="{}" y="{}" z="{}"/>
            <float name="radius" value="0.25"/>{GLASS}</shape>"#,
            center.x, center.y, center.z
        )
    };
    // Panes at the volume's ends, so that it stays as it is.
    let ends = [0.3, 2.3].map(|z| {
        format!(
            r#"<shape type="rectangle"><transform name="to_world"><scale value="0.8"/><translate z="{z}"/></transform>
            <bsdf type="thindielectric"/></shape>"#
        )
    });
    let objects = format!(
        r#"{}{}{}{}<shape type="cube"><transform name="to_world"><scale x="0.1" y="0.1" z="0.5"/>
        <translate x="{post}" y="1.2" z="0.5"/></transform><bsdf type="diffuse"/></shape>"#,
        glass(upper),
        glass(lower),
        ends[0],
        ends[1],
    );
    let text = over_floor(&objects, 24);
    scene_of(&text.replace(
        r#"x="0" y="0" z="4""#,
        &format!(r#"x="{lamp}" y="0" z="4""#),
    ))
}

#[test]
fn a_frame_that_is_made_anew_in_part_has_the_bits_of_one_made_anew_in_all() {
    let common = [("g-buffer", "60"), ("photons", "800"), ("slabs", "4")];
    let start = stage(
        DVec3::new(0.0, 0.0, 2.0),
        DVec3::new(0.1, 0.1, 0.6),
        1.2,
        0.0,
    );
    let prepare = |update: &str| {
        let values = values(&[&common[..], &[("update", update)]].concat());
        let sensor = meter(&start);
        CausticsVolume
            .prepare(&start, sensor, &values, &Context::default())
            .unwrap()
    };
    let (mut full, mut changed) = (prepare("full"), prepare("changed"));
    let mut random = 1_u64;
    let mut next = |range: f64| {
        random = random
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((random >> 40) as f64 / f64::from(1_u32 << 24) - 0.5) * range
    };
    let (mut upper, mut lower) = (DVec3::new(0.0, 0.0, 2.0), DVec3::new(0.1, 0.1, 0.6));
    let (mut post, mut lamp) = (1.2, 0.0);
    let count =
        |frame: &nephroid::internals::approximation::Frame, name: &str| frame.counters.get(name);
    for edit in 0..100 {
        // What is edited, and the first slab that it is in: slabs of half a metre from above.
        let first = match edit % 5 {
            0 => {
                upper.x = next(0.8);
                0
            }
            1 | 2 => {
                lower.y = next(0.8);
                2
            }
            3 => {
                post = 1.3 + next(0.2);
                4
            }
            _ if edit % 10 == 9 => {
                lamp = next(0.2);
                0
            }
            // Nothing.
            _ => 4,
        };
        let scene = stage(upper, lower, post, lamp);
        let sensor = meter(&scene);
        let context = Context::default();
        let all = full.frame(&scene, sensor, &context).unwrap();
        let part = changed.frame(&scene, sensor, &context).unwrap();
        assert!(all.values.iter().any(|value| !value.is_black()));
        assert_eq!(all.values, part.values, "edit {edit}");
        assert_eq!(all.flux, part.flux, "edit {edit}");
        assert_eq!(count(&all, "passes"), 5);
        if edit > 0 {
            assert_eq!(count(&part, "passes"), 5 - first, "edit {edit}");
        }
        let pictures = count(&part, "texels") / 3600;
        match edit % 5 {
            _ if edit == 0 => {}
            // The post is beside the volume: five projectors. The lower ball is in two slabs.
            3 => assert_eq!(pictures, 5, "edit {edit}"),
            1 | 2 => assert_eq!(pictures, 4, "edit {edit}"),
            4 if edit % 10 != 9 => assert_eq!(pictures, 0, "edit {edit}"),
            _ => {}
        }
    }
}

/// Images of some scenes, one after the other.
fn images(given: &[(&str, &str)], scenes: &[&Scene]) -> Vec<Vec<f64>> {
    let common = [
        ("g-buffer", "60"),
        ("photons", "800"),
        ("slabs", "3"),
        ("smooth", "exact"),
    ];
    let values = values(&[&common[..], given].concat());
    let context = Context::default();
    let mut prepared = CausticsVolume
        .prepare(scenes[0], meter(scenes[0]), &values, &context)
        .unwrap();
    let mut image = |scene: &&Scene| -> Vec<f64> {
        let frame = prepared.frame(scene, meter(scene), &context).unwrap();
        frame.values.iter().map(|value| value.mean()).collect()
    };
    scenes.iter().map(&mut image).collect()
}

#[test]
fn a_slab_that_a_ball_left_is_drawn_anew() {
    // Slabs of half a metre. The ball is in the lowest, then two slabs above it and to the side: light falls
    // straight down where it was. On the way back it leaves the second slab from above.
    let upper = DVec3::new(-0.5, -0.5, 2.0);
    let places = [DVec3::new(0.4, 0.4, 0.6), DVec3::new(0.4, -0.4, 1.4)];
    let [low, high] = places.map(|lower| stage(upper, lower, 1.2, 0.0));
    let scenes = [&low, &high, &low];
    let slabs = ("slabs", "4");
    let whole = images(&[slabs], &scenes);
    assert_ne!(whole[0], whole[1]);
    assert_eq!(images(&[slabs, ("update", "changed")], &scenes), whole);
}

#[test]
fn passes_shared_out_over_frames_trail_behind_by_as_many_frames() {
    let balls = [DVec3::new(0.0, 0.0, 2.0), DVec3::new(0.1, 0.1, 0.6)];
    let [before, after] = [0.0, 0.2].map(|lamp| stage(balls[0], balls[1], 1.2, lamp));
    let whole = images(&[], &[&before, &after]);
    assert_ne!(whole[0], whole[1]);
    // Four passes, two a frame: a sweep begins in frames 1, 3, 5 and ends in frames 2, 4, 6.
    let scenes = [&before, &before, &before, &after, &after, &after, &after];
    let trailing = images(&[("amortise", "2")], &scenes);
    assert_eq!(trailing[0], whole[0]);
    for shown in &trailing[1..=3] {
        // The lamp moves as the second half of a sweep runs: its photons are those of before.
        assert_eq!(shown, &whole[0]);
    }
    assert_eq!(trailing[4], whole[1]);
    let all = images(&[("amortise", "4")], &[&before, &after]);
    assert_eq!(all, whole);
}

#[test]
fn photons_shared_out_over_frames_are_all_there_once_each_share_was_traced() {
    let balls = [DVec3::new(0.0, 0.0, 2.0), DVec3::new(0.1, 0.1, 0.6)];
    let [before, after] = [0.0, 0.2].map(|lamp| stage(balls[0], balls[1], 1.2, lamp));
    let whole = images(&[], &[&before, &after]);
    let scenes = [
        &before, &before, &before, &before, &after, &after, &after, &after,
    ];
    let shared = images(&[("shares", "4")], &scenes);
    let apart = |a: &[f64], b: &[f64]| {
        let off: f64 = a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum();
        off / b.iter().sum::<f64>()
    };
    // The same photons in another order.
    assert!(apart(&shared[3], &whole[0]) < 1e-12);
    assert!(apart(&shared[7], &whole[1]) < 1e-12);
    // A quarter of them, with their flux, is a coarser image of as much light; between, two scenes mix.
    assert!(apart(&shared[0], &whole[0]) > 0.05);
    assert!(apart(&shared[5], &whole[1]) > 0.05);
    let sum = |image: &[f64]| image.iter().sum::<f64>();
    assert!((sum(&shared[0]) / sum(&whole[0]) - 1.0).abs() < 0.1);
}
