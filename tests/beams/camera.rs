//! Beams on a camera: the image is the receiver's map seen through the camera, and that of photons.

use std::sync::OnceLock;

use glam::DVec2;

use nephroid::internals::numeric::{Stream, StreamKind};
use nephroid::internals::run::{Estimate, Quantity};
use nephroid::internals::scene::{Scene, Sensor};
use nephroid::internals::transport::camera::Camera;
use nephroid::internals::transport::first_surface::{Source, patches};
use nephroid::internals::transport::fixed_signature::PathFollower;
use nephroid::internals::transport::path_end::End;
use nephroid::internals::transport::scatter::ShadingNormals;
use nephroid::internals::transport::screen::Screen;
use nephroid::internals::transport::signature::Signature;

use crate::support;
use crate::support::seen::{self, FloorView, Map, with_films};

const WIDTH: usize = 80;
const HEIGHT: usize = 60;
const TEXELS: usize = 512;
/// Half the side of the floor.
const FLOOR: f64 = 2.0;
const ALBEDO: f64 = 0.8;

/// glass-ball with a small camera and a fine floor.
fn scene() -> &'static Scene {
    static SCENE: OnceLock<Scene> = OnceLock::new();
    let file = support::bundled_file("glass-ball");
    SCENE.get_or_init(|| with_films(&file, [WIDTH, HEIGHT], TEXELS))
}

fn sensor(id: &str) -> &'static Sensor {
    support::seen::sensor(scene(), id)
}

/// The scene by beams.
fn by_beams(id: &str) -> Estimate {
    let (estimate, report) = seen::by_beams(scene(), id, 1e-4);
    for one in report.signatures.iter().filter(|_| id == "camera") {
        // Some hundred thousand roundings of numbers up to 1, of either sign.
        assert!(one.balance_error < 1e-12, "{one:?}");
    }
    estimate
}

fn camera_image() -> &'static Estimate {
    static IMAGE: OnceLock<Estimate> = OnceLock::new();
    IMAGE.get_or_init(|| by_beams("camera"))
}

#[test]
fn a_cameras_image_is_the_floors_irradiance_times_albedo_by_pi() {
    let image = camera_image();
    assert_eq!(image.quantity, Quantity::Radiance);
    let (image, floor) = (Map::of(image), Map::of(&by_beams("floor")));
    let camera = Camera::new(scene(), sensor("camera")).unwrap();
    let view = FloorView {
        scene: scene(),
        camera: &camera,
        floor: "floor-surface",
        half_side: FLOOR,
        map: &floor,
    };
    let (mut compared, mut sum, mut tolerances) = (0, 0.0, 0.0);
    for pixel in 0..WIDTH * HEIGHT {
        let corner = DVec2::new((pixel % WIDTH) as f64, (pixel / WIDTH) as f64);
        let Some((value, error)) = view.average(corner) else {
            continue;
        };
        let factor = ALBEDO / std::f64::consts::PI;
        let difference = (image.value[pixel] - factor * value).abs();
        let tolerance = factor * error + image.bar[pixel];
        assert!(
            difference <= tolerance,
            "pixel {corner}: {} by beams, {} seen, allowed {tolerance}",
            image.value[pixel],
            factor * value
        );
        compared += 1;
        sum += factor * value;
        tolerances += tolerance;
    }
    // Not all were too rough to say anything.
    assert!(compared > 500, "{compared} pixels compared");
    println!(
        "{compared} pixels within a mean tolerance of {:.2e}",
        tolerances / sum
    );
    assert!(tolerances < 0.03 * sum, "{:e}", tolerances / sum);
}

