//! Normals and surface parameters are those of Mitsuba 3.
//!
//! The constants were read from Mitsuba 3.9.1 (`scalar_rgb`): `ray_intersect`, then `t`,
//! `sh_frame.n` and `uv`. Rays are given in the shape's own space and mapped with it.

use Form::{Cylinder, Disk, Rectangle, Sphere};
use Map::{Identity, Long, MirrorZ, Rotated, RotatedMirror, Sheared, Stretched};
use glam::{DMat3, DMat4, DVec2, DVec3};
use nephroid::internals::geometry;
use nephroid::internals::geometry::{MeshParts, Ray, Shape, SurfacePoint, Transform, World};

use crate::support::geometry::{closest, mesh};

/// Mitsuba computes in `f32`. Its distances (up to 8 here) carry some ten roundings of 2^-24 each.
const SINGLE_PRECISION: f64 = 8.0 * 10.0 / 16_777_216.0;

#[derive(Clone, Copy, Debug)]
enum Form {
    Sphere,
    Rectangle,
    Disk,
    Cylinder,
}

#[derive(Clone, Copy, Debug)]
enum Map {
    Identity,
    Rotated,
    RotatedMirror,
    MirrorZ,
    Stretched,
    Sheared,
    Long,
}

impl Map {
    fn transform(self) -> Transform {
        let scale = |x, y, z| DMat4::from_scale(DVec3::new(x, y, z));
        let rotated = DMat4::from_translation(DVec3::new(1.0, 2.0, 3.0))
            * DMat4::from_axis_angle(DVec3::new(1.0, 2.0, 2.0) / 3.0, 40f64.to_radians())
            * scale(2.0, 2.0, 2.0);
        let matrix = match self {
            Identity => DMat4::IDENTITY,
            Rotated => rotated,
            RotatedMirror => rotated * scale(-1.0, 1.0, 1.0),
            MirrorZ => scale(1.0, 1.0, -1.0),
            Stretched => scale(2.0, 3.0, 0.5),
            Sheared => {
                DMat4::from_translation(DVec3::new(0.5, 0.0, 0.0))
                    * DMat4::from_mat3(DMat3::from_cols(
                        DVec3::new(2.0, 0.0, 0.0),
                        DVec3::new(0.5, 1.0, 0.0),
                        DVec3::new(0.0, 0.3, 1.5),
                    ))
            }
            Long => rotated * scale(1.0, 1.0, 3.0),
        };
        Transform::from_matrix(matrix).expect("these matrices can be inverted")
    }
}

/// From, and through, in the shape's own space.
type Sight = [[f64; 3]; 2];
const OUTSIDE: Sight = [[0.9, 1.7, 2.25], [0.3, 0.4, 0.25]];
const INSIDE: Sight = [[-0.2, -0.3, 0.5], [0.3, -0.4, 0.45]];
const BELOW: Sight = [[-0.2, -0.35, -0.75], [0.3, -0.4, 0.25]];

/// Form, map, `flip_normals`, sight; then what Mitsuba says: distance, normal, uv.
type Row = (Form, Map, bool, Sight, f64, [f64; 3], [f64; 2]);

