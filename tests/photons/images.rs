//! Points that shine through an image: projectors and spots, against closed forms.

use std::f64::consts::PI;

use glam::DVec2;
use nephroid::internals::film::{Image, exr};
use nephroid::internals::mitsuba;
use nephroid::internals::numeric::{Stream, StreamKind};
use nephroid::internals::run::{Budget, Estimate};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::domain::LightSpace;
use tempfile::TempDir;

use super::metered::by_photons;
use crate::support::paths;

/// Height \[m\] of the lights above the floor.
const HEIGHT: f64 = 2.0;

/// Columns and rows of the images, and of the meter.
const SIZE: [usize; 2] = [4, 3];

/// The image's values: no two texels, and no two colours, are alike.
fn texel(column: usize, row: usize) -> [f64; 3] {
    let index = (row * SIZE[0] + column) as f64;
    [1.0 + index, 2.0 + 0.5 * index, 9.0 - 0.25 * index]
}

/// A scene of elements, in which `picture.exr` is an image of such texels.
fn scene(elements: &str, size: [usize; 2], texel: impl Fn(usize, usize) -> [f64; 3]) -> Scene {
    let folder = TempDir::new().unwrap();
    let mut image = Image::new(size[0], size[1]);
    let texels: Vec<[f64; 3]> = (0..size[0] * size[1])
        .map(|index| texel(index % size[0], index / size[0]))
        .collect();
    for (c, name) in ["R", "G", "B"].into_iter().enumerate() {
        image.add_scalar(name, texels.iter().map(|texel| texel[c]));
    }
    exr::write(&folder.path().join("picture.exr"), &image).unwrap();
    let path = folder.path().join("scene.xml");
    std::fs::write(
        &path,
        format!("<scene version=\"3.0.0\">{elements}</scene>"),
    )
    .unwrap();
    mitsuba::load(&path, &[]).unwrap_or_else(|error| panic!("{error}"))
}

fn picture(name: &str) -> String {
    format!(
        "<texture name=\"{name}\" type=\"bitmap\"><string name=\"filename\" value=\"picture.exr\"/>\
         <string name=\"filter_type\" value=\"nearest\"/><boolean name=\"raw\" value=\"true\"/></texture>"
    )
}

/// Looks straight down; +x of its frame is -x of the world, so that the first column falls on the left.
fn down() -> String {
    format!(
        "<transform name=\"to_world\"><rotate y=\"1\" angle=\"180\"/><translate z=\"{HEIGHT}\"/></transform>"
    )
}

/// A projector whose image covers a floor of half width 1.
fn projector(scale: f64) -> String {
    let fov = 2.0 * (1.0 / HEIGHT).atan().to_degrees();
    format!(
        "<emitter type=\"projector\">{}{}<float name=\"scale\" value=\"{scale}\"/><float name=\"fov\" value=\"{fov}\"/></emitter>",
        down(),
        picture("irradiance")
    )
}

/// A floor of half width 1 and as wide for its length as the image, with a meter of its texels.
fn floor() -> String {
    let half = SIZE[1] as f64 / SIZE[0] as f64;
    format!(
        "<shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"1\" y=\"{half}\"/></transform>\
         <bsdf type=\"diffuse\"/><sensor type=\"irradiancemeter\"><film type=\"hdrfilm\">\
         <integer name=\"width\" value=\"{}\"/><integer name=\"height\" value=\"{}\"/>\
         <rfilter type=\"box\"/></film></sensor></shape>",
        SIZE[0], SIZE[1]
    )
}

const THIN: &str = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale x=\"3\" y=\"3\"/><translate z=\"1\"/></transform>\
    <bsdf type=\"thindielectric\"><float name=\"int_ior\" value=\"1.5\"/><float name=\"ext_ior\" value=\"1\"/></bsdf></shape>";

/// The image's texel that falls on a place of the floor: its first column on the left, its first row at +y.
fn falls_on(place: DVec2) -> [f64; 3] {
    let half = SIZE[1] as f64 / SIZE[0] as f64;
    let along = |at: f64, count: usize| ((at * count as f64) as usize).min(count - 1);
    let column = along(0.5 * (place.x + 1.0), SIZE[0]);
    let row = along(0.5 * (1.0 - place.y / half), SIZE[1]);
    texel(column, row)
}

