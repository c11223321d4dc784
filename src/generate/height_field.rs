//! Rippled water, and hills.

use glam::{DVec2, DVec3};

use crate::geometry::MeshParts;
use crate::numeric::math;

/// One sine wave on a water surface: its height is `amplitude · sin(wave · (x, y) + phase)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Wave {
    /// The amplitude in scene units.
    pub amplitude: f64,
    /// The wave vector [rad / scene unit]: along the direction of travel, of length 2π / wavelength.
    pub wave: DVec2,
    /// The phase in radians.
    pub phase: f64,
}

/// A height field z = `level` + Σ waves over the rectangle |x| ≤ `half_widths.x`, |y| ≤ `half_widths.y`, in
/// scene units; normals upward and exact.
///
/// `vertices_per_side`² vertices (at least 2 a side), two triangles a cell, cut from (−, −) to (+, +). The
/// field is open: it has neither walls nor a floor.
pub fn height_field(
    half_widths: DVec2,
    level: f64,
    waves: &[Wave],
    vertices_per_side: u32,
) -> MeshParts {
    let side = vertices_per_side.max(2);
    let coordinate =
        |half_width: f64, i: u32| half_width * (2.0 * f64::from(i) / f64::from(side - 1) - 1.0);
    let mut positions = Vec::with_capacity((side * side) as usize);
    let mut normals = Vec::with_capacity((side * side) as usize);
    for j in 0..side {
        for i in 0..side {
            let xy = DVec2::new(coordinate(half_widths.x, i), coordinate(half_widths.y, j));
            let mut height = level;
            let mut slope = DVec2::ZERO;
            for wave in waves {
                let angle = wave.wave.dot(xy) + wave.phase;
                height += wave.amplitude * math::sin(angle);
                slope += wave.wave * (wave.amplitude * math::cos(angle));
            }
            positions.push(xy.extend(height));
            normals.push(DVec3::new(-slope.x, -slope.y, 1.0).normalize());
        }
    }
    let mut triangles = Vec::with_capacity(2 * ((side - 1) * (side - 1)) as usize);
    for j in 0..side - 1 {
        for i in 0..side - 1 {
            let low = j * side + i;
            let high = low + side;
            triangles.push([low, low + 1, high + 1]);
            triangles.push([low, high + 1, high]);
        }
    }
    MeshParts {
        positions,
        normals: Some(normals),
        triangles,
        ..MeshParts::default()
    }
}

/// Hills: a [`height_field`] about z = 0 with flat faces, and UVs that a meter's film can lie over.
///
/// u runs from 0 to 1 along x, v along y. It has no normals: its faces are what it is.
pub fn terrain(half_widths: DVec2, waves: &[Wave], vertices_per_side: u32) -> MeshParts {
    let mut mesh = height_field(half_widths, 0.0, waves, vertices_per_side);
    let steps = vertices_per_side.max(2) - 1;
    let part = |i: u32| f64::from(i) / f64::from(steps);
    let rows = (0..=steps).flat_map(|j| (0..=steps).map(move |i| (i, j)));
    mesh.uvs = Some(rows.map(|(i, j)| DVec2::new(part(i), part(j))).collect());
    mesh.normals = None;
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_height_field_covers_its_rectangle_once_and_faces_upward() {
        let waves = [Wave {
            amplitude: 0.05,
            wave: DVec2::new(4.0, 1.0),
            phase: 0.3,
        }];
        let mesh = height_field(DVec2::new(1.5, 1.0), 0.7, &waves, 40);
        let mut covered = 0.0;
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize].truncate());
            let area = 0.5 * (b - a).perp_dot(c - a);
            assert!(area > 0.0);
            covered += area;
        }
        // 3042 additions of numbers up to 6, each rounded by at most half an ulp.
        assert!(
            (covered - 6.0).abs() < 3042.0 * 6.0 * f64::EPSILON,
            "{covered}"
        );
    }

    #[test]
    fn its_normals_are_the_heights_gradient() {
        let waves = [
            Wave {
                amplitude: 0.05,
                wave: DVec2::new(4.0, 1.0),
                phase: 0.3,
            },
            Wave {
                amplitude: 0.02,
                wave: DVec2::new(-3.0, 7.0),
                phase: 1.3,
            },
        ];
        let side = 401;
        let mesh = height_field(DVec2::ONE, 0.0, &waves, side);
        let step = 2.0 / f64::from(side - 1);
        let at = |i: u32, j: u32| mesh.positions[(j * side + i) as usize].z;
        for (i, j) in [(1, 1), (57, 200), (350, 9)] {
            let normal = mesh.normals.as_ref().unwrap()[(j * side + i) as usize];
            let slope_x = (at(i + 1, j) - at(i - 1, j)) / (2.0 * step);
            let slope_y = (at(i, j + 1) - at(i, j - 1)) / (2.0 * step);
            // A central difference errs by h²/6 times the third derivative, Σ a |k|³ < 13 here.
            let bound = step * step / 6.0 * 13.0;
            assert!((-normal.x / normal.z - slope_x).abs() < bound);
            assert!((-normal.y / normal.z - slope_y).abs() < bound);
        }
    }
    #[test]
    fn a_terrains_uvs_cover_the_unit_square_as_its_places_do_the_rectangle() {
        let half_widths = DVec2::new(3.0, 2.0);
        let mesh = terrain(half_widths, &[], 7);
        let uvs = mesh.uvs.as_ref().unwrap();
        assert_eq!(uvs.len(), mesh.positions.len());
        assert_eq!((uvs[0], uvs[48]), (DVec2::ZERO, DVec2::ONE));
        for (uv, position) in uvs.iter().zip(&mesh.positions) {
            let expected = position.truncate() / (2.0 * half_widths) + 0.5;
            assert!(uv.distance(expected) < 1e-15);
        }
    }
}
