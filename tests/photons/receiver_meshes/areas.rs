//! Texels that average over parts, slivers, and faces of several areas.

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::{Rectangle, Shape, Transform};
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::scene::{Emitter, Material, Scene, SceneParts, ShapeId};
use nephroid::internals::transport::direct::{AREA_SAMPLES, direct};

use super::scenes::{
    LAMP, ROUNDING, assert_flux, cut, film, lit, mesh, receiver, scene, solid_angle, square,
};

#[test]
fn texels_covered_in_part_average_over_the_part_and_others_stay_dark() {
    // A right triangle over half of the square; the diagonal halves the texels on it. Its legs
    // end in the middle of texels, too: 8 columns, u up to 0.8125 = 6.5 texels.
    let reach = 0.8125;
    let uvs = [(0.0, 0.0), (reach, 0.0), (0.0, reach)].map(|(u, v)| DVec2::new(u, v));
    let rectangle = square();
    let positions = uvs.map(|uv| rectangle.point(uv));
    let (_, receiver, texels) = lit(mesh(&positions, &uvs, &[[0, 1, 2]]), 8, 8);
    let at = |x: f64, y: f64| rectangle.point(DVec2::new(x, y) / 8.0);
    let mut kinds = [0; 3];
    for row in 0..8 {
        for column in 0..8 {
            let texel = row * 8 + column;
            let (x, y) = (column as f64, row as f64);
            // How much of the diagonal x + y = 6.5 is left of this texel's corner.
            let left = 6.5 - x - y;
            let polygon = if left >= 2.0 {
                kinds[0] += 1;
                vec![
                    at(x, y),
                    at(x + 1.0, y),
                    at(x + 1.0, y + 1.0),
                    at(x, y + 1.0),
                ]
            } else if left > 1.0 {
                // All but the corner beyond the diagonal.
                kinds[1] += 1;
                let short = left - 1.0;
                vec![
                    at(x, y),
                    at(x + 1.0, y),
                    at(x + 1.0, y + short),
                    at(x + short, y + 1.0),
                    at(x, y + 1.0),
                ]
            } else if left > 0.0 {
                kinds[1] += 1;
                vec![at(x, y), at(x + left, y), at(x, y + left)]
            } else {
                kinds[2] += 1;
                assert!(!receiver.has_surface(texel));
                assert!(texels[texel].irradiance.is_black() && texels[texel].error.is_black());
                continue;
            };
            let truth = LAMP.1 * solid_angle(&polygon);
            assert_flux(&receiver, &texels, texel, truth, 0.25);
            // The bar is no excuse. Of the smallest part (legs of half a texel, 4 leaves) 6 leaves are
            // whole and 4 cut, half of it at most; over it irradiance changes by 3 h / (2 d), h = 1/8.
            assert!(texels[texel].error.0[0] <= 0.0625 * texels[texel].irradiance.0[0]);
        }
    }
    assert!(kinds.iter().all(|&count| count > 5), "{kinds:?}");
}

#[test]
fn a_sliver_that_no_sample_meets_still_has_its_light() {
    // 1e-4 of a texel's width; texels left of it have none.
    let uvs = [(0.5, 0.0), (0.5 + 1e-4 / 8.0, 0.0), (0.5, 1.0)].map(|(u, v)| DVec2::new(u, v));
    let positions = uvs.map(|uv| square().point(uv));
    let (_, receiver, texels) = lit(mesh(&positions, &uvs, &[[0, 1, 2]]), 8, 8);
    for (texel, measured) in texels.iter().enumerate() {
        assert_eq!(receiver.has_surface(texel), texel % 8 == 4);
        if texel % 8 == 4 {
            let position = square().point(DVec2::new(0.5, (texel / 8) as f64 / 8.0 + 0.0625));
            let offset = LAMP.0 - position;
            let expected = LAMP.1 * offset.z / offset.length().powi(3);
            let found = measured.irradiance.0[0];
            // Within what the irradiance changes over a texel's length: 3 h / (2 d), h = 0.25, d > 1.5.
            assert!((found / expected - 1.0).abs() < 0.25, "{found} {expected}");
            assert!(measured.error.0[0] >= (found - expected).abs());
        } else {
            assert!(measured.irradiance.is_black());
        }
    }
}

#[test]
fn faces_that_stretch_or_lean_differently_share_a_texel_by_their_areas() {
    // Along u: u = 0.3 at x = 0, so the left half is dense in u and the right one spread out; the
    // right half may also rise. The fold runs through the texels of column 2 (u = 2.4 / 8).
    for height in [0.0, 0.5] {
        let fold = 0.3;
        let uvs = [0.0, fold, 1.0]
            .iter()
            .flat_map(|&u| [DVec2::new(u, 0.0), DVec2::new(u, 1.0)])
            .collect::<Vec<_>>();
        let point = |u: f64, v: f64| {
            let (x, z) = if u < fold {
                (u / fold - 1.0, 0.0)
            } else {
                let along = (u - fold) / (1.0 - fold);
                (along, along * height)
            };
            DVec3::new(x, 2.0 * v - 1.0, z)
        };
        let positions: Vec<DVec3> = uvs.iter().map(|uv| point(uv.x, uv.y)).collect();
        let faces = [[0, 2, 3], [0, 3, 1], [2, 4, 5], [2, 5, 3]];
        let (_, receiver, texels) = lit(mesh(&positions, &uvs, &faces), 8, 8);
        for texel in 0..64 {
            let (column, row) = ((texel % 8) as f64 / 8.0, (texel / 8) as f64 / 8.0);
            let (end, top) = (column + 0.125, row + 0.125);
            let flux = |from: f64, to: f64| {
                let corners = [
                    point(from, row),
                    point(to, row),
                    point(to, top),
                    point(from, top),
                ];
                LAMP.1 * solid_angle(&corners)
            };
            let truth = if column < fold && end > fold {
                flux(column, fold) + flux(fold, end)
            } else {
                flux(column, end)
            };
            // Texels reach over 0.42 at most, and the plane's nearest point is 1.3 from the lamp.
            assert_flux(&receiver, &texels, texel, truth, 0.5);
            let bar = texels[texel].error.0[0] / texels[texel].irradiance.0[0];
            // One column of 8 x 8 leaves, two at most, holds the fold: a quarter of the texel, with
            // what irradiance changes over the texel and from one plane to the other.
            assert!(bar <= 0.25 * if height > 0.0 { 1.0 } else { 0.2 }, "{bar}");
        }
    }
}

