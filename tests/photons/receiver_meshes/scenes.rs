//! Meshes as receivers, lights over them, and what they receive.

use glam::{DVec2, DVec3};
use nephroid::internals::geometry::{Mesh, MeshParts, Rectangle, Shape, Transform};
use nephroid::internals::mitsuba;
use nephroid::internals::radiometry::Rgb;
use nephroid::internals::reference::Target;
use nephroid::internals::reference::photons::PhotonSettings;
use nephroid::internals::reference::photons::run::Setup;
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, Progress};
use nephroid::internals::scene::{
    Crop, Emitter, Film, Material, MaterialId, Object, ReconstructionFilter, Scene, SceneParts,
    Sensor, SensorKind, ShapeId, SourcePosition,
};
use nephroid::internals::transport::direct::{AREA_SAMPLES, DirectTexel, direct};
use nephroid::internals::transport::receiver::Receiver;

use crate::support;

/// Rounding of a sum of a few hundred terms of one sign, each of a few dozen operations.
pub const ROUNDING: f64 = 1e4 * f64::EPSILON;

pub fn mesh(positions: &[DVec3], uvs: &[DVec2], triangles: &[[u32; 3]]) -> Mesh {
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
pub fn cut(rectangle: &Rectangle, columns: u32, rows: u32) -> Mesh {
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

pub fn film(width: u32, height: u32) -> Film {
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
pub fn scene(shape: Shape, film: Film, emitters: Vec<Emitter>) -> Scene {
    let object = Object {
        id: "sheet".to_owned(),
        plugin: "ply",
        declared_at: SourcePosition {
            file: "scene.xml".into(),
            line: 1,
            column: 1,
        },
        material: MaterialId(0),
        boundary: None,
        to_world: Transform::IDENTITY,
    };
    Scene::new(SceneParts {
        shapes: vec![shape],
        objects: vec![object],
        materials: vec![Material::Null],
        emitters,
        sensors: vec![Sensor {
            medium: None,
            id: "meter".to_owned(),
            kind: SensorKind::IrradianceMeter { shape: ShapeId(0) },
            film,
        }],
        ..SceneParts::default()
    })
    .unwrap()
}

pub fn receiver(scene: &Scene) -> Receiver {
    Receiver::new(scene, &scene.sensors()[0]).unwrap()
}

pub fn refusal(mesh: Mesh) -> String {
    let scene = scene(Shape::Mesh(mesh), film(8, 8), Vec::new());
    Receiver::new(&scene, &scene.sensors()[0])
        .unwrap_err()
        .to_string()
}

/// Position of the light of [`lit`], and its radiant intensity [W/sr].
pub const LAMP: (DVec3, f64) = (DVec3::new(0.3, 0.2, 1.5), 2.0);

/// Direct light on the texels of a mesh below a lamp.
pub fn lit(mesh: Mesh, columns: u32, rows: u32) -> (Scene, Receiver, Vec<DirectTexel>) {
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
pub fn solid_angle(polygon: &[DVec3]) -> f64 {
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
pub fn assert_flux(
    receiver: &Receiver,
    texels: &[DirectTexel],
    texel: usize,
    truth: f64,
    size: f64,
) {
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

pub fn glass_ball(change: impl FnOnce(&mut SceneParts)) -> Scene {
    let mut parts = mitsuba::load_parts(
        &support::bundled_file("glass-ball"),
        &[("size".into(), "32".into())],
    )
    .unwrap();
    change(&mut parts);
    Scene::new(parts).unwrap()
}

pub fn photons(scene: &Scene) -> (Receiver, Estimate) {
    let progress = Progress::default();
    let settings = PhotonSettings::default();
    let setup = Setup::new(scene, &scene.sensors()[0], settings, &progress).unwrap();
    let budget = Budget {
        work: Some(1 << 18),
        ..Budget::default()
    };
    let Target::Receiver(receiver) = setup.target() else {
        unreachable!("the sensor is a meter")
    };
    (Receiver::clone(receiver), setup.run(&budget).unwrap())
}

/// [-1, 1]² in the xy plane.
pub fn square() -> Rectangle {
    Rectangle::new(&Transform::IDENTITY, false).unwrap()
}
