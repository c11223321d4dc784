//! Light from all round: closed forms, light followed backwards, and what a sun in an image costs.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use nephroid::internals::film::{Image, exr};
use nephroid::internals::mitsuba;
use nephroid::internals::numeric::{SampleMoments, Stream, StreamKind};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::run::Estimate;
use nephroid::internals::scene::{Emitter, Envmap, Scene};
use nephroid::internals::transport::domain::LightSpace;
use tempfile::TempDir;

use super::metered::by_photons_with;
use crate::support::paths;

/// A ball of glass that rests a tenth above the floor.
const BALL: &str = "<shape type=\"sphere\"><point name=\"center\" x=\"0.1\" y=\"0\" z=\"1.1\"/>\
    <bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1\"/></bsdf></shape>";

const EVEN: &str =
    "<emitter type=\"constant\"><rgb name=\"radiance\" value=\"2, 2, 2\"/></emitter>";

const IMAGE: &str = "<emitter type=\"envmap\"><string name=\"filename\" value=\"sky.exr\"/>\
    <transform name=\"to_world\"><rotate x=\"1\" angle=\"77\"/></transform></emitter>";

/// A floor with a meter of `side` texels and half width `half`, other elements, and an image of radiances.
fn scene(elements: &str, half: f64, side: usize, image: Option<&Sky>) -> Scene {
    let folder = TempDir::new().unwrap();
    if let Some(sky) = image {
        let mut image = Image::new(sky.width, sky.texels.len() / sky.width);
        let names = ["R", "G", "B"];
        for (c, name) in names.into_iter().enumerate() {
            image.add_scalar(name, sky.texels.iter().map(|texel| texel[c]));
        }
        exr::write(&folder.path().join("sky.exr"), &image).unwrap();
    }
    let path = folder.path().join("scene.xml");
    let floor = format!(
        "<shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"{half}\" y=\"{half}\"/></transform>\
         <bsdf type=\"diffuse\"/><sensor type=\"irradiancemeter\"><film type=\"hdrfilm\">\
         <integer name=\"width\" value=\"{side}\"/><integer name=\"height\" value=\"{side}\"/>\
         <rfilter type=\"box\"/></film></sensor></shape>"
    );
    let xml = format!("<scene version=\"3.0.0\">{elements}{floor}</scene>");
    std::fs::write(&path, xml).unwrap();
    mitsuba::load(&path, &[]).unwrap_or_else(|error| panic!("{error}"))
}

/// An image of radiances.
struct Sky {
    width: usize,
    texels: Vec<[f64; 3]>,
}

/// A dim sky, brighter to one side, in three colours.
fn uneven() -> Sky {
    let texel = |i: usize| {
        let (column, row) = ((i % 8) as f64, (i / 8) as f64);
        [1.0 + column, 0.5 + row, if i == 19 { 40.0 } else { 0.25 }]
    };
    Sky {
        width: 8,
        texels: (0..40).map(texel).collect(),
    }
}

/// Photons beside direct light that is known to 1 %: by default its noise would hide 15 % of the ball's light.
fn by_photons(scene: &Scene, photons: u64) -> Estimate {
    let settings = PhotonSettings {
        direct_samples: 1 << 13,
        ..PhotonSettings::default()
    };
    by_photons_with(scene, settings, photons)
}