#[test]
fn area_lights_fall_on_meshes_as_on_rectangles() {
    let lamp = |scene_shape: Shape| {
        let to_world = glam::DMat4::from_translation(DVec3::new(0.2, 0.1, 1.2))
            * glam::DMat4::from_rotation_x(std::f64::consts::PI)
            * glam::DMat4::from_scale(DVec3::splat(0.2));
        let light = Rectangle::new(&Transform::from_matrix(to_world).unwrap(), false).unwrap();
        let base = scene(scene_shape.clone(), film(8, 8), Vec::new());
        let object = base.objects()[0].clone();
        Scene::new(SceneParts {
            shapes: vec![scene_shape, Shape::Rectangle(light)],
            objects: vec![object.clone(), object],
            materials: vec![Material::Null],
            emitters: vec![Emitter::Area {
                shape: ShapeId(1),
                radiance: Rgb::WHITE,
                texture: None,
            }],
            sensors: base.sensors().to_vec(),
            ..SceneParts::default()
        })
        .unwrap()
    };
    let measured = |scene: &Scene| {
        direct(scene, &receiver(scene), 0, AREA_SAMPLES, &|| false)
            .unwrap()
            .texels
    };
    let truth = measured(&lamp(Shape::Rectangle(square())));
    let cut = measured(&lamp(Shape::Mesh(cut(&square(), 4, 3))));
    for (found, expected) in cut.iter().zip(&truth) {
        let (a, b) = (found.irradiance.0[0], expected.irradiance.0[0]);
        assert!(b > 0.0 && (a / b - 1.0).abs() < ROUNDING, "{a} {b}");
    }
    // Half of the square: texels within are as before, those on the diagonal sampled.
    let uvs = [DVec2::ZERO, DVec2::X, DVec2::Y];
    let half = mesh(&uvs.map(|uv| square().point(uv)), &uvs, &[[0, 1, 2]]);
    let half = measured(&lamp(Shape::Mesh(half)));
    for (texel, (found, expected)) in half.iter().zip(&truth).enumerate() {
        let (a, b) = (found.irradiance.0[0], expected.irradiance.0[0]);
        match (texel % 8 + texel / 8).cmp(&7) {
            std::cmp::Ordering::Less => assert!((a / b - 1.0).abs() < ROUNDING, "{a} {b}"),
            std::cmp::Ordering::Greater => assert_eq!(a, 0.0),
            std::cmp::Ordering::Equal => {
                // Against the whole texel: the half's centroid is h/6 √2 off the middle, h = 0.25,
                // over which irradiance changes by less than 4/r of itself a unit, r >= 1.2.
                let moved = 4.0 / 1.2 * 0.25 / 6.0 * 2.0_f64.sqrt();
                let bar = found.error.0[0];
                // Student's t with 15 degrees of freedom exceeds 6 once in 40 000.
                assert!(
                    bar > 0.0 && (a - b).abs() < moved * b + 6.0 * bar,
                    "{a} {b} {bar}"
                );
            }
        }
    }
}

#[test]
fn texels_of_discs_and_spheres_average_by_area() {
    // The middle of a disc is one texel wide: by area its mean lies at 2/3 of the texel's radius.
    // By flux: the lamp is on the axis, so a ring's solid angle is closed.
    let disk = nephroid::internals::geometry::Disk::new(&Transform::IDENTITY, false).unwrap();
    let lamp = Emitter::Point {
        position: DVec3::Z,
        intensity: Rgb::WHITE,
    };
    let scene = scene(Shape::Disk(disk), film(16, 4), vec![lamp]);
    let receiver = receiver(&scene);
    let texels = direct(&scene, &receiver, 0, AREA_SAMPLES, &|| false)
        .unwrap()
        .texels;
    let cos = |radius: f64| 1.0 / radius.hypot(1.0);
    for (texel, measured) in texels.iter().enumerate() {
        let (inner, outer) = ((texel % 16) as f64 / 16.0, (texel % 16 + 1) as f64 / 16.0);
        let truth = std::f64::consts::TAU / 4.0 * (cos(inner) - cos(outer));
        let found = measured.irradiance.0[0] * receiver.texel_area(texel);
        // Gauss points leave about (size / distance)⁴ / 100 along the radius, and nothing changes
        // along the circle; leaves are at most 1/64 of their distance (or 1/64 of a texel).
        assert!(
            (found / truth - 1.0).abs() < 1e-6,
            "{texel}: {found} {truth}"
        );
    }
}
