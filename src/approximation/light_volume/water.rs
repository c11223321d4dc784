//! The water's surface as triangles, and the scene's own surface at their points.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use super::grid::JoinedGrid;
use super::settings::Settings;
use super::slicing::{frame, snapped};
use crate::geometry::{Bounds, Frame, Mesh, Ray, Shape, SurfacePoint, TraversalCounters};
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

/// The triangles that settings ask for.
#[derive(Clone, Copy, Debug)]
pub enum Triangles<'a> {
    /// Those of the scene's mesh.
    Own(&'a Mesh),
    /// A grid of so many vertices a row, and rows.
    Grid(u32),
}

impl<'a> Triangles<'a> {
    /// Those of a shape.
    pub fn of(settings: &Settings, shape: &'a Shape) -> Self {
        /// Vertices a row for surfaces that are no meshes: the paper's smallest.
        const DEFAULT: u32 = 120;
        let side = match settings.grid {
            0 => DEFAULT,
            side => side,
        };
        match shape {
            _ if settings.lod > 0.0 => Self::Grid(JoinedGrid::new(settings.buckets, side).side()),
            Shape::Mesh(mesh) if settings.grid == 0 => Self::Own(mesh),
            _ => Self::Grid(side),
        }
    }

    /// The number of their vertices at most: corners of flat facets are vertices of their own.
    pub fn vertices(&self) -> u64 {
        match self {
            Self::Own(mesh) if mesh.has_vertex_normals() => mesh.positions().len() as u64,
            Self::Own(mesh) => 3 * mesh.triangle_count() as u64,
            Self::Grid(side) => u64::from(*side).pow(2),
        }
    }

    /// Their number, as long as the surface fills its rectangle.
    pub fn count(&self) -> u64 {
        match self {
            Self::Own(mesh) => mesh.triangle_count() as u64,
            Self::Grid(side) => 2 * u64::from(side - 1).pow(2),
        }
    }
}

/// What the triangles are made of.
#[derive(Clone, Copy, Debug)]
enum Origin {
    /// The faces of the scene's mesh, by their numbers.
    Mesh,
    /// Samples of the scene's surface along a direction.
    Sampled(Surface),
}

/// A surface of a scene, sampled along its mean normal, whatever is in the way.
#[derive(Clone, Copy, Debug)]
struct Surface {
    shape: u32,
    /// Its normal is the mean normal, snapped.
    frame: Frame,
    /// The least and the largest coordinates across that.
    range: [DVec2; 2],
    /// The height along it from which it is sampled.
    above: f64,
}

impl Surface {
    /// The surface of a shape of a scene.
    fn new(scene: &Scene, shape: u32) -> Self {
        let world = &scene.world().shapes()[shape as usize];
        let (frame, bounds) = (frame(mean_normal(world)), world.bounds());
        let corners = bounds.corners().map(|corner| frame.to_local(corner));
        let local = Bounds::from_points(corners);
        Self {
            shape,
            frame,
            range: [local.min.truncate(), local.max.truncate()],
            above: local.max.z + 1e-3 * bounds.radius(),
        }
    }

    /// The surface at coordinates across the axis; `None` beside it.
    fn at(&self, scene: &Scene, across: DVec2) -> Option<SurfacePoint> {
        /// Places on the border are moved inwards by this share of the extent: rounding would lose some.
        const INWARDS: f64 = 1e-9;
        let [low, high] = self.range;
        let inwards = (high - low) * INWARDS;
        let place = across.clamp(low + inwards, high - inwards);
        let start = self.frame.to_world(place.extend(self.above));
        let ray = Ray::new(start, -self.frame.n);
        let mut counters = TraversalCounters::default();
        let hit = scene.world().hit_on(self.shape, &ray, &mut counters)?;
        Some(scene.world().bounce_point(&ray, &hit))
    }

    /// Coordinates across the axis.
    fn across(&self, place: DVec3) -> DVec2 {
        self.frame.to_local(place).truncate()
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
    /// The triangles of a shape of a scene that settings ask for.
    pub fn new(scene: &Scene, shape: u32, settings: &Settings) -> Self {
        match Triangles::of(settings, &scene.world().shapes()[shape as usize]) {
            Triangles::Own(mesh) => Self::of_mesh(scene, shape, mesh),
            Triangles::Grid(side) => Self::of_grid(scene, shape, side),
        }
    }

    /// The triangles of a mesh. Corners of flat facets are vertices of their own, since their normals differ.
    fn of_mesh(scene: &Scene, shape: u32, mesh: &Mesh) -> Self {
        let (homes, triangles) = homes(mesh);
        let vertices = homes.par_iter().filter_map(|&(face, corner)| {
            let place = [DVec2::ZERO, DVec2::X, DVec2::Y][corner];
            scene.world().face_point(shape, face, place)
        });
        Self {
            shape,
            vertices: vertices.collect(),
            triangles,
            source: Origin::Mesh,
        }
    }

    /// A grid of `side` x `side` vertices on a shape. Cells with a corner beside its surface are left out.
    fn of_grid(scene: &Scene, shape: u32, side: u32) -> Self {
        let surface = Surface::new(scene, shape);
        let [low, high] = surface.range;
        let last = side - 1;
        let sampled: Vec<Option<SurfacePoint>> = (0..side * side)
            .into_par_iter()
            .map(|index| {
                let at = DVec2::new(f64::from(index % side), f64::from(index / side));
                surface.at(scene, low + (high - low) * (at / f64::from(last)))
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
        let mut triangles: Vec<[u32; 3]> = (0..last * last).flat_map(cell).collect();
        triangles.retain(|it| it.iter().all(|&vertex| sampled[vertex as usize].is_some()));
        let mut numbers = Vec::with_capacity(sampled.len());
        let mut vertices = Vec::with_capacity(sampled.len());
        for sample in &sampled {
            numbers.push(vertices.len() as u32);
            vertices.extend(*sample);
        }
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
            source: self.source,
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
                let place = a + (b - a) * weights.x + (c - a) * weights.y;
                surface.at(scene, surface.across(place))
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
