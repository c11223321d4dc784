//! Receivers that are meshes: texels over the file's (u, v) measure what the surface receives.
//!
//! Two independent truths: the same surface as an analytic rectangle, and, for the light of a point
//! without shadows, I times the solid angle of the surface in a texel.

use glam::{DVec2, DVec3};

use nephroid::geometry::{Mesh, MeshParts, Rectangle, Shape, Transform};
use nephroid::mitsuba;
use nephroid::radiometry::Rgb;
use nephroid::reference::Progress;
use nephroid::reference::photons::run::Setup;
use nephroid::reference::photons::{Budget, PhotonSettings};
use nephroid::reference::{Estimate, Target};
use nephroid::scene::{
    Crop, Emitter, Film, Material, MaterialId, Object, ReconstructionFilter, Scene, SceneParts,
    Sensor, SensorKind, ShapeId, SourcePosition,
};
use nephroid::transport::direct::{AREA_SAMPLES, DirectTexel, direct};
use nephroid::transport::receiver::Receiver;

use crate::support;

/// Rounding of a sum of a few hundred terms of one sign, each of a few dozen operations.
const ROUNDING: f64 = 1e4 * f64::EPSILON;

fn mesh(positions: &[DVec3], uvs: &[DVec2], triangles: &[[u32; 3]]) -> Mesh {
    Mesh::new(MeshParts {
        positions: positions.to_vec(),
        triangles: triangles.to_vec(),
        uvs: Some(uvs.to_vec()),
        face_normals: true,
        ..MeshParts::default()
    })
    .unwrap()
}

/// A rectangle's surface as `columns` x `rows` unevenly large cells of two triangles, cut along
/// either diagonal in turn.
fn cut(rectangle: &Rectangle, columns: u32, rows: u32) -> Mesh {
    let stop = |i: u32, n: u32| {
        let x = f64::from(i) / f64::from(n);
        // Denser towards one end; 0 and 1 stay.
        x * (0.6 + 0.4 * x)
    };
    let mut uvs = Vec::new();
    for row in 0..=rows {
        for column in 0..=columns {
            let border = column == 0 || row == 0 || column == columns || row == rows;
            let wobble = if border { 0.0 } else { 0.3 };
            let shift = wobble * f64::from((7 * column + 3 * row) % 5) / 5.0;
            let inner =
                |i: u32, n: u32| stop(i, n) + shift * (stop((i + 1).min(n), n) - stop(i, n));
            uvs.push(DVec2::new(inner(column, columns), inner(row, rows)));
        }
    }
    let mut triangles = Vec::new();
    for row in 0..rows {
        for column in 0..columns {
            let [a, b] = [0, 1].map(|i| row * (columns + 1) + column + i);
            let [c, d] = [a + columns + 1, b + columns + 1];
            if (row + column) % 2 == 0 {
                triangles.extend([[a, b, d], [a, d, c]]);
            } else {
                triangles.extend([[a, b, c], [b, d, c]]);
            }
        }
    }
    let positions: Vec<DVec3> = uvs.iter().map(|&uv| rectangle.point(uv)).collect();
    mesh(&positions, &uvs, &triangles)
}

fn film(width: u32, height: u32) -> Film {
    Film {
        width,
        height,
        crop: Crop {
            offset_x: 0,
            offset_y: 0,
            width,
            height,
        },
        filter: ReconstructionFilter::Box,
        sample_border: false,
    }
}

/// A diffuse shape with a meter, under one emitter.
fn scene(shape: Shape, film: Film, emitters: Vec<Emitter>) -> Scene {
    let object = Object {
        id: "sheet".to_owned(),
        plugin: "ply",
        declared_at: SourcePosition {
            file: "scene.xml".into(),
            line: 1,
            column: 1,
        },
        material: MaterialId(0),
    };
    Scene::new(SceneParts {
        shapes: vec![shape],
        objects: vec![object],
        materials: vec![Material::Null],
        emitters,
        sensors: vec![Sensor {
            id: "meter".to_owned(),
            kind: SensorKind::IrradianceMeter { shape: ShapeId(0) },
            film,
        }],
        ..SceneParts::default()
    })
    .unwrap()
}

fn receiver(scene: &Scene) -> Receiver {
    Receiver::new(scene, &scene.sensors()[0]).unwrap()
}

fn refusal(mesh: Mesh) -> String {
    let scene = scene(Shape::Mesh(mesh), film(8, 8), Vec::new());
    Receiver::new(&scene, &scene.sensors()[0])
        .unwrap_err()
        .to_string()
}

/// Where the light of [`lit`] is, and its radiant intensity [W/sr].
const LAMP: (DVec3, f64) = (DVec3::new(0.3, 0.2, 1.5), 2.0);

/// What the texels of a mesh receive from a lamp above it.
fn lit(mesh: Mesh, columns: u32, rows: u32) -> (Scene, Receiver, Vec<DirectTexel>) {
    let lamp = Emitter::Point {
        position: LAMP.0,
        intensity: Rgb::grey(LAMP.1),
    };
    let scene = scene(Shape::Mesh(mesh), film(columns, rows), vec![lamp]);
    let receiver = receiver(&scene);
    let texels = direct(&scene, &receiver, 0, AREA_SAMPLES, &|| false)
        .unwrap()
        .texels;
    (scene, receiver, texels)
}

