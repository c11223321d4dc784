//! Textures over parts of a surface that shines: values, and exact integrals on flat parts.
//!
//! Places on a flat part are coordinates along its two edges or half axes (`surface.rs`). Surface parameters
//! of parallelograms and triangles are affine in them. So the lines between texels, or between their centers,
//! cut such a part into polygons. In each the texture is one polynomial: constant, or bilinear. A bilinear
//! one has degree 2, and the middles of a triangle's edges integrate it exactly (Hammer and Stroud 1956).

use glam::{DAffine2, DMat2, DMat3, DVec2, DVec3};

use super::patch::ChartPatch;
use super::polygon::{area, cut, fan};
use crate::geometry::{Disk, Mesh, Shape, Sphere};
use crate::radiometry::Rgb;
use crate::scene::{BitmapTexture, Color, Scene, Texture, TextureFilter, TextureId};

/// Most pieces into which a lamp is cut for its integrals: 2048 x 2048 texels, some tenths of a second.
const MAX_PIECES: f64 = 4.2e6;

/// Most texels that are looked at for a bound of a patch.
const MAX_TEXELS: f64 = 5000.0;

/// The values of a texture over a part of a surface.
#[derive(Clone, Debug)]
pub struct Pattern {
    values: PatternValues,
    map: PatternMap,
    /// True if integrals are known: the lamp has few enough pieces, and its parameters are affine in places.
    is_exact: bool,
}

/// A texture with all that it refers to.
#[derive(Clone, Debug)]
enum PatternValues {
    /// One value.
    Even(Rgb),
    /// An image.
    Bitmap(BitmapTexture),
    /// A checkerboard.
    Squares(Box<[PatternValues; 2]>, DMat3),
    /// Linear between the corners of a triangle.
    Corners([Rgb; 3]),
    /// Times a factor.
    Scaled(Box<PatternValues>, Rgb),
}

/// From places on a part to surface parameters.
#[derive(Clone, Debug)]
enum PatternMap {
    /// Of a parallelogram or a triangle.
    Affine(DAffine2),
    /// Of a disc: its radius, and the angle by a full turn.
    Polar,
    /// Of a ball, by the normal.
    Ball(Box<Sphere>),
}

impl Pattern {
    /// A texture over all parts of a shape, by their numbers (see [`new`](Self::new)). If they have too many
    /// pieces together, no part has integrals.
    pub fn all(
        scene: &Scene,
        texture: TextureId,
        shape: &Shape,
        numbers: impl Iterator<Item = u32>,
        across: u32,
    ) -> Vec<Self> {
        let new = |number| Self::new(scene, texture, shape, number, across);
        let mut all: Vec<Self> = numbers.map(new).collect();
        let pieces: f64 = all.iter().map(Self::pieces).sum();
        // NaN is too many, too.
        if pieces.is_nan() || pieces > MAX_PIECES {
            for pattern in &mut all {
                pattern.is_exact = false;
            }
        }
        all
    }

    /// A texture over a part of a shape: `number` counts the parts of a rectangle, `across` a side, and the
    /// faces of a mesh.
    fn new(scene: &Scene, texture: TextureId, shape: &Shape, number: u32, across: u32) -> Self {
        let (map, mesh) = match shape {
            Shape::Mesh(mesh) => {
                let corner = |at: DVec2| mesh.at_barycentric(number, at, DVec3::Z).uv;
                let from = corner(DVec2::ZERO);
                let axes = [corner(DVec2::X) - from, corner(DVec2::Y) - from];
                let map = DAffine2::from_cols(axes[0], axes[1], from);
                (PatternMap::Affine(map), Some((mesh, number)))
            }
            Shape::Disk(_) => (PatternMap::Polar, None),
            Shape::Sphere(sphere) => (PatternMap::Ball(Box::new(sphere.clone())), None),
            Shape::Rectangle(_) | Shape::Cylinder(_) => {
                let size = 1.0 / f64::from(across);
                let from = DVec2::new(f64::from(number % across), f64::from(number / across));
                let map = DAffine2::from_cols(DVec2::X * size, DVec2::Y * size, from * size);
                (PatternMap::Affine(map), None)
            }
        };
        Self {
            values: PatternValues::new(scene, texture, mesh),
            is_exact: matches!(map, PatternMap::Affine(_)),
            map,
        }
    }