/// The light that comes to a point of the floor from `direction`: L of the sky, split at the ball, black where
/// it comes from the floor. Written from the formulas alone.
fn followed_backwards(from: DVec3, direction: DVec3, sky: &dyn Fn(DVec3) -> Rgb) -> Rgb {
    const CENTER: DVec3 = DVec3::new(0.1, 0.0, 1.1);
    // Nothing but the floor is there: it is black, and 3 m wide each way.
    let leaves = |place: DVec3, direction: DVec3| {
        let reach = -place.z / direction.z;
        let at = place + direction * reach;
        if direction.z < 0.0 && at.x.abs() <= 3.0 && at.y.abs() <= 3.0 {
            Rgb::BLACK
        } else {
            sky(direction)
        }
    };
    let offset = from - CENTER;
    let along = -offset.dot(direction);
    let discriminant = along * along - (offset.length_squared() - 1.0);
    if discriminant <= 0.0 || along <= 0.0 {
        return leaves(from, direction);
    }
    let mut place = from + direction * (along - discriminant.sqrt());
    let normal = place - CENTER;
    let cos_i = -direction.dot(normal);
    let cos_t = (1.0 - (1.0 - cos_i * cos_i) / 2.25).sqrt();
    // Fresnel's formulas for unpolarised light.
    let s = (cos_i - 1.5 * cos_t) / (cos_i + 1.5 * cos_t);
    let p = (1.5 * cos_i - cos_t) / (1.5 * cos_i + cos_t);
    let reflected = 0.5 * (s * s + p * p);
    let mut sum = leaves(place, direction + normal * (2.0 * cos_i)) * reflected;
    let mut inside = direction / 1.5 + normal * (cos_i / 1.5 - cos_t);
    let mut rest = 1.0 - reflected;
    // As many events as photons have.
    for _ in 0..15 {
        place += inside * (2.0 * cos_t);
        let normal = (place - CENTER).normalize();
        let tangent = inside - normal * inside.dot(normal);
        let out = tangent * 1.5 + normal * cos_i;
        sum += leaves(place, out.normalize()) * (rest * (1.0 - reflected));
        rest *= reflected;
        inside -= normal * (2.0 * inside.dot(normal));
    }
    sum
}

/// E of the texels of a meter by directions with the density cos θ / π, and its standard errors.
fn backwards(half: f64, side: usize, sky: &dyn Fn(DVec3) -> Rgb) -> Vec<[(f64, f64); 3]> {
    const DIRECTIONS: u64 = 1 << 14;
    let texel = |index: usize| {
        let stream = Stream::new(StreamKind::Random, 5).split(index as u64);
        let corner = DVec2::new((index % side) as f64, (index / side) as f64);
        let mut moments = [SampleMoments::default(); 3];
        for number in 0..DIRECTIONS {
            let [u, v, s, t] = stream.point4(number);
            let uv = (corner + DVec2::new(u, v)) / side as f64;
            let place = ((uv * 2.0 - 1.0) * half).extend(0.0);
            let (r, phi) = (s.sqrt(), 2.0 * PI * t);
            let towards = DVec3::new(r * phi.cos(), r * phi.sin(), (1.0 - s).sqrt());
            let light = followed_backwards(place, towards, sky) * PI;
            for (moments, value) in moments.iter_mut().zip(light.0) {
                moments.add(value);
            }
        }
        moments.map(|it| {
            (
                it.mean().unwrap(),
                (it.variance().unwrap() / DIRECTIONS as f64).sqrt(),
            )
        })
    };
    (0..side * side).map(texel).collect()
}

/// Differences of photons and light followed backwards by their joint errors, texel by texel.
fn assert_same(found: &Estimate, expected: &[[(f64, f64); 3]]) {
    for channel in 0..3 {
        let z: Vec<f64> = (found.total.values.iter())
            .zip(&found.total.standard_error)
            .zip(expected)
            .map(|((value, error), expected)| {
                let (mean, of_mean) = expected[channel];
                (value.0[channel] - mean) / error.0[channel].hypot(of_mean)
            })
            .collect();
        let n = z.len() as f64;
        let mean = z.iter().sum::<f64>() / n;
        let square = z.iter().map(|z| z * z).sum::<f64>() / n;
        let most = z.iter().fold(0.0, |most: f64, z| most.max(z.abs()));
        // Of 32 replicates: Student's t, whose square has a mean of 31/29 and which is beyond 6 once in
        // 800,000. The mean of n has 1/√n if texels are independent; they share directions, so 3 of these
        // twice.
        assert!(most < 6.0, "{channel}: {most} {z:?}");
        assert!(mean.abs() < 6.0 / n.sqrt(), "{channel}: {mean} {z:?}");
        // 36 independent squares have a mean below 0.3 once in 60,000, and above 2.2 once in 20,000.
        assert!((0.3..2.2).contains(&square), "{channel}: {square} {z:?}");
    }
}

