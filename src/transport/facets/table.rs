//! The facets of a scene.

use std::ops::Range;

use glam::{DVec2, DVec3};

use super::outline::outlines;
use crate::geometry::{Mesh, Ray, Shape, SurfacePoint};
use crate::scene::Scene;
use crate::transport::first_surface::SurfaceChart;

/// A convex polygon in one plane.
#[derive(Clone, Debug)]
pub struct Facet {
    /// The chart whose coordinates are the facet's: that of a rectangle, or of one of a mesh's faces.
    pub chart: SurfaceChart,
    /// The point where both coordinates are zero.
    origin: DVec3,
    /// The vectors that are a unit of each coordinate.
    axes: [DVec3; 2],
    /// Duals of the axes: their products with the offset from the origin are the coordinates.
    duals: [DVec3; 2],
    /// Unit normal, on the side that the shape shines to.
    normal: DVec3,
    /// Error of a position on it, per axis.
    position_error: DVec3,
    /// The corners, as a range of [`Facets::corners`], counter-clockwise about `axes[0] x axes[1]`.
    outline: Range<usize>,
    /// The facets beside it, as a range of the neighbours of all.
    beside: Range<usize>,
}

impl Facet {
    fn new(
        chart: SurfaceChart,
        origin: DVec3,
        axes: [DVec3; 2],
        normal: DVec3,
        position_error: DVec3,
        outline: Range<usize>,
    ) -> Option<Self> {
        let across = axes[0].cross(axes[1]);
        let squared = across.length_squared();
        // False for NaN, too.
        (squared > 0.0).then(|| Self {
            chart,
            origin,
            axes,
            duals: [
                axes[1].cross(across) / squared,
                across.cross(axes[0]) / squared,
            ],
            normal,
            position_error,
            outline,
            beside: 0..0,
        })
    }

    /// The shape, all or part of which is the facet.
    #[inline]
    pub fn shape(&self) -> u32 {
        self.chart.shape()
    }

    /// The point where both coordinates are zero.
    #[inline]
    pub fn origin(&self) -> DVec3 {
        self.origin
    }

    /// Area \[m²\] for a unit of coordinate area.
    #[inline]
    pub fn unit_area(&self) -> f64 {
        self.axes[0].cross(self.axes[1]).length()
    }

    /// The point of the plane at coordinates `at`, within the facet or beyond.
    #[inline]
    pub fn point(&self, at: DVec2) -> SurfacePoint {
        self.surface(self.origin + (self.axes[0] * at.x + self.axes[1] * at.y))
    }

    /// The coordinates of a point of the plane.
    #[inline]
    pub fn coordinates(&self, point: DVec3) -> DVec2 {
        let offset = point - self.origin;
        DVec2::new(self.duals[0].dot(offset), self.duals[1].dot(offset))
    }

    /// The point where a ray's line meets the plane, within the facet or beyond; `None` along the plane.
    ///
    /// Light that leaves a facet at its edge meets the next one at a distance of zero, give or take its
    /// rounding. So the distance may be negative.
    #[inline]
    pub fn meet(&self, ray: &Ray) -> Option<SurfacePoint> {
        let distance = self.normal.dot(self.origin - ray.origin) / self.normal.dot(ray.direction);
        distance.is_finite().then(|| self.surface(ray.at(distance)))
    }

    #[inline]
    fn surface(&self, position: DVec3) -> SurfacePoint {
        SurfacePoint {
            position,
            position_error: self.position_error,
            geometric_normal: self.normal,
            shading_normal: self.normal,
            uv: DVec2::ZERO,
        }
    }

    /// The height of a point over the plane, on the side of the normal.
    #[inline]
    pub fn height(&self, point: DVec3) -> f64 {
        self.normal.dot(point - self.origin)
    }

    /// Unit normal, on the side that the shape shines to.
    #[inline]
    pub fn normal(&self) -> DVec3 {
        self.normal
    }

    /// True if light along `direction` comes from the side about which the outline turns counter-clockwise.
    #[inline]
    pub fn is_from_front(&self, direction: DVec3) -> bool {
        self.axes[0].cross(self.axes[1]).dot(direction) < 0.0
    }
}

/// All facets of a scene.
#[derive(Clone, Debug)]
pub struct Facets {
    all: Vec<Facet>,
    corners: Vec<DVec3>,
    neighbours: Vec<u32>,
    /// The facet of each face, by shape; empty for shapes that have none.
    of_face: Vec<Vec<u32>>,
}

/// Mark of a face without area.
pub(super) const NO_FACET: u32 = u32::MAX;