    /// A bound of the pieces of one polynomial on all of the part.
    fn pieces(&self) -> f64 {
        match &self.map {
            PatternMap::Affine(map) => self.values.pieces(around(&map.matrix2, DVec2::ONE)),
            PatternMap::Polar | PatternMap::Ball(_) => 0.0,
        }
    }

    /// The value of a texture that has one only.
    pub fn even(&self) -> Option<Rgb> {
        self.values.even()
    }

    /// The value at a place of a flat part.
    #[inline]
    pub fn value(&self, place: DVec2) -> Rgb {
        let uv = match &self.map {
            PatternMap::Affine(map) => map.transform_point2(place),
            PatternMap::Polar => Disk::polar(place),
            PatternMap::Ball(_) => return self.values.peak(),
        };
        self.values.at(uv, place)
    }

    /// The value where a ball's unit normal is `normal`; as [`value`](Self::value) at (0, 0) for flat parts.
    #[inline]
    pub fn value_along(&self, normal: DVec3) -> Rgb {
        match &self.map {
            PatternMap::Ball(sphere) => self.values.at(sphere.uv_along(normal), DVec2::ZERO),
            _ => self.value(DVec2::ZERO),
        }
    }

    /// No value is above it, channel by channel.
    pub fn peak(&self) -> Rgb {
        self.values.peak()
    }

    /// No value on a patch of a flat part is above it, channel by channel, but where a square of a
    /// checkerboard touches the patch's border.
    pub fn peak_in(&self, patch: &ChartPatch) -> Rgb {
        let PatternMap::Affine(map) = &self.map else {
            return self.peak();
        };
        let size = around(&map.matrix2, patch.to - patch.from);
        let middle = map.transform_point2(patch.at(DVec2::splat(0.5)));
        let bounds = ChartPatch {
            from: middle - 0.5 * size,
            to: middle + 0.5 * size,
        };
        self.values.peak_in(&bounds, patch)
    }

    /// ∫ value dA over a convex polygon of places, in their area. `None` where parameters are not affine in
    /// places, and on lamps whose texture has too many pieces.
    pub fn integral(&self, polygon: &[DVec2]) -> Option<Rgb> {
        match &self.map {
            PatternMap::Affine(map) if self.is_exact => self.values.integral(polygon, map),
            _ => None,
        }
    }

    /// A bound of [`integral`](Self::integral): itself if it is known, else by the peak.
    pub fn integral_bound(&self, polygon: &[DVec2]) -> Rgb {
        let by_peak = || {
            let [from, to] = bounds(polygon);
            self.peak_in(&ChartPatch { from, to }) * area(polygon)
        };
        self.integral(polygon).unwrap_or_else(by_peak)
    }

    /// The number of pieces of one polynomial across a patch of places, in the direction that has more.
    pub fn pieces_across(&self, patch: &ChartPatch) -> f64 {
        let size = patch.to - patch.from;
        let (u, v) = match &self.map {
            PatternMap::Affine(map) => (
                map.matrix2.x_axis.abs() * size.x,
                map.matrix2.y_axis.abs() * size.y,
            ),
            // A turn, or half a turn, in about two units of places, and all of the radius in one.
            PatternMap::Polar | PatternMap::Ball(_) => {
                (DVec2::splat(0.5 * size.x), DVec2::splat(0.5 * size.y))
            }
        };
        self.values.pieces_in(u + v)
    }
}

