//! Thin beams at surfaces.

use glam::DVec3;

use crate::geometry::{Hit, Ray, SurfaceElement, SurfacePoint, World};
use crate::optics::RayDerivative;
use crate::radiometry::Rgb;
use crate::transport::domain::DeltaEmission;
use crate::transport::scatter::{Bending, Interaction, Way};
use crate::transport::signature::Signature;

/// A ray and the light right beside it.
#[derive(Clone, Copy, Debug)]
pub struct ThinBeam {
    /// The ray.
    pub ray: Ray,
    /// Its derivatives by the two coordinates of the light.
    pub derivatives: [RayDerivative; 2],
    /// The share of the emitted flux that it carries: Fresnel's shares and all tints so far.
    pub throughput: Rgb,
}

/// One step of a chain: the surface, and the way on which light leaves it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct ChainStep {
    /// The surface.
    pub element: SurfaceElement,
    /// The way on which light leaves it.
    pub way: Way,
}

/// A beam on the receiver.
#[derive(Clone, Copy, Debug)]
pub struct Landing {
    /// The beam, as it left the last surface.
    pub beam: ThinBeam,
    /// The point of arrival; its `uv` is unspecified.
    pub point: SurfacePoint,
    /// The derivatives of the point by the light's two coordinates; they lie in the surface.
    pub derivatives: [DVec3; 2],
}

/// The signature of a chain of steps.
pub fn signature(chain: &[ChainStep]) -> Signature {
    chain
        .iter()
        .filter_map(|step| step.way.event())
        .fold(Signature::DIRECT, Signature::then)
}

impl ThinBeam {
    /// The beam of an emission: all of its flux.
    pub fn new(emission: &DeltaEmission) -> Self {
        Self {
            ray: emission.ray,
            derivatives: emission.derivatives,
            throughput: Rgb::WHITE,
        }
    }

    /// The beam where it meets a surface.
    pub(super) fn landing(&self, hit: &Hit, point: SurfacePoint) -> Landing {
        Landing {
            beam: *self,
            point,
            derivatives: self
                .at_surface(hit, &point)
                .map(|derivative| derivative.position),
        }
    }

    fn at_surface(&self, hit: &Hit, point: &SurfacePoint) -> [RayDerivative; 2] {
        self.derivatives.map(|derivative| {
            derivative.transferred(self.ray.direction, hit.distance, point.geometric_normal)
        })
    }

    /// The beam after a surface, on one of the ways on; `None` if no light goes there.
    pub(super) fn leaving(
        &self,
        world: &World,
        hit: &Hit,
        point: &SurfacePoint,
        interaction: &Interaction,
        way: Way,
    ) -> Option<Self> {
        let share = interaction.share_of(way);
        if share <= 0.0 {
            return None;
        }
        let branch = interaction.branch::<3>(way)?;
        let throughput = self.throughput * branch.tint.rgb() * share;
        if throughput.is_black() {
            return None;
        }
        let bending = interaction.bending(way);
        let direction = self.ray.direction;
        let [first, second] = self.at_surface(hit, point).map(|arriving| {
            // The interaction's normal is the shading normal or its opposite.
            let turn = |normal: DVec3| {
                let change = world.normal_derivative(hit, arriving.position);
                change * normal.dot(point.shading_normal).signum()
            };
            match bending {
                Bending::Straight => Some(arriving),
                Bending::Reflection { normal } => {
                    Some(arriving.reflected(direction, normal, turn(normal)))
                }
                Bending::Refraction { normal, eta } => {
                    arriving.refracted(direction, normal, turn(normal), eta)
                }
            }
        });
        Some(Self {
            ray: point.spawn(branch.direction),
            derivatives: [first?, second?],
            throughput,
        })
    }
}
