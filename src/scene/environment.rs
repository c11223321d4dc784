//! Light from infinitely far away, all round: an image, or a sky by formula with an image of it.

use std::f64::consts::{FRAC_1_PI, PI, TAU};
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use crate::film::bitmap::Bitmap;
use crate::geometry::Transform;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::spectrum::daylight::ClearSky;

/// An image laid round the scene: Mitsuba's `envmap`.
///
/// Let x be a column and y a row of an image of w x h, both counted from the *centers* of the first texels.
/// In the image's own frame, the direction to them is
///
/// ```text
/// (sin φ sin θ, cos θ, −cos φ sin θ),   φ = 2π (x + 1/2) / w,   θ = π y / (h − 1)
/// ```
///
/// so the centers of the first and the last row are the poles, +y and −y, and the middle column looks along
/// +z. Between centers radiance is bilinear in x and y; the last column's neighbour is the first.
///
/// A clear sky has an image by which directions are chosen, and the radiance of its formula everywhere.
#[derive(Clone, Debug, PartialEq)]
pub struct Envmap {
    image: Arc<Bitmap>,
    /// The sky that the image is of.
    sky: Option<Arc<ClearSky>>,
    /// A rotation, or one with a mirror: its inverse is its transpose.
    to_world: DMat3,
    scale: f64,
    peak: Rgb,
    is_grey: bool,
}

/// Reason why an image cannot be an environment.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum EnvmapError {
    /// Too few columns or rows.
    #[error("the image has {width} x {height} texels; at least 2 x 3 are needed")]
    Size {
        /// Columns.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// Radiance below zero.
    #[error(
        "the texel in column {column}, row {row} (counted from 0) holds {value}; radiance must not be negative"
    )]
    Negative {
        /// Counted from 0.
        column: usize,
        /// Counted from 0.
        row: usize,
        /// The radiance.
        value: f32,
    },
    /// Not a finite number, or negative.
    #[error("\"scale\" is {scale}; finite numbers >= 0 are allowed")]
    Scale {
        /// The factor.
        scale: f64,
    },
    /// The transform is more than a rotation and a scale.
    #[error(
        "\"to_world\" must be a rotation, mirrored or not, and a scale: it must not change angles"
    )]
    Stretched,
}

/// Columns and rows of the image of a sky. The middle row is the horizon, so that no cell is on both sides of
/// it.
const SKY_IMAGE: (usize, usize) = (512, 257);

/// A sky's radiance between four texels of its image, by the brightest of these, at most.
const SKY_EXCESS: f64 = 1.05;

/// Largest deviation of the lengths of axes from 1, with a scale taken out, and of their angles from right
/// ones: matrices written with seven digits pass.
const ROTATION_TOLERANCE: f64 = 2e-6;

fn size(to_world: DMat3) -> Option<f64> {
    let size = math::cbrt(to_world.determinant().abs());
    ((size - 1.0).abs() > ROTATION_TOLERANCE).then_some(size)
}

impl Envmap {
    /// An image of radiances [W/m²/sr], times `scale`. Only the rotation of `to_world` matters, since an
    /// environment is infinitely far away.
    ///
    /// # Errors
    ///
    /// If the image is too small or has negative texels, or if `to_world` changes angles.
    pub fn new(image: Arc<Bitmap>, to_world: &Transform, scale: f64) -> Result<Self, EnvmapError> {
        let (width, height) = (image.width(), image.height());
        if width < 2 || height < 3 {
            return Err(EnvmapError::Size { width, height });
        }
        if !(scale >= 0.0 && scale.is_finite()) {
            return Err(EnvmapError::Scale { scale });
        }
        let to_world = DMat3::from_mat4(to_world.matrix());
        let to_world = match size(to_world) {
            Some(size) => to_world * (1.0 / size),
            None => to_world,
        };
        let off = to_world.transpose() * to_world - DMat3::IDENTITY;
        if off
            .to_cols_array()
            .iter()
            .any(|x| x.is_nan() || x.abs() > ROTATION_TOLERANCE)
        {
            return Err(EnvmapError::Stretched);
        }
        let (mut peak, mut is_grey) = ([0.0f32; 3], true);
        for (index, texel) in image.texels().iter().enumerate() {
            if let Some(value) = texel.iter().find(|value| **value < 0.0) {
                return Err(EnvmapError::Negative {
                    column: index % width,
                    row: index / width,
                    value: *value,
                });
            }
            is_grey &= texel[0] == texel[1] && texel[1] == texel[2];
            peak = std::array::from_fn(|c| peak[c].max(texel[c]));
        }
        Ok(Self {
            image,
            sky: None,
            to_world,
            scale,
            peak: Rgb(peak.map(f64::from)) * scale,
            is_grey,
        })
    }

