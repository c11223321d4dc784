//! The water's surface as triangles, and the scene's own surface at their points.

use std::sync::Arc;

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::slicing::{frame, snapped};
use crate::geometry::{Bounds, Frame, Mesh, Ray, Shape, SurfacePoint, TraversalCounters, World};
use crate::scene::Scene;

/// The water's surface as triangles.
#[derive(Debug)]
pub struct Water {
    shape: u32,
    /// The scene's surface at each vertex.
    pub vertices: Vec<SurfacePoint>,
    /// Vertices of each triangle.
    pub triangles: Vec<[u32; 3]>,
    source: Origin,
}

/// What the triangles are made of.
#[derive(Clone, Debug)]
enum Origin {
    /// The faces of the scene's mesh, by their numbers.
    Mesh,
    /// Samples of the scene's surface along a direction.
    Sampled(Arc<Surface>),
}

/// The scene's surface by itself, sampled along its mean normal.
#[derive(Debug)]
pub struct Surface {
    world: World,
    /// Its normal is the mean normal, snapped.
    frame: Frame,
    bounds: Bounds,
}

impl Surface {
    /// The surface of a shape of a scene.
    pub fn new(scene: &Scene, shape: u32) -> Self {
        let shape = &scene.world().shapes()[shape as usize];
        let axis = mean_normal(shape);
        Self {
            frame: frame(axis),
            bounds: shape.bounds(),
            world: World::new(vec![shape.clone()]),
        }
    }

    /// Least and largest coordinates across the axis, and the height from which it is sampled.
    fn extent(&self) -> ([DVec2; 2], f64) {
        let corners = self
            .bounds
            .corners()
            .map(|corner| self.frame.to_local(corner));
        let low = corners.iter().fold(DVec3::INFINITY, |low, it| low.min(*it));
        let high = corners
            .iter()
            .fold(DVec3::NEG_INFINITY, |high, it| high.max(*it));
        let above = high.z + 1e-3 * self.bounds.radius();
        ([low.truncate(), high.truncate()], above)
    }

    /// The surface at coordinates across the axis; `None` beside it.
    pub fn at(&self, across: DVec2) -> Option<SurfacePoint> {
        /// Places on the border are moved inwards by this share of the extent: rounding would lose some.
        const INWARDS: f64 = 1e-9;
        let ([low, high], above) = self.extent();
        let inwards = (high - low) * INWARDS;
        let place = across.clamp(low + inwards, high - inwards);
        let ray = Ray::new(self.frame.to_world(place.extend(above)), -self.frame.n);
        let mut counters = TraversalCounters::default();
        let hit = self.world.closest_hit(&ray, f64::INFINITY, &mut counters)?;
        Some(self.world.bounce_point(&ray, &hit))
    }

    /// Coordinates across the axis.
    pub fn across(&self, place: DVec3) -> DVec2 {
        self.frame.to_local(place).truncate()
    }

    /// The least and the largest coordinates across the axis.
    pub fn range(&self) -> [DVec2; 2] {
        self.extent().0
    }
}

/// The mean unit normal of a shape, a coordinate axis if one is near; upwards where there is none.
pub fn mean_normal(shape: &Shape) -> DVec3 {
    let sum = match shape {
        Shape::Mesh(mesh) => (0..mesh.triangle_count() as u32)
            .map(|face| mesh.face_normal(face) * mesh.face_area(face))
            .sum(),
        Shape::Rectangle(rectangle) => rectangle.normal(),
        Shape::Disk(disk) => disk.normal(),
        Shape::Sphere(_) | Shape::Cylinder(_) => DVec3::ZERO,
    };
    snapped(sum.try_normalize().unwrap_or(DVec3::Z))
}

impl Water {
    /// The triangles of a mesh. Corners of flat facets are vertices of their own, since their normals differ.
    ///
    /// `None` if the shape is no mesh.
    pub fn of_mesh(scene: &Scene, shape: u32) -> Option<Self> {
        let Shape::Mesh(mesh) = &scene.world().shapes()[shape as usize] else {
            return None;
        };
        let (homes, triangles) = homes(mesh);
        let vertices = homes.par_iter().map(|&(face, corner)| {
            let place = [DVec2::ZERO, DVec2::X, DVec2::Y][corner];
            scene.world().face_point(shape, face, place)
        });
        Some(Self {
            shape,
            vertices: vertices.collect::<Option<Vec<_>>>()?,
            triangles,
            source: Origin::Mesh,
        })
    }

