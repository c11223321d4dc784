//! Reports on meshes that are not in order.

use glam::DVec3;
use nephroid::internals::geometry::{Mesh, MeshDiagnostics, MeshError, MeshParts};

use crate::support::geometry::{bumpy_torus, icosphere, mesh, placed};

fn diagnose(parts: MeshParts) -> MeshDiagnostics {
    mesh(parts).diagnose().clone()
}

#[test]
fn defects_are_found_once_and_change_nothing_of_a_mesh() {
    let asked = mesh(icosphere(2));
    let fresh = asked.clone();
    let first = asked.diagnose();
    assert!(std::ptr::eq(first, asked.diagnose()));
    assert_eq!(asked, fresh);
    assert_ne!(asked, mesh(icosphere(1)));
    assert_eq!(first, fresh.diagnose());
}

/// All of `parts` in one mesh.
fn together(parts: impl IntoIterator<Item = MeshParts>) -> MeshParts {
    parts
        .into_iter()
        .fold(MeshParts::default(), |mut all, one| {
            let first = all.positions.len() as u32;
            all.positions.extend(one.positions);
            all.triangles
                .extend(one.triangles.iter().map(|t| t.map(|vertex| vertex + first)));
            all
        })
}

fn inside_out(mut parts: MeshParts) -> MeshParts {
    for [_, b, c] in &mut parts.triangles {
        std::mem::swap(b, c);
    }
    parts
}

#[test]
fn a_closed_mesh_has_nothing_to_be_said_of_it() {
    for (parts, volume, tolerance) in [
        // The volume of an icosphere of 1280 faces is 1.2 % short of the ball's.
        (icosphere(3), 4.0 / 3.0 * std::f64::consts::PI, 0.02),
        // 2π²Rr² with r² = 0.35² + (0.06² / 4 + 0.02² / 2), up to a grid of 60 × 30.
        (bumpy_torus(60, 30), 2.46, 0.03),
    ] {
        let found = diagnose(parts);
        assert!(found.is_closed(), "{found}");
        assert!(!found.is_inward(), "{found}");
        assert_eq!(found.components, 1);
        assert!(
            (found.signed_volume / volume - 1.0).abs() < tolerance,
            "{found}"
        );
        assert_eq!(found.warnings(true), Vec::<String>::new());
    }
}

#[test]
fn a_hole_has_open_edges() {
    let mut parts = icosphere(1);
    let lost = parts.triangles.pop().expect("there are 80");
    let found = diagnose(parts);
    assert!(!found.is_closed());
    assert_eq!(found.open_edges.count, 3);
    let edge = found.open_edges.example.expect("one of the three");
    assert!(
        edge.iter().all(|vertex| lost.contains(vertex)),
        "{edge:?} is not of {lost:?}"
    );
    assert!(found.warnings(true)[0].contains("3 open edges"), "{found}");
    assert_eq!(found.warnings(false), Vec::<String>::new());
}

#[test]
fn a_fin_has_a_non_manifold_edge() {
    let mut parts = icosphere(1);
    let [a, b, _] = parts.triangles[0];
    parts.positions.push(DVec3::splat(3.0));
    parts
        .triangles
        .push([a, b, parts.positions.len() as u32 - 1]);
    let found = diagnose(parts);
    assert_eq!(found.non_manifold_edges.count, 1);
    assert_eq!(found.open_edges.count, 2);
    let mut edge = found.non_manifold_edges.example.expect("the one");
    edge.sort_unstable();
    assert_eq!(edge, [a.min(b), a.max(b)]);
}

#[test]
fn a_face_turned_round_clashes_with_its_neighbours() {
    let mut parts = icosphere(1);
    parts.triangles[5].swap(0, 1);
    let found = diagnose(parts);
    assert_eq!(found.clashing_edges.count, 3);
    assert!(!found.is_closed());
}

#[test]
fn a_mesh_inside_out_is_inward_unless_its_normals_are_flipped() {
    let found = diagnose(inside_out(icosphere(2)));
    assert!(found.is_closed());
    assert!(found.is_inward());
    assert_eq!(found.inward_components.count, 1);
    assert!(found.warnings(true)[0].contains("inside out"), "{found}");
    let flipped = MeshParts {
        flip_normals: true,
        ..inside_out(icosphere(2))
    };
    assert!(!diagnose(flipped).is_inward());
}

#[test]
fn an_inward_shell_within_an_outward_one_is_a_cavity() {
    let cavity = placed(inside_out(icosphere(2)), 0.5, DVec3::ZERO);
    let found = diagnose(together([icosphere(2), cavity]));
    assert_eq!(found.components, 2);
    assert_eq!(found.inward_components.count, 1);
    assert!(!found.is_inward());
    assert_eq!(found.warnings(true), Vec::<String>::new());
}

#[test]
fn vertices_repeated_for_each_face_do_not_open_a_mesh() {
    let whole = icosphere(2);
    let split = MeshParts {
        positions: whole
            .triangles
            .iter()
            .flatten()
            .map(|&vertex| whole.positions[vertex as usize])
            .collect(),
        triangles: (0..whole.triangles.len() as u32)
            .map(|face| [3 * face, 3 * face + 1, 3 * face + 2])
            .collect(),
        ..MeshParts::default()
    };
    let (split_vertices, vertices) = (split.positions.len(), whole.positions.len());
    let found = diagnose(split);
    assert!(found.is_closed(), "{found}");
    assert_eq!(found.repeated_positions.count, split_vertices - vertices);
}

#[test]
fn faces_of_no_area_and_faces_said_twice_are_counted() {
    let mut parts = icosphere(1);
    let faces = parts.triangles.len() as u32;
    let [a, b, c] = parts.triangles[7];
    parts.triangles.extend([[b, c, a], [a, a, b]]);
    let found = diagnose(parts);
    assert!(found.is_closed(), "{found}");
    assert_eq!(found.duplicate_faces.count, 1);
    assert_eq!(found.duplicate_faces.example, Some(faces));
    assert_eq!(found.zero_area_faces.count, 1);
    assert_eq!(found.zero_area_faces.example, Some(faces + 1));
    assert_eq!(found.warnings(false).len(), 2);
}

#[test]
fn normals_against_the_winding_are_counted() {
    let parts = icosphere(1);
    let normals = parts.positions.iter().map(|&p| -p).collect();
    let found = diagnose(MeshParts {
        normals: Some(normals),
        ..parts
    });
    assert_eq!(found.opposed_normals.count, 80);
}

#[test]
fn parts_that_make_no_mesh_are_refused_by_name() {
    let good = icosphere(0);
    let with = |change: &dyn Fn(&mut MeshParts)| {
        let mut parts = good.clone();
        change(&mut parts);
        Mesh::new(parts).expect_err("a defect")
    };
    assert_eq!(
        with(&|parts| parts.positions[3].y = f64::NAN),
        MeshError::VertexNotFinite { vertex: 3 }
    );
    assert_eq!(
        with(&|parts| parts.triangles[4][1] = 12),
        MeshError::IndexOutOfRange {
            face: 4,
            index: 12,
            vertices: 12
        }
    );
    assert_eq!(with(&|parts| parts.triangles.clear()), MeshError::Empty);
    assert_eq!(
        with(&|parts| parts.normals = Some(vec![DVec3::Z])),
        MeshError::AttributeCount {
            attribute: "normals".to_owned(),
            found: 1,
            of: "vertices",
            needed: 12
        }
    );
    assert!(matches!(
        with(&|parts| parts.positions[2].x = 1e200),
        MeshError::VertexTooFar { vertex: 2, .. }
    ));
}