#[rustfmt::skip]
const ROWS: &[Row] = &[
    (Sphere, Identity, false, OUTSIDE, 1.985507, [0.4156661, 0.6506099, 0.6355537], [0.1595167, 0.2807719]),
    (Sphere, Identity, false, INSIDE, 0.9943591, [0.7703952, -0.4940791, 0.4029604], [0.9092407, 0.3679812]),
    (Sphere, Identity, true, OUTSIDE, 1.985507, [-0.4156661, -0.6506099, -0.6355537], [0.1595167, 0.2807719]),
    (Sphere, Rotated, false, OUTSIDE, 3.971013, [0.3896398, 0.6956902, 0.6034866], [0.1595167, 0.2807719]),
    (Sphere, Rotated, false, INSIDE, 1.988719, [0.9898502, -0.1041138, -0.09673227], [0.9092407, 0.3679812]),
    (Sphere, Rotated, true, OUTSIDE, 3.971013, [-0.3896398, -0.6956902, -0.6034866], [0.1595167, 0.2807719]),
    (Sphere, RotatedMirror, false, OUTSIDE, 3.971014, [0.2688081, -0.2962224, -0.9165121], [0.1595167, 0.2807719]),
    (Sphere, RotatedMirror, false, INSIDE, 1.988719, [0.2305169, 0.8444871, -0.4834291], [0.9092407, 0.3679812]),
    (Sphere, RotatedMirror, true, OUTSIDE, 3.971014, [-0.2688081, 0.2962224, 0.9165121], [0.1595167, 0.2807719]),
    (Sphere, MirrorZ, false, OUTSIDE, 1.985507, [-0.4156661, -0.6506099, 0.6355537], [0.1595167, 0.2807719]),
    (Sphere, MirrorZ, false, INSIDE, 0.9943591, [-0.7703952, 0.4940791, 0.4029604], [0.9092407, 0.3679812]),
    (Sphere, MirrorZ, true, OUTSIDE, 1.985507, [0.4156661, 0.6506099, -0.6355537], [0.1595167, 0.2807719]),
    (Rectangle, Identity, false, OUTSIDE, 2.767134, [0.0, 0.0, 1.0], [0.6125001, 0.61875]),
    (Rectangle, Identity, false, BELOW, 0.8393636, [0.0, 0.0, 1.0], [0.5875, 0.30625]),
    (Rectangle, Identity, true, OUTSIDE, 2.767134, [0.0, 0.0, -1.0], [0.6125001, 0.61875]),
    (Rectangle, Rotated, false, OUTSIDE, 5.534268, [0.4805152, -0.1102823, 0.8700247], [0.6125, 0.6187499]),
    (Rectangle, Rotated, false, BELOW, 1.678727, [0.4805152, -0.1102823, 0.8700247], [0.5875, 0.30625]),
    (Rectangle, Rotated, true, OUTSIDE, 5.534268, [-0.4805152, 0.1102823, -0.8700247], [0.6125, 0.6187499]),
    (Rectangle, RotatedMirror, false, OUTSIDE, 5.534269, [0.4805152, -0.1102823, 0.8700247], [0.6125001, 0.6187499]),
    (Rectangle, RotatedMirror, false, BELOW, 1.678727, [0.4805152, -0.1102823, 0.8700247], [0.5875, 0.3062499]),
    (Rectangle, RotatedMirror, true, OUTSIDE, 5.534269, [-0.4805152, 0.1102823, -0.8700247], [0.6125001, 0.6187499]),
    (Rectangle, MirrorZ, false, OUTSIDE, 2.767134, [0.0, 0.0, -1.0], [0.6125001, 0.61875]),
    (Rectangle, MirrorZ, false, BELOW, 0.8393636, [0.0, 0.0, -1.0], [0.5875, 0.30625]),
    (Rectangle, MirrorZ, true, OUTSIDE, 2.767134, [0.0, 0.0, 1.0], [0.6125001, 0.61875]),
    (Rectangle, Stretched, false, OUTSIDE, 4.72634, [0.0, 0.0, 1.0], [0.6125, 0.61875]),
    (Rectangle, Stretched, false, BELOW, 0.8460385, [0.0, 0.0, 1.0], [0.5875, 0.30625]),
    (Rectangle, Stretched, true, OUTSIDE, 4.72634, [0.0, 0.0, -1.0], [0.6125, 0.61875]),
    (Rectangle, Sheared, false, OUTSIDE, 4.504568, [0.0, 0.0, 1.0], [0.6125, 0.61875]),
    (Rectangle, Sheared, false, BELOW, 1.354809, [0.0, 0.0, 1.0], [0.5875, 0.30625]),
    (Rectangle, Sheared, true, OUTSIDE, 4.504568, [0.0, 0.0, -1.0], [0.6125, 0.61875]),
    (Disk, Identity, false, OUTSIDE, 2.767134, [0.0, 0.0, 1.0], [0.3271563, 0.1293004]),
    (Disk, Identity, false, BELOW, 0.8393636, [0.0, 0.0, 1.0], [0.4251838, 0.8175126]),
    (Disk, Identity, true, OUTSIDE, 2.767134, [0.0, 0.0, -1.0], [0.3271563, 0.1293005]),
    (Disk, Rotated, false, OUTSIDE, 5.534269, [0.4805152, -0.1102823, 0.8700247], [0.3271561, 0.1293004]),
    (Disk, Rotated, false, BELOW, 1.678727, [0.4805152, -0.1102823, 0.8700247], [0.4251837, 0.8175126]),
    (Disk, Rotated, true, OUTSIDE, 5.534269, [-0.4805152, 0.1102823, -0.8700247], [0.3271561, 0.1293005]),
    (Disk, RotatedMirror, false, OUTSIDE, 5.534269, [0.4805152, -0.1102823, 0.8700247], [0.3271562, 0.1293004]),
    (Disk, RotatedMirror, false, BELOW, 1.678727, [0.4805152, -0.1102823, 0.8700247], [0.4251837, 0.8175126]),
    (Disk, RotatedMirror, true, OUTSIDE, 5.534269, [-0.4805152, 0.1102823, -0.8700247], [0.3271564, 0.1293005]),
    (Disk, MirrorZ, false, OUTSIDE, 2.767134, [0.0, 0.0, -1.0], [0.3271563, 0.1293005]),
    (Disk, MirrorZ, false, BELOW, 0.8393636, [0.0, 0.0, -1.0], [0.4251837, 0.8175126]),
    (Disk, MirrorZ, true, OUTSIDE, 2.767134, [0.0, 0.0, 1.0], [0.3271561, 0.1293004]),
    (Disk, Stretched, false, OUTSIDE, 4.72634, [0.0, 0.0, 1.0], [0.3271564, 0.1293005]),
    (Disk, Stretched, false, BELOW, 0.8460385, [0.0, 0.0, 1.0], [0.4251838, 0.8175126]),
    (Disk, Stretched, true, OUTSIDE, 4.72634, [0.0, 0.0, -1.0], [0.3271564, 0.1293005]),
    (Disk, Sheared, false, OUTSIDE, 4.504568, [0.0, 0.0, 1.0], [0.3271562, 0.1293004]),
    (Disk, Sheared, false, BELOW, 1.354809, [0.0, 0.0, 1.0], [0.4251838, 0.8175126]),
    (Disk, Sheared, true, OUTSIDE, 4.504568, [0.0, 0.0, -1.0], [0.3271564, 0.1293004]),
    (Cylinder, Identity, false, OUTSIDE, 1.591106, [0.5118741, 0.8590606, 0.0], [0.1644756, 0.9562469]),
    (Cylinder, Identity, false, INSIDE, 1.085248, [0.8590935, -0.5118186, 0.0], [0.9144859, 0.3940906]),
    (Cylinder, Identity, true, OUTSIDE, 1.591106, [-0.5118741, -0.8590606, 0.0], [0.1644756, 0.9562469]),
    (Cylinder, Rotated, false, OUTSIDE, 3.182212, [0.0819582, 0.9933671, 0.08065131], [0.1644756, 0.9562469]),
    (Cylinder, Rotated, false, INSIDE, 2.170496, [0.8731536, -0.03248734, -0.4863613], [0.9144859, 0.3940906]),
    (Cylinder, Rotated, true, OUTSIDE, 3.182212, [-0.0819582, -0.9933671, -0.08065131], [0.1644756, 0.9562469]),
    (Cylinder, RotatedMirror, false, OUTSIDE, 3.182212, [-0.7288907, 0.5014407, 0.4661282], [0.1644757, 0.9562469]),
    (Cylinder, RotatedMirror, false, INSIDE, 2.170497, [-0.4877184, -0.8581023, 0.1605962], [0.9144859, 0.3940905]),
    (Cylinder, RotatedMirror, true, OUTSIDE, 3.182212, [0.7288907, -0.5014407, -0.4661282], [0.1644757, 0.9562469]),
    (Cylinder, MirrorZ, false, OUTSIDE, 1.591106, [0.5118741, 0.8590605, 0.0], [0.1644756, 0.956247]),
    (Cylinder, MirrorZ, false, INSIDE, 1.085248, [0.8590935, -0.5118186, 0.0], [0.9144859, 0.3940906]),
    (Cylinder, MirrorZ, true, OUTSIDE, 1.591106, [-0.5118741, -0.8590605, 0.0], [0.1644756, 0.956247]),
    (Cylinder, Long, false, OUTSIDE, 7.980473, [0.081958, 0.9933671, 0.08065141], [0.1644757, 0.9562472]),
    (Cylinder, Long, false, INSIDE, 2.251664, [0.8731536, -0.03248734, -0.4863613], [0.9144859, 0.3940905]),
    (Cylinder, Long, true, OUTSIDE, 7.980473, [-0.081958, -0.9933671, -0.08065141], [0.1644757, 0.9562472]),
];

