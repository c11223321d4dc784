//! Blocks with rounded edges and bumpy sides.

use glam::DVec3;

use crate::geometry::MeshParts;
use crate::numeric::math;

use super::ball::geodesic;

/// A block with rounded edges and bumpy sides, `20 frequency²` triangles and exact normals at the vertices.
///
/// Its distance from the origin in direction d is
///
/// ```text
/// r(d) = (Σ (d_i / half_width_i)⁴)^(−1/4) (1 + Σ a sin(k·d + p))
/// ```
///
/// over the three axes and the three waves of `BUMPS`; |a| sums to 0.03. The normal is that of r(d) d: along
/// r d − ∇r, with ∇r the gradient along the unit sphere. `frequency` 0 counts as 1.
pub fn bumpy_block(half_widths: DVec3, frequency: u32) -> MeshParts {
    let (directions, triangles) = geodesic(frequency.max(1));
    let (positions, normals) = directions
        .iter()
        .map(|&direction| surface(half_widths, direction))
        .unzip();
    MeshParts {
        positions,
        normals: Some(normals),
        triangles,
        ..MeshParts::default()
    }
}

/// The block's point and normal in a direction.
fn surface(half_widths: DVec3, direction: DVec3) -> (DVec3, DVec3) {
    let scaled = direction / half_widths;
    let squares = scaled * scaled;
    let sum = squares.dot(squares);
    let smooth = 1.0 / sum.sqrt().sqrt();
    let smooth_gradient = squares * scaled / half_widths * (-smooth / sum);
    let mut bumps = 1.0;
    let mut bumps_gradient = DVec3::ZERO;
    for (amplitude, wave, phase) in BUMPS {
        let wave = DVec3::from_array(wave);
        let angle = wave.dot(direction) + phase;
        bumps += amplitude * math::sin(angle);
        bumps_gradient += wave * (amplitude * math::cos(angle));
    }
    let distance = smooth * bumps;
    let gradient = smooth_gradient * bumps + bumps_gradient * smooth;
    let tangential = gradient - direction * gradient.dot(direction);
    let normal = direction * distance - tangential;
    (direction * distance, normal.normalize())
}

/// Amplitude, wave vector and phase of each bump wave, in no symmetry of the block.
const BUMPS: [(f64, [f64; 3], f64); 3] = [
    (0.014, [4.3, -2.9, 3.7], 0.9),
    (0.010, [-5.1, 6.8, 2.3], 2.3),
    (0.006, [8.7, 5.9, -9.1], 4.6),
];

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::checks::assert_closed_and_outward;

    const HALF_WIDTHS: DVec3 = DVec3::new(1.0, 0.8, 0.5);

    #[test]
    fn a_block_is_closed_and_of_genus_0() {
        let mesh = bumpy_block(HALF_WIDTHS, 24);
        assert_eq!(mesh.triangles.len(), 11_520);
        // V = 2 + F/2 on every closed triangle mesh of genus 0.
        assert_eq!(mesh.positions.len(), 2 + mesh.triangles.len() / 2);
        assert_closed_and_outward(&mesh);
    }

    #[test]
    fn a_block_fills_its_box_but_for_edges_and_bumps() {
        for (axis, half) in [DVec3::X, DVec3::Y, DVec3::Z]
            .into_iter()
            .zip(HALF_WIDTHS.to_array())
        {
            for side in [axis, -axis] {
                let reach = surface(HALF_WIDTHS, side).0.dot(side) / half;
                assert!((reach - 1.0).abs() <= 0.03, "{axis}: {reach}");
            }
        }
        // A corner of the block without bumps: 3^(-1/4) of the box's.
        let corner = surface(HALF_WIDTHS, HALF_WIDTHS.normalize()).0;
        let reach = corner.length() / HALF_WIDTHS.length();
        assert!(
            (reach / math::powf(3.0_f64, -0.25) - 1.0).abs() <= 0.03,
            "{reach}"
        );
    }

    #[test]
    fn normals_are_exact() {
        // Central differences over 2e-5 err by the square of it times third derivatives below 1e4, and by
        // roundings of 1e-16 over 1e-5.
        const STEP: f64 = 1e-5;
        for direction in geodesic(7).0 {
            let (_, normal) = surface(HALF_WIDTHS, direction);
            let (u, v) = direction.any_orthonormal_pair();
            let slope = |w: DVec3| {
                let at = |step: f64| surface(HALF_WIDTHS, (direction + w * step).normalize()).0;
                (at(STEP) - at(-STEP)) / (2.0 * STEP)
            };
            assert!((normal.length() - 1.0).abs() < 1e-14);
            for tangent in [slope(u), slope(v)] {
                assert!(normal.dot(tangent).abs() < 1e-6, "{direction}");
            }
        }
    }
}