#[test]
fn a_cameras_image_is_that_of_photons_connected_to_it() {
    // Bins of 8 x 6 pixels: with enough photons each for a normal sum.
    const BIN: [usize; 2] = [8, 6];
    const BINS: usize = (WIDTH / BIN[0]) * (HEIGHT / BIN[1]);
    const PHOTONS: u64 = 3000;
    let bin = |x: usize, y: usize| y / BIN[1] * (WIDTH / BIN[0]) + x / BIN[0];
    let image = Map::of(camera_image());
    let mut beams = [(0.0, 0.0); BINS];
    for pixel in 0..WIDTH * HEIGHT {
        let sum = &mut beams[bin(pixel % WIDTH, pixel / WIDTH)];
        sum.0 += image.value[pixel];
        sum.1 += image.bar[pixel];
    }
    let camera = Camera::new(scene(), sensor("camera")).unwrap();
    let screen = Screen::Camera {
        camera: &camera,
        etendue: 1.0,
    };
    let source = Source::all(scene())[0];
    let mut follower = PathFollower::<1>::new(
        scene(),
        &source,
        &screen,
        Signature::DIRECT,
        ShadingNormals::Flux,
    );
    let stream = Stream::new(StreamKind::Random, 5);
    let mut sums = [(0.0, 0.0); BINS];
    for (index, patch) in patches(scene(), &source).iter().enumerate() {
        // Each patch is a stratum; the photons in it are independent.
        let stream = stream.split(index as u64);
        let [a, b, c] = patch.corners;
        let area = 0.5 * (b - a).perp_dot(c - a).abs();
        let mut stratum = [(0.0, 0.0); BINS];
        for photon in 0..PHOTONS {
            let mut place: DVec2 = stream.point2(photon).into();
            if place.x + place.y > 1.0 {
                place = DVec2::ONE - place;
            }
            let at = a + (b - a) * place.x + (c - a) * place.y;
            let mut found = Vec::new();
            follower.follow_some(
                &patch.chart,
                at,
                [16; 2],
                1e-9,
                &mut |_| 0.0,
                &mut |_, _, path, _| {
                    if let End::Landed(at) = path.end
                        && camera.pixel(at).is_some()
                    {
                        let radiance = path.throughput.0[0] * path.emitted * area;
                        found.push((bin(at.x as usize, at.y as usize), radiance));
                    }
                },
            );
            // All of a photon's branches into a bin are one sample.
            found.sort_by_key(|(bin, _)| *bin);
            for branches in found.chunk_by(|a, b| a.0 == b.0) {
                let radiance: f64 = branches.iter().map(|(_, radiance)| radiance).sum();
                let sum = &mut stratum[branches[0].0];
                sum.0 += radiance;
                sum.1 += radiance * radiance;
            }
        }
        let count = PHOTONS as f64;
        for (sum, (value, square)) in sums.iter_mut().zip(stratum) {
            sum.0 += value / count;
            sum.1 += (square - value * value / count) / (count * (count - 1.0));
        }
    }
    let mut compared = 0;
    let (mut all, mut variance, mut by_beams, mut bar) = (0.0, 0.0, 0.0, 0.0);
    for (index, ((beams, of_bar), (photons, squared_error))) in beams.iter().zip(sums).enumerate() {
        all += photons;
        variance += squared_error;
        by_beams += beams;
        bar += of_bar;
        let error = squared_error.sqrt();
        // Rarer light is no normal sum.
        if photons == 0.0 || error > 0.03 * photons {
            continue;
        }
        compared += 1;
        // Of a hundred normal numbers the largest is beyond 5 with a chance of 6e-5.
        assert!(
            (beams - photons).abs() <= 5.0 * error + of_bar,
            "bin {index}: {beams} by beams, {photons} ± {error} by photons"
        );
    }
    assert!(compared >= 40, "{compared} bins compared");
    // Nothing is lost on the whole, not in dim or rough pixels either.
    assert!(
        (by_beams - all).abs() <= 5.0 * variance.sqrt() + bar,
        "{by_beams} ± {bar} by beams, {all} ± {} by photons",
        variance.sqrt()
    );
    println!(
        "{compared} bins; in all {by_beams} ± {bar:.1e} by beams, {all} ± {:.1e} by photons",
        variance.sqrt()
    );
}

#[test]
fn radiance_lies_within_its_bounds() {
    let image = camera_image();
    for layer in std::iter::once(&image.total).chain(&image.layers) {
        let bounds = layer.interval.as_ref().unwrap();
        for (pixel, value) in layer.values.iter().enumerate() {
            for channel in 0..3 {
                let (low, high) = (bounds.low[pixel].0[channel], bounds.high[pixel].0[channel]);
                assert!(
                    0.0 <= low && (low..=high).contains(&value.0[channel]),
                    "{} pixel {pixel}: {value:?} outside {low}..{high}",
                    layer.name
                );
            }
        }
    }
}
