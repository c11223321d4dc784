//! The icosahedron from which geodesic spheres are cut.

use glam::DVec3;

/// The corners of an icosahedron of edge length 2 about the origin.
pub fn icosahedron_corners() -> [DVec3; 12] {
    let golden = f64::midpoint(1.0, 5.0_f64.sqrt());
    let mut corners = [DVec3::ZERO; 12];
    for (i, corner) in corners.iter_mut().enumerate() {
        let short = if i & 1 == 0 { 1.0 } else { -1.0 };
        let long = if i & 2 == 0 { golden } else { -golden };
        *corner = match i / 4 {
            0 => DVec3::new(0.0, short, long),
            1 => DVec3::new(long, 0.0, short),
            _ => DVec3::new(short, long, 0.0),
        };
    }
    corners
}

/// The 20 triples of corners at the edge length 2 from each other, oriented outward.
pub const ICOSAHEDRON_FACES: [[usize; 3]; 20] = [
    [0, 1, 4],
    [0, 6, 1],
    [0, 4, 8],
    [0, 9, 6],
    [0, 8, 9],
    [1, 10, 4],
    [1, 6, 11],
    [1, 11, 10],
    [2, 5, 3],
    [2, 3, 7],
    [2, 8, 5],
    [2, 7, 9],
    [2, 9, 8],
    [3, 5, 10],
    [3, 11, 7],
    [3, 10, 11],
    [4, 5, 8],
    [4, 10, 5],
    [6, 9, 7],
    [6, 7, 11],
];
