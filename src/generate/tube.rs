//! Closed tubes: rings and knots.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::geometry::MeshParts;
use crate::numeric::math;

/// A ring about the z axis in the plane z = 0: an ellipse carried round a circle of radius `radius`.
///
/// The ellipse has the half-axes `half_width` along the circle's radius and `half_height` along z. The mesh
/// has `2 around · across` triangles and exact vertex normals; both counts are at least 3.
pub fn ring(radius: f64, half_width: f64, half_height: f64, around: u32, across: u32) -> MeshParts {
    tube(around, across, |along, round| {
        let (sin, cos) = math::sin_cos(along);
        let (sin_round, cos_round) = math::sin_cos(round);
        let outward = DVec3::new(cos, sin, 0.0);
        let position =
            outward * (radius + half_width * cos_round) + DVec3::Z * (half_height * sin_round);
        let normal = outward * (half_height * cos_round) + DVec3::Z * (half_width * sin_round);
        (position, normal.normalize())
    })
}

/// A band about the z axis: a rectangle carried round it, from `inner` to `outer` and |z| ≤ `half_height`.
///
/// Its walls are cylinders, its rims are flat, and its edges sharp. `8 around` triangles with exact
/// normals at the vertices; `around` is at least 3.
pub fn band(inner: f64, outer: f64, half_height: f64, around: u32) -> MeshParts {
    let around = around.max(3);
    // Corners of the rectangle, and the normals of the sides that begin there, as (outward, up).
    let corners = [
        (outer, -half_height),
        (outer, half_height),
        (inner, half_height),
        (inner, -half_height),
    ];
    let side_normals = [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)];
    let (mut positions, mut normals, mut triangles) = (Vec::new(), Vec::new(), Vec::new());
    for (side, normal) in side_normals.into_iter().enumerate() {
        let first = positions.len() as u32;
        for i in 0..around {
            let (sin, cos) = math::sin_cos(TAU * f64::from(i) / f64::from(around));
            let at = |(outward, up): (f64, f64)| DVec3::new(outward * cos, outward * sin, up);
            positions.extend([at(corners[side]), at(corners[(side + 1) % 4])]);
            normals.extend([at(normal), at(normal)]);
            let (here, ahead) = (first + 2 * i, first + 2 * ((i + 1) % around));
            triangles.push([here, ahead, ahead + 1]);
            triangles.push([here, ahead + 1, here + 1]);
        }
    }
    MeshParts {
        positions,
        normals: Some(normals),
        triangles,
        ..MeshParts::default()
    }
}

/// A trefoil knot: a tube along a curve that winds twice about the z axis and three times about a circle.
///
/// The curve lies on the torus of radii `radius` and `winding`. The tube has the radius
///
/// ```text
/// thickness (1 + relief sin(10 t + 2 φ))
/// ```
///
/// with t the angle along the curve and φ the angle about it, counted from the torus's normal. Let `radius`
/// be 2 `winding`: then strands stay apart and bends open while `thickness (1 + relief)` is below 0.8
/// `winding`. The mesh has `2 around · across` triangles and exact vertex normals. Both counts are at least
/// 3.
pub fn trefoil_knot(
    radius: f64,
    winding: f64,
    thickness: f64,
    relief: f64,
    around: u32,
    across: u32,
) -> MeshParts {
    tube(around, across, |along, round| {
        let strand = Strand::new(radius, winding, along);
        let (sin, cos) = math::sin_cos(round);
        let angle = RIPPLES_ALONG * along + RIPPLES_ROUND * round;
        let r = thickness * (1.0 + relief * math::sin(angle));
        let slope = thickness * relief * math::cos(angle);
        let spoke = strand.normal * cos + strand.binormal * sin;
        let spoke_along = strand.normal_along * cos + strand.binormal_along * sin;
        let spoke_round = strand.binormal * cos - strand.normal * sin;
        let along = strand.velocity + spoke * (slope * RIPPLES_ALONG) + spoke_along * r;
        let round = spoke * (slope * RIPPLES_ROUND) + spoke_round * r;
        (strand.place + spoke * r, along.cross(round).normalize())
    })
}

/// Waves on the knot's tube, along it and round it: 10 are no multiple of 3, the knot's own symmetry.
const RIPPLES_ALONG: f64 = 10.0;
const RIPPLES_ROUND: f64 = 2.0;

