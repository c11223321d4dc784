//! Images from other programs, for use as textures and environments.

use crate::numeric::math;
use std::io::Cursor;

use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder as _, ImageFormat, ImageReader, ImageResult, Limits};

/// An RGB image; row 0 is the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    width: usize,
    texels: Vec<[f32; 3]>,
    /// True if its file has one channel: the three are the same.
    is_grey: bool,
}

/// The relation of a file's numbers to light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum BitmapEncoding {
    /// 8 and 16 bits hold sRGB's curve, floats are linear: values become linear.
    Color,
    /// 8 and 16 bits hold the power 1/γ of light, floats are linear: values become linear.
    Gamma(f64),
    /// Values are taken as they are, 8 and 16 bits as fractions of the largest.
    Raw,
}

/// The largest memory of an image, in bytes, before it is refused as damaged.
const LARGEST: u64 = 1 << 32;

/// Bytes of an image for each byte of file, before it is refused as damaged. A black PNG comes to 1032
/// (zlib's limit), black JPEG, BMP and TGA files to a few hundred.
const MAX_EXPANSION: u64 = 1 << 12;

impl Bitmap {
    /// An image of `texels`, row by row; `None` unless they fill a rectangle of that width.
    pub fn new(width: usize, texels: Vec<[f32; 3]>) -> Option<Self> {
        let fits = width > 0 && !texels.is_empty() && texels.len().is_multiple_of(width);
        fits.then_some(Self {
            width,
            texels,
            is_grey: false,
        })
    }

    /// Reads an image file: PNG, JPEG, BMP, TGA, Radiance HDR, PNM or `OpenEXR`. The contents tell the format
    /// (TGA has no mark, and is taken for any file that is none of the others).
    ///
    /// An alpha channel is dropped.
    ///
    /// # Errors
    ///
    /// A description of the file's defect, without the file's name.
    pub fn read(bytes: &[u8], encoding: BitmapEncoding) -> Result<Self, String> {
        if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
            return read_exr(bytes);
        }
        let (image, is_grey) = decode(bytes).map_err(|error| error.to_string())?;
        let is_float = matches!(
            image,
            DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_)
        );
        let width = image.width() as usize;
        let texels = image.into_rgb32f();
        let texels = texels.pixels().map(|pixel| match encoding {
            _ if is_float => pixel.0,
            BitmapEncoding::Raw => pixel.0,
            BitmapEncoding::Color => pixel.0.map(linear),
            BitmapEncoding::Gamma(gamma) => pixel
                .0
                .map(|value| math::powf(f64::from(value), gamma) as f32),
        });
        let mut bitmap = Self::new(width, texels.collect()).ok_or("the image is empty")?;
        bitmap.is_grey = is_grey;
        bitmap.checked()
    }

    /// Number of texels a row.
    pub fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub fn height(&self) -> usize {
        self.texels.len() / self.width
    }

    /// All texels, row by row.
    pub fn texels(&self) -> &[[f32; 3]] {
        &self.texels
    }

    /// True if its file has one channel.
    pub fn is_grey(&self) -> bool {
        self.is_grey
    }

    /// A texel, red, green and blue.
    ///
    /// # Panics
    ///
    /// If the texel is outside of the image.
    #[inline]
    pub fn texel(&self, x: usize, y: usize) -> [f64; 3] {
        self.texels[y * self.width + x].map(f64::from)
    }

    fn checked(self) -> Result<Self, String> {
        let is_finite = |texel: &[f32; 3]| texel.iter().all(|value| value.is_finite());
        match self.texels.iter().position(|texel| !is_finite(texel)) {
            None => Ok(self),
            Some(index) => Err(format!(
                "the texel in column {}, row {} (counted from 0) is not finite",
                index % self.width,
                index / self.width
            )),
        }
    }
}

/// The image, and true if it has one channel.
fn decode(bytes: &[u8]) -> ImageResult<(DynamicImage, bool)> {
    let mut limits = Limits::default();
    limits.max_alloc = Some(LARGEST.min(MAX_EXPANSION * bytes.len() as u64));
    if bytes.starts_with(b"#?") {
        // Radiance files may call themselves by other names than "RADIANCE": Mitsuba's say "RGBE".
        let mut decoder = HdrDecoder::with_strictness(bytes, false)?;
        decoder.set_limits(limits)?;
        return Ok((DynamicImage::from_decoder(decoder)?, false));
    }
    let mut reader = ImageReader::new(Cursor::new(bytes)).with_guessed_format()?;
    if reader.format().is_none() {
        reader.set_format(ImageFormat::Tga);
    }
    reader.limits(limits);
    let decoder = reader.into_decoder()?;
    let is_grey = !decoder.color_type().has_color();
    Ok((DynamicImage::from_decoder(decoder)?, is_grey))
}

/// The channels R, G, B or Y of an `OpenEXR` file; its only channel if it has neither.
fn read_exr(bytes: &[u8]) -> Result<Bitmap, String> {
    let image = super::exr::decode(bytes)?;
    let channel = |names: [&str; 2]| {
        names
            .iter()
            .find_map(|name| image.channel(name))
            .map(|channel| &channel.samples)
    };
    let only = match image.channels.as_slice() {
        [only] => Some(&only.samples),
        _ => channel(["Y", "y"]),
    };
    let rgb = [
        channel(["R", "r"]),
        channel(["G", "g"]),
        channel(["B", "b"]),
    ];
    let (channels, is_grey) = match (rgb, only) {
        ([Some(red), Some(green), Some(blue)], _) => ([red, green, blue], false),
        (_, Some(only)) => ([only; 3], true),
        _ => {
            let names: Vec<&str> = image.channels.iter().map(|c| c.name.as_str()).collect();
            return Err(format!(
                "the image has the channels {}; needed are R, G and B, or Y",
                names.join(", ")
            ));
        }
    };
    let texels = (0..image.width * image.height).map(|i| channels.map(|channel| channel[i]));
    let mut bitmap = Bitmap::new(image.width, texels.collect()).ok_or("the image is empty")?;
    bitmap.is_grey = is_grey;
    bitmap.checked()
}

/// The inverse of sRGB's curve (IEC 61966-2-1).
fn linear(encoded: f32) -> f32 {
    let encoded = f64::from(encoded);
    let value = if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        math::powf((encoded + 0.055) / 1.055, 2.4)
    };
    value as f32
}
