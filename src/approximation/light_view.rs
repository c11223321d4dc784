//! The scene seen from a light: where a photon buffer's pixels and a caustic map's texels are.

use glam::{DVec2, DVec3};

use super::extent::{Extent, farthest};
use crate::geometry::{Bounds, Frame, Ray};
use crate::numeric::math;
use crate::optics::RayDerivative;
use crate::transport::first_surface::Source;

/// A square image seen from a light: a pyramid about an axis, or, of parallel light, a box.
///
/// Pixel (column, row) is [column, column + 1) x [row, row + 1), as of all films.
#[derive(Clone, Copy, Debug)]
pub struct LightView {
    /// The light, or the middle of the box' front.
    origin: DVec3,
    frame: Frame,
    /// Half the side of the image: on the plane at distance 1 of a pyramid; of a box in scene units.
    half: f64,
    is_parallel: bool,
    /// Pixels a row, and rows.
    side: u32,
    /// The nearest and the farthest depth that matter.
    range: [f64; 2],
}

/// Where a point is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Projection {
    /// In pixels; may lie outside of the image.
    pub at: DVec2,
    /// Along the view's axis.
    pub depth: f64,
}

/// The widest pyramid: beyond, six faces of a cube see as much, and evenly (tan of 60 degrees).
const WIDEST: f64 = 1.8;

/// How much further than to the corners of what is seen an image reaches, so that none lies on its border.
const MARGIN: f64 = 1.001;

impl LightView {
    /// The views that together see all of some things: one, or for a point with things all around it up to
    /// six, the faces of a cube. Images are no wider than these reach.
    pub fn around(source: &Source, things: &[Extent], side: u32) -> Vec<Self> {
        let target = things
            .iter()
            .fold(Bounds::EMPTY, |all, one| all.union(one.bounds()));
        match *source {
            Source::Parallel { direction, .. } => {
                let center = target.center();
                let frame = Frame::along(direction, least_aligned(direction));
                let seen = farthest(things.iter().map(|thing| thing.in_beam(&frame, center)));
                let reach = target.radius();
                vec![Self {
                    origin: center - direction * (1.01 * reach),
                    frame,
                    half: seen.half * MARGIN,
                    is_parallel: true,
                    side,
                    range: [0.005 * reach, 2.02 * reach],
                }]
            }
            Source::Point { origin, .. } => Self::pyramids(origin, &target, things, side),
        }
    }

    fn pyramids(origin: DVec3, target: &Bounds, things: &[Extent], side: u32) -> Vec<Self> {
        let corners: Vec<DVec3> = things
            .iter()
            .flat_map(|thing| thing.bounds().corners())
            .collect();
        let far = corners
            .iter()
            .map(|corner| corner.distance(origin))
            .fold(0.0, f64::max);
        let nearest = origin.clamp(target.min, target.max).distance(origin);
        let pyramid = |frame: Frame, half: f64, near: f64| Self {
            origin,
            frame,
            half,
            is_parallel: false,
            side,
            range: [near, far.max(2.0 * near)],
        };
        if let Some(axis) = (target.center() - origin).try_normalize() {
            let frame = Frame::along(axis, least_aligned(axis));
            let seen = farthest(things.iter().map(|thing| thing.in_pyramid(&frame, origin)));
            if seen.ahead > 0.0 && seen.half <= WIDEST {
                return vec![pyramid(frame, seen.half * MARGIN, 0.999 * seen.ahead)];
            }
        }
        // In a face of a cube what is `nearest` is at least 1/√3 of that deep.
        let near = (nearest * 0.57).max(1e-3 * far);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        let faces = (0..6).map(|face| {
            let axis = axes[face / 2] * if face % 2 == 0 { 1.0 } else { -1.0 };
            Frame::along(axis, axes[(face / 2 + 1) % 3])
        });
        // A face does not see what all corners of lie beyond one of its sides.
        let is_beyond = |frame: &Frame, out: DVec2| {
            corners.iter().all(|corner| {
                let p = frame.to_local(*corner - origin);
                out.dot(p.truncate()) > p.z
            })
        };
        faces
            .filter(|frame| {
                let sides = [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y];
                !sides.iter().any(|&out| is_beyond(frame, out))
            })
            .map(|frame| pyramid(frame, 1.0, near))
            .collect()
    }