/// A point of the knot's curve and the frame of its tube, with derivatives by the angle along it.
struct Strand {
    place: DVec3,
    velocity: DVec3,
    /// The torus's outward normal, which is perpendicular to the curve.
    normal: DVec3,
    normal_along: DVec3,
    binormal: DVec3,
    binormal_along: DVec3,
}

impl Strand {
    fn new(radius: f64, winding: f64, t: f64) -> Self {
        // Turns about the axis and about the circle.
        let (p, q) = (2.0, 3.0);
        let (sin, cos) = math::sin_cos(p * t);
        let (outward, onward) = (DVec3::new(cos, sin, 0.0), DVec3::new(-sin, cos, 0.0));
        let (sin, cos) = math::sin_cos(q * t);
        let normal = outward * cos + DVec3::Z * sin;
        let normal_along = outward * (-q * sin) + onward * (p * cos) + DVec3::Z * (q * cos);
        let normal_twice = outward * (-(p * p + q * q) * cos)
            + onward * (-2.0 * p * q * sin)
            + DVec3::Z * (-q * q * sin);
        let velocity = onward * (radius * p) + normal_along * winding;
        let acceleration = outward * (-radius * p * p) + normal_twice * winding;
        let speed = velocity.length();
        let tangent = velocity / speed;
        let tangent_along = (acceleration - tangent * tangent.dot(acceleration)) / speed;
        Self {
            place: outward * radius + normal * winding,
            velocity,
            normal,
            normal_along,
            binormal: normal.cross(tangent),
            binormal_along: normal_along.cross(tangent) + normal.cross(tangent_along),
        }
    }
}

