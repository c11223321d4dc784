//! A rectangle of 8-bit sRGB pixels, with text.

use font8x8::legacy::{BASIC_LEGACY, GREEK_LEGACY, LATIN_LEGACY};
use image::codecs::png::{CompressionType, FilterType, PngEncoder};
use image::{ExtendedColorType, ImageEncoder, ImageResult};

/// Pixels of a glyph each way, before scaling.
pub(super) const GLYPH: usize = 8;

/// The picture being drawn.
pub(super) struct PictureCanvas {
    width: usize,
    height: usize,
    pixels: Vec<[u8; 3]>,
}

impl PictureCanvas {
    pub(super) fn new(width: usize, height: usize, background: [u8; 3]) -> Self {
        Self {
            width,
            height,
            pixels: vec![background; width * height],
        }
    }

    /// Sets a pixel; outside nothing happens.
    pub(super) fn set(&mut self, x: usize, y: usize, colour: [u8; 3]) {
        if x < self.width && y < self.height {
            self.pixels[y * self.width + x] = colour;
        }
    }

    /// Fills a rectangle.
    pub(super) fn fill(
        &mut self,
        x: usize,
        y: usize,
        width: usize,
        height: usize,
        colour: [u8; 3],
    ) {
        for row in y..y + height {
            for column in x..x + width {
                self.set(column, row, colour);
            }
        }
    }

    /// Draws a frame of `thickness` just outside a rectangle; needs as much space around it.
    pub(super) fn frame(
        &mut self,
        [x, y]: [usize; 2],
        [width, height]: [usize; 2],
        thickness: usize,
        colour: [u8; 3],
    ) {
        let (left, top) = (x - thickness, y - thickness);
        let full = width + 2 * thickness;
        self.fill(left, top, full, thickness, colour);
        self.fill(left, y + height, full, thickness, colour);
        self.fill(left, y, thickness, height, colour);
        self.fill(x + width, y, thickness, height, colour);
    }

    /// Writes one line, its upper left corner at (x, y), each font pixel `scale` pixels wide.
    pub(super) fn text(&mut self, x: usize, y: usize, scale: usize, text: &str, colour: [u8; 3]) {
        for (i, character) in text.chars().enumerate() {
            for (row, bits) in glyph(character).into_iter().enumerate() {
                for column in (0..GLYPH).filter(|column| bits >> column & 1 == 1) {
                    let left = x + (i * GLYPH + column) * scale;
                    self.fill(left, y + row * scale, scale, scale, colour);
                }
            }
        }
    }

    /// The pixels as a PNG file.
    pub(super) fn to_png(&self) -> ImageResult<Vec<u8>> {
        let mut file = Vec::new();
        PngEncoder::new_with_quality(&mut file, CompressionType::Default, FilterType::Adaptive)
            .write_image(
                self.pixels.as_flattened(),
                self.width as u32,
                self.height as u32,
                ExtendedColorType::Rgb8,
            )?;
        Ok(file)
    }
}

/// The rows of a character, top first, the leftmost pixel in bit 0.
///
/// ASCII, Latin-1 and Greek; a question mark for all others.
fn glyph(character: char) -> [u8; GLYPH] {
    let code = character as usize;
    match character {
        '\u{2212}' => Some(&BASIC_LEGACY['-' as usize]), // the minus sign
        '\u{0}'..='\u{7f}' => BASIC_LEGACY.get(code),
        '\u{a0}'..='\u{ff}' => LATIN_LEGACY.get(code - 0xa0),
        '\u{390}'..='\u{3c9}' => GREEK_LEGACY.get(code - 0x390),
        _ => None,
    }
    .copied()
    .unwrap_or(BASIC_LEGACY['?' as usize])
}