impl Facets {
    /// Gathers the faces of all meshes without interpolated normals, coplanar neighbours together, and all
    /// rectangles.
    pub fn new(scene: &Scene) -> Self {
        let mut all = Self {
            all: Vec::new(),
            corners: Vec::new(),
            neighbours: Vec::new(),
            of_face: Vec::new(),
        };
        for (index, shape) in scene.world().shapes().iter().enumerate() {
            let index = index as u32;
            let of_face = match shape {
                _ if scene.material_of(index).is_passed(scene.materials()) => Vec::new(),
                Shape::Mesh(mesh) if !mesh.has_vertex_normals() => all.add_mesh(index, mesh),
                Shape::Rectangle(rectangle) => {
                    let first = rectangle.at_uv(DVec2::ZERO);
                    let outline = all.add_corners(&rectangle.corners());
                    let facet = all.add(Facet::new(
                        SurfaceChart::Parameters { shape: index },
                        first.position,
                        rectangle.edges(),
                        rectangle.normal(),
                        first.position_error,
                        outline,
                    ));
                    Vec::from_iter(facet)
                }
                _ => Vec::new(),
            };
            all.of_face.push(of_face);
        }
        all
    }

    fn add(&mut self, facet: Option<Facet>) -> Option<u32> {
        let facet = facet?;
        self.all.push(facet);
        Some(self.all.len() as u32 - 1)
    }

    fn add_corners(&mut self, corners: &[DVec3]) -> Range<usize> {
        let start = self.corners.len();
        self.corners.extend_from_slice(corners);
        start..self.corners.len()
    }

    fn add_mesh(&mut self, shape: u32, mesh: &Mesh) -> Vec<u32> {
        let found = outlines(mesh);
        let numbers: Vec<u32> = found
            .groups
            .iter()
            .map(|group| {
                let outline = self.add_corners(&group.corners);
                let [a, b, c] = mesh.corners(group.face);
                let face = group.face;
                self.add(Facet::new(
                    SurfaceChart::Face { shape, face },
                    a,
                    [b - a, c - a],
                    mesh.face_normal(face),
                    // As for any hit on the face, which is the largest of its facet.
                    mesh.position_error(face),
                    outline,
                ))
                .unwrap_or(NO_FACET)
            })
            .collect();
        for (&number, group) in numbers.iter().zip(&found.groups) {
            if number == NO_FACET {
                continue;
            }
            let start = self.neighbours.len();
            let beside = group.beside.iter().map(|&other| numbers[other as usize]);
            self.neighbours.extend(beside.filter(|&it| it != NO_FACET));
            self.all[number as usize].beside = start..self.neighbours.len();
        }
        found
            .of_face
            .into_iter()
            .map(|group| numbers.get(group as usize).copied().unwrap_or(NO_FACET))
            .collect()
    }

    /// The facet of a shape's face; `None` for shapes that are not flat.
    #[inline]
    pub fn of(&self, shape: u32, face: u32) -> Option<u32> {
        let facet = *self.of_face.get(shape as usize)?.get(face as usize)?;
        (facet != NO_FACET).then_some(facet)
    }

    /// A facet by its number.
    ///
    /// # Panics
    ///
    /// For a number that [`Facets::of`] did not give.
    #[inline]
    pub fn get(&self, facet: u32) -> &Facet {
        &self.all[facet as usize]
    }

    /// Number of facets.
    pub fn len(&self) -> usize {
        self.all.len()
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.all.is_empty()
    }

    /// The corners of a facet, counter-clockwise about the cross product of its axes.
    #[inline]
    pub fn outline(&self, facet: &Facet) -> &[DVec3] {
        &self.corners[facet.outline.clone()]
    }

    /// The facets on the other side of a facet's edges. An edge of three facets or more has none.
    #[inline]
    pub fn beside(&self, facet: u32) -> &[u32] {
        &self.neighbours[self.get(facet).beside.clone()]
    }

    /// The lines of a facet's edges, for light that arrives along `direction`.
    #[inline]
    pub fn edges(&self, facet: &Facet, direction: DVec3) -> impl Iterator<Item = Edge> + '_ {
        let corners = self.outline(facet);
        let is_from_front = facet.is_from_front(direction);
        (0..corners.len()).map(move |index| {
            let [a, b] = [corners[index], corners[(index + 1) % corners.len()]];
            if is_from_front {
                Edge { from: b, to: a }
            } else {
                Edge { from: a, to: b }
            }
        })
    }
}

/// A line in space that parts the rays which pass it on one side from those on the other.
#[derive(Clone, Copy, Debug)]
pub struct Edge {
    from: DVec3,
    to: DVec3,
}

impl Edge {
    /// Six times the signed volume \[m³\] of the edge and a unit of the ray. It is positive if the ray passes
    /// on the side of the facet.
    ///
    /// For rays of one direction it is an affine function of their starts.
    #[inline]
    pub fn side(&self, ray: &Ray) -> f64 {
        let (from, to) = (self.from - ray.origin, self.to - ray.origin);
        ray.direction.dot(from.cross(to))
    }

    /// Rounding error of [`Self::side`] for a ray that has been through a few events.
    #[inline]
    pub fn rounding(&self, ray: &Ray) -> f64 {
        let (from, to) = (self.from - ray.origin, self.to - ray.origin);
        // Three products and their sums, for a ray that is known to some hundred u = 2⁻⁵³.
        512.0 * f64::EPSILON * from.length() * to.length()
    }
}
