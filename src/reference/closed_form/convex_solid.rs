//! Convex solids with flat facets, from triangles.

use glam::{DVec2, DVec3};

use super::polygon::convex_hull;
use crate::geometry::MeshParts;

/// Why a mesh is not a solid for [`FlatFacets`](super::FlatFacets).
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum FacetsError {
    /// A triangle names a vertex that does not exist, or one with a coordinate that is not finite.
    #[error("triangle {triangle} has no finite vertex {vertex}")]
    Vertex {
        /// Counted from 0.
        triangle: usize,
        /// The index it holds.
        vertex: u32,
    },
    /// Some vertex lies outside of a facet's plane.
    #[error(
        "vertex {vertex} lies {distance:e} outside of the plane of triangle {triangle}: the solid must be convex"
    )]
    NotConvex {
        /// Counted from 0.
        vertex: usize,
        /// Counted from 0.
        triangle: usize,
        /// Scene units.
        distance: f64,
    },
    /// Some vertex lies below the plane z = 0.
    #[error("vertex {vertex} lies at z = {z}: the solid must lie above the plane z = 0")]
    BelowThePlane {
        /// Counted from 0.
        vertex: usize,
        /// Scene units.
        z: f64,
    },
    /// The facets cut the light into more beams than can be followed.
    #[error("the facets make more than {most} beams: fewer facets or reflections are allowed")]
    TooManyBeams {
        /// The most.
        most: usize,
    },
    /// The light does not fall downwards.
    #[error("the light's direction {0} must be finite and point down (z < 0)")]
    Direction(DVec3),
}

/// A facet: all triangles of one plane.
pub(super) struct SolidFacet {
    /// Outward, a unit vector.
    pub(super) normal: DVec3,
    /// A point of the plane: the origin of its coordinates.
    pub(super) origin: DVec3,
    /// In the plane, across each other and the normal.
    axes: [DVec3; 2],
    /// Counter-clockwise from outside, in the plane's coordinates.
    pub(super) outline: Vec<DVec2>,
    /// Largest distance (m) of a corner of its triangles from the plane.
    pub(super) bulge: f64,
    /// Largest angle (rad) of one of its triangles to the plane.
    pub(super) tilt: f64,
}

/// Vertices count as coplanar within this fraction of the solid's size: `f32` files hold 6e-8.
const FLATNESS: f64 = 1e-6;

impl SolidFacet {
    /// From the plane's coordinates to world space.
    pub(super) fn world(&self, local: DVec2) -> DVec3 {
        self.origin + self.axes[0] * local.x + self.axes[1] * local.y
    }

    /// The plane's coordinates of a point in it.
    pub(super) fn local(&self, world: DVec3) -> DVec2 {
        let offset = world - self.origin;
        DVec2::new(offset.dot(self.axes[0]), offset.dot(self.axes[1]))
    }
}

/// Gathers the triangles of each plane.
pub(super) fn facets(mesh: &MeshParts) -> Result<Vec<SolidFacet>, FacetsError> {
    for (triangle, indices) in mesh.triangles.iter().enumerate() {
        for &vertex in indices {
            if !mesh
                .positions
                .get(vertex as usize)
                .is_some_and(|position| position.is_finite())
            {
                return Err(FacetsError::Vertex { triangle, vertex });
            }
        }
    }
    let size = mesh.positions.iter().fold(0.0_f64, |size, position| {
        size.max(position.distance(mesh.positions[0]))
    });
    for (vertex, position) in mesh.positions.iter().enumerate() {
        if position.z < 0.0 {
            return Err(FacetsError::BelowThePlane {
                vertex,
                z: position.z,
            });
        }
    }
    let mut planes: Vec<(DVec3, DVec3, f64, Vec<DVec3>)> = Vec::new();
    for (triangle, indices) in mesh.triangles.iter().enumerate() {
        let [a, b, c] = indices.map(|i| mesh.positions[i as usize]);
        let cross = (b - a).cross(c - a);
        let normal = cross.normalize_or_zero();
        for (vertex, &position) in mesh.positions.iter().enumerate() {
            let distance = normal.dot(position - a);
            if distance > FLATNESS * size {
                return Err(FacetsError::NotConvex {
                    vertex,
                    triangle,
                    distance,
                });
            }
        }
        let flat = |plane: &&mut (DVec3, DVec3, f64, Vec<DVec3>)| {
            plane.0.dot(normal) > 0.99
                && [a, b, c]
                    .iter()
                    .all(|p| plane.0.dot(*p - plane.1).abs() < FLATNESS * size)
        };
        match planes.iter_mut().find(flat) {
            Some(plane) => {
                plane.3.extend([a, b, c]);
                // The largest triangle knows the plane best.
                if cross.length() > plane.2 {
                    (plane.0, plane.1, plane.2) = (normal, a, cross.length());
                }
            }
            None => planes.push((normal, a, cross.length(), vec![a, b, c])),
        }
    }
    Ok(planes
        .into_iter()
        .map(|(normal, origin, _, corners)| {
            let first = normal.any_orthonormal_vector();
            let mut facet = SolidFacet {
                normal,
                origin,
                axes: [first, normal.cross(first)],
                outline: Vec::new(),
                bulge: corners
                    .iter()
                    .map(|corner| normal.dot(*corner - origin).abs())
                    .fold(0.0, f64::max),
                tilt: corners
                    .chunks_exact(3)
                    .map(|corner| {
                        let cross = (corner[1] - corner[0]).cross(corner[2] - corner[0]);
                        cross.normalize_or_zero().cross(normal).length()
                    })
                    .fold(0.0, f64::max),
            };
            facet.outline =
                convex_hull(corners.iter().map(|&corner| facet.local(corner)).collect());
            facet
        })
        .collect())
}
