//! Radiance of a pixel that light is connected to.

use glam::{DMat4, DVec2, DVec3};
use nephroid::internals::numeric::quadrature::GaussLegendre;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::scene::SensorKind;
use nephroid::internals::transport::camera::Camera;
use nephroid::internals::transport::scatter::ShadingNormals;

use super::views::{FILM, FLOOR, LAMP, camera, cameras, connect, met, scene};

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
            camera.to_world =
                nephroid::internals::geometry::Transform::from_matrix(turned).unwrap();
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
