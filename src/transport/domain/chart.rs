//! Charts: two-dimensional coordinates over an emitter's light, with its flux density.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::face::{face_frustum, face_sample, rectangle_solid_angle};
use super::normal_light::NormalLight;
use super::patch::{ChartPatch, Emission};
use super::probe::Probe;
use super::sky::Sky;
use super::surface::{Area, surface_point};
use super::textured::TexturedPart;
use crate::geometry::{Bounds, Ray};
use crate::numeric::math;
use crate::numeric::rotation;
use crate::radiometry::Rgb;
use crate::scene::{Emitter, Slide};

/// Dependence of a point emitter's intensity on direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Falloff {
    /// No dependence.
    None,
    /// A cone about the chart's frame axis: see [`Emitter::Spot`].
    Spot {
        /// The cone's axis, a unit vector.
        axis: DVec3,
        /// Half the opening angle \[rad\].
        cutoff_angle: f64,
        /// Angle to the axis at which the intensity starts to fall \[rad\].
        beam_width: f64,
    },
}

impl Falloff {
    /// The falloff of an emitter: none, except for spots.
    pub fn of(emitter: &Emitter) -> Self {
        match emitter {
            Emitter::Spot {
                to_world,
                cutoff_angle,
                beam_width,
                ..
            } => Self::Spot {
                axis: to_world.vector(DVec3::Z).normalize(),
                cutoff_angle: *cutoff_angle,
                beam_width: *beam_width,
            },
            _ => Self::None,
        }
    }

    /// The factor on the intensity in a direction. For a spot it is linear in the angle to the axis between
    /// `beam_width` and `cutoff_angle`.
    #[inline]
    pub fn factor(&self, direction: DVec3) -> f64 {
        match *self {
            Self::None => 1.0,
            Self::Spot { axis, .. } => {
                // atan2 keeps its accuracy near the axis, where acos loses half the digits.
                self.at_angle(rotation::angle_between(direction, axis))
            }
        }
    }

    /// The factor at an angle \[rad\] to the axis.
    #[inline]
    pub fn at_angle(&self, angle: f64) -> f64 {
        match *self {
            Self::None => 1.0,
            Self::Spot {
                cutoff_angle,
                beam_width,
                ..
            } => {
                if angle <= beam_width {
                    1.0
                } else if angle >= cutoff_angle {
                    0.0
                } else {
                    (cutoff_angle - angle) / (cutoff_angle - beam_width)
                }
            }
        }
    }
}

/// Two-dimensional coordinates over an emitter's light, or over a part of it.
#[derive(Clone, Debug)]
pub enum LightChart {
    /// A cube-map face about a point: direction ∝ a₁ x + a₂ y + a₃, x and y in [-1, 1].
    Face {
        /// Start of the light.
        origin: DVec3,
        /// Right-handed orthonormal frame; the third looks through the face.
        axes: [DVec3; 3],
        /// Radiant intensity [W/sr].
        intensity: Rgb,
        /// Its dependence on direction.
        falloff: Falloff,
        /// The image that it shines through, if any: a factor.
        slide: Option<Slide>,
    },
    /// The light of a projector: coordinates are places on its image's plane ([`Slide`]), where flux by
    /// area is the image's value times the irradiance.
    Projector {
        /// The image, and the point behind it.
        slide: Slide,
        /// The factor on the image [W/m²].
        irradiance: Rgb,
    },
    /// Parallel light: coordinates are metres along two axes across it.
    Parallel {
        /// The point at coordinates (0, 0), before all geometry.
        origin: DVec3,
        /// Orthonormal, across the light.
        across: [DVec3; 2],
        /// The direction of travel.
        direction: DVec3,
        /// Irradiance across the light [W/m²].
        irradiance: Rgb,
    },
    /// Light from a flat surface. Coordinates are the projections of the direction on two axes in the surface
    /// (Nusselt's analog), x² + y² < 1. The place on the surface takes two more dimensions.
    Flat {
        /// The surface from which light starts.
        area: Area,
        /// Orthonormal frame; the third is the normal on the side that shines.
        axes: [DVec3; 3],
        /// Radiance [W/m²/sr], a factor on the texture if there is one.
        radiance: Rgb,
        /// The texture, if it varies over the surface: starts are in proportion to its light.
        texture: Option<Box<TexturedPart>>,
    },
    /// Light from a ball. Coordinates are as of a face. The place on the disc that the ball shows in that
    /// direction takes two more dimensions.
    Ball {
        /// Middle of the ball.
        center: DVec3,
        /// Its radius.
        radius: f64,
        /// Frame as of a face.
        axes: [DVec3; 3],
        /// Radiance [W/m²/sr], a factor on the texture if there is one.
        radiance: Rgb,
        /// The texture, if it varies over the ball.
        texture: Option<Box<TexturedPart>>,
    },
    /// Light along the normals of a surface. Coordinates are places on a flat part, or as of a face about the
    /// middle of a ball.
    Normal(Box<NormalLight>),
    /// Light from all round.
    Sky(Sky),
}

