//! Cameras: light that arrives at a surface, connected to the film, makes the radiance that pixels average.
//!
//! Where points are seen is held against Mitsuba 3.9.1; how bright, against integrals over the
//! pixel of radiance in closed form, which know nothing of footprints.

use glam::{DMat4, DVec2, DVec3};

use nephroid::geometry::{Ray, SurfacePoint, TraversalCounters};
use nephroid::numeric::quadrature::GaussLegendre;
use nephroid::radiometry::Rgb;
use nephroid::scene::{Scene, SensorKind};
use nephroid::transport::camera::{Camera, CameraError, Connection};
use nephroid::transport::scatter::ShadingNormals;

use crate::support;

const FILM: &str = "<film type=\"hdrfilm\"><integer name=\"width\" value=\"120\"/>\
    <integer name=\"height\" value=\"80\"/><integer name=\"crop_offset_x\" value=\"10\"/>\
    <integer name=\"crop_offset_y\" value=\"20\"/><integer name=\"crop_width\" value=\"100\"/>\
    <integer name=\"crop_height\" value=\"50\"/><rfilter type=\"box\"/></film>";

const LOOK: &str = "<lookat origin=\"1, -5, 2\" target=\"0, 0, 0\" up=\"0, 0, 1\"/>";

fn scene(elements: &str) -> Scene {
    Scene::new(support::scene_files::scene(elements).unwrap()).unwrap()
}

fn sensor(plugin: &str, parameters: &str, transform: &str) -> String {
    format!(
        "<sensor type=\"{plugin}\">{parameters}<transform name=\"to_world\">{transform}</transform>\
         {FILM}</sensor>"
    )
}

fn perspective(parameters: &str) -> String {
    sensor("perspective", parameters, LOOK)
}

fn orthographic() -> String {
    let parameters =
        "<float name=\"near_clip\" value=\"0.5\"/><float name=\"far_clip\" value=\"20\"/>";
    let transform = format!("<scale x=\"1.5\" y=\"1.5\" z=\"2\"/>{LOOK}");
    sensor("orthographic", parameters, &transform)
}

fn camera(scene: &Scene) -> Camera {
    Camera::new(scene, &scene.sensors()[0]).unwrap()
}

/// Both kinds, with all that moves their images.
fn cameras() -> [String; 2] {
    let offset = "<float name=\"fov\" value=\"35\"/>\
        <float name=\"principal_point_offset_x\" value=\"0.07\"/>\
        <float name=\"principal_point_offset_y\" value=\"-0.04\"/>";
    [perspective(offset), orthographic()]
}

/// The film coordinates of `MITSUBA`'s rays.
const SEEN_AT: [(f64, f64); 3] = [(0.0, 0.0), (37.0, 11.0), (100.0, 50.0)];

type MitsubaRay = ([f64; 3], [f64; 3]);

