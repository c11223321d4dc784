//! Light of emitters without size, and its change across their charts.

use glam::{DVec2, DVec3};

use super::chart::LightChart;
use super::face::face_sample;
use crate::geometry::Ray;
use crate::optics::RayDerivative;

/// One ray of a delta emitter, and its change with the chart's two coordinates.
#[derive(Clone, Copy, Debug)]
pub struct DeltaEmission {
    /// The ray.
    pub ray: Ray,
    /// Derivatives by each coordinate.
    pub derivatives: [RayDerivative; 2],
    /// Light-space measure per unit of chart area: solid angle \[sr\] of a point, cross section \[m²\] of
    /// parallel light.
    pub measure: f64,
    /// Flux per measure, as a factor on the chart's [strength](LightChart::strength): the falloff of a spot.
    pub falloff: f64,
}

impl LightChart {
    /// The ray at `place` (in chart coordinates) with its derivatives.
    ///
    /// `None` for area emitters and environments, whose light at a place of the chart is more than one ray.
    /// Neither for images, whose light changes in other ways, nor for light along the normals of a surface,
    /// which ends at the surface's border.
    ///
    /// `place` may lie beyond the chart's border: the coordinates go on.
    pub fn delta_emission(&self, place: DVec2) -> Option<DeltaEmission> {
        match *self {
            Self::Face {
                origin,
                axes,
                falloff,
                ..
            } => {
                let (direction, measure) = face_sample(&axes, place);
                // D = V/|V| with V = a₁ x + a₂ y + a₃: ∂D = (a − (a·D) D) / |V|.
                let inverse_length = 1.0 / (1.0 + place.length_squared()).sqrt();
                let by = |axis: DVec3| RayDerivative {
                    position: DVec3::ZERO,
                    direction: (axis - direction * axis.dot(direction)) * inverse_length,
                };
                Some(DeltaEmission {
                    ray: Ray::new(origin, direction),
                    derivatives: [by(axes[0]), by(axes[1])],
                    measure,
                    falloff: falloff.factor(direction),
                })
            }
            Self::Parallel {
                origin,
                across,
                direction,
                ..
            } => Some(DeltaEmission {
                ray: Ray::new(
                    origin + across[0] * place.x + across[1] * place.y,
                    direction,
                ),
                derivatives: across.map(|position| RayDerivative {
                    position,
                    direction: DVec3::ZERO,
                }),
                measure: 1.0,
                falloff: 1.0,
            }),
            Self::Flat { .. }
            | Self::Ball { .. }
            | Self::Normal(_)
            | Self::Projector { .. }
            | Self::Sky(_) => None,
        }
    }

    /// The place on the chart of the ray that passes through `point`; `None` if this chart has none, and for
    /// emitters on surfaces, environments and projectors.
    pub fn place_towards(&self, point: DVec3) -> Option<DVec2> {
        match *self {
            Self::Face { origin, axes, .. } => {
                let [x, y, z] = axes.map(|axis| axis.dot(point - origin));
                let place = DVec2::new(x / z, y / z);
                (z > 0.0 && place.abs().max_element() <= 1.0).then_some(place)
            }
            Self::Parallel { origin, across, .. } => Some(DVec2::new(
                across[0].dot(point - origin),
                across[1].dot(point - origin),
            )),
            Self::Flat { .. }
            | Self::Ball { .. }
            | Self::Normal(_)
            | Self::Projector { .. }
            | Self::Sky(_) => None,
        }
    }
}
