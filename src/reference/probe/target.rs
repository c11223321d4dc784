//! The receiver point, and plane coordinates about it.

use glam::{DMat2, DVec2, DVec3};

use crate::geometry::SurfacePoint;
use crate::scene::Scene;
use crate::transport::differentials::{Landing, ThinBeam};
use crate::transport::receiver::Receiver;

/// The point whose light is searched for.
pub(super) struct ProbeTarget {
    shape: u32,
    point: SurfacePoint,
    /// Orthonormal, in the tangent plane; right-handed with the normal.
    axes: [DVec3; 2],
}

/// The landing of a ray as seen from the target, and its derivatives by the light's two coordinates.
#[derive(Clone, Copy, Debug)]
pub(super) struct TargetImage {
    /// Vector \[m\] from the target, projected on its tangent plane.
    pub offset: DVec2,
    /// Jacobian: its columns are the derivatives of `offset` by the two coordinates.
    pub jacobian: DMat2,
    /// Vector \[m\] from the target to the nearest point of the line that the ray lies on. It is zero if
    /// `offset` is, and stays small when that grows without limit: for light that almost passes along the
    /// receiver.
    pub miss: DVec3,
    /// The derivatives of `miss`.
    pub miss_derivatives: [DVec3; 2],
}

impl ProbeTarget {
    /// The point at `uv` of the receiver; `None` if that is outside 0..=1 or NaN.
    pub fn new(scene: &Scene, receiver: &Receiver, uv: DVec2) -> Option<Self> {
        let inside = uv.cmpge(DVec2::ZERO).all() && uv.cmple(DVec2::ONE).all();
        if !inside {
            return None;
        }
        let point = scene.world().shapes()[receiver.shape() as usize].at_uv(uv)?;
        let normal = point.geometric_normal;
        let (x, _) = normal.any_orthonormal_pair();
        Some(Self {
            shape: receiver.shape(),
            point,
            axes: [x, normal.cross(x)],
        })
    }

    pub fn shape(&self) -> u32 {
        self.shape
    }

    pub fn point(&self) -> SurfacePoint {
        self.point
    }

    /// A landing in the plane coordinates; `None` on the far side of a round receiver, which the projection
    /// would lay over the near one.
    ///
    /// At the target itself the derivatives lie in the tangent plane, so there the determinant is that of
    /// areas.
    pub fn image(&self, landing: &Landing) -> Option<TargetImage> {
        let facing = landing
            .point
            .geometric_normal
            .dot(self.point.geometric_normal);
        let project = |v: DVec3| DVec2::new(self.axes[0].dot(v), self.axes[1].dot(v));
        let [x, y] = landing.derivatives.map(project);
        let ThinBeam {
            ray, derivatives, ..
        } = landing.beam;
        // Q = S − (S·D) D with S from the target to the ray's start.
        let start = ray.origin - self.point.position;
        let along = start.dot(ray.direction);
        let image = TargetImage {
            offset: project(landing.point.position - self.point.position),
            jacobian: DMat2::from_cols(x, y),
            miss: start - ray.direction * along,
            miss_derivatives: derivatives.map(|by| {
                let change = by.position.dot(ray.direction) + start.dot(by.direction);
                by.position - ray.direction * change - by.direction * along
            }),
        };
        let finite = image.offset.is_finite() && image.jacobian.is_finite();
        (facing > 0.0 && finite).then_some(image)
    }
}