impl PatternValues {
    fn new(scene: &Scene, id: TextureId, mesh: Option<(&Mesh, u32)>) -> Self {
        match scene.texture(id) {
            Texture::Bitmap(bitmap) => {
                let [low, high] = bitmap.image.range();
                if low == high {
                    Self::Even(Rgb(low))
                } else {
                    Self::Bitmap(bitmap.clone())
                }
            }
            Texture::Checkerboard {
                color0,
                color1,
                to_uv,
            } => {
                let of = |color: &Color| match color {
                    Color::Texture(id) => Self::new(scene, *id, mesh),
                    color => Self::Even(color.even()),
                };
                let both = [of(color0), of(color1)];
                match (both[0].even(), both[1].even()) {
                    (Some(a), Some(b)) if a == b => Self::Even(a),
                    _ => Self::Squares(Box::new(both), *to_uv),
                }
            }
            Texture::MeshAttribute { name, scale } => {
                let corners = [DVec2::ZERO, DVec2::X, DVec2::Y].map(|weights| {
                    mesh.and_then(|(mesh, face)| mesh.attribute(name, face, weights))
                        .map_or(Rgb::BLACK, |value| Rgb(value) * *scale)
                });
                let is_even = corners.iter().all(|value| *value == corners[0]);
                if is_even {
                    Self::Even(corners[0])
                } else {
                    Self::Corners(corners)
                }
            }
            Texture::Scaled { nested, scale } => {
                let nested = Self::new(scene, *nested, mesh);
                match nested.even() {
                    Some(value) => Self::Even(value * *scale),
                    None => Self::Scaled(Box::new(nested), *scale),
                }
            }
        }
    }

    fn even(&self) -> Option<Rgb> {
        match self {
            Self::Even(value) => Some(*value),
            _ => None,
        }
    }

    fn at(&self, uv: DVec2, place: DVec2) -> Rgb {
        match self {
            Self::Even(value) => *value,
            Self::Bitmap(image) => image.value(uv),
            Self::Squares(both, to_uv) => {
                let at = to_uv.transform_point2(uv);
                both[square(at)].at(uv, place)
            }
            Self::Corners([a, b, c]) => {
                *a * (1.0 - place.x - place.y) + *b * place.x + *c * place.y
            }
            Self::Scaled(nested, scale) => nested.at(uv, place) * *scale,
        }
    }

    fn peak(&self) -> Rgb {
        match self {
            Self::Even(value) => *value,
            Self::Bitmap(image) => image.peak(),
            Self::Squares(both, _) => most(both[0].peak(), both[1].peak()),
            Self::Corners([a, b, c]) => most(most(*a, *b), *c),
            Self::Scaled(nested, scale) => nested.peak() * *scale,
        }
    }

    /// A bound of the values in a box of surface parameters that holds those of a box of places.
    fn peak_in(&self, bounds: &ChartPatch, places: &ChartPatch) -> Rgb {
        match self {
            Self::Even(value) => *value,
            Self::Bitmap(image) => {
                let size = around(&affine(&image.to_uv).matrix2, bounds.to - bounds.from);
                let texels = size * texels_of(image) + 2.0;
                if texels.x * texels.y <= MAX_TEXELS {
                    image.peak_between(bounds.from, bounds.to)
                } else {
                    image.peak()
                }
            }
            Self::Squares(both, to_uv) => {
                let [a, b] = [0, 1].map(|index: usize| both[index].peak_in(bounds, places));
                let map = affine(to_uv);
                // A hair smaller: a border of the box may be one of a square.
                let size = around(&map.matrix2, bounds.to - bounds.from) * (1.0 - 1e-9);
                let middle = map.transform_point2(bounds.at(DVec2::splat(0.5)));
                let [low, high] = [-0.5, 0.5].map(|by| (middle + size * by) * 2.0);
                match square(middle) {
                    _ if low.floor() != high.floor() => most(a, b),
                    0 => a,
                    _ => b,
                }
            }
            Self::Corners(_) => {
                let corners = places.corners().map(|place| self.at(DVec2::ZERO, place));
                least(corners.into_iter().fold(Rgb::BLACK, most), self.peak())
            }
            Self::Scaled(nested, scale) => nested.peak_in(bounds, places) * *scale,
        }
    }