/// Origins and directions that `sensor.sample_ray` of Mitsuba 3.9.1 (`scalar_rgb`) gives at (x / 100, y / 50)
/// of `SEEN_AT`, for these films and `fov_axis`; the last one is orthographic.
const MITSUBA: [(&str, [MitsubaRay; 3]); 5] = [
    (
        "x",
        [
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
        ],
    ),
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
    (
        "larger",
        [
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
        ],
    ),
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

/// A floor of two colours (the back is red), and a lamp above it.
const FLOOR: &str = "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"9\"/>\
    <rotate y=\"1\" angle=\"20\"/></transform><bsdf type=\"twosided\">\
    <bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"0.2, 0.4, 0.8\"/></bsdf>\
    <bsdf type=\"diffuse\"><rgb name=\"reflectance\" value=\"1, 0, 0\"/></bsdf></bsdf></shape>";

const LAMP: DVec3 = DVec3::new(0.5, 0.3, 1.7);

fn connect(
    scene: &Scene,
    camera: &Camera,
    point: &SurfacePoint,
    from: DVec3,
) -> Option<Connection> {
    let direction = (point.position - from).normalize();
    camera.connect(
        scene,
        0,
        point,
        direction,
        &mut TraversalCounters::default(),
    )
}

/// Where a ray meets the first shape.
fn met(scene: &Scene, ray: &Ray) -> SurfacePoint {
    let hit = scene
        .world()
        .closest_hit(ray, f64::INFINITY, &mut TraversalCounters::default());
    scene.world().surface_point(ray, &hit.unwrap())
}

/// Irradiance of a lamp of 1 W/sr.
fn irradiance(position: DVec3, normal: DVec3) -> f64 {
    let offset = LAMP - position;
    offset.dot(normal) / offset.length().powi(3)
}

/// Pixels, and their blue radiance as Mitsuba 3.9.1 renders `cameras()`, `FLOOR` and a lamp of 1 W/sr at
/// `LAMP` (integrator `direct`, 1024 stratified samples): perspective and orthographic.
const RENDERED: [((u32, u32), [f64; 2]); 4] = [
    ((0, 0), [0.04067511, 0.04357789]),
    ((50, 25), [0.07479803, 0.06807174]),
    ((99, 49), [0.02510639, 0.02916098]),
    ((20, 40), [0.03218238, 0.02027195]),
];

#[test]
fn flux_over_a_pixels_footprint_makes_the_radiance_that_the_pixel_averages() {
    let rule = GaussLegendre::new(8).unwrap();
    let on_square = || {
        let rule = &rule;
        rule.on(0.0, 1.0).flat_map(move |(x, a)| {
            rule.on(0.0, 1.0)
                .map(move |(y, b)| (DVec2::new(x, y), a * b))
        })
    };
    for (kind, elements) in cameras().into_iter().enumerate() {
        let scene = scene(&format!("{elements}{FLOOR}"));
        let camera = camera(&scene);
        for (pixel, rendered) in RENDERED {
            let corner = DVec2::new(f64::from(pixel.0), f64::from(pixel.1));
            // By the definition: the pixel's average of ρ/π E, straight from camera rays.
            let average: f64 = on_square()
                .map(|(at, weight)| {
                    let point = met(&scene, &camera.pixel_ray(corner + at).ray);
                    weight * irradiance(point.position, point.geometric_normal)
                })
                .sum::<f64>()
                / std::f64::consts::PI;
            // By connections: flux E dA over the footprint, which on a plane is a quadrilateral.
            let [a, b, c, d] = [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)].map(|(x, y)| {
                let at = corner + DVec2::new(x, y);
                met(&scene, &camera.pixel_ray(at).ray).position
            });
            let mut point = met(&scene, &camera.pixel_ray(corner).ray);
            let mut sum = Rgb::BLACK;
            for (at, weight) in on_square() {
                let (from, to) = (a.lerp(b, at.x), c.lerp(d, at.x));
                point.position = from.lerp(to, at.y);
                let along = (b - a).lerp(d - c, at.y);
                let area = along.cross(to - from).length();
                let connection = connect(&scene, &camera, &point, LAMP).unwrap();
                assert_eq!(
                    camera.pixel(connection.at),
                    Some(pixel.1 as usize * 100 + pixel.0 as usize)
                );
                let flux = irradiance(point.position, point.geometric_normal) * area * weight;
                sum += connection.radiance_per_flux * flux;
            }
            // Eight Gauss points a side: over a pixel, 1/60 of the distance, what is smooth on the
            // scale of the distance leaves (1/120)¹⁶; rounding remains, of a few hundred operations.
            let expected = Rgb::new(0.2, 0.4, 0.8) * average;
            for c in 0..3 {
                let error = sum.0[c] / expected.0[c] - 1.0;
                assert!(error.abs() < 1e-11, "{elements} {pixel:?}: {error:e}");
            }
            // Radiance changes by up to 4 % over a pixel, by 0.04 / 32 over a stratum: 1024 strata leave
            // 0.04 / 32 / √12 / 32 = 1.1e-5; sums of f32 less.
            let error = sum.0[2] / rendered[kind] - 1.0;
            assert!(
                error.abs() < 5e-5,
                "{pixel:?}: Mitsuba differs by {error:e}"
            );
        }
    }
}

#[test]
fn a_scene_twice_as_large_takes_four_times_the_flux() {
    // Radiance by flux is 1/m² (and sr): everything but lengths stays.
    let make = |scale: f64| {
        let camera = format!(
            "<sensor type=\"perspective\"><float name=\"fov\" value=\"35\"/><transform name=\"to_world\">\
             <lookat origin=\"{}, {}, {}\" target=\"0, 0, 0\" up=\"0, 0, 1\"/></transform>{FILM}</sensor>",
            scale,
            -5.0 * scale,
            2.0 * scale
        );
        let floor = FLOOR.replace("value=\"9\"", &format!("value=\"{}\"", 9.0 * scale));
        scene(&format!("{camera}{floor}"))
    };
    let connection = |scale: f64| {
        let scene = make(scale);
        let camera = camera(&scene);
        let at = DVec2::new(12.3, 34.5);
        let point = met(&scene, &camera.pixel_ray(at).ray);
        connect(&scene, &camera, &point, LAMP * scale).unwrap()
    };
    let (one, two) = (connection(1.0), connection(2.0));
    assert!(one.at.abs_diff_eq(two.at, 1e-10));
    for c in 0..3 {
        let ratio = one.radiance_per_flux.0[c] / two.radiance_per_flux.0[c];
        assert!((ratio - 4.0).abs() < 1e-11, "{ratio}");
    }
}