/// The mean over a texel of the meter, by the midpoint rule.
fn mean(index: usize, value: &dyn Fn(DVec2) -> [f64; 3]) -> [f64; 3] {
    const STEPS: usize = 512;
    let half = SIZE[1] as f64 / SIZE[0] as f64;
    let corner = DVec2::new((index % SIZE[0]) as f64, (index / SIZE[0]) as f64);
    let size = DVec2::new(SIZE[0] as f64, SIZE[1] as f64);
    let mut sum = [0.0; 3];
    for step in 0..STEPS * STEPS {
        let at = DVec2::new((step % STEPS) as f64 + 0.5, (step / STEPS) as f64 + 0.5);
        let uv = (corner + at / STEPS as f64) / size;
        let place = (uv * 2.0 - 1.0) * DVec2::new(1.0, half);
        for (sum, value) in sum.iter_mut().zip(value(place)) {
            *sum += value / (STEPS * STEPS) as f64;
        }
    }
    sum
}

/// Power of a thin pane to let unpolarised light through: 1 − 2 R / (1 + R), Fresnel's R of one side.
fn through_the_pane(cos_i: f64) -> f64 {
    let cos_t = (1.0 - (1.0 - cos_i * cos_i) / 2.25).sqrt();
    let s = (cos_i - 1.5 * cos_t) / (cos_i + 1.5 * cos_t);
    let p = (1.5 * cos_i - cos_t) / (1.5 * cos_i + cos_t);
    let reflected = 0.5 * (s * s + p * p);
    1.0 - 2.0 * reflected / (1.0 + reflected)
}

/// Each value within six standard errors of what is expected, which is known to `rule`; errors below a part of it.
fn assert_near(found: &Estimate, expected: &dyn Fn(usize) -> [f64; 3], rule: f64, most: f64) {
    let layer = &found.total;
    let all = layer.values.iter().zip(&layer.standard_error).enumerate();
    for (index, (value, error)) in all {
        let expected = expected(index);
        for c in 0..3 {
            let off = (value.0[c] - expected[c]).abs();
            // 16 or 32 replicates: Student's t of 15 degrees is beyond 6 once in 40,000.
            assert!(
                off <= 6.0 * error.0[c] + rule * expected[c],
                "{index}, {c}: {} for {expected:?}, error {error:?}",
                value.0[c]
            );
            assert!(
                error.0[c] <= most * expected[c],
                "{index}, {c}: {error:?} says little"
            );
        }
    }
}

#[test]
fn a_projector_throws_its_image_as_irradiance() {
    // On a plane across the axis all of a texel has π s T / h²: 1/cos³ θ of the intensity takes out what distance
    // and slant take away.
    let found = by_photons(
        &scene(&format!("{}{}", projector(2.0), floor()), SIZE, texel),
        1 << 10,
    );
    let factor = 2.0 * PI / (HEIGHT * HEIGHT);
    let expected = |index: usize| mean(index, &|place| falls_on(place).map(|it| it * factor));
    // Replicates differ by rounding, 1e-16 of their squares.
    assert_near(&found, &expected, 1e-9, 1e-7);
}

#[test]
fn a_projectors_photons_pass_a_thin_pane_as_fresnel_says() {
    let scene = scene(&format!("{}{THIN}{}", projector(2.0), floor()), SIZE, texel);
    let found = by_photons(&scene, 1 << 18);
    let factor = 2.0 * PI / (HEIGHT * HEIGHT);
    let expected = |index: usize| {
        mean(index, &|place| {
            let cos = HEIGHT / (place.length_squared() + HEIGHT * HEIGHT).sqrt();
            falls_on(place).map(|it| it * factor * through_the_pane(cos))
        })
    };
    // The midpoint rule's h²/24 of light that bends by less than itself.
    assert_near(&found, &expected, 1e-6, 1e-2);
    // All of it by photons.
    assert!(found.layers[0].values.iter().all(|it| it.is_black()));
}

/// A spot above the floor that shines through the picture, and its light on a place.
fn spot() -> (String, impl Fn(DVec2) -> [f64; 3]) {
    let cutoff: f64 = 40.0;
    let element = format!(
        "<emitter type=\"spot\">{}{}<rgb name=\"intensity\" value=\"1, 2, 3\"/><float name=\"cutoff_angle\" value=\"{cutoff}\"/>\
         <float name=\"beam_width\" value=\"10\"/></emitter>",
        down(),
        picture("texture")
    );
    let light = move |place: DVec2| {
        let squared = place.length_squared() + HEIGHT * HEIGHT;
        let cos = HEIGHT / squared.sqrt();
        let falloff = ((cutoff - cos.acos().to_degrees()) / (cutoff - 10.0)).clamp(0.0, 1.0);
        // (u, v) is 1/2 + d.xy / (2 d.z tan cutoff) in its frame, which has the world's x turned round.
        let reach = HEIGHT * cutoff.to_radians().tan();
        let uv = DVec2::new(-place.x, place.y) / (2.0 * reach) + 0.5;
        let at = |at: f64, count: usize| ((at * count as f64) as usize).min(count - 1);
        let [r, g, b] = texel(at(uv.x, SIZE[0]), at(uv.y, SIZE[1]));
        [r, 2.0 * g, 3.0 * b].map(|it| it * falloff * cos / squared)
    };
    (element, light)
}