fn shape(form: Form, to_world: &Transform, flip: bool) -> Shape {
    match form {
        Sphere => Shape::Sphere(geometry::Sphere::new(to_world, flip).expect("round")),
        Rectangle => Shape::Rectangle(geometry::Rectangle::new(to_world, flip).expect("any map")),
        Disk => Shape::Disk(geometry::Disk::new(to_world, flip).expect("any map")),
        Cylinder => Shape::Cylinder(geometry::Cylinder::new(to_world, flip).expect("round")),
    }
}

fn look(world: &World, ray: &Ray) -> (f64, SurfacePoint) {
    let hit = closest(world, ray).expect("Mitsuba hits it");
    (hit.distance, world.surface_point(ray, &hit))
}

#[test]
fn analytic_shapes_have_mitsubas_normals_and_parameters() {
    for row in ROWS {
        let (form, map, flip, sight, distance, normal, uv) = *row;
        let to_world = map.transform();
        let [from, through] = sight.map(|p| to_world.point(DVec3::from_array(p)));
        let ray = Ray::new(from, (through - from).normalize());
        let (found, point) = look(&World::new(vec![shape(form, &to_world, flip)]), &ray);
        let off = (found - distance)
            .abs()
            .max(
                (point.geometric_normal - DVec3::from_array(normal))
                    .abs()
                    .max_element(),
            )
            .max((point.uv - DVec2::from_array(uv)).abs().max_element());
        assert!(off <= SINGLE_PRECISION, "{row:?}: {found}, {point:?}");
        assert_eq!(point.geometric_normal, point.shading_normal);
    }
}

