//! Surfaces that shine by a texture: places on them, in proportion to how bright they are.
//!
//! A parallelogram or a triangle is divided into pieces of the same shape and area. The flux of each is exact
//! (`pattern.rs`), and a piece is chosen in proportion to it. Within a piece places are uniform, and the
//! value there by the piece's mean is a factor on the light. On discs and balls places are uniform.

use glam::{DVec2, DVec3};

use super::patch::ChartPatch;
use super::pattern::Pattern;
use super::surface::{ACROSS, Area, LightPart, LightSurface, surface_point};
use crate::geometry::SurfacePoint;
use crate::numeric::WeightedChoice;
use crate::radiometry::Rgb;
use crate::scene::{Scene, ShapeId, TextureId};

/// Most pieces along a side of a part.
const MOST_ACROSS: f64 = 64.0;

/// A part of a surface with a texture.
#[derive(Clone, Debug)]
pub struct TexturedPart {
    part: LightPart,
    pattern: Pattern,
    pieces: Option<Pieces>,
    /// Mean of the texture over the part; of a disc or a ball, its largest value.
    mean: Rgb,
}

/// Pieces of a part, alike but for their light.
#[derive(Clone, Debug)]
struct Pieces {
    /// A corner of each and the two edges from it, in coordinates of the part.
    corners: Vec<[DVec2; 3]>,
    choice: WeightedChoice,
}

impl TexturedPart {
    /// A part of a shape, counted by [`LightSurface::numbered`]; `None` if all of it is black.
    pub fn new(
        scene: &Scene,
        shape: ShapeId,
        texture: TextureId,
        (number, part): (u32, &LightPart),
    ) -> Option<Self> {
        let shape = &scene.world().shapes()[shape.0 as usize];
        let pattern = Pattern::new(scene, texture, shape, number, ACROSS);
        let mut one = Self {
            part: *part,
            mean: pattern.peak(),
            pattern,
            pieces: None,
        };
        if let (None, LightPart::Flat(area, _)) = (one.pattern.even(), part)
            && let Some((pieces, mean)) = Pieces::new(area, &one.pattern)
        {
            one.mean = mean;
            one.pieces = pieces;
        }
        (!one.mean.is_black()).then_some(one)
    }

    /// The value of the texture, if it is the same all over the part.
    pub fn even(&self) -> Option<Rgb> {
        self.pattern.even()
    }

    /// Mean of the texture over a parallelogram or a triangle; a bound of it on a disc or a ball.
    pub fn mean(&self) -> Rgb {
        self.mean
    }

    /// The value where a ball's unit normal is `normal`.
    #[inline]
    pub fn value_along(&self, normal: DVec3) -> Rgb {
        self.pattern.value_along(normal)
    }

    /// A point, and the texture there by the density of points, as a multiple of a uniform one. The mean of
    /// that over `at` in [0, 1)² is the mean of the texture.
    #[inline]
    pub fn sample(&self, at: DVec2) -> (SurfacePoint, Rgb) {
        let LightPart::Flat(area, normal) = &self.part else {
            let point = self.part.sample(at);
            let value = self.pattern.value_along(point.geometric_normal);
            return (point, value);
        };
        let Some(pieces) = &self.pieces else {
            return (self.part.sample(at), self.pattern.value(area.place(at)));
        };
        let chosen = pieces.choice.choose(at.x);
        let [corner, s, t] = pieces.corners[chosen.index];
        let within = area.place(DVec2::new(chosen.rest, at.y));
        let place = corner + s * within.x + t * within.y;
        let density = pieces.choice.probability(chosen.index) * pieces.corners.len() as f64;
        let (origin, [x, y]) = area.axes();
        let point = surface_point(origin + x * place.x + y * place.y, *normal);
        (point, self.pattern.value(place) / density)
    }
}

impl Pieces {
    /// The pieces of a flat part and the mean of its texture; no pieces if it is black. `None` if the
    /// integrals are not known.
    fn new(area: &Area, pattern: &Pattern) -> Option<(Option<Self>, Rgb)> {
        let is_triangle = match area {
            Area::Parallelogram { .. } => false,
            Area::Triangle(_) => true,
            Area::Disk { .. } => return None,
        };
        let (from, to) = area.extent();
        let wanted = pattern.pieces_across(&ChartPatch { from, to });
        let across = wanted.ceil().clamp(1.0, MOST_ACROSS) as u32;
        let size = 1.0 / f64::from(across);
        let mut corners = Vec::new();
        for (row, column) in (0..across).flat_map(|row| (0..across).map(move |it| (row, it))) {
            let corner = DVec2::new(f64::from(column), f64::from(row)) * size;
            let (x, y) = (DVec2::X * size, DVec2::Y * size);
            if !is_triangle || row + column < across {
                corners.push([corner, x, y]);
            }
            if is_triangle && row + column + 1 < across {
                corners.push([corner + x + y, -x, -y]);
            }
        }
        let mut sum = Rgb::BLACK;
        let mut weights = Vec::with_capacity(corners.len());
        for [corner, x, y] in &corners {
            let outline = [*corner, *corner + *x, *corner + *x + *y, *corner + *y];
            let triangle = [outline[0], outline[1], outline[3]];
            let integral = pattern.integral(if is_triangle { &triangle } else { &outline })?;
            weights.push(integral.mean());
            sum += integral;
        }
        let mean = sum * if is_triangle { 2.0 } else { 1.0 };
        let choice = WeightedChoice::new(weights);
        Some((choice.map(|choice| Self { corners, choice }), mean))
    }
}

/// A whole surface with a texture.
#[derive(Clone, Debug)]
pub struct TexturedSurface {
    parts: Vec<TexturedPart>,
    choice: WeightedChoice,
    /// True if no part is black.
    is_whole: bool,
}

impl TexturedSurface {
    /// The surface of a shape; `None` if all of it is black.
    pub fn new(
        scene: &Scene,
        shape: ShapeId,
        texture: TextureId,
        surface: &LightSurface,
    ) -> Option<Self> {
        let parts: Vec<TexturedPart> = surface
            .numbered()
            .filter_map(|numbered| TexturedPart::new(scene, shape, texture, numbered))
            .collect();
        let flux = |part: &TexturedPart| part.mean.mean() * part.part.area();
        let choice = WeightedChoice::new(parts.iter().map(flux))?;
        Some(Self {
            is_whole: parts.len() == surface.parts().len(),
            parts,
            choice,
        })
    }

    /// The value of the texture, if it is the same everywhere.
    pub fn even(&self) -> Option<Rgb> {
        let first = self.parts.first()?.even()?;
        let is_first = |part: &TexturedPart| part.even() == Some(first);
        (self.is_whole && self.parts.iter().all(is_first)).then_some(first)
    }

    /// A point, and the texture there by the density of points [1/m²]. The mean of that over `at` in [0, 1)²
    /// is ∫ texture dA [m²].
    pub fn sample(&self, at: DVec2) -> (SurfacePoint, Rgb) {
        let chosen = self.choice.choose(at.x);
        let part = &self.parts[chosen.index];
        let (point, value) = part.sample(DVec2::new(chosen.rest, at.y));
        let size = part.part.area() / self.choice.probability(chosen.index);
        (point, value * size)
    }
}
