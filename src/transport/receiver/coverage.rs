//! The area of a mesh's surface in each texel.

use glam::DVec2;

use super::clip::{ClipGrid, Clipper, TexelPiece};
use super::problem::UvProblem;
use crate::geometry::{Mesh, SurfacePoint};
use crate::scene::Film;

/// Distance \[texels\] within which an image's points are moved onto a texel's border.
///
/// A mesh whose uvs end on a border but for rounding would else leave slivers in the texels beyond. These
/// would be so thin that the rounding of a photon's uv decides if they receive it. With uvs of 2⁻⁵² relative
/// error on a film of 2¹⁶ texels, that rounding is 2⁻³⁶ texels. So it moves 2⁻⁶ of the thinnest strip that
/// stays.
const SNAP: f64 = 1.0 / (1_u64 << 30) as f64;

/// Largest share of a texel's surface on faces whose image is a line or a point. Photons find these faces,
/// but the inverse map that direct light needs does not.
const COLLAPSED_SHARE: f64 = 1e-6;

/// Share of a texel below which its coverage counts as thin; such a texel remembers a point of its surface.
///
/// A search on a grid of points might find none there. (The grid of direct light, 2 x 2 Gauss points in 8 x 8
/// parts, has gaps of 0.072 texels: it finds every strip that is wider.)
const THIN: f64 = 0.125;

/// The surface in each texel of a film's crop.
#[derive(Clone, Debug)]
pub(super) struct Coverage {
    /// Areas row by row; zero if a texel has no surface.
    areas: Vec<f64>,
    /// For each texel hardly covered, a point of its largest piece of surface.
    homes: Vec<(usize, Home)>,
}

/// A point of a mesh.
#[derive(Clone, Copy, Debug, Default)]
struct Home {
    face: u32,
    barycentric: DVec2,
}

/// Sums over the pieces of a texel, while the faces are cut.
#[derive(Clone, Copy, Default)]
struct TexelTally {
    area: f64,
    /// The part of `area` on faces that the uv map collapses.
    collapsed: f64,
    /// The share (0..=1) of the texel that images cover.
    covered: f64,
    largest: f64,
    home: Home,
}

impl Coverage {
    /// Cuts every face's image along the texels' borders.
    ///
    /// # Errors
    ///
    /// If faces that the uv map collapses make up more than a millionth of a texel's surface.
    pub fn new(mesh: &Mesh, uvs: &[DVec2], film: &Film) -> Result<Self, UvProblem> {
        let crop = film.crop;
        let grid = ClipGrid {
            columns: film.width,
            rows: film.height,
        };
        let size = DVec2::new(f64::from(film.width), f64::from(film.height));
        let mut texels = vec![TexelTally::default(); crop.width as usize * crop.height as usize];
        let mut clipper = Clipper::default();
        for (face, triangle) in mesh.triangles().iter().enumerate() {
            let face = face as u32;
            let area = mesh.face_area(face);
            if area == 0.0 {
                continue;
            }
            let image = triangle.map(|vertex| snapped(uvs[vertex as usize] * size));
            let image_area = image_area(image);
            let is_collapsed = is_thin(image, image_area);
            clipper.pieces(grid, image, |piece| {
                let Some(texel) = cropped(film, &piece) else {
                    return;
                };
                let texel = &mut texels[texel];
                let held = area * piece.share;
                texel.area += held;
                texel.covered += image_area * piece.share;
                if is_collapsed {
                    texel.collapsed += held;
                }
                if held > texel.largest {
                    texel.largest = held;
                    texel.home = Home {
                        face,
                        barycentric: piece.centroid,
                    };
                }
            });
        }
        let is_lost = |texel: &TexelTally| texel.collapsed > COLLAPSED_SHARE * texel.area;
        if let Some(index) = texels.iter().position(is_lost) {
            let width = crop.width as usize;
            return Err(UvProblem::Collapsed {
                share: texels[index].collapsed / texels[index].area,
                column: crop.offset_x as usize + index % width,
                row: crop.offset_y as usize + index / width,
            });
        }
        Ok(Self {
            areas: texels.iter().map(|texel| texel.area).collect(),
            homes: texels
                .iter()
                .enumerate()
                .filter(|(_, texel)| texel.area > 0.0 && texel.covered < THIN)
                .map(|(index, texel)| (index, texel.home))
                .collect(),
        })
    }

    /// The surface in a texel \[m²\].
    #[inline]
    pub fn area(&self, texel: usize) -> f64 {
        self.areas[texel]
    }

    /// A point amid the largest piece of surface in a texel that is hardly covered.
    pub fn home(&self, mesh: &Mesh, texel: usize) -> Option<SurfacePoint> {
        let index = self
            .homes
            .binary_search_by_key(&texel, |home| home.0)
            .ok()?;
        let home = self.homes[index].1;
        let normal = mesh.face_normal(home.face);
        Some(mesh.at_barycentric(home.face, home.barycentric, normal))
    }
}

/// The point, moved onto a texel's border if it is there but for rounding.
fn snapped(at: DVec2) -> DVec2 {
    let snap = |x: f64| {
        let border = x.round();
        if (x - border).abs() < SNAP { border } else { x }
    };
    DVec2::new(snap(at.x), snap(at.y))
}

/// Area of an image, in square texels.
fn image_area([a, b, c]: [DVec2; 3]) -> f64 {
    0.5 * (b - a).perp_dot(c - a).abs()
}

/// True if a triangle is so thin that points on a film will not find it.
fn is_thin([a, b, c]: [DVec2; 3], area: f64) -> bool {
    let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
    2.0 * area <= SNAP * longest
}

/// The index of a piece's texel in the crop.
fn cropped(film: &Film, piece: &TexelPiece) -> Option<usize> {
    let crop = film.crop;
    let column = piece.column.checked_sub(crop.offset_x)?;
    let row = piece.row.checked_sub(crop.offset_y)?;
    (column < crop.width && row < crop.height)
        .then(|| row as usize * crop.width as usize + column as usize)
}
