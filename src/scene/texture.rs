//! Quantities that vary over a surface.
//!
//! A parameter of a material is a constant or refers to a texture. It is asked for its value at a
//! [`TexturePoint`](super::TexturePoint). Conventions are Mitsuba's (checked against 3.9.1, see
//! `tests/scattering/textures.rs`). So v = 0 is the first row of an image, and the center of the first texel
//! lies half a texel from the border.

use std::sync::Arc;

use glam::{DMat3, DVec2};

use crate::film::bitmap::Bitmap;
use crate::radiometry::Rgb;

/// The index of a [`Texture`] in [`Scene::textures`](super::Scene::textures).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct TextureId(pub u32);

/// A colour, constant or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Color {
    /// The same everywhere.
    Constant(Rgb),
    /// Looked up in a texture.
    Texture(TextureId),
    /// Not known: the file names an image that is not there, or a spectrum from a file, which is not
    /// modelled. No irradiance depends on a diffuse reflectance; the light that a camera sees does.
    Unknown,
}

/// A number, constant or not.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Scalar {
    /// The same everywhere.
    Constant(f64),
    /// Looked up in a texture: the luminance of its colour.
    Texture(TextureId),
}

impl Color {
    /// One everywhere: a factor that changes nothing.
    pub const WHITE: Self = Self::Constant(Rgb::WHITE);

    /// The value of a colour that is the same everywhere; black for any other.
    #[inline]
    pub fn even(&self) -> Rgb {
        match self {
            Self::Constant(rgb) => *rgb,
            Self::Texture(_) | Self::Unknown => Rgb::BLACK,
        }
    }

    /// True if red, green and blue are known to be the same everywhere.
    pub fn is_grey(&self) -> bool {
        matches!(self, Self::Constant(rgb) if rgb.is_grey())
    }

    /// The texture it refers to.
    pub fn texture(&self) -> Option<TextureId> {
        match self {
            Self::Texture(id) => Some(*id),
            Self::Constant(_) | Self::Unknown => None,
        }
    }
}

impl Scalar {
    /// The texture it refers to.
    pub fn texture(&self) -> Option<TextureId> {
        match self {
            Self::Texture(id) => Some(*id),
            Self::Constant(_) => None,
        }
    }

    /// True if it may be above 0 anywhere.
    #[inline]
    pub fn may_exceed_zero(&self) -> bool {
        !matches!(self, Self::Constant(number) if *number <= 0.0)
    }

    /// True if it may lie between 0 and 1 anywhere, as an opacity.
    #[inline]
    pub fn is_partial(&self) -> bool {
        !matches!(self, Self::Constant(number) if *number <= 0.0 || *number >= 1.0)
    }
}

/// A quantity that varies over a surface.
#[derive(Clone, Debug, PartialEq)]
pub enum Texture {
    /// An image.
    Bitmap(BitmapTexture),
    /// Two colours in turn, two by two squares to the unit square.
    Checkerboard {
        /// The colour where u and v are in the same half of the unit interval.
        color0: Color,
        /// The colour elsewhere.
        color1: Color,
        /// The transform that is applied to (u, v, 1) first.
        to_uv: DMat3,
    },
    /// Values that a mesh file gives for its vertices or faces.
    MeshAttribute {
        /// Mitsuba's name: `vertex_color`, `face_color`, ...
        name: String,
        /// A factor.
        scale: f64,
    },
    /// Another texture, times a factor.
    Scaled {
        /// The other texture.
        nested: TextureId,
        /// The factor.
        scale: Rgb,
    },
}

/// An image laid over a surface.
#[derive(Clone, Debug, PartialEq)]
pub struct BitmapTexture {
    /// Its texels, as they are used: linear unless the file asked for raw values.
    pub image: Arc<Bitmap>,
    /// The value between the centers of texels.
    pub filter: TextureFilter,
    /// The value outside of the unit square.
    pub wrap: TextureWrap,
    /// The transform that is applied to (u, v, 1) first.
    pub to_uv: DMat3,
}

/// The value between the centers of texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureFilter {
    /// The texel itself.
    Nearest,
    /// A blend of the four nearest.
    Bilinear,
}

/// The value outside of the unit square.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TextureWrap {
    /// The image again.
    Repeat,
    /// The image again, each copy the mirror image of its neighbours.
    Mirror,
    /// The texels of the border.
    Clamp,
}

/// Luminance of linear sRGB, with Mitsuba's weights.
#[inline]
pub fn luminance(Rgb([red, green, blue]): Rgb) -> f64 {
    0.212671 * red + 0.715160 * green + 0.072169 * blue
}

