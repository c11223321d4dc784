//! Projections of space: the geometry between a film point and a ray, in both directions.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{DMat3, DVec2, DVec3};

use crate::geometry::{Ray, Transform};
use crate::numeric::math;
use crate::numeric::rotation;
use crate::scene::SensorKind;

/// A projection of space.
#[derive(Clone, Copy, Debug)]
pub(super) enum CameraLens {
    /// Rays from a point, or from a disk about it.
    Central {
        /// Position in world space.
        position: DVec3,
        /// |det M|.
        determinant: f64,
        /// `None` for a pinhole.
        aperture: Option<Aperture>,
    },
    /// Parallel rays.
    Parallel {
        /// The unit vector along which the camera looks, world space.
        axis: DVec3,
        /// World area across the axis per area of camera space's xy plane.
        magnification: f64,
    },
}

/// A thin lens in the plane z = 0 of camera space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Aperture {
    radius: f64,
    /// Distance of the plane in focus, z = `focus_distance`.
    focus_distance: f64,
}

/// A point as a lens sees it.
pub(super) struct LensProjection {
    /// Point on the plane z = 1 of camera space (its xy plane, for parallel rays).
    pub on_film: DVec2,
    /// Unit vector from the point to the camera.
    pub towards: DVec3,
    /// Depth behind the near plane, in the unit of the clip distances.
    pub depth: f64,
    /// Distance from the point to the near plane, along `towards`.
    pub distance: f64,
    /// |M q|³ / (d² |det M|), by area of the film.
    pub importance: f64,
}

impl CameraLens {
    /// The lens of a camera; for any other sensor a pinhole at its origin.
    pub fn new(kind: &SensorKind, to_world: &Transform) -> Self {
        let linear = DMat3::from_mat4(to_world.matrix());
        match *kind {
            SensorKind::Orthographic { .. } => {
                let axis = linear.z_axis.normalize();
                Self::Parallel {
                    axis,
                    magnification: linear.x_axis.cross(linear.y_axis).dot(axis).abs(),
                }
            }
            _ => Self::Central {
                position: to_world.point(DVec3::ZERO),
                determinant: linear.determinant().abs(),
                aperture: match *kind {
                    SensorKind::ThinLens {
                        aperture_radius,
                        focus_distance,
                        ..
                    } => Some(Aperture {
                        radius: aperture_radius,
                        focus_distance,
                    }),
                    _ => None,
                },
            },
        }
    }

    /// The world's length of a typical unit of camera space.
    pub fn scale(&self) -> f64 {
        match self {
            Self::Central { determinant, .. } => math::cbrt(*determinant),
            Self::Parallel { magnification, .. } => magnification.sqrt(),
        }
    }

    /// True if rays start anywhere on a disk.
    pub fn has_aperture(&self) -> bool {
        matches!(
            self,
            Self::Central {
                aperture: Some(_),
                ..
            }
        )
    }

    /// The projection of a point through the point `lens` of the lens; `None` behind the camera.
    #[inline]
    pub fn project(
        &self,
        to_world: &Transform,
        position: DVec3,
        lens: DVec2,
        near_clip: f64,
    ) -> Option<LensProjection> {
        let local = to_world.inverse().point(position);
        match *self {
            Self::Central {
                position: pinhole,
                determinant,
                aperture,
            } => {
                if local.z <= 0.0 {
                    return None;
                }
                let mut on_film = local.truncate() / local.z;
                let mut offset = pinhole - position;
                if let Some(aperture) = aperture {
                    let start = aperture.point(lens);
                    offset += to_world.vector(start.extend(0.0));
                    // Here, shifted by its distance, the ray from the lens through the point meets the plane
                    // in focus.
                    on_film += start * (1.0 / aperture.focus_distance - 1.0 / local.z);
                }
                let whole = offset.length();
                // |M q| is the distance that belongs to one unit of camera space's z.
                let stretch = whole / local.z;
                Some(LensProjection {
                    on_film,
                    towards: offset / whole,
                    depth: local.z - near_clip,
                    distance: whole - near_clip * stretch,
                    importance: stretch * stretch * stretch / (whole * whole * determinant),
                })
            }
            Self::Parallel {
                axis,
                magnification,
            } => {
                let stretch = to_world.vector(DVec3::Z).length();
                let distance = (local.z - near_clip) * stretch;
                Some(LensProjection {
                    on_film: local.truncate(),
                    towards: -axis,
                    // As in Mitsuba, rays are far_clip − near_clip long in the *world*, however camera space
                    // is scaled.
                    depth: distance,
                    distance,
                    importance: 1.0 / magnification,
                })
            }
        }
    }

    /// The ray through a film point and a point of the lens, from the near plane on, and its length per unit
    /// of [`LensProjection::depth`].
    #[inline]
    pub fn ray(
        &self,
        to_world: &Transform,
        on_film: DVec2,
        lens: DVec2,
        near_clip: f64,
    ) -> (Ray, f64) {
        match *self {
            Self::Central {
                position, aperture, ..
            } => {
                let mut slope = on_film;
                let mut start = position;
                if let Some(aperture) = aperture {
                    let at = aperture.point(lens);
                    slope -= at / aperture.focus_distance;
                    start += to_world.vector(at.extend(0.0));
                }
                let along = to_world.vector(slope.extend(1.0));
                let stretch = along.length();
                (
                    Ray::new(start + along * near_clip, along / stretch),
                    stretch,
                )
            }
            Self::Parallel { axis, .. } => (
                Ray::new(to_world.point(on_film.extend(near_clip)), axis),
                1.0,
            ),
        }
    }
}

impl Aperture {
    /// The point of the lens that belongs to a point of the unit square.
    ///
    /// The map keeps areas in proportion and neighbours together (Shirley and Chiu, *A Low Distortion Map
    /// Between Disk and Square*, 1997).
    fn point(&self, square: DVec2) -> DVec2 {
        let centred = 2.0 * square - 1.0;
        if centred == DVec2::ZERO {
            return DVec2::ZERO;
        }
        let (radius, angle) = if centred.x.abs() > centred.y.abs() {
            (centred.x, FRAC_PI_4 * (centred.y / centred.x))
        } else {
            (centred.y, FRAC_PI_2 - FRAC_PI_4 * (centred.x / centred.y))
        };
        rotation::direction(angle) * (radius * self.radius)
    }
}