    /// A clear sky, times `scale`, whose zenith `to_world` turns from +y.
    ///
    /// Radiance in a channel is at least zero: see [`ClearSky::radiance`].
    ///
    /// # Errors
    ///
    /// If `to_world` changes angles.
    pub fn of_sky(sky: ClearSky, to_world: &Transform, scale: f64) -> Result<Self, EnvmapError> {
        let (width, height) = SKY_IMAGE;
        let texels = (0..width * height).map(|index| {
            let [x, y] = [index % width, index / width].map(|it| it as f64);
            let (own, _) = direction_in(DVec2::new(x, y), (width, height));
            of_sky(&sky, own).0.map(|channel| channel as f32)
        });
        let size = EnvmapError::Size { width, height };
        let image = Bitmap::new(width, texels.collect()).ok_or(size)?;
        let drawn = Self::new(image.into(), to_world, scale)?;
        Ok(Self {
            sky: Some(sky.into()),
            peak: drawn.peak * SKY_EXCESS,
            ..drawn
        })
    }

    /// The factor that `to_world` changes volumes' sides by; `None` if it changes none.
    ///
    /// Mitsuba 3 does not take it out. Its directions then have the wrong length, and its image is distorted.
    pub fn size_of(to_world: &Transform) -> Option<f64> {
        size(DMat3::from_mat4(to_world.matrix()))
    }

    /// The image, before `scale`.
    pub fn image(&self) -> &Bitmap {
        &self.image
    }

    /// The factor on the image's radiance.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// At least the radiance of any direction, channel by channel [W/m²/sr]; of an image, the largest of any
    /// texel.
    pub fn peak(&self) -> Rgb {
        self.peak
    }

    /// At least the radiance [W/m²/sr] next to texels with these values, channel by channel.
    ///
    /// Bilinear values are no larger than those of their texels. A sky's formula is, by 2.1 % where the sun
    /// is in the middle of four texels.
    pub fn bound(&self, brightest: Rgb) -> Rgb {
        brightest * (self.scale * if self.sky.is_some() { SKY_EXCESS } else { 1.0 })
    }

    /// True if red, green and blue are the same all round.
    pub fn is_grey(&self) -> bool {
        self.is_grey
    }

    /// Radiance [W/m²/sr] that comes from `direction`, a unit vector that points away from the scene.
    pub fn radiance(&self, direction: DVec3) -> Rgb {
        match &self.sky {
            Some(sky) => of_sky(sky, self.to_world.transpose() * direction) * self.scale,
            None => self.at(self.coordinates(direction).0),
        }
    }

    /// [`Self::radiance`] from a direction whose place in the image is in this cell.
    pub fn radiance_in(&self, direction: DVec3, cell: &EnvmapCell) -> Rgb {
        match &self.sky {
            Some(_) => self.radiance(direction),
            None => self.in_cell(cell),
        }
    }

    /// Radiance [W/m²/sr] at a column in 0..w and a row in 0..=h − 1.
    pub fn at(&self, coordinates: DVec2) -> Rgb {
        if let Some(sky) = &self.sky {
            let (own, _) = direction_in(coordinates, (self.image.width(), self.image.height()));
            return of_sky(sky, own) * self.scale;
        }
        self.in_cell(&self.cell(coordinates))
    }

