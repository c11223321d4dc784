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

/// Pieces of all parts of a lamp together, if they are many; each has at least 8 x 8.
const MOST_PIECES: f64 = 65536.0;

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
    across: u32,
    is_triangle: bool,
    choice: WeightedChoice,
    /// ∫ texture over each, in the area of coordinates.
    integrals: Vec<Rgb>,
}

impl TexturedPart {
    /// The parts of a shape's surface that are not black.
    pub fn all(
        scene: &Scene,
        shape: ShapeId,
        texture: TextureId,
        surface: &LightSurface,
    ) -> Vec<Self> {
        let shape = &scene.world().shapes()[shape.0 as usize];
        let numbers = surface.numbered().map(|(number, _)| number);
        let patterns = Pattern::all(scene, texture, shape, numbers, ACROSS);
        let count = patterns.len() as f64;
        let most_across = (MOST_PIECES / count).sqrt().clamp(8.0, MOST_ACROSS);
        let parts = patterns.into_iter().zip(surface.parts());
        let parts = parts.map(|(pattern, part)| Self::new(*part, pattern, most_across));
        parts.filter(|part| !part.mean.is_black()).collect()
    }

    fn new(part: LightPart, pattern: Pattern, most_across: f64) -> Self {
        let mut one = Self {
            part,
            mean: pattern.peak(),
            pattern,
            pieces: None,
        };
        if let (None, LightPart::Flat(area, _)) = (one.pattern.even(), part)
            && let Some((pieces, mean)) = Pieces::new(&area, &one.pattern, most_across)
        {
            one.mean = mean;
            one.pieces = pieces;
        }
        one
    }

    /// The part of a surface that it is.
    pub fn light(&self) -> LightPart {
        self.part
    }

    /// For each piece, the largest value by the density of points, and its part of the mean.
    fn largest(&self) -> Vec<[Rgb; 2]> {
        let (Some(pieces), LightPart::Flat(area, _)) = (&self.pieces, &self.part) else {
            return vec![[self.pattern.peak(), self.mean]];
        };
        let scale = match area {
            Area::Triangle(_) => 2.0,
            Area::Parallelogram { .. } | Area::Disk { .. } => 1.0,
        };
        let of_piece = |index: usize| {
            let [corner, x, y] = pieces.corner(index);
            let other = corner + x + y;
            let patch = ChartPatch {
                from: corner.min(other),
                to: corner.max(other),
            };
            let density = pieces.choice.probability(index) * pieces.count() as f64;
            let value = self.pattern.peak_in(&patch) / density;
            [value, pieces.integrals[index] * scale]
        };
        let chosen = (0..pieces.count()).filter(|index| pieces.choice.probability(*index) > 0.0);
        chosen.map(of_piece).collect()
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
        let [corner, s, t] = pieces.corner(chosen.index);
        let within = area.place(DVec2::new(chosen.rest, at.y));
        let place = corner + s * within.x + t * within.y;
        let density = pieces.choice.probability(chosen.index) * pieces.count() as f64;
        let (origin, [x, y]) = area.axes();
        let point = surface_point(origin + x * place.x + y * place.y, *normal);
        (point, self.pattern.value(place) / density)
    }
}

impl Pieces {
    /// The pieces of a flat part and the mean of its texture; no pieces if it is black. `None` if the
    /// integrals are not known.
    fn new(area: &Area, pattern: &Pattern, most_across: f64) -> Option<(Option<Self>, Rgb)> {
        let is_triangle = match area {
            Area::Parallelogram { .. } => false,
            Area::Triangle(_) => true,
            Area::Disk { .. } => return None,
        };
        let (from, to) = area.extent();
        let wanted = pattern.pieces_across(&ChartPatch { from, to });
        let across = wanted.ceil().clamp(1.0, most_across) as u32;
        let count = (across * across) as usize;
        let mut sum = Rgb::BLACK;
        let mut weights = Vec::with_capacity(count);
        let mut integrals = Vec::with_capacity(count);
        for index in 0..count {
            let [corner, x, y] = corner(across, is_triangle, index);
            let outline = [corner, corner + x, corner + x + y, corner + y];
            let triangle = [outline[0], outline[1], outline[3]];
            let integral = pattern.integral(if is_triangle { &triangle } else { &outline })?;
            weights.push(integral.mean());
            integrals.push(integral);
            sum += integral;
        }
        let mean = sum * if is_triangle { 2.0 } else { 1.0 };
        let choice = WeightedChoice::new(weights);
        let pieces = choice.map(|choice| Self {
            across,
            is_triangle,
            choice,
            integrals,
        });
        Some((pieces, mean))
    }

