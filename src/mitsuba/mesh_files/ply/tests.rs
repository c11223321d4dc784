use super::*;

/// A square of two triangles, given as one polygon, with every attribute and properties to skip.
fn ascii() -> String {
    "ply\r\nformat ascii 1.0\r\ncomment a square\nelement vertex 4\n\
     property float confidence\nproperty double z\nproperty float x\nproperty float y\n\
     property float nx\nproperty float ny\nproperty float nz\nproperty float s\nproperty float t\n\
     property list uchar int skipped\n\
     element material 1\nproperty uchar red\nproperty list uint8 float32 weights\n\
     element face 1\nproperty uchar flags\nproperty list uchar uint vertex_index\n\
     element nothing 1000000000000\nend_header\n\
     0.5 0 0 0  0 0 1  0 0  0\n0.5 0 1 0  0 0 1  1 0  2 7 8\n\
     0.5 0.1 1 1  0 0 1  1 1  0\n0.5 0 0 1  0 0 2  0 1  0\n\
     255 2 0.5 0.5\n9 4 0 1 2 3\n"
        .to_owned()
}

/// The same in binary.
fn binary(big_endian: bool) -> Vec<u8> {
    let name = if big_endian {
        "binary_big_endian"
    } else {
        "binary_little_endian"
    };
    let text = ascii();
    let header_end = text.find("end_header\n").unwrap() + "end_header\n".len();
    let mut bytes = text[..header_end]
        .replace("ascii 1.0\r", &format!("{name} 1.0"))
        .into_bytes();
    let mut put = |little: &[u8]| {
        let mut little = little.to_vec();
        if big_endian {
            little.reverse();
        }
        bytes.extend(little);
    };
    for (index, [x, y, z]) in [
        [0.0, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.1],
        [0.0, 1.0, 0.0_f64],
    ]
    .iter()
    .enumerate()
    {
        put(&0.5_f32.to_le_bytes());
        put(&z.to_le_bytes());
        let nz = if index == 3 { 2.0 } else { 1.0 };
        for number in [*x, *y, 0.0, 0.0, nz, *x, *y] {
            put(&(number as f32).to_le_bytes());
        }
        if index == 1 {
            put(&[2]);
            put(&7_i32.to_le_bytes());
            put(&8_i32.to_le_bytes());
        } else {
            put(&[0]);
        }
    }
    put(&[255]);
    put(&[2]);
    put(&0.5_f32.to_le_bytes());
    put(&0.5_f32.to_le_bytes());
    put(&[9]);
    put(&[4]);
    (0..4_u32).for_each(|index| put(&index.to_le_bytes()));
    bytes
}

fn error(text: &str) -> String {
    parse(text.as_bytes()).unwrap_err().to_string()
}

/// Header lines between `format` and `end_header`, then the body.
fn with(header: &str, body: &str) -> String {
    format!("ply\nformat ascii 1.0\n{header}end_header\n{body}")
}

const XYZ: &str = "property float x\nproperty float y\nproperty float z\n";
const POLYGONS: &str = "property list uchar int vertex_indices\n";

#[test]
fn ascii_and_both_binary_forms_say_the_same() {
    let files = [ascii().into_bytes(), binary(false), binary(true)];
    for parts in files.iter().map(|bytes| parse(bytes).unwrap()) {
        assert_eq!(parts.triangles, [[0, 1, 2], [0, 2, 3]]);
        // A double keeps its digits.
        assert_eq!(parts.positions[2], DVec3::new(1.0, 1.0, 0.1));
        assert_eq!(parts.normals.unwrap()[3], DVec3::new(0.0, 0.0, 2.0));
        assert_eq!(parts.uvs.unwrap()[1], DVec2::X);
    }
}

#[test]
fn attributes_that_are_not_complete_are_no_attributes() {
    let text = with(
        &format!(
            "element vertex 3\n{XYZ}property float nx\nproperty float u\nelement face 1\n{POLYGONS}"
        ),
        "0 0 0 1 1\n1 0 0 1 1\n0 1 0 1 1\n3 0 1 2\n",
    );
    let parts = parse(text.as_bytes()).unwrap();
    assert!(parts.normals.is_none() && parts.uvs.is_none());
}

#[test]
fn every_truncation_is_an_error_and_names_a_place() {
    for bytes in [binary(false), binary(true)] {
        for length in 0..bytes.len() {
            let error = parse(&bytes[..length]).unwrap_err().to_string();
            assert!(
                error.starts_with("line ") || error.starts_with("byte "),
                "{length}: {error}"
            );
        }
    }
}