    /// A grid of `side` x `side` vertices on a surface. Cells with a corner beside the surface are left out.
    pub fn of_grid(surface: Arc<Surface>, shape: u32, side: u32) -> Self {
        let [low, high] = surface.range();
        let last = side - 1;
        let sampled: Vec<Option<SurfacePoint>> = (0..side * side)
            .into_par_iter()
            .map(|index| {
                let at = DVec2::new(f64::from(index % side), f64::from(index / side));
                surface.at(low + (high - low) * (at / f64::from(last)))
            })
            .collect();
        let cell = |index: u32| {
            let (column, row) = (index % last, index / last);
            let corner = row * side + column;
            [
                [corner, corner + 1, corner + side + 1],
                [corner, corner + side + 1, corner + side],
            ]
        };
        let triangles = (0..last * last).flat_map(cell).collect();
        Self::of_samples(surface, shape, &sampled, triangles)
    }

    /// Triangles between samples of a surface; those with a corner beside it are left out.
    pub fn of_samples(
        surface: Arc<Surface>,
        shape: u32,
        sampled: &[Option<SurfacePoint>],
        mut triangles: Vec<[u32; 3]>,
    ) -> Self {
        let mut numbers = Vec::with_capacity(sampled.len());
        let mut vertices = Vec::with_capacity(sampled.len());
        for sample in sampled {
            numbers.push(vertices.len() as u32);
            vertices.extend(*sample);
        }
        triangles.retain(|it| it.iter().all(|&vertex| sampled[vertex as usize].is_some()));
        for triangle in &mut triangles {
            *triangle = triangle.map(|vertex| numbers[vertex as usize]);
        }
        Self {
            shape,
            vertices,
            triangles,
            source: Origin::Sampled(surface),
        }
    }

    /// Other triangles between the same vertices, of a sampled surface.
    #[must_use]
    pub fn with_triangles(&self, triangles: Vec<[u32; 3]>) -> Self {
        Self {
            shape: self.shape,
            vertices: self.vertices.clone(),
            triangles,
            source: self.source.clone(),
        }
    }

    /// The shape of the scene.
    pub fn shape(&self) -> u32 {
        self.shape
    }

    /// The corners of a triangle.
    #[inline]
    pub fn corners(&self, triangle: u32) -> [DVec3; 3] {
        self.triangles[triangle as usize].map(|vertex| self.vertices[vertex as usize].position)
    }

    /// The scene's own surface over a place of a triangle, given by barycentric weights of its second and
    /// third vertex; `None` beside it.
    #[inline]
    pub fn place(&self, scene: &Scene, triangle: u32, weights: DVec2) -> Option<SurfacePoint> {
        match &self.source {
            Origin::Mesh => scene.world().face_point(self.shape, triangle, weights),
            Origin::Sampled(surface) => {
                let [a, b, c] = self.corners(triangle);
                surface.at(surface.across(a + (b - a) * weights.x + (c - a) * weights.y))
            }
        }
    }
}

/// For each vertex a face and its corner there, and the vertices of each face.
fn homes(mesh: &Mesh) -> (Vec<(u32, usize)>, Vec<[u32; 3]>) {
    let faces = mesh.triangles();
    if !mesh.has_vertex_normals() {
        let homes = (0..3 * faces.len()).map(|index| ((index / 3) as u32, index % 3));
        let triangles = (0..faces.len() as u32).map(|face| [3 * face, 3 * face + 1, 3 * face + 2]);
        return (homes.collect(), triangles.collect());
    }
    let mut homes = vec![None; mesh.positions().len()];
    for (face, triangle) in (0_u32..).zip(faces) {
        for (corner, &vertex) in triangle.iter().enumerate() {
            homes[vertex as usize].get_or_insert((face, corner));
        }
    }
    // Vertices of no face have no place, and no beam.
    let mut numbers = vec![0; homes.len()];
    let mut kept = Vec::with_capacity(homes.len());
    for (number, home) in numbers.iter_mut().zip(homes) {
        *number = kept.len() as u32;
        kept.extend(home);
    }
    let triangles = faces
        .iter()
        .map(|face| face.map(|vertex| numbers[vertex as usize]));
    (kept, triangles.collect())
}
