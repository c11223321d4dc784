//! Sources of light that send at most one ray to each point.

use glam::DVec3;

use super::place::ChartPlace;
use crate::geometry::{Bounds, Ray};
use crate::radiometry::Rgb;
use crate::scene::{Emitter, Scene};
use crate::transport::domain::chart::Falloff;

/// A delta emitter: its light arrives at a point along one ray only.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Source {
    /// Light from one point.
    Point {
        /// The point where it starts.
        origin: DVec3,
        /// Radiant intensity [W/sr].
        intensity: Rgb,
        /// Its dependence on direction.
        falloff: Falloff,
    },
    /// Parallel light.
    Parallel {
        /// The direction of travel, a unit vector.
        direction: DVec3,
        /// Irradiance across the light [W/m²].
        irradiance: Rgb,
        /// A point in the middle of the scene.
        middle: DVec3,
        /// Distance before the plane across it through the middle at which light starts, ahead of all
        /// geometry.
        ahead: f64,
    },
}

/// The ray of a source to a point.
#[derive(Clone, Copy, Debug)]
pub struct SourceRay {
    /// The ray, from the emitter to the point.
    pub ray: Ray,
    /// The distance of the point along it.
    pub distance: f64,
    /// Irradiance across the ray at the point, in units of the source's [strength](Source::strength). It is
    /// falloff / distance² for a point, and 1 for parallel light.
    pub density: f64,
    /// The part of a spot's light that the ray is in; 0 for other sources. Between the parts density has a
    /// kink, or a jump.
    pub zone: u8,
}

impl SourceRay {
    /// Flux \[W\] that falls on a place of a first surface, for a unit of chart area and of the source's
    /// strength. It is density · |cos θ| · the surface's area for a unit of chart area.
    #[inline]
    pub fn emitted(&self, place: &ChartPlace) -> f64 {
        let facing = self.ray.direction.dot(place.point.geometric_normal);
        self.density * facing.abs() * place.area
    }
}

impl Source {
    /// The source that a delta emitter is; `None` for all others, and for those that throw an image.
    pub fn new(emitter: &Emitter, bounds: &Bounds) -> Option<Self> {
        match emitter {
            Emitter::Point {
                position,
                intensity,
            } => Some(Self::Point {
                origin: *position,
                intensity: *intensity,
                falloff: Falloff::None,
            }),
            Emitter::Spot {
                to_world,
                intensity,
                slide: None,
                ..
            } => Some(Self::Point {
                origin: to_world.point(DVec3::ZERO),
                intensity: *intensity,
                falloff: Falloff::of(emitter),
            }),
            Emitter::Directional {
                direction,
                irradiance,
            } => Some(Self::Parallel {
                direction: *direction,
                irradiance: *irradiance,
                middle: bounds.center(),
                ahead: bounds.radius() * 1.01,
            }),
            Emitter::Projector { .. }
            | Emitter::Spot { slide: Some(_), .. }
            | Emitter::Area { .. }
            | Emitter::DirectionalArea { .. }
            | Emitter::Constant { .. }
            | Emitter::Envmap(_)
            | Emitter::Sunsky(_) => None,
        }
    }

    /// The delta emitters of a scene that shine at all.
    pub fn all(scene: &Scene) -> Vec<Self> {
        let bounds = scene.world().bounds();
        scene
            .emitters()
            .iter()
            .filter(|emitter| !emitter.strength().is_black())
            .filter_map(|emitter| Self::new(emitter, &bounds))
            .collect()
    }

    /// Radiant intensity [W/sr] of a point, or irradiance across the light [W/m²] of parallel light.
    pub fn strength(&self) -> Rgb {
        match *self {
            Self::Point { intensity, .. } => intensity,
            Self::Parallel { irradiance, .. } => irradiance,
        }
    }

    /// The ray that arrives at a point; `None` at the emitter itself.
    #[inline]
    pub fn arrive(&self, point: DVec3) -> Option<SourceRay> {
        match *self {
            Self::Point {
                origin, falloff, ..
            } => {
                let offset = point - origin;
                let distance = offset.length();
                if distance == 0.0 {
                    return None;
                }
                let direction = offset / distance;
                let factor = falloff.factor(direction);
                Some(SourceRay {
                    ray: Ray::new(origin, direction),
                    distance,
                    density: factor / (distance * distance),
                    zone: match falloff {
                        Falloff::None => 0,
                        Falloff::Spot { .. } => u8::from(factor > 0.0) + u8::from(factor == 1.0),
                    },
                })
            }
            Self::Parallel {
                direction,
                middle,
                ahead,
                ..
            } => {
                let distance = (point - middle).dot(direction) + ahead;
                Some(SourceRay {
                    ray: Ray::new(point - direction * distance, direction),
                    distance,
                    density: 1.0,
                    zone: 0,
                })
            }
        }
    }

    /// The start of all light; `None` for parallel light.
    pub fn origin(&self) -> Option<DVec3> {
        match self {
            Self::Point { origin, .. } => Some(*origin),
            Self::Parallel { .. } => None,
        }
    }

    /// True if light is parallel, from infinitely far away.
    pub fn is_parallel(&self) -> bool {
        matches!(self, Self::Parallel { .. })
    }

    /// A vector from `point` towards the emitter, of any length.
    #[inline]
    pub fn towards(&self, point: DVec3) -> DVec3 {
        match *self {
            Self::Point { origin, .. } => origin - point,
            Self::Parallel { direction, .. } => -direction,
        }
    }
}
