//! The way from (u, v) back to the surface.

use glam::{DVec2, UVec2};

use super::problem::UvProblem;
use crate::geometry::Mesh;

/// Distance by which uvs may leave [0, 1], and faces may overlap: one unit in the sixth digit, as mesh files
/// write them (and 16 roundings of `f32`). Uvs beyond [0, 1] belong to border texels.
const HAIR: f64 = 1e-6;

/// Distance outside a face, in barycentric weights, at which a point still counts as on it, because of
/// rounding.
///
/// It is also the height, in units of u and v, up to which a face is only a line.
const BORDER: f64 = 1e-12;

/// Largest number of references to faces by the grid's cells, for each face. Above it (with long thin faces)
/// the grid is made coarser.
const REFERENCES_A_FACE: usize = 16;

/// A uniform grid over the images of a mesh's faces in the uv plane.
#[derive(Clone, Debug)]
pub(super) struct UvLookup {
    low: DVec2,
    /// Cells per unit of u and v.
    scale: DVec2,
    /// Number of cells in a row, and of rows.
    side: u32,
    /// The index in `faces` at which each cell's faces begin; one more than there are cells.
    starts: Vec<u32>,
    faces: Vec<u32>,
}

/// A point of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct FacePlace {
    pub face: u32,
    /// The weights of the face's second and third vertex.
    pub barycentric: DVec2,
    /// The area of the face's image in the uv plane.
    pub uv_area: f64,
}

/// A face's image.
type FaceImage = [DVec2; 3];

impl UvLookup {
    /// The grid over `mesh`, whose texture coordinates are `uvs`.
    ///
    /// # Errors
    ///
    /// If a (u, v) lies outside [0, 1]² by more than a hair, or on two faces.
    pub fn new(mesh: &Mesh, uvs: &[DVec2]) -> Result<Self, UvProblem> {
        let images: Vec<FaceImage> = mesh
            .triangles()
            .iter()
            .map(|triangle| triangle.map(|vertex| uvs[vertex as usize]))
            .collect();
        for (face, image) in images.iter().enumerate() {
            let is_outside = |uv: &&DVec2| (**uv - 0.5).abs().max_element() > 0.5 + HAIR;
            if let Some(uv) = image.iter().find(is_outside) {
                let (u, v) = (uv.x, uv.y);
                return Err(UvProblem::Outside { face, u, v });
            }
        }
        let lookup = Self::over(&images);
        match lookup.overlap(&images) {
            Some((first, second)) => Err(UvProblem::Overlap { first, second }),
            None => Ok(lookup),
        }
    }

    /// About one cell a face, over the box of all images.
    fn over(images: &[FaceImage]) -> Self {
        let corners = || images.iter().flatten().copied();
        let low = corners().fold(DVec2::INFINITY, DVec2::min);
        let high = corners().fold(DVec2::NEG_INFINITY, DVec2::max);
        let mut grid = Self {
            low,
            scale: DVec2::ZERO,
            side: (images.len() as f64).sqrt().ceil().clamp(1.0, 4096.0) as u32,
            starts: Vec::new(),
            faces: Vec::new(),
        };
        loop {
            // A mesh without extent has one cell for all: 0 times infinity would not be a number.
            let extent = (high - low).max(DVec2::splat(f64::MIN_POSITIVE.sqrt()));
            grid.scale = f64::from(grid.side) / extent;
            let references: usize = images.iter().map(|image| grid.cells(image).count()).sum();
            if grid.side == 1 || references <= REFERENCES_A_FACE * images.len() {
                break;
            }
            grid.side = grid.side.div_ceil(2);
        }
        grid.fill(images);
        grid
    }

    /// Counting sort of the faces by the cells that they reach.
    fn fill(&mut self, images: &[FaceImage]) {
        let cells = self.side as usize * self.side as usize;
        let mut starts = vec![0_u32; cells + 1];
        for image in images {
            for cell in self.cells(image) {
                starts[cell + 1] += 1;
            }
        }
        for cell in 0..cells {
            starts[cell + 1] += starts[cell];
        }
        let mut next = starts.clone();
        self.faces = vec![0; starts[cells] as usize];
        for (face, image) in images.iter().enumerate() {
            for cell in self.cells(image) {
                self.faces[next[cell] as usize] = face as u32;
                next[cell] += 1;
            }
        }
        self.starts = starts;
    }

