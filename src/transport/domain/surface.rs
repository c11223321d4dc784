//! Surfaces that shine, in parts that can be sampled.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use crate::geometry::{Shape, SurfacePoint};
use crate::numeric::math;
use crate::scene::MAX_SHINING_TRIANGLES;

/// A flat piece of an emitter's surface.
#[derive(Clone, Copy, Debug)]
pub enum Area {
    /// origin + u e₁ + v e₂.
    Parallelogram {
        /// A corner.
        origin: DVec3,
        /// The edges from it.
        edges: [DVec3; 2],
    },
    /// A triangle.
    Triangle([DVec3; 3]),
    /// A disc, or an ellipse: center + r (cos φ a₁ + sin φ a₂).
    Disk {
        /// Its middle.
        center: DVec3,
        /// Two conjugate half axes.
        axes: [DVec3; 2],
    },
}

impl Area {
    /// The point at (u, v) in [0, 1)², by a map that keeps areas in proportion.
    #[inline]
    pub fn point(&self, at: DVec2) -> DVec3 {
        match *self {
            Self::Parallelogram { origin, edges } => origin + edges[0] * at.x + edges[1] * at.y,
            Self::Triangle([a, b, c]) => {
                // Turk 1990: the density of √u cancels the narrowing towards the corner.
                let root = at.x.sqrt();
                a * (1.0 - root) + b * (root * (1.0 - at.y)) + c * (root * at.y)
            }
            Self::Disk { center, axes } => {
                let (sin, cos) = math::sin_cos(2.0 * PI * at.y);
                center + (axes[0] * cos + axes[1] * sin) * at.x.sqrt()
            }
        }
    }

    /// The coordinates, along the edges or half axes, of [`point`](Self::point) at (u, v).
    #[inline]
    pub fn place(&self, at: DVec2) -> DVec2 {
        match self {
            Self::Parallelogram { .. } => at,
            Self::Triangle(_) => {
                let root = at.x.sqrt();
                DVec2::new(root * (1.0 - at.y), root * at.y)
            }
            Self::Disk { .. } => {
                let (sin, cos) = math::sin_cos(2.0 * PI * at.y);
                DVec2::new(cos, sin) * at.x.sqrt()
            }
        }
    }

    /// The origin of such coordinates, and their axes.
    pub fn axes(&self) -> (DVec3, [DVec3; 2]) {
        match *self {
            Self::Parallelogram { origin, edges } => (origin, edges),
            Self::Triangle([a, b, c]) => (a, [b - a, c - a]),
            Self::Disk { center, axes } => (center, axes),
        }
    }

    /// The lowest and the highest coordinates.
    pub fn extent(&self) -> (DVec2, DVec2) {
        match self {
            Self::Parallelogram { .. } | Self::Triangle(_) => (DVec2::ZERO, DVec2::ONE),
            Self::Disk { .. } => (DVec2::NEG_ONE, DVec2::ONE),
        }
    }

    /// True if coordinates are on it.
    #[inline]
    pub fn holds(&self, place: DVec2) -> bool {
        let is_first_quadrant = place.x >= 0.0 && place.y >= 0.0;
        match self {
            Self::Parallelogram { .. } => is_first_quadrant && place.x <= 1.0 && place.y <= 1.0,
            Self::Triangle(_) => is_first_quadrant && place.x + place.y <= 1.0,
            Self::Disk { .. } => place.length_squared() <= 1.0,
        }
    }

    /// Area \[m²\].
    pub fn area(&self) -> f64 {
        match *self {
            Self::Parallelogram { edges: [a, b], .. } => a.cross(b).length(),
            Self::Triangle([a, b, c]) => 0.5 * (b - a).cross(c - a).length(),
            Self::Disk { axes: [a, b], .. } => PI * a.cross(b).length(),
        }
    }

    /// Middle and radius of a ball that holds it.
    pub fn ball(&self) -> (DVec3, f64) {
        let points: Vec<DVec3> = match *self {
            Self::Parallelogram {
                origin,
                edges: [a, b],
            } => {
                vec![origin, origin + a, origin + b, origin + a + b]
            }
            Self::Triangle(corners) => corners.to_vec(),
            Self::Disk {
                center,
                axes: [a, b],
            } => {
                vec![
                    center + a + b,
                    center + a - b,
                    center - a + b,
                    center - a - b,
                ]
            }
        };
        let center = points.iter().sum::<DVec3>() / points.len() as f64;
        let radius = points
            .iter()
            .map(|point| point.distance(center))
            .fold(0.0, f64::max);
        (center, radius)
    }
}

/// A part of a light's surface.
#[derive(Clone, Copy, Debug)]
pub enum LightPart {
    /// A flat part, and the unit normal on the side that shines.
    Flat(Area, DVec3),
    /// A whole ball, shining outward.
    Ball {
        /// Its middle.
        center: DVec3,
        /// Its radius.
        radius: f64,
    },
}

impl LightPart {
    /// Area \[m²\].
    pub fn area(&self) -> f64 {
        match self {
            Self::Flat(area, _) => area.area(),
            Self::Ball { radius, .. } => 4.0 * PI * radius * radius,
        }
    }