    fn count(&self) -> usize {
        (self.across * self.across) as usize
    }

    fn corner(&self, index: usize) -> [DVec2; 3] {
        corner(self.across, self.is_triangle, index)
    }
}

/// A corner of a piece and the two edges from it, in coordinates of the part.
///
/// Pieces of a parallelogram are counted row by row. Row s of a triangle, from its tip, has 2 s + 1 pieces,
/// and s² are before it.
fn corner(across: u32, is_triangle: bool, index: usize) -> [DVec2; 3] {
    let size = 1.0 / f64::from(across);
    let (x, y) = (DVec2::X * size, DVec2::Y * size);
    let index = index as u32;
    if !is_triangle {
        let place = DVec2::new(f64::from(index % across), f64::from(index / across));
        return [place * size, x, y];
    }
    let from_tip = index.isqrt();
    let within = index - from_tip * from_tip;
    let (column, row) = (within / 2, across - 1 - from_tip);
    let place = DVec2::new(f64::from(column), f64::from(row)) * size;
    if within.is_multiple_of(2) {
        [place, x, y]
    } else {
        [place + x + y, -x, -y]
    }
}

/// A whole surface with a texture.
#[derive(Clone, Debug)]
pub struct TexturedSurface {
    parts: Vec<TexturedPart>,
    choice: WeightedChoice,
    /// True if no part is black.
    is_whole: bool,
    /// Of each piece: the largest texture by density of points [m²], and ∫ texture dA [m²].
    pieces: Vec<[Rgb; 2]>,
}

impl TexturedSurface {
    /// The surface of a shape; `None` if all of it is black.
    pub fn new(
        scene: &Scene,
        shape: ShapeId,
        texture: TextureId,
        surface: &LightSurface,
    ) -> Option<Self> {
        let parts = TexturedPart::all(scene, shape, texture, surface);
        let flux = |part: &TexturedPart| part.mean.mean() * part.part.area();
        let choice = WeightedChoice::new(parts.iter().map(flux))?;
        let pieces_of = |(number, part): (usize, &TexturedPart)| {
            let size = part.part.area();
            let largest = part.largest().into_iter();
            let probability = choice.probability(number);
            let of_piece = |[value, mean]: [Rgb; 2]| [value * (size / probability), mean * size];
            largest.map(of_piece).collect::<Vec<_>>()
        };
        Some(Self {
            pieces: parts.iter().enumerate().flat_map(pieces_of).collect(),
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

    /// The most light that a share of points may have, above what points have on average:
    /// ∫ texture dA [m²].
    ///
    /// A bright place in a dark piece has few points. If none of them is there, they do not tell. The pieces
    /// with the largest values come first, each with no more points than make up its light.
    pub fn unseen(&self, share: f64) -> Rgb {
        let mut average = Rgb::BLACK;
        for part in &self.parts {
            // Else the mean is a bound, and the average may be next to nothing.
            if part.pieces.is_some() || part.even().is_some() {
                average += part.mean * part.part.area();
            }
        }
        let of_channel = |c: usize| {
            let all = self.pieces.iter();
            let brighter = all.map(|[largest, flux]| (largest.0[c], flux.0[c]));
            let mut brighter: Vec<(f64, f64)> = brighter
                .filter(|(largest, _)| *largest > average.0[c])
                .collect();
            brighter.sort_by(|a, b| b.0.total_cmp(&a.0));
            let (mut left, mut sum) = (share, 0.0);
            for (largest, flux) in brighter {
                let points = left.min(flux / largest);
                sum += points * (largest - average.0[c]);
                left -= points;
            }
            sum
        };
        Rgb(std::array::from_fn(of_channel))
    }
}