impl LightChart {
    /// The patch of coordinates that holds all of the chart's light.
    pub fn root(&self, specular: &Bounds) -> ChartPatch {
        match self {
            Self::Parallel { origin, across, .. } => {
                let range = |axis: DVec3| {
                    let middle = (specular.center() - *origin).dot(axis);
                    let reach = 0.5 * specular.extent().dot(axis.abs());
                    // A hair more than the bounds, so that rounding loses nothing.
                    let reach = reach * (1.0 + 1e-9);
                    (middle - reach, middle + reach)
                };
                let (x, y) = (range(across[0]), range(across[1]));
                ChartPatch {
                    from: DVec2::new(x.0, y.0),
                    to: DVec2::new(x.1, y.1),
                }
            }
            Self::Normal(light) => light.root(),
            Self::Sky(sky) => sky.root(),
            Self::Projector { slide, .. } => {
                let (from, to) = slide.extent();
                ChartPatch { from, to }
            }
            _ => ChartPatch {
                from: DVec2::NEG_ONE,
                to: DVec2::ONE,
            },
        }
    }

    /// The emitter's strength: radiant intensity [W/sr], irradiance [W/m²] or radiance [W/m²/sr].
    pub fn strength(&self) -> Rgb {
        match self {
            Self::Face { intensity, .. } => *intensity,
            Self::Parallel { irradiance, .. } | Self::Projector { irradiance, .. } => *irradiance,
            Self::Flat { radiance, .. } | Self::Ball { radiance, .. } => *radiance,
            Self::Normal(light) => light.strength(),
            Self::Sky(sky) => sky.strength(),
        }
    }

    /// True if flux may be much more uneven within a patch than over the whole chart divided by its area.
    pub(super) fn is_uneven(&self, patch: &ChartPatch) -> bool {
        match self {
            Self::Normal(light) => light.is_uneven(patch),
            Self::Sky(sky) => sky.is_uneven(patch),
            Self::Projector { slide, .. } => slide.is_coarser_than_a_texel(patch.to - patch.from),
            Self::Face { axes, slide, .. } => slide.as_ref().is_some_and(|slide| {
                *axes == slide.axes() && slide.is_coarser_than_a_texel(patch.to - patch.from)
            }),
            _ => false,
        }
    }

    /// True if the start of light needs two dimensions beside the chart's.
    pub fn has_area(&self) -> bool {
        matches!(self, Self::Flat { .. } | Self::Ball { .. } | Self::Sky(_))
    }

    /// The region that light of a patch can reach.
    pub fn probe(&self, patch: &ChartPatch) -> Probe {
        match *self {
            Self::Normal(ref light) => light.probe(patch),
            Self::Sky(ref sky) => sky.probe(),
            Self::Face { origin, axes, .. } => face_frustum(origin, 0.0, &axes, patch),
            Self::Projector { ref slide, .. } => {
                face_frustum(slide.origin(), 0.0, &slide.axes(), patch)
            }
            Self::Ball {
                center,
                radius,
                axes,
                ..
            } => face_frustum(center, radius, &axes, patch),
            Self::Parallel { origin, across, .. } => {
                let offset = DVec2::new(origin.dot(across[0]), origin.dot(across[1]));
                Probe::Prism {
                    across,
                    ranges: [
                        [patch.from.x + offset.x, patch.to.x + offset.x],
                        [patch.from.y + offset.y, patch.to.y + offset.y],
                    ],
                }
            }
            Self::Flat { area, axes, .. } => {
                let (apex, apex_radius) = area.ball();
                let (axis, half_angle) = hemisphere_cone(patch);
                Probe::Cone {
                    apex,
                    axis: axes[0] * axis.x + axes[1] * axis.y + axes[2] * axis.z,
                    half_angle,
                    apex_radius,
                }
            }
        }
    }

    /// True if a patch is known to send no light, as [`flux_bound`](Self::flux_bound) would tell, but in
    /// little time: that may integrate a texture.
    pub(super) fn is_dark(&self, patch: &ChartPatch) -> bool {
        match self {
            Self::Normal(light) => light.is_dark(patch),
            other => other.flux_bound(patch).is_black(),
        }
    }

