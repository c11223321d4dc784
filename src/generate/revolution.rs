//! Surfaces of revolution about the z axis: dishes and lenses.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::geometry::MeshParts;
use crate::numeric::math;

/// A paraboloid dish z = (x² + y²) / (4 `focal_length`) out to the radius `aperture`, normals inward
/// (upward).
///
/// Light that falls straight down onto it is reflected through the focus (0, 0, `focal_length`). `6 rings²`
/// triangles; the mesh is open.
pub fn paraboloid(focal_length: f64, aperture: f64, rings: u32) -> MeshParts {
    disc_mesh(rings, |x, y| {
        let (x, y) = (x * aperture, y * aperture);
        let position = DVec3::new(x, y, (x * x + y * y) / (4.0 * focal_length));
        let normal = DVec3::new(-x, -y, 2.0 * focal_length).normalize();
        (position, normal)
    })
}

/// A plano-convex lens: a spherical cap of radius of curvature `curvature` over a flat disc of radius
/// `aperture` in the plane z = 0, closed, with exact normals and a sharp rim.
///
/// The cap's top is at z = R − √(R² − a²). `6 rings² + 6 rings` triangles. The rim is a regular polygon of `6
/// rings` corners on the circle.
pub fn plano_convex_lens(curvature: f64, aperture: f64, rings: u32) -> MeshParts {
    let rings = rings.max(1);
    let depth = (curvature * curvature - aperture * aperture)
        .max(0.0)
        .sqrt();
    let mut mesh = disc_mesh(rings, |x, y| {
        let (x, y) = (x * aperture, y * aperture);
        let height = (curvature * curvature - x * x - y * y).max(0.0).sqrt();
        // On the rim this difference must be exactly 0 for cap and disc to meet.
        let z = if (x * x + y * y).sqrt() > aperture * (1.0 - 1e-12) {
            0.0
        } else {
            height - depth
        };
        (DVec3::new(x, y, z), DVec3::new(x, y, height) / curvature)
    });
    // The flat side has corners of its own on the rim, because the normal jumps there.
    let corners = 6 * rings;
    let cap_rim = mesh.positions.len() as u32 - corners;
    let center = mesh.positions.len() as u32;
    let normals = mesh.normals.get_or_insert_default();
    mesh.positions.push(DVec3::ZERO);
    normals.push(DVec3::NEG_Z);
    for i in 0..corners {
        mesh.positions.push(mesh.positions[(cap_rim + i) as usize]);
        normals.push(DVec3::NEG_Z);
        let next = (i + 1) % corners;
        mesh.triangles
            .push([center, center + 1 + next, center + 1 + i]);
    }
    mesh
}

/// The image of the unit disc under `surface(x, y)` -> (position, unit normal), cut into `6 rings²`
/// triangles of nearly the same size, counter-clockwise seen from +z.
///
/// Ring j = 1..=`rings` has 6 j corners at the radius j / `rings`; the last ring's come last.
fn disc_mesh(rings: u32, surface: impl Fn(f64, f64) -> (DVec3, DVec3)) -> MeshParts {
    let rings = rings.max(1);
    let (mut positions, mut normals) = (Vec::new(), Vec::new());
    let mut add = |x: f64, y: f64| {
        let (position, normal) = surface(x, y);
        positions.push(position);
        normals.push(normal);
    };
    add(0.0, 0.0);
    for ring in 1..=rings {
        let radius = f64::from(ring) / f64::from(rings);
        for i in 0..6 * ring {
            let (sin, cos) = math::sin_cos(TAU * f64::from(i) / f64::from(6 * ring));
            add(radius * cos, radius * sin);
        }
    }
    // The index of a ring's i-th corner: 1 + 6 (1 + 2 + ... + (ring - 1)) lie before it.
    let corner = |ring: u32, i: u32| match ring {
        0 => 0,
        _ => 1 + 3 * ring * (ring - 1) + i % (6 * ring),
    };
    let mut triangles = Vec::new();
    for ring in 0..rings {
        for sector in 0..6 {
            let inner = |i: u32| corner(ring, sector * ring + i);
            let outer = |i: u32| corner(ring + 1, sector * (ring + 1) + i);
            for i in 0..=ring {
                triangles.push([inner(i), outer(i), outer(i + 1)]);
                if i < ring {
                    triangles.push([inner(i), outer(i + 1), inner(i + 1)]);
                }
            }
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

    #[test]
    fn light_straight_down_onto_a_paraboloids_corners_meets_in_the_focus() {
        let mesh = paraboloid(0.5, 0.4, 8);
        assert_eq!(mesh.triangles.len(), 6 * 64);
        for (position, normal) in mesh.positions.iter().zip(mesh.normals.as_ref().unwrap()) {
            let direction = crate::optics::reflect(DVec3::NEG_Z, *normal);
            let to_focus = DVec3::new(0.0, 0.0, 0.5) - *position;
            // A cross product of lengths below 1: a few roundings.
            assert!(direction.cross(to_focus).length() < 1e-15);
            assert!(direction.dot(to_focus) > 0.0);
        }
    }

    #[test]
    fn a_plano_convex_lens_is_closed_and_has_the_volume_of_a_spherical_cap() {
        let (curvature, aperture) = (2.0, 1.0);
        let coarse = plano_convex_lens(curvature, aperture, 16);
        assert_closed_and_outward(&coarse);
        let height = curvature - (curvature * curvature - aperture * aperture).sqrt();
        let cap = std::f64::consts::PI * height * height * (3.0 * curvature - height) / 3.0;
        let fine = plano_convex_lens(curvature, aperture, 32);
        // The lens is inscribed: the deficit is O(h²), so it falls by 4 when the rings double. The next order
        // is smaller by h² < (1/16)².
        let ratio = (cap - volume(&coarse)) / (cap - volume(&fine));
        assert!((ratio - 4.0).abs() < 4.0 / 256.0 * 4.0, "{ratio}");
    }
}