#[test]
fn open_floors_have_pi_l_of_even_light() {
    let scene = scene(EVEN, 1.0, 4, None);
    let found = by_photons(&scene, 1 << 10);
    for value in &found.total.values {
        // Each sample is 2 π, to the rounding of a mean of 128.
        assert!((value.0[0] - 2.0 * PI).abs() < 1e-13, "{value:?}");
    }
}

#[test]
fn open_floors_have_the_light_of_an_image_by_its_cosine() {
    let scene = scene(IMAGE, 1.0, 4, Some(&uneven()));
    let [Emitter::Envmap(map)] = scene.emitters() else {
        panic!("an image");
    };
    // The midpoint rule in cos θ and φ.
    let (rows, columns) = (400, 800);
    let mut expected = Rgb::BLACK;
    for row in 0..rows {
        let squared = (row as f64 + 0.5) / f64::from(rows);
        let (up, out) = (squared.sqrt(), (1.0 - squared).sqrt());
        for column in 0..columns {
            let phi = 2.0 * PI * (f64::from(column) + 0.5) / f64::from(columns);
            expected += map.radiance(DVec3::new(out * phi.cos(), out * phi.sin(), up));
        }
    }
    expected *= PI / f64::from(rows * columns);
    let found = by_photons(&scene, 1 << 10);
    for (value, error) in found.total.values.iter().zip(&found.total.standard_error) {
        for c in 0..3 {
            let off = (value.0[c] - expected.0[c]).abs();
            // 16 replicates, Student's t: beyond 6 once in 40,000; the rule itself is good to 1e-3.
            assert!(
                off < 6.0 * error.0[c] + 1e-3 * expected.0[c],
                "{off} {error:?} {expected:?}"
            );
            // And the error says something. Directions are drawn by luminance, of which blue is 7 %.
            assert!(error.0[c] < 0.5 * expected.0[c], "{error:?}");
        }
    }
}

#[test]
fn a_ball_in_even_light_changes_nothing_but_by_the_black_floor() {
    let scene = scene(&format!("{EVEN}{BALL}"), 3.0, 6, None);
    let found = by_photons(&scene, 1 << 20);
    assert_same(&found, &backwards(3.0, 6, &|_| Rgb::grey(2.0)));
}

#[test]
fn a_balls_light_of_an_image_is_that_of_light_followed_backwards() {
    let scene = scene(&format!("{IMAGE}{BALL}"), 3.0, 6, Some(&uneven()));
    let [Emitter::Envmap(map)] = scene.emitters() else {
        panic!("an image");
    };
    let map: &Envmap = map;
    let found = by_photons(&scene, 1 << 20);
    assert_same(
        &found,
        &backwards(3.0, 6, &|direction| map.radiance(direction)),
    );
}

#[test]
fn a_balls_light_of_a_sky_and_its_sun_is_that_of_light_followed_backwards() {
    // A sun that directions by cosine meet often enough: 4 % of the dome.
    let sky = "<emitter type=\"sunsky\"><vector name=\"sun_direction\" x=\"0.5\" y=\"0.2\" z=\"0.6\"/>\
        <float name=\"sun_aperture\" value=\"30\"/></emitter>";
    let scene = scene(&format!("{sky}{BALL}"), 3.0, 6, None);
    let [Emitter::Sunsky(daylight)] = scene.emitters() else {
        panic!("a sky");
    };
    let found = by_photons(&scene, 1 << 20);
    assert_same(
        &found,
        &backwards(3.0, 6, &|direction| daylight.radiance(direction)),
    );
}

#[test]
fn an_image_of_one_colour_is_even_light() {
    let grey = Sky {
        width: 8,
        texels: vec![[2.0; 3]; 40],
    };
    let scenes = [
        scene(&format!("{EVEN}{BALL}"), 3.0, 6, None),
        scene(&format!("{IMAGE}{BALL}"), 3.0, 6, Some(&grey)),
    ];
    // Both bound the flux of the ball's disc: 4 π · π r² L. An image bounds it cell by cell: no cell is
    // brighter than another.
    let ball = 4.0 * PI * PI * 2.0;
    for scene in &scenes {
        let flux = LightSpace::new(scene).unwrap().flux_bound().0[0];
        // Photons aim at the ball itself, of radius 1, not at the one about its bounds.
        assert!((flux / ball - 1.0).abs() < 1e-8, "{flux} {ball}");
    }
    let found = scenes.map(|scene| by_photons(&scene, 1 << 20));
    let expected: Vec<[(f64, f64); 3]> = found[1]
        .total
        .values
        .iter()
        .zip(&found[1].total.standard_error)
        .map(|(value, error)| std::array::from_fn(|c| (value.0[c], error.0[c])))
        .collect();
    assert_same(&found[0], &expected);
}