    /// The flux of a patch \[W\], or an upper bound; zero only if there is none.
    ///
    /// It is a bound for spots, images, textures on discs and balls, and for patches across the rim of a disc
    /// or of a flat emitter's hemisphere, of which it counts the whole.
    pub fn flux_bound(&self, patch: &ChartPatch) -> Rgb {
        match *self {
            Self::Normal(ref light) => light.flux_bound(patch),
            Self::Sky(ref sky) => sky.flux_bound(patch),
            Self::Projector {
                ref slide,
                irradiance,
            } => irradiance * slide.peak_between(patch.from, patch.to) * patch.area(),
            Self::Face {
                axes,
                intensity,
                falloff,
                ref slide,
                ..
            } => {
                let nearest = match falloff {
                    Falloff::None => 1.0,
                    Falloff::Spot { axis, .. } => {
                        let middle = face_direction(&axes, patch.at(DVec2::splat(0.5)));
                        let radius = patch
                            .corners()
                            .iter()
                            .map(|corner| {
                                rotation::angle_between(middle, face_direction(&axes, *corner))
                            })
                            .fold(0.0, f64::max);
                        falloff.at_angle(
                            (rotation::angle_between(middle, axis) - radius * 1.001).max(0.0),
                        )
                    }
                };
                let bound = intensity * (nearest * rectangle_solid_angle(patch));
                match slide {
                    Some(slide) if slide.axes() == axes => {
                        bound * slide.peak_between(patch.from, patch.to)
                    }
                    Some(slide) => bound * slide.peak(),
                    None => bound,
                }
            }
            Self::Ball {
                radius,
                radiance,
                ref texture,
                ..
            } => {
                let flux = radiance * (PI * radius * radius * rectangle_solid_angle(patch));
                texture.as_ref().map_or(flux, |it| flux * it.mean())
            }
            Self::Parallel { irradiance, .. } => irradiance * patch.area(),
            Self::Flat {
                area,
                radiance,
                ref texture,
                ..
            } => {
                if nearest_to_zero(patch).length_squared() >= 1.0 {
                    return Rgb::BLACK;
                }
                let flux = radiance * (area.area() * patch.area());
                texture.as_ref().map_or(flux, |it| flux * it.mean())
            }
        }
    }

    /// The ray at fractions `at` across a patch, and at `start` across the emitter's surface if it has one.
    #[inline]
    pub fn emit(&self, patch: &ChartPatch, at: DVec2, start: DVec2) -> Emission {
        let place = patch.at(at);
        match *self {
            Self::Normal(ref light) => light.emit(patch, at),
            Self::Sky(ref sky) => sky.emit(place, patch.area(), start),
            Self::Face {
                origin,
                axes,
                falloff,
                ref slide,
                ..
            } => {
                let (direction, jacobian) = face_sample(&axes, place);
                let density = jacobian * falloff.factor(direction);
                Emission {
                    ray: Ray::new(origin, direction),
                    measure: density * patch.area(),
                    color: slide.as_ref().map(|slide| slide.towards(direction)),
                }
            }
            Self::Projector { ref slide, .. } => Emission {
                ray: Ray::new(slide.origin(), face_direction(&slide.axes(), place)),
                measure: patch.area(),
                color: Some(slide.at(place)),
            },
            Self::Ball {
                center,
                radius,
                axes,
                ref texture,
                ..
            } => {
                let (direction, jacobian) = face_sample(&axes, place);
                let (sin, cos) = math::sin_cos(2.0 * PI * start.y);
                let (s, t) = direction.any_orthonormal_pair();
                let across = start.x.sqrt();
                let forward = (1.0 - start.x).max(0.0).sqrt();
                let normal = (s * cos + t * sin) * across + direction * forward;
                Emission {
                    ray: surface_point(center + normal * radius, normal).spawn(direction),
                    measure: PI * radius * radius * jacobian * patch.area(),
                    color: texture
                        .as_ref()
                        .map(|it| it.value_along(normal.normalize())),
                }
            }
            Self::Parallel {
                origin,
                across,
                direction,
                ..
            } => Emission {
                ray: Ray::new(
                    origin + across[0] * place.x + across[1] * place.y,
                    direction,
                ),
                measure: patch.area(),
                color: None,
            },
            Self::Flat {
                area,
                axes,
                ref texture,
                ..
            } => {
                let height_squared = 1.0 - place.length_squared();
                let lit = height_squared > 0.0;
                let direction = (axes[0] * place.x
                    + axes[1] * place.y
                    + axes[2] * height_squared.max(0.0).sqrt())
                .normalize();
                let (point, color) = match texture {
                    None => (surface_point(area.point(start), axes[2]), None),
                    Some(texture) => {
                        let (point, color) = texture.sample(start);
                        (point, Some(color))
                    }
                };
                Emission {
                    ray: point.spawn(direction),
                    measure: if lit { area.area() * patch.area() } else { 0.0 },
                    color,
                }
            }
        }
    }
}

/// The unit vector through a point of a cube-map face.
fn face_direction(axes: &[DVec3; 3], place: DVec2) -> DVec3 {
    face_sample(axes, place).0
}