/// A closed grid of `around` rings of `across` vertices, `surface(along, round)` -> (position, unit normal).
///
/// Both angles run from 0 to 2π. Seen from outside, `round` runs to the left of `along`.
fn tube(around: u32, across: u32, surface: impl Fn(f64, f64) -> (DVec3, DVec3)) -> MeshParts {
    let (around, across) = (around.max(3), across.max(3));
    let count = (around * across) as usize;
    let (mut positions, mut normals) = (Vec::with_capacity(count), Vec::with_capacity(count));
    let mut triangles = Vec::with_capacity(2 * count);
    let angle = |i: u32, count: u32| TAU * f64::from(i) / f64::from(count);
    for i in 0..around {
        for j in 0..across {
            let (position, normal) = surface(angle(i, around), angle(j, across));
            positions.push(position);
            normals.push(normal);
            let vertex = |i: u32, j: u32| i % around * across + j % across;
            let (here, ahead) = (vertex(i, j), vertex(i + 1, j));
            let (left, beyond) = (vertex(i, j + 1), vertex(i + 1, j + 1));
            triangles.push([here, ahead, beyond]);
            triangles.push([here, beyond, left]);
        }
    }
    MeshParts {
        positions,
        normals: Some(normals),
        triangles,
        ..MeshParts::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::generate::checks::{assert_closed_and_outward, volume};
    use crate::numeric::rotation;

    /// The largest angle between a vertex's normal and the tube's slope by differences over its neighbours.
    fn worst_angle(mesh: &MeshParts, around: u32, across: u32) -> f64 {
        let at = |i: u32, j: u32| mesh.positions[(i % around * across + j % across) as usize];
        let normals = mesh.normals.as_ref().unwrap();
        let mut worst: f64 = 0.0;
        for i in 0..around {
            for j in 0..across {
                let along = at(i + 1, j) - at(i + around - 1, j);
                let round = at(i, j + 1) - at(i, j + across - 1);
                let normal = normals[(i * across + j) as usize];
                assert!((normal.length() - 1.0).abs() < 1e-14);
                worst = worst.max(rotation::angle_between(along.cross(round), normal));
            }
        }
        worst
    }

    #[test]
    fn a_ring_is_a_closed_torus_of_the_right_volume() {
        let mesh = ring(2.0, 0.3, 0.5, 60, 24);
        assert_eq!(mesh.triangles.len(), 2880);
        // V = F/2 on every closed triangle mesh of genus 1.
        assert_eq!(mesh.positions.len(), mesh.triangles.len() / 2);
        assert_closed_and_outward(&mesh);
        // Pappus: the ellipse's area times its middle's path. Both are inscribed: h²/6 of each angle h.
        let volume_of = |around, across| volume(&ring(2.0, 0.3, 0.5, around, across));
        let exact = std::f64::consts::PI * 0.3 * 0.5 * TAU * 2.0;
        let ratio = (exact - volume_of(40, 40)) / (exact - volume_of(80, 80));
        assert!((ratio - 4.0).abs() < 4.0 * 0.01, "{ratio}");
    }

    #[test]
    fn a_band_is_closed_and_has_the_volume_of_its_polygons() {
        let mesh = band(0.85, 0.92, 0.38, 96);
        assert_eq!(mesh.triangles.len(), 8 * 96);
        assert_closed_and_outward(&mesh);
        // A regular polygon of n corners on a circle of radius r has the area n/2 r² sin(2π/n).
        let part = 48.0 * math::sin(TAU / 96.0);
        let exact = part * (math::powi(0.92_f64, 2) - math::powi(0.85_f64, 2)) * 0.76;
        assert!((volume(&mesh) - exact).abs() < 1e-13);
        for normal in mesh.normals.unwrap() {
            assert!((normal.length() - 1.0).abs() < 1e-15);
        }
    }

    #[test]
    fn a_trefoil_knot_is_a_closed_torus_with_a_tubes_volume() {
        let mesh = trefoil_knot(2.0, 1.0, 0.4, 0.05, 330, 24);
        assert_eq!(mesh.triangles.len(), 2 * 330 * 24);
        // V = F/2 on every closed triangle mesh of genus 1.
        assert_eq!(mesh.positions.len(), mesh.triangles.len() / 2);
        assert_closed_and_outward(&mesh);
        // Pappus again: the round tube's area times the curve's length, as its middle is the curve.
        let steps = 1 << 12;
        let speed = |i| Strand::new(2.0, 1.0, TAU * f64::from(i) / f64::from(steps)).velocity;
        let length: f64 =
            (0..steps).map(|i| speed(i).length()).sum::<f64>() * TAU / f64::from(steps);
        let exact = std::f64::consts::PI * 0.4 * 0.4 * length;
        let defect =
            |around, across| exact - volume(&trefoil_knot(2.0, 1.0, 0.4, 0.0, around, across));
        let ratio = defect(300, 30) / defect(600, 60);
        assert!((ratio - 4.0).abs() < 4.0 * 0.02, "{ratio}");
    }

    /// On circles and ellipses differences over both neighbours are along the slope, up to the 1e-8 of an arc
    /// cosine. Else they err by the square of the distance: halving it divides the error by 4.
    #[test]
    fn normals_are_exact() {
        let ring = worst_angle(&ring(2.0, 0.3, 0.5, 60, 24), 60, 24);
        assert!(ring < 1e-7, "{ring}");
        let knot = |n| worst_angle(&trefoil_knot(2.0, 1.0, 0.35, 0.06, 6 * n, n), 6 * n, n);
        let (coarse, fine) = (knot(80), knot(160));
        assert!(fine < 0.01, "{fine}");
        assert!((coarse / fine - 4.0).abs() < 0.2, "{coarse} {fine}");
    }

    /// Points of the tube that are far from each other along it stay apart, and its bends are open.
    #[test]
    fn a_trefoil_knot_does_not_meet_itself() {
        let (winding, thickness) = (1.0, 0.8);
        let steps = 900;
        let strands: Vec<Strand> = (0..steps)
            .map(|i| {
                Strand::new(
                    2.0 * winding,
                    winding,
                    TAU * f64::from(i) / f64::from(steps),
                )
            })
            .collect();
        let mut nearest = f64::INFINITY;
        for (i, a) in strands.iter().enumerate() {
            let b = &strands[(i + 1) % strands.len()];
            let turn = rotation::angle_between(a.velocity, b.velocity);
            assert!(turn / a.place.distance(b.place) * thickness < 0.9);
            for (j, b) in strands.iter().enumerate().skip(i) {
                let apart = (j - i).min(strands.len() - (j - i));
                if apart > strands.len() / 8 {
                    nearest = nearest.min(a.place.distance(b.place));
                }
            }
        }
        assert!(nearest > 2.0 * thickness, "{nearest}");
    }
}