#[test]
fn a_sun_in_an_image_gets_cells_of_its_own() {
    let mut sun = Sky {
        width: 256,
        texels: vec![[1.0; 3]; 256 * 129],
    };
    // Of all light 10⁶ / (10⁶ + 256 · 128) is in one texel of four square ones.
    sun.texels[40 * 256 + 77] = [1e6; 3];
    let scene = scene(&format!("{IMAGE}{BALL}"), 3.0, 6, Some(&sun));
    let light = LightSpace::new(&scene).unwrap();
    let (mut of_sun, mut waste) = (0.0, 0.0);
    for (index, cell) in light.cells().iter().enumerate() {
        let size = cell.patch().to - cell.patch().from;
        let middle = 0.5 * (cell.patch().to + cell.patch().from);
        let is_near = (middle - DVec2::new(77.0, 40.0)).abs().max_element() < 1.0;
        if is_near {
            of_sun += light.share(index);
        } else {
            waste += light.share(index);
        }
        // No cell with more than its share is wider than a texel.
        assert!(size.max_element() <= 1.0 || light.share(index) < 2.0 / 2048.0);
    }
    assert!(of_sun > 0.9, "{of_sun} {waste}");
}

#[test]
fn environments_give_the_same_bits_on_any_number_of_threads() {
    let scene = scene(&format!("{IMAGE}{BALL}"), 3.0, 6, Some(&uneven()));
    paths::assert_same_on_threads(&[2, 5], || by_photons(&scene, 1 << 16));
}

#[test]
fn a_lossless_ball_changes_nothing_where_the_meter_is_too_small_to_darken_it() {
    // The ball shows the meter its own black image, a fortieth of its distance across, by 4 % of the light, so
    // that it hides less than 1e-4 of it.
    let ball = "<shape type=\"sphere\"><point name=\"center\" x=\"0\" y=\"0\" z=\"20\"/><float name=\"radius\" value=\"10\"/>\
        <bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1\"/></bsdf></shape>";
    let found = by_photons(&scene(&format!("{EVEN}{ball}"), 1.0, 2, None), 1 << 22);
    let (direct, all) = (&found.layers[0], 2.0 * PI);
    for texel in 0..4 {
        let value = found.total.values[texel].0[0];
        let error = found.total.standard_error[texel].0[0];
        println!("{value} ± {error} for {all}");
        assert!((value - all).abs() < 6.0 * error + 1e-4 * all);
        // At twice its radius a ball hides a quarter, which its own light must bring back.
        assert!(error < 0.02 * all, "{error} says little");
        assert!((direct.values[texel].0[0] - 0.75 * all).abs() < 0.05 * all);
    }
}

#[test]
fn the_middle_of_a_glass_ball_sees_light_by_the_square_of_its_index() {
    const INDEX: f64 = 1.5;
    let ball = "<shape type=\"sphere\"><float name=\"radius\" value=\"8\"/>\
        <bsdf type=\"dielectric\"><float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1\"/></bsdf></shape>";
    let found = by_photons(&scene(&format!("{EVEN}{ball}"), 1.0, 2, None), 1 << 22);
    // From inside, the ball mirrors the meter onto the meter, which is black: R = ((n − 1)/(n + 1))² of its
    // light is lost, up to the aberration, by 1/8² of R twice over.
    let reflected = ((INDEX - 1.0) / (INDEX + 1.0)).powi(2);
    let expected = PI * INDEX * INDEX * 2.0 * (1.0 - reflected);
    for (value, error) in found.total.values.iter().zip(&found.total.standard_error) {
        println!("{} ± {} for {expected}", value.0[0], error.0[0]);
        let off = (value.0[0] - expected).abs();
        assert!(off < 6.0 * error.0[0] + reflected / 32.0 * expected);
        // That 128 samples see no sky straight on leaves 7.6/128 of 2 π, with a standard error of 0.8 % of all.
        assert!(error.0[0] < 0.015 * expected, "{error:?} says little");
    }
    // Glass lets no light pass straight on.
    assert!(found.layers[0].values.iter().all(|it| it.is_black()));
}