/// The point of a patch nearest to (0, 0).
fn nearest_to_zero(patch: &ChartPatch) -> DVec2 {
    DVec2::ZERO.clamp(patch.from, patch.to)
}

/// A cone (axis in the frame, half angle) round all unit vectors (x, y, √(1 − x² − y²)) with (x, y) in the
/// patch. It surrounds a ball that holds the box in which they lie.
fn hemisphere_cone(patch: &ChartPatch) -> (DVec3, f64) {
    let height = |radius_squared: f64| (1.0 - radius_squared).max(0.0).sqrt();
    let highest = height(nearest_to_zero(patch).length_squared());
    let lowest = height(
        patch
            .corners()
            .iter()
            .map(|corner| corner.length_squared())
            .fold(0.0, f64::max),
    );
    let from = patch.from.extend(lowest);
    let to = patch.to.extend(highest);
    let center = 0.5 * (from + to);
    let radius = 0.5 * (to - from).length();
    let length = center.length();
    if radius >= length {
        return (DVec3::Z, PI);
    }
    (center / length, math::asin(radius / length))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_six_faces_make_a_whole_sphere() {
        let root = ChartPatch {
            from: DVec2::NEG_ONE,
            to: DVec2::ONE,
        };
        let sphere = 6.0 * rectangle_solid_angle(&root);
        // Four arc tangents and three additions: a few units in the last place.
        assert!((sphere - 4.0 * PI).abs() < 16.0 * f64::EPSILON * 4.0 * PI);
        let quarters: f64 = root.quarters().iter().map(rectangle_solid_angle).sum();
        assert!((6.0 * quarters - sphere).abs() < 16.0 * f64::EPSILON * sphere);
    }

    #[test]
    fn a_patch_has_the_solid_angle_of_its_samples() {
        let patch = ChartPatch {
            from: DVec2::new(-0.3, 0.2),
            to: DVec2::new(0.5, 0.9),
        };
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let n = 400;
        let mut sum = 0.0;
        for i in 0..n * n {
            let at = DVec2::new((i % n) as f64 + 0.5, (i / n) as f64 + 0.5) / f64::from(n);
            sum += face_sample(&axes, patch.at(at)).1;
        }
        let midpoint = sum * patch.area() / f64::from(n * n);
        // The midpoint rule's error is about h²/24 · f″ · area, f″ of order 3, h = 1/400.
        assert!((midpoint - rectangle_solid_angle(&patch)).abs() < 1e-6);
    }

    #[test]
    fn a_probe_holds_every_ray_of_its_patch() {
        let charts = [
            LightChart::Flat {
                area: Area::Triangle([DVec3::ZERO, DVec3::X, DVec3::new(0.2, 0.7, 0.1)]),
                axes: [DVec3::X, DVec3::Y, DVec3::Z],
                radiance: Rgb::WHITE,
                texture: None,
            },
            LightChart::Ball {
                center: DVec3::new(1.0, 2.0, 3.0),
                radius: 0.5,
                axes: [DVec3::Y, DVec3::Z, DVec3::X],
                radiance: Rgb::WHITE,
                texture: None,
            },
            LightChart::Face {
                origin: DVec3::new(5.0, 0.0, -1.0),
                axes: [DVec3::Z, DVec3::X, DVec3::Y],
                intensity: Rgb::WHITE,
                falloff: Falloff::None,
                slide: None,
            },
            LightChart::Parallel {
                origin: DVec3::new(5.0, 0.0, -1.0),
                across: [DVec3::X, DVec3::Y],
                direction: DVec3::Z,
                irradiance: Rgb::WHITE,
            },
        ];
        let steps = [0.0, 0.25, 0.5, 0.75, 1.0];
        for chart in &charts {
            let mut patches = vec![chart.root(&Bounds::from_points([DVec3::ZERO, DVec3::ONE]))];
            for _ in 0..4 {
                patches = patches.iter().flat_map(ChartPatch::quarters).collect();
            }
            for patch in &patches {
                let probe = chart.probe(patch);
                for (i, j, k, l) in itertools(&steps) {
                    let emission = chart.emit(patch, DVec2::new(i, j), DVec2::new(k, l));
                    if emission.measure == 0.0 {
                        continue;
                    }
                    assert!(!chart.flux_bound(patch).is_black());
                    for distance in [0.0, 0.1, 3.0, 1e3] {
                        let point = emission.ray.at(distance);
                        assert!(probe.may_overlap_ball(point, 0.0), "{chart:?} {patch:?}");
                    }
                }
            }
        }
    }

    fn itertools(steps: &[f64]) -> impl Iterator<Item = (f64, f64, f64, f64)> {
        steps.iter().flat_map(move |a| {
            steps.iter().flat_map(move |b| {
                steps
                    .iter()
                    .flat_map(move |c| steps.iter().map(move |d| (*a, *b, *c, *d)))
            })
        })
    }
}