#[test]
fn each_side_of_a_surface_shows_its_own_light() {
    let [elements, _] = cameras();
    let scene_with = |bsdf: &str| {
        let floor = format!(
            "<shape type=\"rectangle\"><transform name=\"to_world\"><scale value=\"9\"/></transform>{bsdf}</shape>"
        );
        scene(&format!("{elements}{floor}"))
    };
    let seen = |bsdf: &str, lamp: DVec3, eye_below: bool| {
        let scene = scene_with(bsdf);
        let mut parts = scene.sensors()[0].clone();
        if eye_below && let SensorKind::Perspective(camera) = &mut parts.kind {
            // Half a turn about x: from above to below.
            let turned = DMat4::from_rotation_x(std::f64::consts::PI) * camera.to_world.matrix();
            camera.to_world = nephroid::geometry::Transform::from_matrix(turned).unwrap();
        }
        let camera = Camera::new(&scene, &parts).unwrap();
        let point = met(&scene, &camera.pixel_ray(DVec2::new(50.0, 25.0)).ray);
        connect(&scene, &camera, &point, lamp).map(|it| it.radiance_per_flux)
    };
    let diffuse = "<bsdf type=\"diffuse\"><float name=\"reflectance\" value=\"0.5\"/></bsdf>";
    let both = format!("<bsdf type=\"twosided\">{diffuse}</bsdf>");
    let mask =
        format!("<bsdf type=\"mask\"><float name=\"opacity\" value=\"0.25\"/>{diffuse}</bsdf>");
    let (above, below) = (LAMP, -LAMP);

    let front = seen(diffuse, above, false).unwrap();
    assert!(seen(diffuse, below, false).is_none(), "light from behind");
    assert!(seen(diffuse, above, true).is_none(), "seen from behind");
    assert!(
        seen(diffuse, below, true).is_none(),
        "a diffuse back is black"
    );
    assert_eq!(seen(&both, above, false), Some(front));
    assert!(seen(&both, above, true).is_none());
    assert!(seen(&both, below, true).is_some());
    let masked = seen(&mask, above, false).unwrap();
    assert!((masked.0[0] / front.0[0] - 0.25).abs() < 1e-15);
    for specular in ["dielectric", "conductor", "null", "thindielectric"] {
        assert!(seen(&format!("<bsdf type=\"{specular}\"/>"), above, false).is_none());
    }
    let black = "<bsdf type=\"diffuse\"><float name=\"reflectance\" value=\"0\"/></bsdf>";
    assert!(seen(black, above, false).is_none());
}

#[test]
fn what_stands_between_hides_unless_light_passes_it() {
    let [elements, _] = cameras();
    let at = DVec2::new(50.0, 25.0);
    let with = |bsdf: &str, towards_eye: f64| {
        let open = scene(&format!("{elements}{FLOOR}"));
        let ray = camera(&open).pixel_ray(at).ray;
        let point = met(&open, &ray);
        let center = point.position - ray.direction * towards_eye;
        let ball = format!(
            "<shape type=\"sphere\"><point name=\"center\" x=\"{}\" y=\"{}\" z=\"{}\"/>\
             <float name=\"radius\" value=\"0.004\"/>{bsdf}</shape>",
            center.x, center.y, center.z
        );
        let scene = scene(&format!("{elements}{FLOOR}{ball}"));
        connect(&scene, &camera(&scene), &point, LAMP).map(|it| it.radiance_per_flux.0[2])
    };
    let mask = |opacity: f64| {
        format!(
            "<bsdf type=\"mask\"><float name=\"opacity\" value=\"{opacity}\"/><bsdf type=\"diffuse\"/></bsdf>"
        )
    };
    let clear = with("<bsdf type=\"null\"/>", 1.0).unwrap();
    assert!(with("<bsdf type=\"diffuse\"/>", 1.0).is_none());
    assert!(with("<bsdf type=\"dielectric\"/>", 1.0).is_none());
    assert!(with(&mask(1.0), 1.0).is_none());
    // Through a mask's ball light goes in and out.
    let masked = with(&mask(0.25), 1.0).unwrap();
    assert!(
        (masked / clear - 0.5625).abs() < 1e-14,
        "{}",
        masked / clear
    );
    // Behind the near plane (0.01 from the pinhole along the axis) nothing hides anything.
    let open = scene(&format!("{elements}{FLOOR}"));
    let eye = DVec3::new(1.0, -5.0, 2.0);
    let distance = met(&open, &camera(&open).pixel_ray(at).ray)
        .position
        .distance(eye);
    assert_eq!(
        with("<bsdf type=\"diffuse\"/>", distance - 0.0045),
        Some(clear)
    );
    assert!(with("<bsdf type=\"diffuse\"/>", distance - 0.0155).is_none());
}