#[test]
fn photons_aim_at_a_ball_that_holds_all_balls_and_boxes() {
    let cube = "<shape type=\"cube\"><transform name=\"to_world\"><translate x=\"-3\" y=\"0\" z=\"1.1\"/></transform>\
        <bsdf type=\"conductor\"/></shape>";
    let both = scene(&format!("{EVEN}{BALL}{cube}"), 3.0, 2, None);
    let light = LightSpace::new(&both).unwrap();
    // Bounds from -4 to 1.1 in x: the middle is at -1.45. The cube's corners are the farthest, at 2.55 and 1, 1.
    let squared = 2.55 * 2.55 + 2.0;
    let flux = light.flux_bound().0[0] / (4.0 * PI * PI * squared * 2.0);
    assert!((flux - 1.0).abs() < 1e-8, "{flux}");
    // And nothing that meets either is lost: the flux that misses the ball would be.
    let stream = Stream::new(StreamKind::Random, 9);
    for chart in light.charts() {
        let root = light.root(chart);
        for number in 0..1000 {
            let [u, v, s, t] = stream.point4(number);
            let ray = chart.emit(&root, DVec2::new(u, v), DVec2::new(s, t)).ray;
            let to = DVec3::new(-1.45, 0.0, 1.1) - ray.origin;
            let off = (to - ray.direction * to.dot(ray.direction)).length_squared();
            assert!(off < squared * (1.0 + 1e-8), "{off}");
            // It starts before all geometry.
            assert!(to.dot(ray.direction) > squared.sqrt());
        }
    }
}

#[test]
fn light_starts_evenly_on_the_disc_that_the_ball_shows() {
    const RAYS: u64 = 4096;
    let scene = scene(&format!("{EVEN}{BALL}"), 3.0, 6, None);
    let light = LightSpace::new(&scene).unwrap();
    let chart = &light.charts()[0];
    let stream = Stream::new(StreamKind::Sobol, 3);
    let mut sum = 0.0;
    for number in 0..RAYS {
        let [x, y, u, v] = stream.point4(number);
        let ray = chart
            .emit(&light.root(chart), DVec2::new(x, y), DVec2::new(u, v))
            .ray;
        let offset = ray.origin - DVec3::new(0.1, 0.0, 1.1);
        sum += offset.length_squared() - offset.dot(ray.direction).powi(2);
    }
    // Squares of distances from the middle are uniform in 0..=1: their mean is 1/2 and their variance 1/12.
    // Scrambled points have at most e times the variance of random ones; six errors.
    let error = (std::f64::consts::E / 12.0 / RAYS as f64).sqrt();
    let mean = sum / RAYS as f64;
    assert!((mean - 0.5).abs() < 6.0 * error, "{mean}");
}

/// A small ball of radius `radius`, black, at height 1.
fn small_ball(radius: f64) -> String {
    format!(
        "<shape type=\"sphere\"><point name=\"center\" x=\"0\" y=\"0\" z=\"1\"/><float name=\"radius\" value=\"{radius}\"/>\
         <bsdf type=\"diffuse\"/></shape>"
    )
}

/// E of a texel of 16² of a floor of half width 1/2 below it, in a sky of radiance 2: 2 π (1 − R² cos θ / d²), by
/// the midpoint rule.
fn below_small_ball(radius: f64, index: usize) -> f64 {
    let mut sum = 0.0;
    for step in 0..16 {
        let at = DVec2::new(f64::from(step % 4) + 0.5, f64::from(step / 4) + 0.5) / 4.0;
        let corner = DVec2::new((index % 16) as f64, (index / 16) as f64);
        let place = (corner + at) / 16.0 - 0.5;
        let squared = place.length_squared() + 1.0;
        sum += radius * radius / squared.powf(1.5) / 16.0;
    }
    2.0 * PI * (1.0 - sum)
}

