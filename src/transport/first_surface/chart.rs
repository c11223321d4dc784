//! Coordinates over first surfaces.

use glam::{DVec2, DVec3};

use super::place::ChartPlace;
use super::source::Source;
use crate::geometry::{Shape, Sphere, World};
use crate::numeric::math;

/// Two coordinates over (a part of) a surface.
#[derive(Clone, Copy, Debug)]
pub enum SurfaceChart {
    /// The side of a ball that a source outside of it sees. The coordinates are the angle of incidence i in
    /// [0, π/2] and the azimuth φ about the line from the centre to the source.
    ///
    /// All that happens to light at a ball is a smooth function of i, through the silhouette (i = π/2) and
    /// beyond.
    Cap {
        /// The ball.
        shape: u32,
        /// Orthonormal axes; the third points from the centre to the source.
        axes: [DVec3; 3],
        /// Radius / distance of the source from the centre; 0 for parallel light.
        radius_over_distance: f64,
    },
    /// Mitsuba's (u, v) of an analytic shape.
    Parameters {
        /// The shape.
        shape: u32,
    },
    /// Barycentric weights of the second and third vertex of a mesh's face.
    Face {
        /// The mesh.
        shape: u32,
        /// Its face.
        face: u32,
    },
}

impl SurfaceChart {
    /// The side of a ball that a source sees; `None` for a source inside.
    pub(super) fn cap(shape: u32, ball: &Sphere, source: &Source) -> Option<Self> {
        let to_source = source.towards(ball.center());
        let length = to_source.length();
        let radius_over_distance = if source.is_parallel() {
            0.0
        } else {
            ball.radius() / length
        };
        // False for NaN: the source is in the centre.
        if radius_over_distance < 1.0 {
            let axis = to_source / length;
            let (x, y) = axis.any_orthonormal_pair();
            Some(Self::Cap {
                shape,
                axes: [x, y, axis],
                radius_over_distance,
            })
        } else {
            None
        }
    }

    /// The shape whose surface it covers.
    #[inline]
    pub fn shape(&self) -> u32 {
        match *self {
            Self::Cap { shape, .. } | Self::Parameters { shape } | Self::Face { shape, .. } => {
                shape
            }
        }
    }

    /// The face whose surface it covers; 0 if that is no mesh.
    #[inline]
    pub fn face(&self) -> u32 {
        match *self {
            Self::Face { face, .. } => face,
            _ => 0,
        }
    }

    /// True if coordinates mean the same in another chart of the same source.
    pub fn is_that_of(&self, other: &Self) -> bool {
        let face = |chart: &Self| match chart {
            Self::Face { face, .. } => Some(*face),
            _ => None,
        };
        let kind = |chart: &Self| matches!(chart, Self::Parameters { .. });
        self.shape() == other.shape() && face(self) == face(other) && kind(self) == kind(other)
    }

    /// The surface at coordinates `at`; `None` only for a world that the chart was not made for.
    #[inline]
    pub fn place(&self, world: &World, at: DVec2) -> Option<ChartPlace> {
        match *self {
            Self::Cap {
                shape,
                axes,
                radius_over_distance,
            } => {
                let Shape::Sphere(ball) = &world.shapes()[shape as usize] else {
                    return None;
                };
                let (sin_i, cos_i) = math::sin_cos(at.x);
                // Seen from the source, the point is at the angle θ to the centre, sin θ = (r/d) sin i. Seen
                // from the centre, it is at γ = i − θ to the source.
                let sin_theta = radius_over_distance * sin_i;
                let cos_theta = ((1.0 - sin_theta) * (1.0 + sin_theta)).sqrt();
                let sin_gamma = sin_i * cos_theta - cos_i * sin_theta;
                let cos_gamma = cos_i * cos_theta + sin_i * sin_theta;
                let (sin_phi, cos_phi) = math::sin_cos(at.y);
                let across = axes[0] * cos_phi + axes[1] * sin_phi;
                // dγ/di = 1 − (r/d) cos i / cos θ, and the area element is r² sin γ dγ dφ.
                let stretch = 1.0 - radius_over_distance * cos_i / cos_theta;
                Some(ChartPlace {
                    point: ball.along(across * sin_gamma + axes[2] * cos_gamma),
                    area: ball.radius() * ball.radius() * sin_gamma * stretch,
                })
            }
            Self::Parameters { shape } => {
                let shape = &world.shapes()[shape as usize];
                let area = shape.area()
                    * match shape {
                        // u is the radius: rings grow with it.
                        Shape::Disk(_) => 2.0 * at.x,
                        // v is the polar angle / π.
                        Shape::Sphere(_) => {
                            let theta = std::f64::consts::PI * at.y;
                            std::f64::consts::FRAC_PI_2 * math::sin(theta)
                        }
                        _ => 1.0,
                    };
                let point = shape.at_uv(at)?;
                Some(ChartPlace { point, area })
            }
            Self::Face { shape, face } => {
                let Shape::Mesh(mesh) = &world.shapes()[shape as usize] else {
                    return None;
                };
                let [a, b, c] = mesh.corners(face);
                Some(ChartPlace {
                    point: world.face_point(shape, face, at)?,
                    area: (b - a).cross(c - a).length(),
                })
            }
        }
    }

    /// Flux \[W\] of a source that falls on the surface at coordinates `at`, for a unit of chart area and of
    /// the source's strength; `None` at the emitter itself.
    pub fn emitted(&self, world: &World, source: &Source, at: DVec2) -> Option<f64> {
        let place = self.place(world, at)?;
        Some(source.arrive(place.point.position)?.emitted(&place))
    }
}