    /// The part of the image in which a box is seen: two opposite corners; all of it where the box reaches
    /// behind the light.
    pub fn window(&self, bounds: &Bounds) -> [DVec2; 2] {
        let whole = [DVec2::ZERO, DVec2::splat(f64::from(self.side))];
        let mut window = [DVec2::INFINITY, DVec2::NEG_INFINITY];
        for corner in bounds.corners() {
            let Some(seen) = self.project(corner) else {
                return whole;
            };
            window = [window[0].min(seen.at), window[1].max(seen.at)];
        }
        [window[0].max(whole[0]), window[1].min(whole[1])]
    }

    /// The same view from further back, so that all of a box is ahead. Of a point nothing changes.
    #[must_use]
    pub fn before(mut self, bounds: &Bounds) -> Self {
        if self.is_parallel {
            let corners = bounds.corners().into_iter();
            let least = corners
                .map(|corner| self.frame.n.dot(corner - self.origin))
                .fold(0.0, f64::min);
            let back = (1.01 * -least).max(0.0);
            self.origin -= self.frame.n * back;
            self.range[1] += back;
        }
        self
    }

    /// The same view with other pixels.
    #[must_use]
    pub fn with_side(mut self, side: u32) -> Self {
        self.side = side;
        self
    }

    /// Pixels a row, and rows.
    #[inline]
    pub fn side(&self) -> usize {
        self.side as usize
    }

    /// The nearest and the farthest depth that matter.
    pub fn range(&self) -> [f64; 2] {
        self.range
    }

    /// Whether light is parallel, from infinitely far away.
    pub fn is_parallel(&self) -> bool {
        self.is_parallel
    }

    /// Half the side of the image, on the plane at distance 1.
    pub fn half(&self) -> f64 {
        self.half
    }

    /// The image point's place on the plane at distance 1, of parallel light across it.
    fn on_plane(&self, at: DVec2) -> DVec2 {
        (at * (2.0 / f64::from(self.side)) - 1.0) * self.half
    }

    /// The light's ray through an image point.
    #[inline]
    pub fn ray(&self, at: DVec2) -> Ray {
        let place = self.on_plane(at);
        if self.is_parallel {
            let across = self.frame.to_world(place.extend(0.0));
            Ray::new(self.origin + across, self.frame.n)
        } else {
            let direction = self.frame.to_world(place.extend(1.0)).normalize();
            Ray::new(self.origin, direction)
        }
    }

    /// How the light's ray changes with the image point's two coordinates, by pixel.
    pub fn ray_derivatives(&self, at: DVec2) -> [RayDerivative; 2] {
        let pixel = 2.0 * self.half / f64::from(self.side);
        let axes = [self.frame.s * pixel, self.frame.t * pixel];
        if self.is_parallel {
            return axes.map(|position| RayDerivative {
                position,
                direction: DVec3::ZERO,
            });
        }
        // D = V/|V|: ∂D = (∂V − (∂V·D) D) / |V|.
        let length = (1.0 + self.on_plane(at).length_squared()).sqrt();
        let direction = self.ray(at).direction;
        axes.map(|axis| RayDerivative {
            position: DVec3::ZERO,
            direction: (axis - direction * axis.dot(direction)) / length,
        })
    }

    /// Where a point is seen, also beyond the image; `None` behind the light.
    #[inline]
    pub fn project(&self, point: DVec3) -> Option<Projection> {
        let p = self.frame.to_local(point - self.origin);
        let place = if self.is_parallel {
            p.truncate()
        } else {
            p.truncate() / p.z
        };
        let at = (place / self.half + 1.0) * (0.5 * f64::from(self.side));
        (p.z > 0.0 && at.is_finite()).then_some(Projection { at, depth: p.z })
    }

