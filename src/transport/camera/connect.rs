//! Light on a surface, connected to the camera that sees it.

use glam::{DVec2, DVec3};

use super::diffuse::reflectance;
use super::projection::{Camera, LENS_MIDDLE};
use crate::geometry::{SurfacePoint, TraversalCounters};
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::scatter::ShadingNormals;
use crate::transport::visibility::transmittance;

/// The connection of a camera to flux that arrives at a point it sees.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Connection {
    /// Film point in pixels of the cropped film, continuous; may lie outside of it.
    pub at: DVec2,
    /// Radiance of the pixel [W/m²/sr] per flux arriving at the point \[W\].
    pub radiance_per_flux: Rgb,
    /// Distance from the point to the near plane; the way between was found clear.
    pub distance: f64,
}

impl Camera {
    /// The gain of a pixel from flux that arrives at `point` of shape `shape`, travelling along the unit
    /// vector `direction`.
    ///
    /// `None` if the camera sees nothing of it. The surface may not be diffuse, or have an open mask over it.
    /// Light and camera may be on different sides, or on one that is black. The point may be out of the clip
    /// planes, or hidden. Film coordinates outside the crop are no reason, since a beam's image may reach in.
    ///
    /// Mirrors and glass between point and camera hide it, too: light seen by way of them takes another path.
    pub fn connect(
        &self,
        scene: &Scene,
        shape: u32,
        point: &SurfacePoint,
        direction: DVec3,
        counters: &mut TraversalCounters,
    ) -> Option<Connection> {
        self.connect_through(scene, shape, point, direction, LENS_MIDDLE, counters)
    }

    /// The same as [`connect`](Self::connect), through a point of the lens: see
    /// [`project_through`](Self::project_through).
    pub fn connect_through(
        &self,
        scene: &Scene,
        shape: u32,
        point: &SurfacePoint,
        direction: DVec3,
        lens: DVec2,
        counters: &mut TraversalCounters,
    ) -> Option<Connection> {
        let projection = self.project_through(point.position, lens)?;
        let normal = point.geometric_normal;
        let (arriving, leaving) = (-direction.dot(normal), projection.towards.dot(normal));
        let is_one_side = arriving * leaving > 0.0;
        if !is_one_side {
            return None;
        }
        let reflectance = reflectance(scene, scene.material_of(shape), arriving > 0.0)?;
        let cosine = match self.shading_normals {
            ShadingNormals::Flux => leaving.abs(),
            ShadingNormals::Adjoint => {
                let normal = point.shading_normal;
                let bent = (-direction.dot(normal), projection.towards.dot(normal));
                let do_agree = bent.0 * arriving > 0.0 && bent.1 * leaving > 0.0;
                if !do_agree {
                    return None;
                }
                leaving.abs() * (bent.0 / arriving)
            }
        };
        let passed = transmittance(
            scene,
            point,
            projection.towards,
            projection.distance,
            counters,
        );
        let factor = cosine * projection.importance * passed * std::f64::consts::FRAC_1_PI;
        (factor > 0.0 && !reflectance.is_black()).then(|| Connection {
            at: projection.at,
            radiance_per_flux: reflectance * factor,
            distance: projection.distance,
        })
    }

    /// [`connect`](Self::connect), for light that counts in one pixel alone. The result is that pixel,
    /// counted row by row from the top, and its radiance [W/m²/sr] per flux arriving at the point \[W\].
    ///
    /// `None` also if the point is seen outside of the crop: no shadow ray is spent on it.
    pub fn connect_pixel(
        &self,
        scene: &Scene,
        shape: u32,
        point: &SurfacePoint,
        direction: DVec3,
        counters: &mut TraversalCounters,
    ) -> Option<(usize, Rgb)> {
        // Most surfaces that light meets on its way are glass: they cost no projection either.
        let front = direction.dot(point.geometric_normal) < 0.0;
        reflectance(scene, scene.material_of(shape), front)?;
        let pixel = self.pixel(self.project(point.position)?.at)?;
        let seen = self.connect(scene, shape, point, direction, counters)?;
        Some((pixel, seen.radiance_per_flux))
    }

    /// True if a shape's surface is diffuse and not black on either side, so that light on it may be seen.
    pub fn may_see_surface(&self, scene: &Scene, shape: u32) -> bool {
        let material = scene.material_of(shape);
        [true, false]
            .iter()
            .any(|&front| reflectance(scene, material, front).is_some_and(|seen| !seen.is_black()))
    }
}