/// Two faces over an edge, not in one plane.
fn fold(normals: Option<[[f64; 3]; 4]>, uvs: Option<[[f64; 2]; 4]>) -> MeshParts {
    MeshParts {
        positions: [
            [0.0, 0.0, 0.0],
            [1.0, 0.0, 0.0],
            [0.0, 1.0, 0.2],
            [1.2, 1.0, 1.0],
        ]
        .map(DVec3::from_array)
        .to_vec(),
        triangles: vec![[0, 1, 2], [1, 3, 2]],
        normals: normals.map(|normals| normals.map(DVec3::from_array).to_vec()),
        uvs: uvs.map(|uvs| uvs.map(DVec2::from_array).to_vec()),
        ..MeshParts::default()
    }
}

const UPWARD: [[f64; 3]; 4] = [
    [0.0, 0.0, 2.0],
    [0.3, 0.0, 1.0],
    [0.0, 0.3, 1.0],
    [0.3, 0.3, 1.0],
];

/// The points where the two faces of the fold are met from above.
fn fold_points(parts: MeshParts) -> [SurfacePoint; 2] {
    let world = World::new(vec![Shape::Mesh(mesh(parts))]);
    [[0.25, 0.375], [0.75, 0.75]].map(|[x, y]| {
        let ray = Ray::new(DVec3::new(x, y, 5.0), DVec3::NEG_Z);
        look(&world, &ray).1
    })
}

