//! The map from the surface to texels, and back.

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::Shape;
use nephroid::internals::scene::Crop;
use nephroid::internals::transport::direct::{AREA_SAMPLES, direct};

use super::scenes::{ROUNDING, cut, film, glass_ball, lit, mesh, photons, receiver, scene, square};

#[test]
fn a_rectangle_cut_into_triangles_measures_the_same_photons_and_the_same_direct_light() {
    let analytic = glass_ball(|_| {});
    let (whole, truth) = photons(&analytic);
    for (columns, rows) in [(1, 1), (7, 5)] {
        let scene = glass_ball(|parts| {
            let shape = parts
                .shapes
                .iter_mut()
                .find(|shape| matches!(shape, Shape::Rectangle(_)))
                .unwrap();
            if let Shape::Rectangle(rectangle) = &*shape {
                *shape = Shape::Mesh(cut(rectangle, columns, rows));
            }
        });
        let (receiver, found) = photons(&scene);
        // A photon changes texels only where it falls on a border but for rounding: of 2¹⁸ that
        // spread over 32 texels, none is expected within 2⁻⁴⁵ of one.
        assert_eq!(found.counts, truth.counts);
        let mut total = 0.0;
        for texel in 0..receiver.texels() {
            let (a, b) = (receiver.texel_area(texel), whole.texel_area(texel));
            assert!((a / b - 1.0).abs() < ROUNDING, "texel {texel}: {a} {b}");
            total += a;
            for (layer, expected) in found.layers.iter().zip(&truth.layers) {
                let (a, b) = (layer.values[texel].0[0], expected.values[texel].0[0]);
                // Direct light has bars on its shadow's edge, where rounding may turn a shadow ray.
                let bar = if layer.name == truth.layers[0].name {
                    expected.standard_error[texel].0[0]
                } else {
                    0.0
                };
                assert!(
                    (a - b).abs() <= 2.0 * bar + ROUNDING * b,
                    "{} texel {texel}: {a} {b}",
                    layer.name
                );
            }
        }
        let area = match &scene.world().shapes()[receiver.shape() as usize] {
            Shape::Mesh(mesh) => mesh.area(),
            _ => unreachable!(),
        };
        assert!((total / area - 1.0).abs() < ROUNDING, "{total} {area}");
    }
}

#[test]
fn what_a_mesh_with_gaps_receives_is_what_its_map_holds() {
    // Half of the floor, in (u, v) that fill a part of the film: caustic light falls on and beside it.
    let scene = glass_ball(|parts| {
        let shape = parts
            .shapes
            .iter_mut()
            .find(|shape| matches!(shape, Shape::Rectangle(_)))
            .unwrap();
        if let Shape::Rectangle(rectangle) = &*shape {
            let corners = [(0.0, 0.0), (1.0, 0.1), (0.3, 1.0)].map(|(u, v)| DVec2::new(u, v));
            let uvs = corners.map(|uv| 0.1 + 0.77 * uv);
            let positions = corners.map(|uv| rectangle.point(uv));
            *shape = Shape::Mesh(mesh(&positions, &uvs, &[[0, 1, 2]]));
        }
    });
    let (receiver, estimate) = photons(&scene);
    let mut on_map = 0.0;
    for layer in &estimate.layers[1..] {
        for (texel, value) in layer.values.iter().enumerate() {
            assert!(receiver.has_surface(texel) || value.is_black());
            assert!(value.is_finite());
            on_map += value.0[0] * receiver.texel_area(texel);
        }
    }
    // Deposits are exact; dividing by and multiplying with the area rounds.
    let received = estimate.ledger.sum().received.0[0];
    assert!(received > 0.0 && (on_map / received - 1.0).abs() < ROUNDING);
    assert!(estimate.ledger.sum().escaped.0[0] > 0.0);
}

#[test]
fn the_way_from_a_texel_to_the_surface_leads_back_to_the_texel() {
    for (columns, rows) in [(1, 1), (7, 5), (60, 90)] {
        let scene = scene(
            Shape::Mesh(cut(&square(), columns, rows)),
            film(13, 9),
            Vec::new(),
        );
        let receiver = receiver(&scene);
        for texel in 0..receiver.texels() {
            for (x, y) in [(0.01, 0.01), (0.5, 0.5), (0.3, 0.99), (0.99, 0.2)] {
                let at = DVec2::new(x, y);
                let patch = receiver.patch(&scene, texel, at).unwrap();
                let uv = receiver.uv(texel, at);
                assert!(patch.point.uv.abs_diff_eq(uv, ROUNDING), "{texel} {at}");
                let expected = square().point(uv);
                assert!(patch.point.position.abs_diff_eq(expected, ROUNDING));
                assert_eq!(receiver.texel(&patch.point, -DVec3::Z), Some(texel));
                assert_eq!(receiver.texel(&patch.point, DVec3::Z), None);
                // The square's 4 m² spread evenly over 13 x 9 texels.
                assert!((patch.density * 117.0 / 4.0 - 1.0).abs() < ROUNDING);
            }
        }
    }
}

#[test]
fn a_cropped_film_measures_its_part() {
    let whole = lit(cut(&square(), 3, 3), 12, 12);
    let crop = Crop {
        offset_x: 2,
        offset_y: 5,
        width: 7,
        height: 4,
    };
    let mut film = film(12, 12);
    film.crop = crop;
    let part = scene(
        Shape::Mesh(cut(&square(), 3, 3)),
        film,
        whole.0.emitters().to_vec(),
    );
    let receiver = receiver(&part);
    let texels = direct(&part, &receiver, 0, AREA_SAMPLES, &|| false)
        .unwrap()
        .texels;
    for row in 0..4 {
        for column in 0..7 {
            let (a, b) = (row * 7 + column, (row + 5) * 12 + column + 2);
            assert_eq!(receiver.texel_area(a), whole.1.texel_area(b));
            let (a, b) = (texels[a].irradiance.0[0], whole.2[b].irradiance.0[0]);
            assert!((a / b - 1.0).abs() < ROUNDING, "({column}, {row}): {a} {b}");
        }
    }
}