    /// A bound of the pieces of one polynomial in a box of surface parameters.
    fn pieces(&self, size: DVec2) -> f64 {
        // Lines of a grid that cross a box, and the space on both sides.
        let cells = |to_uv: &DMat3, by: DVec2| {
            let across = around(&affine(to_uv).matrix2, size) * by + 2.0;
            across.x * across.y
        };
        match self {
            Self::Even(_) | Self::Corners(_) => 1.0,
            Self::Bitmap(image) => cells(&image.to_uv, texels_of(image)),
            Self::Squares(both, to_uv) => {
                let cell = around(&affine(to_uv).matrix2.inverse(), DVec2::splat(0.5)).min(size);
                let within = both[0].pieces(cell).max(both[1].pieces(cell));
                cells(to_uv, DVec2::splat(2.0)) * within
            }
            Self::Scaled(nested, _) => nested.pieces(size),
        }
    }

    /// Pieces across a box of surface parameters, in the direction that has more.
    fn pieces_in(&self, size: DVec2) -> f64 {
        let through = |to_uv: &DMat3, by: DVec2| {
            let extent =
                to_uv.x_axis.truncate().abs() * size.x + to_uv.y_axis.truncate().abs() * size.y;
            (extent * by).max_element()
        };
        match self {
            Self::Even(_) => 0.0,
            Self::Bitmap(image) => through(&image.to_uv, texels_of(image)),
            Self::Squares(both, to_uv) => {
                let nested = both[0].pieces_in(size).max(both[1].pieces_in(size));
                nested.max(through(to_uv, DVec2::splat(2.0)))
            }
            Self::Corners(_) => 8.0 * size.max_element(),
            Self::Scaled(nested, _) => nested.pieces_in(size),
        }
    }

    fn integral(&self, polygon: &[DVec2], map: &DAffine2) -> Option<Rgb> {
        let mut sum = Rgb::BLACK;
        match self {
            Self::Even(value) => sum = *value * area(polygon),
            Self::Corners(_) => sum = by_middles(polygon, |place| self.at(DVec2::ZERO, place)),
            Self::Scaled(nested, scale) => sum = nested.integral(polygon, map)? * *scale,
            Self::Squares(both, to_uv) => {
                let lines = DAffine2::from_scale(DVec2::splat(2.0)) * affine(to_uv) * *map;
                each_cell(polygon, &lines, &mut |piece| {
                    let at = affine(to_uv).transform_point2(map.transform_point2(middle(piece)));
                    sum += both[square(at)].integral(piece, map)?;
                    Some(())
                })?;
            }
            Self::Bitmap(image) => {
                let texels = DAffine2::from_scale(texels_of(image)) * affine(&image.to_uv) * *map;
                let value = |place: DVec2| image.value(map.transform_point2(place));
                match image.filter {
                    TextureFilter::Nearest => each_cell(polygon, &texels, &mut |piece| {
                        sum += value(middle(piece)) * area(piece);
                        Some(())
                    })?,
                    TextureFilter::Bilinear => {
                        let centers = DAffine2::from_translation(DVec2::splat(-0.5)) * texels;
                        each_cell(polygon, &centers, &mut |piece| {
                            sum += by_middles(piece, value);
                            Some(())
                        })?;
                    }
                }
            }
        }
        Some(sum)
    }
}

/// The size of the box around a box of this size, after a linear map.
fn around(map: &DMat2, size: DVec2) -> DVec2 {
    map.x_axis.abs() * size.x + map.y_axis.abs() * size.y
}

/// The lowest and the highest coordinates of a polygon.
fn bounds(polygon: &[DVec2]) -> [DVec2; 2] {
    let places = || polygon.iter().copied();
    [
        places().fold(DVec2::INFINITY, DVec2::min),
        places().fold(DVec2::NEG_INFINITY, DVec2::max),
    ]
}