    /// A point with its normal at `at` in [0, 1)², uniform over the part.
    pub fn sample(&self, at: DVec2) -> SurfacePoint {
        match self {
            Self::Flat(area, normal) => surface_point(area.point(at), *normal),
            Self::Ball { center, radius } => {
                // Archimedes: belts of equal height have equal area.
                let height = 1.0 - 2.0 * at.x;
                let out = 2.0 * (at.x * (1.0 - at.x)).sqrt();
                let (sin, cos) = math::sin_cos(2.0 * PI * at.y);
                let normal = DVec3::new(out * cos, out * sin, height).normalize();
                surface_point(*center + normal * *radius, normal)
            }
        }
    }
}

/// The surface of an area light.
#[derive(Clone, Debug)]
pub struct LightSurface {
    parts: Vec<LightPart>,
    /// The face of a mesh that each part is; else its number.
    numbers: Vec<u32>,
    /// The whole of a rectangle, and its normal.
    rectangle: Option<(Area, DVec3)>,
    /// Sum of the areas of all parts up to and including each.
    cumulative: Vec<f64>,
}

/// A rectangle is divided into 4 x 4 parts: a smaller start makes a tighter test of the light's reach.
pub const ACROSS: u32 = 4;

impl LightSurface {
    /// The parts of a shape; `None` if the shape is not modelled as a light: a cylinder, a ball that shines
    /// inward, a mesh of more than [`MAX_SHINING_TRIANGLES`] triangles.
    pub fn new(shape: &Shape) -> Option<Self> {
        let mut numbers = Vec::new();
        let parts: Vec<LightPart> = match shape {
            Shape::Rectangle(rectangle) => {
                let whole = rectangle.edges();
                let corner = rectangle.center() - 0.5 * (whole[0] + whole[1]);
                let edges = whole.map(|edge| edge / f64::from(ACROSS));
                (0..ACROSS * ACROSS)
                    .map(|i| {
                        let (u, v) = (f64::from(i % ACROSS), f64::from(i / ACROSS));
                        let origin = corner + edges[0] * u + edges[1] * v;
                        LightPart::Flat(Area::Parallelogram { origin, edges }, rectangle.normal())
                    })
                    .collect()
            }
            Shape::Disk(disk) => {
                let area = Area::Disk {
                    center: disk.center(),
                    axes: disk.half_axes(),
                };
                vec![LightPart::Flat(area, disk.normal())]
            }
            Shape::Sphere(sphere) if !sphere.is_inward() => vec![LightPart::Ball {
                center: sphere.center(),
                radius: sphere.radius(),
            }],
            Shape::Mesh(mesh) if mesh.triangle_count() <= MAX_SHINING_TRIANGLES => {
                (0..mesh.triangle_count() as u32)
                    .filter_map(|face| {
                        let normal = mesh.face_normal(face) * mesh.shining_side(face);
                        let part = LightPart::Flat(Area::Triangle(mesh.corners(face)), normal);
                        let has_area = part.area() > 0.0;
                        if has_area {
                            numbers.push(face);
                        }
                        has_area.then_some(part)
                    })
                    .collect()
            }
            _ => return None,
        };
        if numbers.is_empty() {
            numbers = (0..parts.len() as u32).collect();
        }
        let rectangle = match shape {
            Shape::Rectangle(rectangle) => {
                let edges = rectangle.edges();
                let origin = rectangle.center() - 0.5 * (edges[0] + edges[1]);
                let whole = Area::Parallelogram { origin, edges };
                Some((whole, rectangle.normal()))
            }
            _ => None,
        };
        let mut sum = 0.0;
        let cumulative = parts
            .iter()
            .map(|part| {
                sum += part.area();
                sum
            })
            .collect();
        Some(Self {
            parts,
            numbers,
            rectangle,
            cumulative,
        })
    }

    /// The parts.
    pub fn parts(&self) -> &[LightPart] {
        &self.parts
    }

    /// The parts, each with the face of a mesh that it is, or else its number.
    pub fn numbered(&self) -> impl Iterator<Item = (u32, &LightPart)> {
        self.numbers.iter().copied().zip(&self.parts)
    }

    /// The whole surface and its normal, if it is one parallelogram.
    pub fn rectangle(&self) -> Option<(Area, DVec3)> {
        self.rectangle
    }

    /// All of the surface \[m²\].
    pub fn area(&self) -> f64 {
        self.cumulative.last().copied().unwrap_or(0.0)
    }

    /// A point with its normal at `at` in [0, 1)², uniform over the surface.
    pub fn sample(&self, at: DVec2) -> Option<SurfacePoint> {
        let wanted = at.x * self.area();
        let index = self
            .cumulative
            .partition_point(|sum| *sum <= wanted)
            .min(self.parts.len().checked_sub(1)?);
        let before = if index == 0 {
            0.0
        } else {
            self.cumulative[index - 1]
        };
        let part = &self.parts[index];
        let across = ((wanted - before) / part.area()).clamp(0.0, 1.0);
        Some(part.sample(DVec2::new(across, at.y)))
    }
}

/// A point on an emitter, with room for the rounding of its place: eight roundings, each at most half a unit
/// in the last place of the coordinate sums.
pub fn surface_point(position: DVec3, normal: DVec3) -> SurfacePoint {
    SurfacePoint {
        position,
        position_error: position.abs() * (8.0 * f64::EPSILON),
        geometric_normal: normal,
        shading_normal: normal,
        uv: DVec2::ZERO,
    }
}
