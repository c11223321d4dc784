//! Cut glass: solids with flat facets and sharp edges.

use std::f64::consts::{FRAC_PI_8, TAU};

use glam::DVec3;

use crate::geometry::MeshParts;
use crate::numeric::math;

use super::cuts::{Weights, cut};

/// A prism: an equilateral triangle of side length `side` about the z axis, extruded along z from
/// −`length`/2 to `length`/2, one corner on the +x axis. 8 triangles.
pub fn equilateral_prism(side: f64, length: f64) -> MeshParts {
    let circumradius = side / 3.0_f64.sqrt();
    let mut positions = Vec::with_capacity(6);
    for z in [-0.5 * length, 0.5 * length] {
        for i in 0..3 {
            let (sin, cos) = math::sin_cos(TAU * f64::from(i) / 3.0);
            positions.push(DVec3::new(circumradius * cos, circumradius * sin, z));
        }
    }
    let mut triangles = vec![[0, 2, 1], [3, 4, 5]];
    for i in 0..3 {
        let next = (i + 1) % 3;
        triangles.push([i, next, next + 3]);
        triangles.push([i, next + 3, i + 3]);
    }
    flat(positions, triangles)
}

/// The proportions of a round brilliant cut; lengths are fractions of its girdle's radius.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BrilliantCut {
    /// Radius of the octagonal table's corners.
    pub table: f64,
    /// Angle of the kite facets to the table (rad).
    pub crown_angle: f64,
    /// Angle of the pavilion's main facets to the table (rad).
    pub pavilion_angle: f64,
    /// Radius at which a star facet's tip lies.
    pub star: f64,
    /// Radius at which the lower halves' tips lie.
    pub lower_half: f64,
    /// Height of the girdle.
    pub girdle: f64,
}

impl BrilliantCut {
    /// Near Tolkowsky's proportions: table 0.53, crown 34.5°, pavilion 40.75°.
    pub const TOLKOWSKY: Self = Self {
        table: 0.53,
        crown_angle: 34.5 * TAU / 360.0,
        pavilion_angle: 40.75 * TAU / 360.0,
        star: 0.78,
        lower_half: 0.22,
        girdle: 0.04,
    };
}

/// A round brilliant: 57 flat facets and a girdle of 16, pointed down, the girdle's middle in the plane z =
/// 0.
///
/// Around the table (1) lie 8 stars, 8 kites and 16 upper halves; below the girdle 16 lower halves and 8
/// pavilion mains that meet in the culet. Kites and mains are exactly planar: the tips of the stars and of
/// the lower halves are placed in their planes. 110 triangles.
pub fn round_brilliant(girdle_radius: f64, cut: BrilliantCut) -> MeshParts {
    // Corners by ring: kites are an eighth of a turn apart, "half" corners between them.
    let at = |radius: f64, eighths: f64, z: f64| {
        let (sin, cos) = math::sin_cos(2.0 * FRAC_PI_8 * eighths);
        DVec3::new(radius * cos, radius * sin, z) * girdle_radius
    };
    let cos_half = math::cos(FRAC_PI_8);
    let crown_slope = math::tan(cut.crown_angle);
    let pavilion_slope = math::tan(cut.pavilion_angle);
    let top = 0.5 * cut.girdle;
    let bottom = -top;
    // A facet at the angle 0 has the plane z = z_girdle ± (1 − x) slope; a corner on the ring of radius r
    // half an eighth off has x = r cos(π/8).
    let table_z = top + (1.0 - cut.table) * crown_slope;
    let star_z = top + (1.0 - cut.star * cos_half) * crown_slope;
    let lower_z = bottom - (1.0 - cut.lower_half * cos_half) * pavilion_slope;
    let culet_z = bottom - pavilion_slope;

    let mut positions = Vec::new();
    let mut ring = |count: u32, radius: f64, first: f64, z: f64| {
        let start = positions.len() as u32;
        let step = 8.0 / f64::from(count);
        positions.extend((0..count).map(|i| at(radius, first + step * f64::from(i), z)));
        move |i: u32| start + i % count
    };
    let table = ring(8, cut.table, 0.0, table_z);
    let star = ring(8, cut.star, 0.5, star_z);
    let upper = ring(16, 1.0, 0.0, top);
    let under = ring(16, 1.0, 0.0, bottom);
    let lower = ring(8, cut.lower_half, 0.5, lower_z);
    let culet = ring(1, 0.0, 0.0, culet_z)(0);

    let mut triangles = Vec::with_capacity(110);
    triangles.extend((1..7).map(|i| [table(0), table(i), table(i + 1)]));
    for i in 0..8 {
        let (here, half, next) = (2 * i, 2 * i + 1, 2 * i + 2);
        triangles.push([table(i), star(i), table(i + 1)]);
        // The kite at this eighth: table corner, the tips on both sides, girdle corner.
        triangles.push([table(i), star(i + 7), upper(here)]);
        triangles.push([table(i), upper(here), star(i)]);
        triangles.push([star(i), upper(here), upper(half)]);
        triangles.push([star(i), upper(half), upper(next)]);
        for j in [here, half] {
            triangles.push([upper(j), under(j), under(j + 1)]);
            triangles.push([upper(j), under(j + 1), upper(j + 1)]);
        }
        triangles.push([lower(i), under(half), under(here)]);
        triangles.push([lower(i), under(next), under(half)]);
        triangles.push([culet, under(here), lower(i + 7)]);
        triangles.push([culet, lower(i), under(here)]);
    }
    flat(positions, triangles)
}

