//! The grid of texels over a surface.

use glam::{DVec2, DVec3};

use super::coverage::Coverage;
use super::lookup::UvLookup;
use super::problem::{ReceiverError, UvProblem};
use crate::geometry::{Mesh, Shape, SurfacePoint};
use crate::numeric::math;
use crate::scene::{Crop, Film, Scene, Sensor, SensorKind};

/// An irradiance meter: a grid of texels over the (u, v) of a shape's front side.
///
/// Texel (column, row) of the full film covers u in [column, column + 1) / width and v in [row, row + 1) /
/// height. Row 0 is at v = 0, as in Mitsuba's images of an `irradiancemeter`. Only the cropped part is
/// measured. u = 1 and v = 1 belong to the last texel.
///
/// On a mesh, texels lie over the mesh's own uvs, which must be within [0, 1] and on one face each. (A meter
/// of several texels on a mesh has no such layout in Mitsuba 3.9.1: its rows go through the faces in the
/// file's order. With one texel, both measure the same.) Irradiance is flux by *surface* area, so a texel
/// that the mesh covers in part has the average over that part.
#[derive(Clone, Debug)]
pub struct Receiver {
    shape: u32,
    full: DVec2,
    crop: Crop,
    area: TexelArea,
}

/// The area of a texel, by the coordinates that it depends on.
#[derive(Clone, Debug)]
enum TexelArea {
    /// The same for all texels (rectangle, cylinder).
    Uniform(f64),
    /// One area a column: rings of a disc, where u is the radius.
    Column(Vec<f64>),
    /// One area a row: belts of a sphere, where v runs from pole to pole.
    Row(Vec<f64>),
    /// One area a texel of a mesh.
    Mesh(Box<MeshTexels>),
}

/// Areas of a mesh's texels, and the way back to the mesh.
#[derive(Clone, Debug)]
struct MeshTexels {
    coverage: Coverage,
    lookup: UvLookup,
}

/// A point of a receiver, and the density of surface around it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReceiverPatch {
    /// The surface.
    pub point: SurfacePoint,
    /// The triangle of a mesh; 0 for analytic shapes.
    pub face: u32,
    /// Surface area per fraction of a texel \[m²\]: its average over a texel is the texel's area.
    pub density: f64,
}

impl ReceiverPatch {
    /// Largest relative difference by rounding between equal normals or densities.
    ///
    /// Both come from differences of coordinates. Let faces be 1e-3 as long as their distance from the
    /// origin, with coordinates from `f32` files (6e-8): then both keep four digits.
    const SAME: f64 = 1e-4;

    /// True if this and `other` are one smooth surface: on one face, or on faces that lie and stretch alike.
    #[inline]
    pub fn continues(&self, other: &Self) -> bool {
        self.face == other.face || {
            let (a, b) = (self.point.geometric_normal, other.point.geometric_normal);
            a.abs_diff_eq(b, Self::SAME)
                && (self.density - other.density).abs() <= Self::SAME * self.density
        }
    }
}

impl MeshTexels {
    fn new(mesh: &Mesh, film: &Film) -> Result<Self, UvProblem> {
        let uvs = mesh.uvs().ok_or(UvProblem::Missing)?;
        let lookup = UvLookup::new(mesh, uvs)?;
        let coverage = Coverage::new(mesh, uvs, film)?;
        Ok(Self { coverage, lookup })
    }

    /// The patch at `uv`; `None` if no face lies there. Its density is by share of the uv square, not yet of
    /// a texel.
    fn at_uv(&self, mesh: &Mesh, uv: DVec2) -> Option<ReceiverPatch> {
        let place = self.lookup.find(mesh, mesh.uvs()?, uv)?;
        let normal = mesh.face_normal(place.face);
        Some(ReceiverPatch {
            point: mesh.at_barycentric(place.face, place.barycentric, normal),
            face: place.face,
            density: mesh.face_area(place.face) / place.uv_area,
        })
    }
}