    /// How the image point of `point` changes as it moves by `along` \[m\], in pixels.
    pub fn project_derivative(&self, point: DVec3, along: DVec3) -> DVec2 {
        let scale = 0.5 * f64::from(self.side) / self.half;
        let moved = self.frame.to_local(along);
        if self.is_parallel {
            return moved.truncate() * scale;
        }
        let p = self.frame.to_local(point - self.origin);
        (moved.truncate() - p.truncate() * (moved.z / p.z)) * (scale / p.z)
    }

    /// Whether an image point is in the image.
    #[inline]
    pub fn holds(&self, at: DVec2) -> bool {
        let side = f64::from(self.side);
        at.x >= 0.0 && at.y >= 0.0 && at.x < side && at.y < side
    }

    /// Light-space measure of the whole image: solid angle \[sr\], of parallel light area \[m²\].
    pub fn measure(&self) -> f64 {
        let side = f64::from(self.side);
        self.measure_of(DVec2::ZERO, DVec2::splat(side))
    }

    /// Light-space measure of a rectangle of the image between two corners: solid angle \[sr\], of parallel
    /// light area \[m²\].
    ///
    /// On the plane z = 1 the solid angle of [0, x] x [0, y] is atan(x y / √(1 + x² + y²)), and that of any
    /// rectangle follows from its four corners.
    pub fn measure_of(&self, low: DVec2, high: DVec2) -> f64 {
        let (a, b) = (self.on_plane(low), self.on_plane(high));
        if self.is_parallel {
            return (b - a).element_product();
        }
        let corner = |x: f64, y: f64| math::atan(x * y / (1.0 + x * x + y * y).sqrt());
        corner(b.x, b.y) - corner(a.x, b.y) - corner(b.x, a.y) + corner(a.x, a.y)
    }

    /// Light-space measure of one pixel by the density of the image at a point, which may lie beyond it:
    /// solid angle \[sr\], of parallel light area \[m²\].
    ///
    /// A pixel's solid angle is (2h/N)² cos³ of the angle to the axis.
    pub fn pixel_measure_at(&self, at: DVec2) -> f64 {
        let pixel = 2.0 * self.half / f64::from(self.side);
        if self.is_parallel {
            return pixel * pixel;
        }
        // On the plane at distance 1 the point is 1/cos away.
        pixel * pixel / math::powf(1.0 + self.on_plane(at).length_squared(), 1.5)
    }

    /// The axis of the image: a unit vector away from the light.
    pub fn axis(&self) -> DVec3 {
        self.frame.n
    }

    /// Area \[m²\] of a surface with unit `normal` that one pixel sees about `point`, by the density of the
    /// image there; infinite along the light.
    ///
    /// A pixel's solid angle is (2h/N)² cos³ of the angle to the axis; it sees dω d² / cos θ.
    #[inline]
    pub fn seen_area(&self, point: DVec3, normal: DVec3) -> f64 {
        let pixel = 2.0 * self.half / f64::from(self.side);
        if self.is_parallel {
            return pixel * pixel / self.frame.n.dot(normal).abs();
        }
        let offset = point - self.origin;
        let depth = offset.dot(self.frame.n);
        // (2h/N)² (depth/d)³ d² / (|offset·n| / d): the distance d drops out.
        pixel * pixel * depth * depth * depth / offset.dot(normal).abs()
    }

    /// Whether a surface with this `normal` faces the light at `point`.
    #[inline]
    pub fn is_before(&self, point: DVec3, normal: DVec3) -> bool {
        let arriving = if self.is_parallel {
            self.frame.n
        } else {
            point - self.origin
        };
        arriving.dot(normal) < 0.0
    }

    /// Towards the surface point: the direction of the light's ray through it, a unit vector.
    pub fn direction_to(&self, point: DVec3) -> DVec3 {
        if self.is_parallel {
            self.frame.n
        } else {
            (point - self.origin).normalize_or_zero()
        }
    }
}

/// The axis of space that is least along a direction.
fn least_aligned(direction: DVec3) -> DVec3 {
    let a = direction.abs();
    if a.x <= a.y && a.x <= a.z {
        DVec3::X
    } else if a.y <= a.z {
        DVec3::Y
    } else {
        DVec3::Z
    }
}
