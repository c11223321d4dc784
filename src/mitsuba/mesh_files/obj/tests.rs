use std::fmt::Write;

use super::*;
use crate::numeric::math;

fn error(text: &str) -> String {
    parse(text.as_bytes()).unwrap_err().to_string()
}

#[test]
fn corners_merge_only_where_all_three_indices_agree() {
    let text = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvn 0 0 1\nvn 0 0 2\nvt 0 0\nf 1/1/1 2/1/1 3/1/1\nf 1/1/1 3/1/2 4/1/1\n";
    let parts = parse(text.as_bytes()).unwrap();
    assert_eq!(parts.positions.len(), 5);
    assert_eq!(parts.triangles, [[0, 1, 2], [0, 3, 4]]);
    assert_eq!(parts.positions[2], parts.positions[3]);
    assert_eq!(parts.normals.unwrap()[3], DVec3::new(0.0, 0.0, 2.0));
}

#[test]
fn groups_do_not_split_the_mesh() {
    let text = "g a\nv 0 0 0\nv 1 0 0\nv 1 1 0\nf 1 2 3\ng b\nusemtl x\nv 0 1 0\nf 1 3 4\n";
    let parts = parse(text.as_bytes()).unwrap();
    assert_eq!(parts.positions.len(), 4);
    assert_eq!(parts.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert!(parts.normals.is_none() && parts.uvs.is_none());
}

#[test]
fn polygons_become_fans_and_negative_indices_count_from_the_end() {
    let text = "v 0 0 0\nv 1 0 0\r\nv 2 1 0 1.0\nv 1 2 0\nv 0 1 0\nf -5 -4 -3 -2 -1\n";
    let parts = parse(text.as_bytes()).unwrap();
    assert_eq!(parts.triangles, [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
}

/// tobj triangulates convex polygons as fans, too, and keeps single precision.
#[test]
fn corners_are_those_that_tobj_reads() {
    let size = 20;
    let mut text = String::new();
    for row in 0..=size {
        for column in 0..=size {
            let (x, y) = (f64::from(column) / 7.0, f64::from(row) / 3.0);
            writeln!(
                text,
                "v {x} {y} {}\nvt {} {}",
                math::sin(x * y),
                x / 9.0,
                y / 9.0
            )
            .unwrap();
        }
    }
    text += "vn 0 0 1\nvn 0 0.6 0.8\nvn 1e-3 0 1\n";
    for row in 0..size {
        for column in 0..size {
            let first = 1 + row * (size + 1) + column;
            let ring = [first, first + 1, first + size + 2, first + size + 1];
            let corner = |index: &i32| format!(" {index}/{index}/{}", 1 + (index + row) % 3);
            writeln!(text, "f{}", ring.iter().map(corner).collect::<String>()).unwrap();
        }
    }
    let options = tobj::LoadOptions {
        triangulate: true,
        single_index: true,
        ..tobj::LoadOptions::default()
    };
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::GenericFailure);
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, no_materials).unwrap();
    let [model] = &models[..] else {
        panic!("{} models", models.len())
    };
    let (theirs, ours) = (&model.mesh, parse(text.as_bytes()).unwrap());
    assert_eq!(theirs.positions.len(), 3 * ours.positions.len());
    assert_eq!(theirs.indices.len(), 3 * ours.triangles.len());
    let (normals, uvs) = (ours.normals.unwrap(), ours.uvs.unwrap());
    for (their_vertex, our_vertex) in theirs.indices.iter().zip(ours.triangles.iter().flatten()) {
        let (theirs_at, ours_at) = (*their_vertex as usize, *our_vertex as usize);
        assert_eq!(
            theirs.positions[3 * theirs_at..][..3],
            ours.positions[ours_at].as_vec3().to_array()
        );
        assert_eq!(
            theirs.normals[3 * theirs_at..][..3],
            normals[ours_at].as_vec3().to_array()
        );
        assert_eq!(
            theirs.texcoords[2 * theirs_at..][..2],
            uvs[ours_at].as_vec2().to_array()
        );
    }
}

#[test]
fn decimals_keep_double_precision() {
    let parts = parse(b"v 0.1 1e-300 3\nv 1 0 0\nv 1 1 0\nf 1 2 3").unwrap();
    assert_eq!(parts.positions[0], DVec3::new(0.1, 1e-300, 3.0));
}

#[test]
fn a_position_with_many_normals_stays_merged_beyond_the_chain() {
    let count = 3 * LONGEST_CHAIN;
    let mut text = String::from("v 0 0 0\nv 1 0 0\nv 0 1 0\n");
    for n in 1..=count {
        writeln!(text, "vn 0 0 {n}").unwrap();
    }
    for _ in 0..2 {
        for n in 1..=count {
            writeln!(text, "f 1//{n} 2//1 3//1").unwrap();
        }
    }
    assert_eq!(parse(text.as_bytes()).unwrap().positions.len(), count + 2);
}

#[test]
fn errors_name_the_line_and_the_value() {
    assert_eq!(
        error("v 0 0\n"),
        "line 1: vertex 0: expected 3 numbers, found 2"
    );
    assert_eq!(
        error("\nv 0 x 0\n"),
        "line 2: vertex 0: \"x\" is not a finite number"
    );
    assert_eq!(
        error("v nan 0 0\n"),
        "line 1: vertex 0: \"nan\" is not a finite number"
    );
    assert_eq!(
        error("v 0 0 0\nf 1 2 1\n"),
        "line 2: refers to vertex 2, but 1 are known here"
    );
    assert_eq!(
        error("v 0 0 0\nf 0 1 1\n"),
        "line 2: refers to vertex 0, but 1 are known here"
    );
    assert_eq!(
        error("v 0 0 0\nf 1 1\n"),
        "line 2: a face needs 3 corners or more, not 2"
    );
    assert_eq!(
        error("v 0 0 0\nf 1/1/1/1 1 1\n"),
        "line 2: refers to texture coordinate 1, but 0 are known here"
    );
    assert_eq!(
        error("v 0 0 0\nf / 1 1\n"),
        "line 2: \"/\" must be v, v/vt, v//vn or v/vt/vn"
    );
    assert_eq!(error("v 0 0 0\n"), "holds no faces");
}