    /// The image's radiance at a place.
    fn in_cell(&self, cell: &EnvmapCell) -> Rgb {
        cell.blend(|column, row| Rgb(self.image.texel(column, row))) * self.scale
    }

    /// The column (in 0..w) and row (in 0..=h − 1) that lie in `direction`, a unit vector, not rounded, and
    /// the sine of its angle to the poles.
    pub fn coordinates(&self, direction: DVec3) -> (DVec2, f64) {
        let DVec3 { x, y, z } = self.to_world.transpose() * direction;
        let sin = (x * x + z * z).sqrt();
        // The angle to the axis by atan2: acos loses half the digits at the poles.
        let theta = math::atan2(sin, y);
        let width = self.image.width() as f64;
        let column = math::atan2(x, -z) / TAU * width - 0.5;
        // The column is in -w/2 - 1/2..=w/2 - 1/2.
        let wrapped = if column < 0.0 { column + width } else { column };
        let coordinates = DVec2::new(
            // The sum may round up to the width itself.
            if wrapped < width { wrapped } else { 0.0 },
            theta * FRAC_1_PI * (self.image.height() - 1) as f64,
        );
        (coordinates, sin)
    }

    /// The direction of a column and a row, a unit vector, and the sine of its angle to the poles.
    pub fn direction(&self, coordinates: DVec2) -> (DVec3, f64) {
        let (own, sin) = direction_in(coordinates, (self.image.width(), self.image.height()));
        ((self.to_world * own).normalize(), sin)
    }

    /// The square of four texels about a place.
    pub fn cell(&self, coordinates: DVec2) -> EnvmapCell {
        let (width, height) = (self.image.width(), self.image.height());
        // Casts saturate: out of range is not out of bounds.
        let column = (coordinates.x as usize).min(width - 1);
        let row = (coordinates.y as usize).min(height - 2);
        EnvmapCell {
            columns: [column, (column + 1) % width],
            rows: [row, row + 1],
            weight: coordinates - DVec2::new(column as f64, row as f64),
        }
    }
}

/// The direction of a column and a row of an image of a size, in its own frame, and the sine of its angle to
/// the poles.
fn direction_in(coordinates: DVec2, (width, height): (usize, usize)) -> (DVec3, f64) {
    let (sin_phi, cos_phi) = math::sin_cos(TAU * (coordinates.x + 0.5) / width as f64);
    let (sin, cos) = math::sin_cos(PI * coordinates.y / (height - 1) as f64);
    (DVec3::new(sin_phi * sin, cos, -cos_phi * sin), sin)
}

/// The radiance of a sky, whose z axis points up, in a direction of an image, whose y axis does.
fn of_sky(sky: &ClearSky, own: DVec3) -> Rgb {
    let DVec3 { x, y, z } = own;
    sky.radiance(DVec3::new(x, -z, y))
        .map(|channel| channel.max(0.0))
}

/// Four neighbouring texels, and a place between their centers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct EnvmapCell {
    /// The left and the right one.
    pub columns: [usize; 2],
    /// The upper and the lower one.
    pub rows: [usize; 2],
    /// Distances to the right and down, in texels, in 0..=1.
    pub weight: DVec2,
}

impl EnvmapCell {
    /// The bilinear blend of the values that `value` gives for each (column, row).
    pub fn blend<T>(&self, value: impl Fn(usize, usize) -> T) -> T
    where
        T: std::ops::Mul<f64, Output = T> + std::ops::Add<Output = T>,
    {
        let DVec2 { x, y } = self.weight;
        let along = |row| value(self.columns[0], row) * (1.0 - x) + value(self.columns[1], row) * x;
        along(self.rows[0]) * (1.0 - y) + along(self.rows[1]) * y
    }
}
