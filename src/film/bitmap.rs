//! Images from other programs, for use as textures and environments.

use std::io::Cursor;

use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};

use crate::numeric::math;

/// An RGB image; row 0 is the top.
#[derive(Clone, Debug, PartialEq)]
pub struct Bitmap {
    width: usize,
    texels: Vec<[f32; 3]>,
    /// The smallest and the largest number of each channel.
    range: [[f32; 3]; 2],
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

/// The largest memory of an image as its decoder has it, in bytes.
const LARGEST: u64 = 1 << 32;

/// The most texels of an image: 16384 x 16384. A scene keeps 12 bytes of each, and reading takes as much
/// again.
const MOST_TEXELS: u64 = 1 << 28;

/// Bytes of an image for each byte of file, before it is refused as damaged.
///
/// PNM packs nothing but eight black or white texels into a byte, each of which is decoded to a byte. Of
/// other formats a black image is the extreme: PNG comes to 1032 (zlib's limit), JPEG, BMP and TGA to a few
/// hundred.
fn max_expansion(format: Option<ImageFormat>) -> u64 {
    match format {
        Some(ImageFormat::Pnm) => 8,
        _ => 1 << 12,
    }
}

impl Bitmap {
    /// An image of `texels`, row by row; `None` unless they fill a rectangle of that width.
    pub fn new(width: usize, texels: Vec<[f32; 3]>) -> Option<Self> {
        let fits = width > 0 && !texels.is_empty() && texels.len().is_multiple_of(width);
        let mut range = [[f32::INFINITY; 3], [f32::NEG_INFINITY; 3]];
        for texel in &texels {
            for (c, value) in texel.iter().enumerate() {
                range[0][c] = range[0][c].min(*value);
                range[1][c] = range[1][c].max(*value);
            }
        }
        fits.then_some(Self {
            width,
            texels,
            range,
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
    /// A description of the file's defect, without the file's name. Sizes are checked before memory is taken:
    /// images of more than 2²⁸ texels are refused, and those that a file of this length cannot hold.
    pub fn read(bytes: &[u8], encoding: BitmapEncoding) -> Result<Self, String> {
        if bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01]) {
            return read_exr(bytes);
        }
        let (image, is_grey) = decode(bytes)?;
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

    /// The smallest and the largest number of each channel.
    pub fn range(&self) -> [[f64; 3]; 2] {
        self.range.map(|bound| bound.map(f64::from))
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
fn decode(bytes: &[u8]) -> Result<(DynamicImage, bool), String> {
    if bytes.starts_with(b"#?") {
        // Radiance files may call themselves by other names than "RADIANCE": Mitsuba's say "RGBE".
        let decoder =
            HdrDecoder::with_strictness(bytes, false).map_err(|error| error.to_string())?;
        return image_of(decoder, Some(ImageFormat::Hdr), bytes.len());
    }
    let mut reader = ImageReader::new(Cursor::new(bytes))
        .with_guessed_format()
        .map_err(|error| error.to_string())?;
    if reader.format().is_none() {
        reader.set_format(ImageFormat::Tga);
    }
    let format = reader.format();
    // What a decoder takes for itself while it reads the header.
    reader.limits(limits(format, bytes.len()));
    let decoder = reader.into_decoder().map_err(|error| error.to_string())?;
    image_of(decoder, format, bytes.len())
}

/// What a decoder may take for itself.
fn limits(format: Option<ImageFormat>, length: usize) -> Limits {
    let mut limits = Limits::default();
    limits.max_alloc = Some(LARGEST.min(max_expansion(format) * length as u64));
    limits
}

/// The image of a decoder that has read the header of a file of so many bytes.
///
/// `DynamicImage::from_decoder` takes the memory that the header asks for, whatever limits the decoder has:
/// the size is checked before.
fn image_of(
    mut decoder: impl ImageDecoder,
    format: Option<ImageFormat>,
    length: usize,
) -> Result<(DynamicImage, bool), String> {
    let (width, height) = decoder.dimensions();
    check_texels(u64::from(width), u64::from(height))?;
    let most = max_expansion(format);
    let needed = decoder.total_bytes();
    if needed > LARGEST || needed / most > length as u64 {
        return Err(format!(
            "damaged: claims {width} x {height} texels, which take {needed} bytes, in a file of {length} bytes: \
             allowed are {most} for each, and {LARGEST}"
        ));
    }
    decoder
        .set_limits(limits(format, length))
        .map_err(|error| error.to_string())?;
    let is_grey = !decoder.color_type().has_color();
    let image = DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())?;
    Ok((image, is_grey))
}

/// Refuses images of more texels than a scene can be expected to keep.
fn check_texels(width: u64, height: u64) -> Result<(), String> {
    if width.saturating_mul(height) <= MOST_TEXELS {
        return Ok(());
    }
    Err(format!(
        "claims {width} x {height} texels: allowed are up to {MOST_TEXELS}"
    ))
}

/// The channels R, G, B or Y of an `OpenEXR` file; its only channel if it has neither.
fn read_exr(bytes: &[u8]) -> Result<Bitmap, String> {
    let image = super::exr::decode(bytes, check_texels)?;
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