impl BitmapTexture {
    /// The color at surface parameters.
    pub fn value(&self, uv: DVec2) -> Rgb {
        match self.filter {
            TextureFilter::Nearest => {
                let size = self.size();
                let at = (self.to_uv.transform_point2(uv) * size).floor();
                self.texel(at)
            }
            TextureFilter::Bilinear => {
                let (corner, weight) = self.cell(uv);
                let [a, b, c, d] = self.corners(corner);
                (a * (1.0 - weight.x) + b * weight.x) * (1.0 - weight.y)
                    + (c * (1.0 - weight.x) + d * weight.x) * weight.y
            }
        }
    }

    /// The change of luminance with u and v. It is that of the blend, so zero without one.
    pub fn gradient(&self, uv: DVec2) -> DVec2 {
        if self.filter == TextureFilter::Nearest {
            return DVec2::ZERO;
        }
        let (corner, weight) = self.cell(uv);
        let [a, b, c, d] = self.corners(corner).map(luminance);
        let by_texel = DVec2::new(
            (b - a) * (1.0 - weight.y) + (d - c) * weight.y,
            (c - a) * (1.0 - weight.x) + (d - b) * weight.x,
        );
        // The chain rule through `to_uv`. Mitsuba multiplies by the image's size after `to_uv`, not before.
        // Both are the same unless `to_uv` turns an image that is not square.
        self.size()
            * DVec2::new(
                self.to_uv.x_axis.truncate().dot(by_texel),
                self.to_uv.y_axis.truncate().dot(by_texel),
            )
    }

    /// The largest texel, channel by channel: no value is above it.
    pub fn peak(&self) -> Rgb {
        let [_, high] = self.image.range();
        Rgb(high.map(|it| it.max(0.0)))
    }

    /// A bound of the values between two surface parameters, channel by channel: values between centers are
    /// no larger than the texels around them.
    pub fn peak_between(&self, from: DVec2, to: DVec2) -> Rgb {
        let corners = [from, DVec2::new(from.x, to.y), DVec2::new(to.x, from.y), to];
        let places = corners.map(|uv| self.to_uv.transform_point2(uv) * self.size());
        // A texel reaches from a whole number to the next; blends, from one center to the next.
        let shift = match self.filter {
            TextureFilter::Nearest => 0.0,
            TextureFilter::Bilinear => 0.5,
        };
        let low = places.into_iter().fold(DVec2::INFINITY, DVec2::min) - shift;
        let high = places.into_iter().fold(DVec2::NEG_INFINITY, DVec2::max) - shift;
        let first = low.floor();
        let end = high.ceil() + 2.0 * shift;
        let count = (end - first).max(DVec2::ONE);
        if !count.cmplt(self.size()).all() {
            return self.peak();
        }
        let (columns, rows) = (count.x as usize, count.y as usize);
        let places = (0..rows).flat_map(|y| (0..columns).map(move |x| (x, y)));
        brightest(places.map(|(x, y)| self.texel(first + DVec2::new(x as f64, y as f64))))
    }

    fn size(&self) -> DVec2 {
        DVec2::new(self.image.width() as f64, self.image.height() as f64)
    }

    /// The texel whose center is the upper left of the four nearest, and the distance from it.
    fn cell(&self, uv: DVec2) -> (DVec2, DVec2) {
        let at = self.to_uv.transform_point2(uv) * self.size() - 0.5;
        let corner = at.floor();
        (corner, at - corner)
    }

    /// The four texels of a cell: upper left, upper right, lower left, lower right.
    fn corners(&self, corner: DVec2) -> [Rgb; 4] {
        [(0.0, 0.0), (1.0, 0.0), (0.0, 1.0), (1.0, 1.0)]
            .map(|(x, y)| self.texel(corner + DVec2::new(x, y)))
    }

    /// The texel at whole coordinates, wherever they are.
    fn texel(&self, at: DVec2) -> Rgb {
        let x = self.wrap.apply(at.x, self.image.width());
        let y = self.wrap.apply(at.y, self.image.height());
        Rgb(self.image.texel(x, y))
    }
}

/// The largest of some texels, channel by channel.
fn brightest(texels: impl Iterator<Item = Rgb>) -> Rgb {
    texels.fold(Rgb::BLACK, |most, texel| {
        Rgb(std::array::from_fn(|c| most.0[c].max(texel.0[c])))
    })
}

impl TextureWrap {
    /// The place in 0..`count` that stands for a whole coordinate.
    fn apply(self, at: f64, count: usize) -> usize {
        let size = count as f64;
        let inside = match self {
            Self::Repeat => at.rem_euclid(size),
            Self::Mirror => {
                let twice = at.rem_euclid(2.0 * size);
                twice.min(2.0 * size - 1.0 - twice)
            }
            Self::Clamp => at,
        };
        // The cast saturates, and a remainder that rounded up to the size itself is brought back.
        (inside.max(0.0) as usize).min(count - 1)
    }
}