/// The larger of two values, channel by channel.
fn most(a: Rgb, b: Rgb) -> Rgb {
    Rgb(std::array::from_fn(|c| a.0[c].max(b.0[c])))
}

/// The smaller of two values, channel by channel.
fn least(a: Rgb, b: Rgb) -> Rgb {
    Rgb(std::array::from_fn(|c| a.0[c].min(b.0[c])))
}

/// Columns and rows of an image.
fn texels_of(image: &BitmapTexture) -> DVec2 {
    DVec2::new(image.image.width() as f64, image.image.height() as f64)
}

/// 0 where u and v are in the same half of the unit interval, else 1.
fn square(at: DVec2) -> usize {
    let first_half = |x: f64| x - x.floor() < 0.5;
    usize::from(first_half(at.x) != first_half(at.y))
}

fn affine(to_uv: &DMat3) -> DAffine2 {
    DAffine2::from_cols(
        to_uv.x_axis.truncate(),
        to_uv.y_axis.truncate(),
        to_uv.z_axis.truncate(),
    )
}

/// The mean of a polygon's corners.
fn middle(polygon: &[DVec2]) -> DVec2 {
    polygon.iter().sum::<DVec2>() / polygon.len() as f64
}

/// ∫ over a polygon of a polynomial of degree 2: the mean of its values at the middles of a triangle's edges,
/// by its area.
fn by_middles(polygon: &[DVec2], value: impl Fn(DVec2) -> Rgb) -> Rgb {
    let mut sum = Rgb::BLACK;
    for [a, b, c] in fan(polygon) {
        let size = 0.5 * (b - a).perp_dot(c - a).abs();
        let values = value(0.5 * (a + b)) + value(0.5 * (b + c)) + value(0.5 * (c + a));
        sum += values * (size / 3.0);
    }
    sum
}

