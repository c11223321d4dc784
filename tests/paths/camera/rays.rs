//! Rays of pixels: where Mitsuba sees points, and back again.

use glam::{DVec2, DVec3};

use super::views::{MitsubaRay, camera, cameras, orthographic, scene};

/// The film coordinates of `MITSUBA`'s rays.
const SEEN_AT: [(f64, f64); 3] = [(0.0, 0.0), (37.0, 11.0), (100.0, 50.0)];

/// Rays for `fov_axis` `x`, which is the larger one of these films.
const ALONG_X: [MitsubaRay; 3] = [
    (
        [0.9959433, -4.9908633, 1.9974835],
        [-0.3935263, 0.8863084, -0.24412],
    ),
    (
        [0.9978913, -4.9906893, 1.9969454],
        [-0.2103756, 0.9289077, -0.30475],
    ),
    (
        [1.0012845, -4.9907737, 1.9950374],
        [0.121692, 0.8741423, -0.4701767],
    ),
];

/// Origins and directions that `sensor.sample_ray` of Mitsuba 3.9.1 (`scalar_rgb`) gives at (x / 100, y / 50)
/// of `SEEN_AT`, for these films and `fov_axis`; the last one is orthographic.
const MITSUBA: [(&str, [MitsubaRay; 3]); 5] = [
    ("x", ALONG_X),
    (
        "y",
        [
            (
                [0.9948279, -4.9908595, 1.9980509],
                [-0.4842088, 0.855715, -0.1824655],
            ),
            (
                [0.9977499, -4.9905982, 1.9972438],
                [-0.223837, 0.9352664, -0.2741784],
            ),
            (
                [1.0028394, -4.990725, 1.9943819],
                [0.2533116, 0.8274302, -0.501191],
            ),
        ],
    ),
    ("larger", ALONG_X),
    (
        "diagonal",
        [
            (
                [0.996318, -4.9908648, 1.9972929],
                [-0.3604638, 0.8943304, -0.2650263],
            ),
            (
                [0.9979388, -4.9907198, 1.9968451],
                [-0.2057826, 0.926522, -0.314977],
            ),
            (
                [1.0007621, -4.9907899, 1.9952576],
                [0.0733666, 0.8866622, -0.4565606],
            ),
        ],
    ),
    (
        "orthographic",
        [
            (
                [-0.4441057, -4.1532459, 2.1003263],
                [-0.1825742, 0.9128709, -0.3651484],
            ),
            (
                [0.4826244, -4.0703039, 1.8443153],
                [-0.1825742, 0.9128709, -0.3651484],
            ),
            (
                [2.0968597, -4.110527, 0.9366396],
                [-0.1825742, 0.9128709, -0.3651484],
            ),
        ],
    ),
];

#[test]
fn points_are_seen_where_mitsuba_sees_them() {
    for (axis, rays) in MITSUBA {
        let elements = if axis == "orthographic" {
            orthographic()
        } else {
            cameras()[0].replace(
                "<transform",
                &format!("<string name=\"fov_axis\" value=\"{axis}\"/><transform"),
            )
        };
        let scene = scene(&elements);
        let camera = camera(&scene);
        assert_eq!((camera.width(), camera.height()), (100, 50));
        for ((x, y), (origin, direction)) in SEEN_AT.into_iter().zip(rays) {
            let (origin, direction) = (DVec3::from(origin), DVec3::from(direction));
            let seen = camera.pixel_ray(DVec2::new(x, y)).ray;
            // Mitsuba's f32 has 2⁻²⁴ relative, of coordinates up to 5, and a few operations: 4 x 5 x 6e-8.
            assert!(
                seen.origin.abs_diff_eq(origin, 1.2e-6),
                "{axis} {seen:?} {origin}"
            );
            assert!(
                seen.direction.abs_diff_eq(direction, 1.2e-6),
                "{axis} {seen:?} {direction}"
            );
            for distance in [0.5, 3.0, 15.0] {
                let found = camera.project(origin + distance * direction).unwrap().at;
                // The same, over a distance of 0.5, by at most 300 pixels a unit (fov 31 degrees on
                // 120 pixels: 216, at up to 31 degrees off the axis: / cos²).
                assert!(
                    found.abs_diff_eq(DVec2::new(x, y), 300.0 * 1.2e-6 / 0.5),
                    "{axis}: {found} for ({x}, {y})"
                );
            }
        }
    }
}

#[test]
fn a_pixel_ray_leads_back_to_its_film_coordinates() {
    for elements in cameras() {
        let scene = scene(&elements);
        let camera = camera(&scene);
        for at in [(0.0, 0.0), (31.4, 15.9), (99.9, 0.1), (-50.0, 70.0)] {
            let at = DVec2::from(at);
            let view = camera.pixel_ray(at);
            for share in [1e-3, 0.1, 0.9] {
                let distance = share * view.reach;
                let seen = camera.project(view.ray.at(distance)).unwrap();
                // A few dozen roundings of numbers of 200 pixels.
                assert!(seen.at.abs_diff_eq(at, 1e-10), "{} for {at}", seen.at);
                assert!((seen.distance / distance - 1.0).abs() < 1e-10);
                assert!(seen.towards.abs_diff_eq(-view.ray.direction, 1e-12));
            }
            assert!(camera.project(view.ray.at(1.001 * view.reach)).is_none());
            assert!(camera.project(view.ray.at(-1e-3 * view.reach)).is_none());
        }
        // Borders belong to the pixel that begins there.
        assert_eq!(camera.pixel(DVec2::ZERO), Some(0));
        assert_eq!(camera.pixel(DVec2::new(99.5, 49.5)), Some(4999));
        assert_eq!(camera.pixel(DVec2::new(3.0, 2.0)), Some(203));
        for outside in [(100.0, 1.0), (1.0, 50.0), (-1e-9, 1.0), (f64::NAN, 1.0)] {
            assert_eq!(camera.pixel(DVec2::from(outside)), None);
        }
    }
}