impl Receiver {
    /// The receiver that a sensor describes.
    ///
    /// # Errors
    ///
    /// For a camera, for a meter on a mesh without (u, v), and for a mesh whose (u, v) leave [0, 1]², overlap
    /// or collapse.
    pub fn new(scene: &Scene, sensor: &Sensor) -> Result<Self, ReceiverError> {
        let SensorKind::IrradianceMeter { shape } = sensor.kind else {
            return Err(ReceiverError::NotAMeter {
                id: sensor.id.clone(),
                plugin: sensor.plugin(),
            });
        };
        let film = &sensor.film;
        let (columns, rows) = (f64::from(film.width), f64::from(film.height));
        let belt = |i: u32, n: f64| (f64::from(i) / n, f64::from(i + 1) / n);
        let area = match &scene.world().shapes()[shape.0 as usize] {
            Shape::Rectangle(rectangle) => TexelArea::Uniform(rectangle.area() / (columns * rows)),
            Shape::Cylinder(cylinder) => TexelArea::Uniform(cylinder.area() / (columns * rows)),
            Shape::Disk(disk) => TexelArea::Column(
                (0..film.width)
                    .map(|column| {
                        let (from, to) = belt(column, columns);
                        disk.area() * (to - from) * (to + from) / rows
                    })
                    .collect(),
            ),
            Shape::Sphere(sphere) => TexelArea::Row(
                (0..film.height)
                    .map(|row| {
                        let (from, to) = belt(row, rows);
                        // cos a − cos b = 2 sin((a+b)/2) sin((b−a)/2), without cancellation.
                        let half = std::f64::consts::FRAC_PI_2;
                        let belt = math::sin(half * (from + to)) * math::sin(half * (to - from));
                        sphere.area() * belt / columns
                    })
                    .collect(),
            ),
            Shape::Mesh(mesh) => {
                let object = &scene.objects()[shape.0 as usize];
                let texels =
                    MeshTexels::new(mesh, film).map_err(|problem| ReceiverError::Mesh {
                        id: sensor.id.clone(),
                        shape: object.id.clone(),
                        plugin: object.plugin,
                        problem,
                    })?;
                TexelArea::Mesh(Box::new(texels))
            }
        };
        Ok(Self {
            shape: shape.0,
            full: DVec2::new(columns, rows),
            crop: film.crop,
            area,
        })
    }

    /// The shape that receives.
    #[inline]
    pub fn shape(&self) -> u32 {
        self.shape
    }

    /// Number of texels in a row.
    #[inline]
    pub fn width(&self) -> usize {
        self.crop.width as usize
    }

    /// Number of rows.
    #[inline]
    pub fn height(&self) -> usize {
        self.crop.height as usize
    }

    /// Number of texels.
    pub fn texels(&self) -> usize {
        self.width() * self.height()
    }

    /// The texel, counted row by row, into which light travelling along `direction` falls at `point`.
    ///
    /// `None` if the light arrives from behind or falls outside the crop. Also `None` if, by rounding, it
    /// falls into a texel that a mesh reaches with its border only.
    #[inline]
    pub fn texel(&self, point: &SurfacePoint, direction: DVec3) -> Option<usize> {
        if direction.dot(point.geometric_normal) >= 0.0 {
            return None;
        }
        let place = |along: f64, size: f64, offset: u32, kept: u32| {
            // Rounding may put a point a hair outside [0, 1]: it belongs to the border texel.
            let index = (along * size).clamp(0.0, size - 1.0) as u32;
            index.checked_sub(offset).filter(|index| *index < kept)
        };
        let column = place(point.uv.x, self.full.x, self.crop.offset_x, self.crop.width)?;
        let row = place(
            point.uv.y,
            self.full.y,
            self.crop.offset_y,
            self.crop.height,
        )?;
        let texel = row as usize * self.width() + column as usize;
        self.has_surface(texel).then_some(texel)
    }

    /// The film point at which light travelling along `direction` falls at `point`, in texels from the
    /// cropped film's corner, beyond its border too. `None` if it arrives from behind.
    #[inline]
    pub fn place(&self, point: &SurfacePoint, direction: DVec3) -> Option<DVec2> {
        (direction.dot(point.geometric_normal) < 0.0).then(|| self.film_place(point.uv))
    }