#[test]
fn announced_counts_reserve_no_memory_that_the_file_does_not_have() {
    let vertices = with(
        &format!("element vertex 999999999999\n{XYZ}element face 1\n{POLYGONS}"),
        "0 0 0\n",
    );
    assert!(
        error(&vertices).contains("announces 999999999999 of \"vertex\""),
        "{}",
        error(&vertices)
    );
    let faces = with(
        &format!("element vertex 1\n{XYZ}element face 88888888888\n{POLYGONS}"),
        "0 0 0\n3 0 0 0\n",
    );
    assert!(
        error(&faces).contains("announces 88888888888 of \"face\""),
        "{}",
        error(&faces)
    );
    let list = with(
        &format!("element vertex 1\n{XYZ}element face 1\nproperty list uint int vertex_indices\n"),
        "0 0 0\n4000000000 0 0 0\n",
    );
    assert!(error(&list).contains("ends too early"), "{}", error(&list));
}

#[test]
fn attributes_of_a_face_with_many_corners_take_no_memory_that_the_file_does_not_pay_for() {
    let attributes = |count: usize| {
        let lines = (0..count).map(|index| format!("property uchar a{index}_0\n"));
        lines.collect::<Vec<_>>().concat()
    };
    let file = |corners: usize, count: usize| {
        let face = |value: &str| format!("{value} ").repeat(count);
        with(
            &format!(
                "element vertex 1\n{XYZ}element face 1\n{}property list uint uchar vertex_indices\n",
                attributes(count)
            ),
            &format!("0 0 0\n{}{corners} {}\n", face("7"), "0 ".repeat(corners)),
        )
    };
    // 2,000 attributes of 50,000 triangles are 800 MB, of a file of 150 kB.
    let message = error(&file(50_002, 2_000));
    assert!(
        message.contains("face 0: so many corners, by 2000 attributes"),
        "{message}"
    );
    let parts = parse(file(10, 2_000).as_bytes()).unwrap();
    assert_eq!((parts.triangles.len(), parts.attributes.len()), (8, 2_000));
    // Without attributes, a polygon may have as many corners as it likes.
    assert_eq!(
        parse(file(50_002, 0).as_bytes()).unwrap().triangles.len(),
        50_000
    );
}

#[test]
fn errors_name_the_line_and_the_value() {
    let one_face = |face: &str| {
        error(&with(
            &format!("element vertex 1\n{XYZ}element face 1\n{POLYGONS}"),
            &format!("0 0 0\n{face}\n"),
        ))
    };
    assert_eq!(one_face("3 0 0 x"), "line 11: \"x\" is not a number");
    assert_eq!(
        one_face("2 0 0"),
        "line 10: a face needs 3 corners or more, not 2"
    );
    assert_eq!(
        one_face("-1 0 0"),
        "line 10: -1 cannot be the length of a list"
    );
    assert_eq!(
        one_face("3 0 0.5 0"),
        "line 11: 0.5 cannot be the number of a vertex"
    );
    assert_eq!(
        one_face("3 0 1 0"),
        "triangle 0 refers to vertex 1, but there are only 1"
    );
    let infinite = with(
        &format!("element vertex 1\n{XYZ}element face 0\n{POLYGONS}"),
        "0 inf 0\n",
    );
    assert!(error(&infinite).contains("vertex 0 has a number that is not finite"));
}

#[test]
fn headers_are_checked_line_by_line() {
    for (text, expected) in [
        ("", "line 1: the header has no end_header"),
        ("plyx\n", "line 1: a PLY file begins with \"ply\""),
        (
            "ply\nformat ascii 2.0\n",
            "line 2: \"format ascii 2.0\" is not known in a header",
        ),
        ("ply\nformat binary 1.0\n", "line 2: the format must be"),
        (
            "ply\nformat ascii 1.0\nproperty float x\n",
            "line 3: a property before the first element",
        ),
        (
            "ply\nelement vertex -1\n",
            "line 2: \"-1\" is not a number of elements",
        ),
        (
            "ply\nelement a 1\nelement a 1\n",
            "line 3: element \"a\" is declared twice",
        ),
        (
            "ply\nelement a 1\nproperty real x\n",
            "line 3: \"property real x\" is not",
        ),
        ("ply\nend_header\n", "line 2: the header names no format"),
        (
            "ply\nformat ascii 1.0\nend_header\n",
            "the header declares no element \"vertex\"",
        ),
    ] {
        let found = error(text);
        assert!(
            found.starts_with(expected),
            "{found:?} does not begin with {expected:?}"
        );
    }
}
