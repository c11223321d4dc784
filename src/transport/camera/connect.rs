//! Light on a surface, connected to the camera that sees it.

use glam::{DVec2, DVec3};

use super::diffuse::{may_reflect, reflectance};
use super::projection::{Camera, LENS_MIDDLE};
use crate::geometry::{Hit, SurfacePoint, TraversalCounters};
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
    /// The gain of a pixel from flux that arrives at `point`, the place of `hit`, travelling along the unit
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
        hit: &Hit,
        point: &SurfacePoint,
        direction: DVec3,
        counters: &mut TraversalCounters,
    ) -> Option<Connection> {
        self.connect_through(scene, hit, point, direction, LENS_MIDDLE, counters)
    }

    /// The same as [`connect`](Self::connect), through a point of the lens: see
    /// [`project_through`](Self::project_through).
    pub fn connect_through(
        &self,
        scene: &Scene,
        hit: &Hit,
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
        let reflectance = reflectance(scene, hit, point, arriving > 0.0)?;
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

    /// [`connect`](Self::connect), for light that counts only where `is_wanted` says so of its film
    /// coordinates: no shadow ray is spent on other light.
    pub fn connect_where(
        &self,
        scene: &Scene,
        hit: &Hit,
        point: &SurfacePoint,
        direction: DVec3,
        is_wanted: impl FnOnce(DVec2) -> bool,
        counters: &mut TraversalCounters,
    ) -> Option<Connection> {
        // Most surfaces that light meets on its way are glass: they cost no projection either.
        let front = direction.dot(point.geometric_normal) < 0.0;
        if !may_reflect(scene, hit.shape, front) || !is_wanted(self.project(point.position)?.at) {
            return None;
        }
        self.connect(scene, hit, point, direction, counters)
    }

    /// True if a shape's surface is diffuse and not black on either side, so that light on it may be seen.
    pub fn may_see_surface(&self, scene: &Scene, shape: u32) -> bool {
        [true, false]
            .iter()
            .any(|&front| may_reflect(scene, shape, front))
    }
}
