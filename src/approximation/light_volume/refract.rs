//! Light that the water's surface refracts at a point.

use glam::DVec3;

use super::beam::Ruling;
use super::slicing::Slicing;
use crate::approximation::interface::{Fresnel, cross};
use crate::geometry::SurfacePoint;
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::first_surface::Source;
use crate::transport::scatter::Way;

/// Light that goes on below the water's surface.
#[derive(Clone, Copy, Debug)]
pub struct Refracted {
    /// Its unit direction above the surface.
    pub incident: DVec3,
    /// Its unit direction below.
    pub direction: DVec3,
    /// Irradiance across the light above, by the source's strength.
    pub density: f64,
    /// The share that goes on, but for the water's colour.
    pub share: f64,
    /// The water's colour.
    pub tint: Rgb,
}

/// Light of a source that meets a point of the water from outside; `None` if none does.
pub fn refracted(
    scene: &Scene,
    shape: u32,
    point: &SurfacePoint,
    source: &Source,
    fresnel: Fresnel,
) -> Option<Refracted> {
    let light = source.arrive(point.position)?;
    let incident = light.ray.direction;
    if incident.dot(point.geometric_normal) >= 0.0 {
        return None;
    }
    let crossing = cross(scene, shape, point, incident, Way::Transmitted, fresnel)?;
    Some(Refracted {
        incident,
        direction: crossing.direction,
        density: light.density,
        share: crossing.share,
        tint: crossing.tint,
    })
}

impl Refracted {
    /// Its ray below a place of the surface; `None` if it does not go down.
    pub fn ruling(&self, place: DVec3, slicing: &Slicing) -> Option<Ruling> {
        Ruling::new(slicing.local(place), slicing.local_vector(self.direction))
    }
}

/// The same at a vertex, whose normal is that of all its triangles.
pub fn refracted_at_vertex(
    scene: &Scene,
    shape: u32,
    vertex: &SurfacePoint,
    source: &Source,
    fresnel: Fresnel,
) -> Option<Refracted> {
    let point = SurfacePoint {
        geometric_normal: vertex.shading_normal,
        ..*vertex
    };
    refracted(scene, shape, &point, source, fresnel)
}