#[track_caller]
fn assert_normals(points: [SurfacePoint; 2], geometric: [[f64; 3]; 2], shading: [[f64; 3]; 2]) {
    for i in 0..2 {
        for (found, expected) in [
            (points[i].geometric_normal, geometric[i]),
            (points[i].shading_normal, shading[i]),
        ] {
            let off = (found - DVec3::from_array(expected)).abs().max_element();
            assert!(
                off <= SINGLE_PRECISION,
                "face {i}: {found}, not {expected:?}"
            );
        }
    }
}

/// Mitsuba's normals of the fold's faces, whatever their vertex normals.
const FACES: [[f64; 3]; 2] = [
    [0.0, -0.1961161, 0.9805807],
    [-0.4499213, -0.5848976, 0.6748819],
];
/// Its interpolated normals if it has made the vertex normals itself.
const SMOOTH: [[f64; 3]; 2] = [
    [-0.1736526, -0.3572012, 0.9177429],
    [-0.3501806, -0.5076218, 0.7872062],
];
/// Its interpolated normals from `UPWARD`.
const FROM_FILE: [[f64; 3]; 2] = [
    [0.0731376, 0.1097064, 0.9912695],
    [0.1900386, 0.2143852, 0.9580836],
];

fn reversed(normals: [[f64; 3]; 2]) -> [[f64; 3]; 2] {
    normals.map(|normal| normal.map(|x| -x))
}

#[test]
fn a_mesh_without_normals_gets_angle_weighted_ones() {
    assert_normals(fold_points(fold(None, None)), FACES, SMOOTH);
}

#[test]
fn a_meshs_own_normals_are_normalised_then_interpolated() {
    assert_normals(fold_points(fold(Some(UPWARD), None)), FACES, FROM_FILE);
}

#[test]
fn normals_against_the_winding_do_not_turn_the_geometric_normal_round() {
    let downward = UPWARD.map(|normal| normal.map(|x| -x));
    assert_normals(
        fold_points(fold(Some(downward), None)),
        FACES,
        reversed(FROM_FILE),
    );
}

#[test]
fn flip_normals_turns_both_normals_round() {
    let parts = MeshParts {
        flip_normals: true,
        ..fold(Some(UPWARD), None)
    };
    assert_normals(fold_points(parts), reversed(FACES), reversed(FROM_FILE));
}

#[test]
fn face_normals_ignores_vertex_normals() {
    for normals in [None, Some(UPWARD)] {
        let parts = MeshParts {
            face_normals: true,
            ..fold(normals, None)
        };
        assert_normals(fold_points(parts), FACES, FACES);
    }
}

#[test]
fn mesh_parameters_are_interpolated_or_else_barycentric() {
    let uvs = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.8, 0.9]];
    for (uvs, expected) in [
        (None, [[0.25, 0.375], [0.4166667, 0.3333333]]),
        (Some(uvs), [[0.25, 0.375], [0.5833334, 0.7083333]]),
    ] {
        let points = fold_points(fold(None, uvs));
        for i in 0..2 {
            let off = (points[i].uv - DVec2::from_array(expected[i]))
                .abs()
                .max_element();
            assert!(
                off <= SINGLE_PRECISION,
                "{} is not {:?}",
                points[i].uv,
                expected[i]
            );
        }
    }
}

#[test]
fn a_ball_that_is_not_round_is_refused() {
    for map in [Stretched, Sheared, Long] {
        assert!(
            geometry::Sphere::new(&map.transform(), false).is_err(),
            "{map:?}"
        );
    }
    for map in [Stretched, Sheared] {
        assert!(
            geometry::Cylinder::new(&map.transform(), false).is_err(),
            "{map:?}"
        );
    }
}
