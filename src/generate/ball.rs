//! Closed balls, smooth and bumpy.

use glam::DVec3;

use crate::geometry::{ICOSAHEDRON_FACES, MeshParts, icosahedron_corners};
use crate::numeric::math;

use super::cuts::{Weights, cut};

/// A geodesic sphere about the origin with `20 frequency²` triangles and exact vertex normals.
///
/// Every face of an icosahedron is cut into `frequency²` triangles, whose corners are then pushed onto the
/// sphere. The surface is inscribed: it lies inside the sphere by up to 0.3 radius / `frequency`².
///
/// `frequency` 0 counts as 1.
pub fn geodesic_sphere(radius: f64, frequency: u32) -> MeshParts {
    let (directions, triangles) = geodesic(frequency.max(1));
    MeshParts {
        positions: directions
            .iter()
            .map(|&direction| direction * radius)
            .collect(),
        normals: Some(directions),
        triangles,
        ..MeshParts::default()
    }
}

/// A ball with smooth bumps, `20 frequency²` triangles and exact normals at the vertices.
///
/// Its distance from the origin in direction d is
///
/// ```text
/// r(d) = radius (1 + Σ a sin(k·d + p))
/// ```
///
/// over the four waves of `BUMPS`; |a| sums to 0.07, so it is star-shaped and close to round. The normal is
/// that of r(d) d: along r d − ∇r, with ∇r the gradient along the unit sphere.
pub fn bumpy_ball(radius: f64, frequency: u32) -> MeshParts {
    let (directions, triangles) = geodesic(frequency.max(1));
    let mut positions = Vec::with_capacity(directions.len());
    let mut normals = Vec::with_capacity(directions.len());
    for &direction in &directions {
        let mut distance = 1.0;
        let mut gradient = DVec3::ZERO;
        for &(amplitude, wave, phase) in &BUMPS {
            let wave = DVec3::from_array(wave);
            let angle = wave.dot(direction) + phase;
            distance += amplitude * math::sin(angle);
            gradient += wave * (amplitude * math::cos(angle));
        }
        let tangential = gradient - direction * gradient.dot(direction);
        positions.push(direction * (radius * distance));
        normals.push((direction * distance - tangential).normalize());
    }
    MeshParts {
        positions,
        normals: Some(normals),
        triangles,
        ..MeshParts::default()
    }
}

/// Amplitude, wave vector and phase of each bump wave: of different lengths and in different
/// directions, so that the ball has no symmetry.
const BUMPS: [(f64, [f64; 3], f64); 4] = [
    (0.030, [3.1, 1.3, -2.2], 0.4),
    (0.020, [-2.4, 5.2, 3.3], 1.7),
    (0.012, [6.1, -4.7, 5.9], 2.9),
    (0.008, [-9.3, 8.4, 7.7], 5.1),
];

/// The unit directions and the triangles of an icosahedron cut `frequency` (at least 1) times,
/// counter-clockwise from outside.
pub(crate) fn geodesic(frequency: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let corners = icosahedron_corners();
    let (vertices, triangles) = cut(ICOSAHEDRON_FACES, frequency);
    let direction = |weights: &Weights| {
        let weighted = weights.iter().filter(|(_, weight)| *weight > 0);
        let sum: DVec3 = weighted
            .map(|&(corner, weight)| corners[corner] * f64::from(weight))
            .sum();
        sum.normalize()
    };
    (vertices.iter().map(direction).collect(), triangles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::checks::{assert_closed_and_outward, volume};

    #[test]
    fn a_geodesic_sphere_is_closed_outward_and_has_eulers_vertex_count() {
        for frequency in [1, 2, 5, 32] {
            let mesh = geodesic_sphere(2.0, frequency);
            assert_eq!(mesh.triangles.len(), 20 * (frequency * frequency) as usize);
            // V = 2 + F/2 on every closed triangle mesh of genus 0.
            assert_eq!(mesh.positions.len(), 2 + mesh.triangles.len() / 2);
            assert_closed_and_outward(&mesh);
        }
    }

    #[test]
    fn a_geodesic_spheres_volume_converges_to_the_balls_with_the_square_of_its_frequency() {
        let ball = 4.0 / 3.0 * std::f64::consts::PI;
        let deficit = |frequency| ball - volume(&geodesic_sphere(1.0, frequency));
        // Halving h divides an O(h²) deficit by 4, up to the O(h⁴) term: h² < 0.005 at frequency 16.
        let ratio = deficit(16) / deficit(32);
        assert!((ratio - 4.0).abs() < 4.0 * 0.005, "{ratio}");
    }

    #[test]
    fn a_bumpy_balls_normals_are_those_of_its_own_fine_facets() {
        let mesh = bumpy_ball(1.0, 96);
        assert_closed_and_outward(&mesh);
        let normals = mesh.normals.as_ref().unwrap();
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let facet = (b - a).cross(c - a).normalize();
            let mean: DVec3 = triangle
                .iter()
                .map(|&i| normals[i as usize])
                .sum::<DVec3>()
                .normalize();
            // Over a triangle of width w both means differ from the slope in its middle by less than w²/2
            // times the surface's third derivative. That is Σ a |k|³ < 45, and 5 for the products of lower
            // derivatives with the sphere's own. Projection widens an icosahedron's edges, 1.052 / frequency
            // apart on the sphere's chord, by less than 1.26.
            let width: f64 = 1.052 * 1.26 / 96.0;
            let bound = 2.0 * 0.5 * width * width * 50.0;
            assert!(
                facet.dot(mean) > math::cos(bound),
                "{}",
                math::acos(facet.dot(mean))
            );
        }
    }

    #[test]
    fn the_bench_sizes_are_80_thousand_and_330_thousand_triangles() {
        assert_eq!(bumpy_ball(1.0, 64).triangles.len(), 81_920);
        assert_eq!(bumpy_ball(1.0, 128).triangles.len(), 327_680);
    }
}