    /// Surface parameters in texels from the cropped film's corner.
    #[inline]
    pub fn film_place(&self, uv: DVec2) -> DVec2 {
        uv * self.full - DVec2::new(f64::from(self.crop.offset_x), f64::from(self.crop.offset_y))
    }

    /// True if any surface lies in a texel.
    #[inline]
    pub fn has_surface(&self, texel: usize) -> bool {
        match &self.area {
            TexelArea::Mesh(texels) => texels.coverage.area(texel) > 0.0,
            _ => true,
        }
    }

    /// The area of the surface in a texel \[m²\]; zero if a mesh does not reach.
    pub fn texel_area(&self, texel: usize) -> f64 {
        match &self.area {
            TexelArea::Uniform(area) => *area,
            TexelArea::Column(areas) => areas[texel % self.width() + self.crop.offset_x as usize],
            TexelArea::Row(areas) => areas[texel / self.width() + self.crop.offset_y as usize],
            TexelArea::Mesh(texels) => texels.coverage.area(texel),
        }
    }

    /// The surface at fractions `at` (in 0..=1) across a texel; `None` if a mesh has none.
    ///
    /// # Panics
    ///
    /// For a scene other than the one the receiver was made for.
    #[inline]
    pub fn point(&self, scene: &Scene, texel: usize, at: DVec2) -> Option<SurfacePoint> {
        self.patch(scene, texel, at).map(|patch| patch.point)
    }

    /// [`point`](Self::point), with the density of surface there.
    ///
    /// # Panics
    ///
    /// For a scene other than the one the receiver was made for.
    #[inline]
    pub fn patch(&self, scene: &Scene, texel: usize, at: DVec2) -> Option<ReceiverPatch> {
        let shape = &scene.world().shapes()[self.shape as usize];
        let uv = self.uv(texel, at);
        let whole = self.full.x * self.full.y;
        if let (Shape::Mesh(mesh), TexelArea::Mesh(texels)) = (shape, &self.area) {
            let mut patch = texels.at_uv(mesh, uv)?;
            patch.density /= whole;
            return Some(patch);
        }
        let point = shape.at_uv(uv)?;
        let density = match (&self.area, shape) {
            (TexelArea::Uniform(area), _) => *area,
            // dA = r dr dφ, and r = u R.
            (_, Shape::Disk(disk)) => disk.area() * 2.0 * uv.x / whole,
            // dA = R² sin θ dθ dφ, and θ = π v.
            (_, sphere) => {
                let angle = std::f64::consts::PI * uv.y;
                sphere.area() * std::f64::consts::FRAC_PI_2 * math::sin(angle) / whole
            }
        };
        Some(ReceiverPatch {
            point,
            face: 0,
            density,
        })
    }

    /// A point of the surface in a texel of which a mesh covers so little that a search by
    /// [`point`](Self::point) may miss it. `None` if the mesh covers enough, or nothing.
    pub fn home(&self, scene: &Scene, texel: usize) -> Option<SurfacePoint> {
        match (&scene.world().shapes()[self.shape as usize], &self.area) {
            (Shape::Mesh(mesh), TexelArea::Mesh(texels)) => texels.coverage.home(mesh, texel),
            _ => None,
        }
    }

    /// The point nearest to `at`, in fractions across a texel or a little beyond it, at which there is
    /// surface.
    pub fn clamped(&self, texel: usize, at: DVec2) -> DVec2 {
        let corner = self.uv(texel, DVec2::ZERO) * self.full;
        at.clamp(-corner, self.full - corner)
    }

    /// The (u, v) at fractions `at` (in 0..=1) across a texel.
    #[inline]
    pub fn uv(&self, texel: usize, at: DVec2) -> DVec2 {
        let column = texel % self.width() + self.crop.offset_x as usize;
        let row = texel / self.width() + self.crop.offset_y as usize;
        (DVec2::new(column as f64, row as f64) + at) / self.full
    }
}