/// A mesh of flat facets with every triangle cut into `frequency²` in its plane.
///
/// The body is the same. Triangles that share corners share the new vertices on their edges, so a closed
/// mesh stays closed. Normals and UVs are dropped; `frequency` 0 counts as 1.
pub fn subdivided_facets(mesh: &MeshParts, frequency: u32) -> MeshParts {
    let frequency = frequency.max(1);
    let faces = mesh
        .triangles
        .iter()
        .map(|triangle| triangle.map(|i| i as usize));
    let (vertices, triangles) = cut(faces, frequency);
    let position = |weights: &Weights| {
        let weighted = weights.iter().filter(|(_, weight)| *weight > 0);
        let sum: DVec3 = weighted
            .map(|&(corner, weight)| mesh.positions[corner] * f64::from(weight))
            .sum();
        sum / f64::from(frequency)
    };
    flat(vertices.iter().map(position).collect(), triangles)
}

fn flat(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> MeshParts {
    MeshParts {
        positions,
        triangles,
        face_normals: true,
        ..MeshParts::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::checks::{assert_closed_and_outward, volume};

    /// The unit normals of all triangles, those of one plane counted once.
    fn facets(mesh: &MeshParts) -> Vec<DVec3> {
        let mut normals: Vec<DVec3> = Vec::new();
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let normal = (b - a).cross(c - a).normalize();
            if normals.iter().all(|known| known.distance(normal) > 1e-12) {
                normals.push(normal);
            }
        }
        normals
    }

    #[test]
    fn a_round_brilliant_has_57_facets_and_16_on_its_girdle() {
        let mesh = round_brilliant(3.0, BrilliantCut::TOLKOWSKY);
        assert_eq!(mesh.triangles.len(), 110);
        assert_closed_and_outward(&mesh);
        let (girdle, cut): (Vec<_>, Vec<_>) =
            facets(&mesh).into_iter().partition(|n| n.z.abs() < 1e-12);
        assert_eq!((girdle.len(), cut.len()), (16, 57));
    }

    #[test]
    fn a_round_brilliant_is_convex() {
        let mesh = round_brilliant(1.0, BrilliantCut::TOLKOWSKY);
        for triangle in &mesh.triangles {
            let [a, b, c] = triangle.map(|i| mesh.positions[i as usize]);
            let normal = (b - a).cross(c - a).normalize();
            for &position in &mesh.positions {
                // On the plane up to a few roundings of coordinates of size 1, or behind it.
                assert!(normal.dot(position - a) < 1e-14, "{triangle:?} {position}");
            }
        }
    }

    #[test]
    fn a_subdivided_brilliant_is_the_same_closed_body() {
        let coarse = round_brilliant(1.0, BrilliantCut::TOLKOWSKY);
        let fine = subdivided_facets(&coarse, 4);
        assert_eq!(fine.triangles.len(), 110 * 16);
        // V = 2 + F/2 on every closed triangle mesh of genus 0.
        assert_eq!(fine.positions.len(), 2 + fine.triangles.len() / 2);
        assert!(fine.face_normals);
        assert_closed_and_outward(&fine);
        // Sums of 1760 terms below 1e-2, and corners that a quarter of them rounds.
        assert!((volume(&fine) - volume(&coarse)).abs() < 1e-13);
        for triangle in &fine.triangles {
            let [a, b, c] = triangle.map(|i| fine.positions[i as usize]);
            let normal = (b - a).cross(c - a).normalize();
            for &position in &coarse.positions {
                assert!(normal.dot(position - a) < 1e-13, "{triangle:?} {position}");
            }
        }
    }

    #[test]
    fn a_prism_has_five_facets_and_a_triangles_area_times_its_length() {
        let mesh = equilateral_prism(0.4, 1.5);
        assert_closed_and_outward(&mesh);
        assert_eq!(facets(&mesh).len(), 5);
        let exact = 3.0_f64.sqrt() / 4.0 * 0.16 * 1.5;
        assert!((volume(&mesh) - exact).abs() < 1e-15);
    }
}