#[test]
fn shading_normals_tilt_radiance_only_where_asked() {
    let [elements, _] = cameras();
    let scene = scene(&format!("{elements}{FLOOR}"));
    let camera = camera(&scene);
    let mut point = met(&scene, &camera.pixel_ray(DVec2::new(50.0, 25.0)).ray);
    let flat = connect(&scene, &camera, &point, LAMP)
        .unwrap()
        .radiance_per_flux;
    let bent = camera.clone().with_shading_normals(ShadingNormals::Adjoint);
    assert_eq!(
        connect(&scene, &bent, &point, LAMP)
            .unwrap()
            .radiance_per_flux,
        flat
    );

    let normal = point.geometric_normal;
    point.shading_normal = (normal + DVec3::new(0.2, 0.1, 0.0)).normalize();
    assert_eq!(
        connect(&scene, &camera, &point, LAMP)
            .unwrap()
            .radiance_per_flux,
        flat
    );
    let towards = (LAMP - point.position).normalize();
    let factor = towards.dot(point.shading_normal) / towards.dot(normal);
    let found = connect(&scene, &bent, &point, LAMP)
        .unwrap()
        .radiance_per_flux;
    assert!((found.0[1] / flat.0[1] / factor - 1.0).abs() < 1e-14);
    point.shading_normal = -normal;
    assert!(connect(&scene, &bent, &point, LAMP).is_none());
}

#[test]
fn sensors_and_scenes_that_give_no_image_are_refused_by_name() {
    let refused = |elements: &str| {
        let scene = scene(elements);
        Camera::new(&scene, &scene.sensors()[0]).unwrap_err()
    };
    let [pinhole, _] = cameras();
    let id = "id=\"eye\" type=";
    let named = pinhole.replacen("type=", id, 1);
    assert_eq!(
        refused(
            &named
                .replace(
                    "type=\"perspective\">",
                    "type=\"thinlens\"><float name=\"aperture_radius\" value=\"0.1\"/>"
                )
                .replace(
                    "<float name=\"principal_point_offset_x\" value=\"0.07\"/>",
                    ""
                )
                .replace(
                    "<float name=\"principal_point_offset_y\" value=\"-0.04\"/>",
                    ""
                )
        )
        .to_string(),
        "sensor \"eye\" is a thinlens: a camera that light can be connected to must be perspective or \
         orthographic"
    );
    assert_eq!(
        refused(&named.replace("type=\"box\"", "type=\"gaussian\"")).to_string(),
        "sensor \"eye\" has a film with a gaussian filter: pixels here are plain averages; add <rfilter \
         type=\"box\"/> to the film"
    );
    let textured = "<shape type=\"sphere\" id=\"globe\"><bsdf type=\"twosided\"><bsdf type=\"diffuse\">\
        <texture type=\"checkerboard\" name=\"reflectance\"/></bsdf></bsdf></shape>";
    assert_eq!(
        refused(&format!("{named}{textured}")).to_string(),
        "sensor \"eye\" may see shape \"globe\", whose diffuse reflectance (or opacity) is a texture or a \
         spectrum from a file: light that is connected to a camera needs an rgb or a float"
    );
    let far = "<shape type=\"rectangle\"><sensor type=\"irradiancemeter\" id=\"meter\"/></shape>";
    assert!(matches!(
        refused(far),
        CameraError::Kind {
            plugin: "irradiancemeter",
            ..
        }
    ));
    let vast = orthographic().replace("x=\"1.5\" y=\"1.5\"", "x=\"1e80\" y=\"1e80\"");
    assert!(matches!(refused(&vast), CameraError::Size { .. }));
}

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

/// Film coordinates of the crop, points of the lens, and what `sensor.sample_ray` of Mitsuba 3.9.1 (`scalar_rgb`)
/// makes of them: origin, direction and `maxt`.
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
    // Radiance 1 everywhere is radiance 1 in the pixel: ∫ W cos dA = 1 over its footprint, for any point of the lens.
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