    fn cell(&self, uv: DVec2) -> UVec2 {
        ((uv - self.low) * self.scale)
            .clamp(DVec2::ZERO, DVec2::splat(f64::from(self.side - 1)))
            .as_uvec2()
    }

    /// The cells that the box of an image reaches; none for an image that is but a line or a point.
    fn cells(&self, image: &FaceImage) -> impl Iterator<Item = usize> + use<> {
        let [a, b, c] = *image;
        let low = self.cell(a.min(b).min(c));
        let high = self.cell(a.max(b).max(c));
        let side = self.side as usize;
        let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
        let is_line = double_area(image).abs() <= BORDER * longest;
        let end = if is_line { low.y } else { high.y + 1 };
        (low.y..end).flat_map(move |row| {
            (low.x..=high.x).map(move |column| row as usize * side + column as usize)
        })
    }

    fn faces_of(&self, cell: usize) -> &[u32] {
        &self.faces[self.starts[cell] as usize..self.starts[cell + 1] as usize]
    }

    /// Two faces whose images overlap by more than a hair.
    fn overlap(&self, images: &[FaceImage]) -> Option<(u32, u32)> {
        (0..self.starts.len() - 1).find_map(|cell| {
            let faces = self.faces_of(cell);
            faces.iter().enumerate().find_map(|(i, &first)| {
                faces[i + 1..]
                    .iter()
                    .find(|&&second| overlap(&images[first as usize], &images[second as usize]))
                    .map(|&second| (first, second))
            })
        })
    }

    /// The point of `mesh` at `uv`; `None` if no face lies there.
    #[inline]
    pub fn find(&self, mesh: &Mesh, uvs: &[DVec2], uv: DVec2) -> Option<FacePlace> {
        let cell = self.cell(uv);
        let cell = cell.y as usize * self.side as usize + cell.x as usize;
        self.faces_of(cell).iter().find_map(|&face| {
            let image = mesh.triangles()[face as usize].map(|vertex| uvs[vertex as usize]);
            let barycentric = barycentric(&image, uv)?;
            Some(FacePlace {
                face,
                barycentric,
                uv_area: 0.5 * double_area(&image).abs(),
            })
        })
    }
}

/// Twice the signed area: positive if the image is counter-clockwise.
fn double_area([a, b, c]: &FaceImage) -> f64 {
    (*b - *a).perp_dot(*c - *a)
}

/// The weights of the second and third corner at `uv`; `None` outside.
fn barycentric(image: &FaceImage, uv: DVec2) -> Option<DVec2> {
    let [a, b, c] = *image;
    let double_area = double_area(image);
    let b1 = (uv - a).perp_dot(c - a) / double_area;
    let b2 = (b - a).perp_dot(uv - a) / double_area;
    let is_inside = b1 >= -BORDER && b2 >= -BORDER && b1 + b2 <= 1.0 + BORDER;
    is_inside.then(|| {
        let b1 = b1.clamp(0.0, 1.0);
        DVec2::new(b1, b2.clamp(0.0, 1.0 - b1))
    })
}

/// True if two triangles overlap by more than a hair: no edge of either separates them. (In the plane edges
/// are enough for the separating-axis theorem.)
fn overlap(one: &FaceImage, other: &FaceImage) -> bool {
    !(separates(one, other) || separates(other, one))
}

/// True if an edge of `image` has all of `other` on its far side, but for a hair.
fn separates(image: &FaceImage, other: &FaceImage) -> bool {
    let inward = double_area(image).signum();
    (0..3).any(|i| {
        let (from, to) = (image[i], image[(i + 1) % 3]);
        let edge = to - from;
        let depth = |corner: &DVec2| inward * edge.perp_dot(*corner - from);
        other.iter().map(depth).fold(f64::NEG_INFINITY, f64::max) <= HAIR * edge.length()
    })
}