#[test]
fn a_spot_shines_through_its_image_directly_and_by_photons() {
    let (element, light) = spot();
    let open = scene(&format!("{element}{}", floor()), SIZE, texel);
    let direct = by_photons(&open, 1 << 10);
    // The rule misplaces jumps between the image's texels by half of 1/512 of a meter's texel at most, and no texel
    // has three times its neighbour's light.
    assert_near(&direct, &|index| mean(index, &light), 2e-3, 0.2);
    let below_pane = scene(&format!("{element}{THIN}{}", floor()), SIZE, texel);
    let found = by_photons(&below_pane, 1 << 18);
    let expected = |index: usize| {
        mean(index, &|place| {
            let cos = HEIGHT / (place.length_squared() + HEIGHT * HEIGHT).sqrt();
            light(place).map(|it| it * through_the_pane(cos))
        })
    };
    assert_near(&found, &expected, 2e-3, 2e-2);
}

#[test]
fn a_bright_texel_gets_the_photons() {
    // One texel of 64² has 10⁶ / (10⁶ + 4095) of the light.
    let sun = |column: usize, row: usize| [if (column, row) == (40, 21) { 1e6 } else { 1.0 }; 3];
    let scene = scene(
        &format!("{}{THIN}{}", projector(1.0), floor()),
        [64, 64],
        sun,
    );
    let light = LightSpace::new(&scene).unwrap();
    let chart = &light.charts()[0];
    let middle = |index: usize| {
        let patch = light.cells()[index].patch();
        chart.emit(patch, DVec2::splat(0.5), DVec2::ZERO)
    };
    let of_sun: f64 = (0..light.cells().len())
        .filter(|&index| middle(index).color.is_some_and(|it| it.0[0] > 1e5))
        .map(|index| light.share(index))
        .sum();
    // Cells that only touch it have its bound, too: no more than half of all.
    assert!(of_sun > 0.5, "{of_sun}");
    // The bound holds, so that no light is lost: the mean of emission by each cell is below its bound.
    let stream = Stream::new(StreamKind::Sobol, 3);
    for cell in light.cells() {
        let bound = chart.flux_bound(cell.patch()).0[0];
        for number in 0..16 {
            let [x, y, ..] = stream.point4(number);
            let one = chart.emit(cell.patch(), DVec2::new(x, y), DVec2::ZERO);
            let flux = one.color.unwrap().0[0] * one.measure * PI;
            assert!(flux <= bound * (1.0 + 1e-12), "{flux} {bound}");
        }
    }
}

#[test]
fn images_give_the_same_bits_on_any_number_of_threads() {
    let (element, _) = spot();
    let scene = scene(
        &format!("{element}{}{THIN}{}", projector(2.0), floor()),
        SIZE,
        texel,
    );
    paths::assert_same_on_threads(&[2, 5], || by_photons(&scene, 1 << 14));
}

#[test]
fn methods_that_cannot_start_at_images_say_so() {
    // Beside a lamp that they take, too.
    let lamp =
        "<emitter type=\"point\"><point name=\"position\" x=\"0\" y=\"0\" z=\"2\"/></emitter>";
    for lights in [
        projector(2.0),
        spot().0,
        format!("{lamp}{}", projector(2.0)),
    ] {
        let scene = scene(&format!("{lights}{THIN}{}", floor()), SIZE, texel);
        for name in [
            "beams",
            "caustic-map",
            "caustics-volume",
            "local-irradiance",
        ] {
            let method = nephroid::Method::new(name, &Default::default()).unwrap();
            let result = method.run(
                &scene,
                &scene.sensors()[0],
                &Budget::default(),
                &Default::default(),
            );
            let message = result.map(|_| ()).unwrap_err().to_string();
            assert!(message.contains("throws an image"), "{name}: {message}");
        }
    }
}