/// The solid angle of a polygon, seen from the lamp: van Oosterom and Strackee 1983, eq. 8, over a fan.
fn solid_angle(polygon: &[DVec3]) -> f64 {
    let seen: Vec<DVec3> = polygon.iter().map(|corner| *corner - LAMP.0).collect();
    (1..seen.len() - 1)
        .map(|i| {
            let (a, b, c) = (seen[0], seen[i], seen[i + 1]);
            let (la, lb, lc) = (a.length(), b.length(), c.length());
            let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
            2.0 * a.dot(b.cross(c)).abs().atan2(below)
        })
        .sum()
}

/// Holds a texel's flux against the closed form, within the texel's own bar.
///
/// Beside it there is the error of 2 x 2 Gauss points where nothing bends, (size / distance)⁴ / 100
/// (see `transport/direct/delta.rs`), with sizes up to `size` at a distance of 1.5.
fn assert_flux(receiver: &Receiver, texels: &[DirectTexel], texel: usize, truth: f64, size: f64) {
    let area = receiver.texel_area(texel);
    let (found, bar) = (texels[texel].irradiance.0[0], texels[texel].error.0[0]);
    let gauss = (size / 1.5_f64).powi(4) / 100.0;
    assert!(
        (found * area - truth).abs() <= bar * area + (gauss + ROUNDING) * truth,
        "texel {texel}: {} for {truth}, bar {}",
        found * area,
        bar * area
    );
}

fn glass_ball(change: impl FnOnce(&mut SceneParts)) -> Scene {
    let mut parts = mitsuba::load_parts(
        &support::bundled_file("glass-ball"),
        &[("size".into(), "32".into())],
    )
    .unwrap();
    change(&mut parts);
    Scene::new(parts).unwrap()
}

fn photons(scene: &Scene) -> (Receiver, Estimate) {
    let progress = Progress::default();
    let settings = PhotonSettings::default();
    let setup = Setup::new(scene, &scene.sensors()[0], settings, &progress).unwrap();
    let budget = Budget {
        photons: Some(1 << 18),
        ..Budget::default()
    };
    let Target::Receiver(receiver) = setup.target() else {
        unreachable!("the sensor is a meter")
    };
    (Receiver::clone(receiver), setup.run(&budget).unwrap())
}

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
                let (a, b) = (
                    layer.irradiance[texel].0[0],
                    expected.irradiance[texel].0[0],
                );
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
        for (texel, value) in layer.irradiance.iter().enumerate() {
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

/// [-1, 1]² in the xy plane.
fn square() -> Rectangle {
    Rectangle::new(&Transform::IDENTITY, false).unwrap()
}

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
    let disk = nephroid::geometry::Disk::new(&Transform::IDENTITY, false).unwrap();
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

#[test]
fn a_uv_map_that_cannot_carry_texels_is_refused_with_its_shape() {
    let flat = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let positions = flat.map(|(x, y)| DVec3::new(x, y, 0.0));
    let faces = [[0, 1, 2], [0, 2, 3]];
    let with = |uvs: [(f64, f64); 4]| {
        refusal(mesh(
            &positions,
            &uvs.map(|(u, v)| DVec2::new(u, v)),
            &faces,
        ))
    };
    let who = "sensor \"meter\" measures shape \"sheet\" (ply), which has ";

    let tiled = with([(0.0, 0.0), (3.0, 0.0), (3.0, 3.0), (0.0, 3.0)]);
    assert_eq!(
        tiled,
        format!(
            "{who}(u, v) = (3, 0) at a corner of face 0 (counted from 0): allowed on a receiver are 0 \
             to 1, without repetition"
        )
    );
    let folded = with([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (1.0, 0.2)]);
    assert_eq!(
        folded,
        format!(
            "{who}faces 0 and 1 (counted from 0) on the same (u, v): on a receiver each (u, v) may lie \
             on one face only"
        )
    );
    let line = with([(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.5, 0.5)]);
    assert!(
        line.starts_with(&format!("{who}faces whose (u, v) are a line or a point; ")),
        "{line}"
    );
    let none = Mesh::new(MeshParts {
        positions: positions.to_vec(),
        triangles: faces.to_vec(),
        ..MeshParts::default()
    });
    assert!(refusal(none.unwrap()).starts_with(&format!("{who}no texture coordinates: ")));
}

#[test]
fn uvs_off_by_the_rounding_of_a_file_are_taken() {
    // Six digits, or f32: the border texels hold what lies a hair beyond.
    let flat = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)];
    let positions = flat.map(|(x, y)| DVec3::new(x, y, 0.0));
    let uvs = flat.map(|(x, y): (f64, f64)| DVec2::new(x * 1.000_000_5, y - 1e-7));
    let mesh = mesh(&positions, &uvs, &[[0, 1, 2], [0, 2, 3]]);
    let scene = scene(Shape::Mesh(mesh), film(4, 4), Vec::new());
    let receiver = receiver(&scene);
    let sum: f64 = (0..16).map(|texel| receiver.texel_area(texel)).sum();
    assert!((sum - 1.0).abs() < ROUNDING, "{sum}");
}