#[test]
fn a_small_thing_below_the_sky_is_within_the_bounds_of_texels_that_did_not_see_it() {
    for radius in [0.05, 0.01] {
        let scene = scene(&format!("{EVEN}{}", small_ball(radius)), 0.5, 16, None);
        let found = by_photons(&scene, 1 << 10);
        let direct = &found.layers[0];
        let missed = (0..256)
            .filter(|&index| {
                let off = direct.values[index].0[0] - below_small_ball(radius, index);
                off.abs() > 3.29 * direct.standard_error[index].0[0]
            })
            .count();
        // Bounds of 99.9 %, of texels that are independent: more than 3 of 256 once in 10,000.
        assert!(missed <= 3, "{radius}: {missed}");
    }
}

#[test]
fn more_samples_of_a_sky_have_no_bias() {
    let scene = scene(&format!("{EVEN}{}", small_ball(0.05)), 0.5, 16, None);
    let settings = PhotonSettings {
        direct_samples: 1 << 12,
        ..PhotonSettings::default()
    };
    let found = by_photons_with(&scene, settings, 1 << 10);
    let direct = &found.layers[0];
    let off: f64 = (0..256)
        .map(|index| direct.values[index].0[0] - below_small_ball(0.05, index))
        .sum();
    let squares: f64 = direct.standard_error.iter().map(|it| it.0[0].powi(2)).sum();
    assert!(off.abs() < 4.0 * squares.sqrt(), "{off} {}", squares.sqrt());
    // 0.25 % of the sky is hidden, which the mean of all must show.
    assert!(squares.sqrt() / 256.0 < 2e-4 * 2.0 * PI, "{squares}");
}

#[test]
fn a_sun_at_the_zenith_is_not_lost() {
    let row = |index: usize| if index / 256 == 0 { 1e6 } else { 1.0 };
    let sky = Sky {
        width: 256,
        texels: (0..256 * 129).map(|index| [row(index); 3]).collect(),
    };
    // The pole, +y of the image, is overhead.
    let image = IMAGE.replace("77", "90");
    let found = by_photons(&scene(&image, 1.0, 6, Some(&sky)), 1 << 10);
    // L falls in a line to the first row, δ = π / 128 from the pole: E = ∫ L cos θ dω by the midpoint rule.
    let (delta, steps) = (PI / 128.0, 4096);
    let mut expected = PI * (delta.cos() * delta.cos());
    for step in 0..steps {
        let theta = delta * (f64::from(step) + 0.5) / f64::from(steps);
        let light = 1e6 + (1.0 - 1e6) * theta / delta;
        expected += 2.0 * PI * light * theta.sin() * theta.cos() * delta / f64::from(steps);
    }
    for (value, error) in found.total.values.iter().zip(&found.total.standard_error) {
        let off = (value.0[0] - expected).abs();
        // 16 replicates, Student's t: beyond 6 once in 40,000.
        assert!(off < 6.0 * error.0[0], "{value:?} {error:?} {expected}");
        // Some 64 samples are of the sun, each of which is off by 0.7 of it.
        assert!(error.0[0] < 0.25 * expected, "{error:?} of {expected}");
    }
}

#[test]
fn a_dim_sky_takes_no_photons_from_a_lamp() {
    let lamp =
        "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"30\"/></emitter>";
    let dim = "<emitter type=\"constant\"><rgb name=\"radiance\" value=\"1e-9\"/></emitter>";
    let flux = |lights: &str| {
        let scene = scene(&format!("{lights}{BALL}"), 3.0, 6, None);
        LightSpace::new(&scene).unwrap().flux_bound().0[0]
    };
    // Cells of the lamp follow the ball's outline as without the sky, whose flux is 4 π² r² L.
    let (alone, both) = (flux(lamp), flux(&format!("{lamp}{dim}")));
    let sky = 4.0 * PI * PI * 1e-9;
    assert!((both - alone - sky).abs() < 1e-9 * alone, "{alone} {both}");
}
