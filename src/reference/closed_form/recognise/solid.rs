//! A convex solid with flat facets in parallel light.

use glam::DVec3;

use super::ball::body_paths;
use super::glass::Glass;
use super::known_layer::{KnownLayer, KnownLight};
use super::parts::{Body, LightOrigin, OneLight};
use super::plane::ReceiverPlane;
use crate::geometry::{Mesh, MeshParts};
use crate::radiometry::Rgb;
use crate::reference::closed_form::{FacetsError, FlatFacets, ParallelLight};
use crate::run::Refusal;

/// Error of a texel as a part of the light's irradiance.
///
/// A polygon's share of a texel is a difference of areas of the size of the polygon: some 1e-15 of it, that
/// is 1e-11 of a texel for the largest, and a hundred such polygons add up.
const OF_LIGHT: f64 = 1e-9;

/// Largest number of triangles; a solid of more is taken for a curved one.
const MOST_TRIANGLES: usize = 1000;

/// A solid in light of strength 1.
pub(super) struct SolidInParallelLight {
    /// Triangles in the receiver's coordinates.
    mesh: MeshParts,
    direction: DVec3,
    glass: Glass,
    strength: Rgb,
    name: String,
}

impl SolidInParallelLight {
    /// The solid of a scene.
    ///
    /// # Errors
    ///
    /// If it is no closed convex solid of glass with flat facets in front of the receiver, or the light is
    /// not parallel.
    pub(super) fn new(
        plane: &ReceiverPlane,
        light: &OneLight,
        body: &Body,
        mesh: &Mesh,
    ) -> Result<Self, Refusal> {
        let parts = flat_solid(plane, body, mesh)?;
        let glass = Glass::of(body, false)?;
        let LightOrigin::Parallel(direction) = light.origin else {
            return Err(Refusal::new(format!(
                "{} shines on {}: closed forms know solids with flat facets in directional light",
                light.name, body.name
            )));
        };
        FlatFacets::check(&parts, direction).map_err(|error| refusal(body, light, &error))?;
        Ok(Self {
            mesh: parts,
            direction,
            glass,
            strength: light.strength,
            name: body.name.clone(),
        })
    }
}

impl KnownLight for SolidInParallelLight {
    fn layers(
        &self,
        plane: &ReceiverPlane,
        max_depth: u32,
        take: &mut dyn FnMut(KnownLayer) -> bool,
    ) -> Result<(), Refusal> {
        let light = ParallelLight {
            direction: self.direction,
            irradiance: 1.0,
        };
        let reflections = max_depth.saturating_sub(2);
        let solid = FlatFacets::new(&self.mesh, self.glass.ior, light, reflections)
            .map_err(|error| Refusal::new(format!("{}: {error}", self.name)))?;
        let film = plane.grid();
        body_paths(max_depth).all(|path| {
            let errors = film.in_film_order(&solid.errors(path, &film.grid));
            take(KnownLayer {
                path,
                values: film.in_film_order(&solid.map(path, &film.grid)),
                accuracy: errors.iter().map(|error| OF_LIGHT + error).collect(),
                factor: self.strength * self.glass.factor(path),
            })
        });
        Ok(())
    }
}

/// The mesh in the receiver's coordinates.
fn flat_solid(plane: &ReceiverPlane, body: &Body, mesh: &Mesh) -> Result<MeshParts, Refusal> {
    if mesh.has_vertex_normals() {
        return Err(Refusal::new(format!(
            "{} has interpolated normals: a mesh of a curved surface has facets and the formula has none; closed forms \
             know solids with flat facets (face_normals true) and curved surfaces as sphere and cylinder",
            body.name
        )));
    }
    if mesh.triangle_count() > MOST_TRIANGLES {
        return Err(Refusal::new(format!(
            "{} has {} triangles: closed forms know solids of up to {MOST_TRIANGLES}",
            body.name,
            mesh.triangle_count()
        )));
    }
    let found = mesh.diagnose();
    if !found.is_closed() || found.components != 1 || found.zero_area_faces.count > 0 {
        return Err(Refusal::new(format!(
            "{} is no single closed surface of triangles with areas: closed forms know convex solids",
            body.name
        )));
    }
    let positions: Vec<DVec3> = mesh
        .positions()
        .iter()
        .map(|position| plane.point(*position))
        .collect();
    let is_inward = (0..mesh.triangle_count() as u32).any(|face| {
        let [a, b, c] = mesh.corners(face);
        (b - a).cross(c - a).dot(mesh.face_normal(face)) < 0.0
    });
    if is_inward || found.is_inward() {
        return Err(Refusal::new(format!(
            "{} has its normals inside: closed forms know solids whose normals point outside",
            body.name
        )));
    }
    Ok(MeshParts {
        positions,
        triangles: mesh.triangles().to_vec(),
        face_normals: true,
        ..MeshParts::default()
    })
}

fn refusal(body: &Body, light: &OneLight, error: &FacetsError) -> Refusal {
    Refusal::new(match error {
        FacetsError::NotConvex { distance, .. } => format!(
            "{} is not convex, by {distance:e}: closed forms know convex solids with flat facets",
            body.name
        ),
        FacetsError::BelowThePlane { z, .. } => format!(
            "{} has a corner at the height {z:e} over the receiver: it must be in front of the receiver and not touch it",
            body.name
        ),
        FacetsError::Direction(_) => format!(
            "{} comes from behind the receiver: it must fall on its front",
            light.name
        ),
        FacetsError::Vertex { .. } | FacetsError::TooManyBeams { .. } => {
            format!("{}: {error}", body.name)
        }
    })
}
