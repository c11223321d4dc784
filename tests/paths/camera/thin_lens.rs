//! Cameras with a thin lens.

use glam::{DVec2, DVec3};
use nephroid::internals::numeric::quadrature::GaussLegendre;
use nephroid::internals::transport::camera::Camera;

use super::views::{LOOK, MitsubaRay, perspective, scene, sensor};

/// A thin lens of some size.
fn thin_lens() -> String {
    let parameters = "<float name=\"fov\" value=\"35\"/><float name=\"aperture_radius\" value=\"0.3\"/>\
        <float name=\"focus_distance\" value=\"4\"/>";
    sensor("thinlens", parameters, LOOK)
}

fn lens_camera() -> Camera {
    Camera::of_sensor(&scene(&thin_lens()).sensors()[0]).unwrap()
}

/// Film coordinates of the crop, a point of the lens, a ray and its length.
type LensRay = ((f64, f64), (f64, f64), MitsubaRay, f64);

/// Film coordinates of the crop, points of the lens, and what `sensor.sample_ray` of Mitsuba 3.9.1
/// (`scalar_rgb`) makes of them: origin, direction and `maxt`.
const LENS_RAYS: [LensRay; 3] = [
    (
        (0.0, 0.0),
        (0.5, 0.5),
        (
            [0.995_522_56, -4.991_010_2, 1.997_327],
            [-0.430_828_3, 0.865_004_3, -0.257_205_4],
        ),
        10_392.694,
    ),
    (
        (37.0, 11.0),
        (0.9, 0.2),
        (
            [0.811_806_74, -5.077_496_5, 1.872_969_3],
            [-0.205_714_5, 0.934_934_7, -0.289_099_7],
        ),
        10_034.135,
    ),
    (
        (100.0, 50.0),
        (0.25, 0.75),
        (
            [1.097_033_4, -4.932_288_6, 2.093_376],
            [0.059_641, 0.855_694_8, -0.514_032_6],
        ),
        10_438.968,
    ),
];

#[test]
fn rays_through_a_thin_lens_are_mitsubas() {
    let camera = lens_camera();
    for (at, lens, (origin, direction), reach) in LENS_RAYS {
        let view = camera.ray_through(DVec2::from(at), DVec2::from(lens));
        // As above: f32, coordinates up to 5, a few operations.
        assert!(
            view.ray.origin.abs_diff_eq(DVec3::from(origin), 1.2e-6),
            "{view:?}"
        );
        assert!(
            view.ray
                .direction
                .abs_diff_eq(DVec3::from(direction), 1.2e-6),
            "{view:?}"
        );
        assert!((view.reach / reach - 1.0).abs() < 1.2e-6, "{view:?}");
    }
}

#[test]
fn a_thin_lens_is_sharp_where_it_is_in_focus_and_a_pinhole_in_its_middle() {
    let (camera, axis) = (lens_camera(), DVec3::new(-1.0, 5.0, -2.0).normalize());
    let pinhole = scene(&perspective("<float name=\"fov\" value=\"35\"/>"));
    let pinhole = Camera::of_sensor(&pinhole.sensors()[0]).unwrap();
    let eye = DVec3::new(1.0, -5.0, 2.0);
    for at in [(0.0, 0.0), (37.0, 11.0), (99.0, 50.0)].map(DVec2::from) {
        assert_eq!(camera.pixel_ray(at), pinhole.pixel_ray(at));
        let sharp = |lens: DVec2| {
            let ray = camera.ray_through(at, lens).ray;
            ray.at((4.0 - (ray.origin - eye).dot(axis)) / ray.direction.dot(axis))
        };
        let middle = sharp(DVec2::splat(0.5));
        for lens in [(0.0, 0.0), (0.9, 0.2), (0.3, 0.99)].map(DVec2::from) {
            // A few dozen roundings of numbers up to 5.
            assert!(sharp(lens).abs_diff_eq(middle, 1e-13), "{at} {lens}");
            let view = camera.ray_through(at, lens);
            let near = view.ray.origin - eye - axis * (view.ray.origin - eye).dot(axis);
            assert!(
                near.length() <= 0.3 + 0.01,
                "the lens has a radius of 0.3: {}",
                near.length()
            );
            for distance in [0.1, 3.0, 40.0] {
                let seen = camera.project_through(view.ray.at(distance), lens).unwrap();
                // As for pinholes; 1 / distance magnifies what is rounded near the lens.
                assert!(
                    seen.at.abs_diff_eq(at, 1e-10 / distance),
                    "{} for {at}",
                    seen.at
                );
                assert!((seen.distance / distance - 1.0).abs() < 1e-10 / distance);
                assert!(
                    seen.towards
                        .abs_diff_eq(-view.ray.direction, 1e-12 / distance)
                );
            }
        }
    }
}

#[test]
fn a_pixels_importance_through_a_lens_is_one_wherever_the_surface_is() {
    // Radiance 1 everywhere is radiance 1 in the pixel: ∫ W cos dA = 1 over its footprint, for any point of
    // the lens.
    let camera = lens_camera();
    let rule = GaussLegendre::new(8).unwrap();
    let normal = DVec3::new(0.3, -0.8, 0.4).normalize();
    for lens in [(0.5, 0.5), (0.1, 0.8)].map(DVec2::from) {
        for height in [-1.0, -4.0] {
            let met = |at: DVec2| {
                let ray = camera.ray_through(at, lens).ray;
                ray.at((height - ray.origin.dot(normal)) / ray.direction.dot(normal))
            };
            let corner = DVec2::new(20.0, 40.0);
            let step = |x: f64, y: f64| met(corner + DVec2::new(x, y));
            let mut sum = 0.0;
            for (x, a) in rule.on(0.0, 1.0) {
                for (y, b) in rule.on(0.0, 1.0) {
                    // The footprint's area element, by central differences: to h² = 1e-8 of itself.
                    let h = 1e-4;
                    let along_x = (step(x + h, y) - step(x - h, y)) / (2.0 * h);
                    let along_y = (step(x, y + h) - step(x, y - h)) / (2.0 * h);
                    let seen = camera.project_through(step(x, y), lens).unwrap();
                    let cosine = seen.towards.dot(normal).abs();
                    sum += a * b * along_x.cross(along_y).length() * cosine * seen.importance;
                }
            }
            assert!((sum - 1.0).abs() < 1e-7, "{lens} at {height}: {sum}");
        }
    }
}