/// Hands on the pieces of a polygon between whole coordinates of `lines`. `None` if they are too many, or
/// `each` fails.
fn each_cell(
    polygon: &[DVec2],
    lines: &DAffine2,
    each: &mut impl FnMut(&[DVec2]) -> Option<()>,
) -> Option<()> {
    let at = |place: &DVec2| lines.transform_point2(*place);
    let range = |polygon: &[DVec2], axis: usize| {
        let along = || polygon.iter().map(|place| at(place)[axis]);
        let from = along().fold(f64::INFINITY, f64::min).floor();
        let to = along().fold(f64::NEG_INFINITY, f64::max).ceil();
        (from, (to - from).max(1.0))
    };
    let ((left, columns), (_, rows)) = (range(polygon, 0), range(polygon, 1));
    // A second guard: [`Pattern::all`] has counted them.
    let pieces = columns * rows;
    if pieces > 2.0 * MAX_PIECES || pieces.is_nan() {
        return None;
    }
    let between = |polygon: &[DVec2], axis: usize, from: f64| {
        let above = cut(polygon, |place| at(place)[axis] - from);
        cut(&above, |place| from + 1.0 - at(place)[axis])
    };
    for column in 0..columns as u64 {
        let strip = between(polygon, 0, left + column as f64);
        if strip.len() < 3 {
            continue;
        }
        let (bottom, rows) = range(&strip, 1);
        for row in 0..rows as u64 {
            let piece = between(&strip, 1, bottom + row as f64);
            if piece.len() >= 3 {
                each(&piece)?;
            }
        }
    }
    Some(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::bitmap::{Bitmap, BitmapEncoding};
    use crate::scene::TextureWrap;
    use crate::transport::domain::polygon::cut;

    fn image(filter: TextureFilter) -> Pattern {
        let bytes = include_bytes!("../../../tests/mitsuba/color.png");
        let image = Bitmap::read(bytes, BitmapEncoding::Raw).unwrap();
        // Turned by the angle of a triangle of sides 3, 4 and 5.
        let turn = DMat3::from_mat2(DMat2::from_cols_array(&[1.04, 0.78, -0.42, 0.56]));
        Pattern {
            values: PatternValues::Bitmap(BitmapTexture {
                image: image.into(),
                filter,
                wrap: TextureWrap::Mirror,
                to_uv: turn,
            }),
            map: PatternMap::Affine(DAffine2::from_cols_array(&[1.0, 0.2, -0.2, 1.0, 0.1, 0.3])),
            is_exact: true,
        }
    }

    const SQUARE: [DVec2; 4] = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];

    #[test]
    fn the_integrals_of_parts_are_that_of_the_whole() {
        for filter in [TextureFilter::Nearest, TextureFilter::Bilinear] {
            let pattern = image(filter);
            let whole = pattern.integral(&SQUARE).unwrap();
            let mut sum = Rgb::BLACK;
            for step in 0..7 {
                let [low, high] = [step, step + 1].map(|it| f64::from(it) / 7.0);
                let part = cut(&SQUARE, |place| place.x + 0.3 * place.y - 1.3 * low);
                let part = cut(&part, |place| 1.3 * high - place.x - 0.3 * place.y);
                sum += pattern.integral(&part).unwrap();
            }
            for c in 0..3 {
                // Some hundred pieces, each to a few units in the last place.
                assert!((sum.0[c] - whole.0[c]).abs() <= 1e-13, "{sum:?} {whole:?}");
            }
        }
    }

    #[test]
    fn no_value_of_a_patch_is_above_its_peak() {
        for filter in [TextureFilter::Nearest, TextureFilter::Bilinear] {
            let pattern = image(filter);
            for step in 0..64 {
                let from = DVec2::new(f64::from(step % 8), f64::from(step / 8)) / 8.0;
                let patch = ChartPatch {
                    from,
                    to: from + 0.125,
                };
                let peak = pattern.peak_in(&patch);
                for inner in 0..100 {
                    let at = DVec2::new(f64::from(inner % 10), f64::from(inner / 10)) / 10.0 + 0.05;
                    let value = pattern.value(patch.at(at));
                    // A blend of four texels, each weight to a few roundings.
                    assert!((0..3).all(|c| value.0[c] <= peak.0[c] * (1.0 + 1e-14)));
                }
            }
        }
    }

    #[test]
    fn lamps_of_too_many_pieces_have_a_bound_instead_of_an_integral() {
        let mut pattern = image(TextureFilter::Nearest);
        let whole = pattern.integral(&SQUARE).unwrap();
        assert!(pattern.pieces() < MAX_PIECES);
        if let PatternValues::Bitmap(image) = &mut pattern.values {
            image.to_uv = DMat3::from_scale(DVec2::splat(1e4)) * image.to_uv;
        }
        assert!(pattern.pieces() > MAX_PIECES);
        assert!(pattern.integral(&SQUARE).is_none());
        let bound = pattern.integral_bound(&SQUARE);
        assert_eq!(bound, pattern.peak());
        assert!((0..3).all(|c| bound.0[c] >= whole.0[c]));
    }

    #[test]
    fn an_integral_is_the_mean_of_many_values() {
        const STEPS: usize = 1000;
        for filter in [TextureFilter::Nearest, TextureFilter::Bilinear] {
            let pattern = image(filter);
            let whole = pattern.integral(&SQUARE).unwrap();
            let mut sum = Rgb::BLACK;
            for step in 0..STEPS * STEPS {
                let (i, j) = ((step % STEPS) as f64 + 0.5, (step / STEPS) as f64 + 0.5);
                sum += pattern.value(DVec2::new(i, j) / STEPS as f64);
            }
            let mean = sum / (STEPS * STEPS) as f64;
            for c in 0..3 {
                // Jumps of at most 1 along some ten lines, each in 1.5 · 1/1000 of the square, half of it
                // missed at random over 1000 steps; without jumps, h²/24.
                assert!((mean.0[c] - whole.0[c]).abs() <= 5e-4, "{mean:?} {whole:?}");
            }
        }
    }
}
