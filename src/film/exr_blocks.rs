//! Blocks of lines of an `OpenEXR` file, deflated.
//!
//! A block holds its lines one after the other, and of each line all channels in the order of their names. Its
//! bytes of even places come before those of odd places, and each is stored as the difference to the one before,
//! plus 128 ("Technical Introduction to `OpenEXR`", ZIP compression). That is where neighbours are alike. A block
//! that deflating would not make smaller is stored as it is.

use std::io::{self, Write as _};
use std::ops::Range;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use rayon::prelude::*;

use super::lazy::LazyImage;

/// Lines of a block: they are deflated together.
pub(super) const LINES: usize = 16;

/// Level of deflate. From 4 to 6, files of beams become smaller by some thousandths.
const LEVEL: u32 = 4;

/// Copies of a block \[blocks\] that a thread holds: its samples, these in the order for deflating, and the result.
const COPIES: u64 = 3;

/// Memory \[bytes\] in which so many channels of `f32` are encoded.
pub(super) fn bytes([width, height]: [u64; 2], channels: u64) -> u64 {
    let lines = LINES as u64;
    let busy = (rayon::current_num_threads() as u64).min(height.div_ceil(lines));
    width * lines.min(height) * channels * 4 * COPIES * busy
}

/// Writes all blocks of an image in the order of their lines, each with the number of its first line. The samples of
/// a few are in memory at a time: as many as there are threads.
///
/// # Errors
///
/// As `write`.
pub(super) fn deflate<E>(
    image: &LazyImage,
    mut write: impl FnMut(usize, Vec<u8>) -> Result<(), E>,
) -> Result<(), E>
where
    E: From<io::Error> + Send,
{
    let places = places(image);
    let starts: Vec<usize> = (0..image.height).step_by(LINES).collect();
    for some in starts.chunks(rayon::current_num_threads()) {
        let deflated = some.par_iter().map(|start| {
            let lines = *start..(start + LINES).min(image.height);
            let block = block(image, &places, lines);
            let deflated = zipped(&in_two_halves(&block))?;
            Ok(if deflated.len() < block.len() {
                deflated
            } else {
                block
            })
        });
        let deflated: Result<Vec<Vec<u8>>, io::Error> = deflated.collect();
        for (start, bytes) in some.iter().zip(deflated?) {
            write(*start, bytes)?;
        }
    }
    Ok(())
}

/// The place of each channel in a line.
fn places(image: &LazyImage) -> Vec<usize> {
    let names: Vec<&str> = image.names().collect();
    let mut sorted: Vec<usize> = (0..names.len()).collect();
    sorted.sort_by_key(|channel| names[*channel]);
    let mut places = vec![0; names.len()];
    for (place, channel) in sorted.into_iter().enumerate() {
        places[channel] = place;
    }
    places
}

/// The samples of some lines.
fn block(image: &LazyImage, places: &[usize], lines: Range<usize>) -> Vec<u8> {
    let line = image.width * places.len();
    let mut bytes = vec![0; lines.len() * line * size_of::<f32>()];
    let mut first = 0;
    for quantity in &image.quantities {
        let places = &places[first..][..quantity.names.len()];
        first += places.len();
        let mut samples = vec![0.0_f32; places.len()];
        for (row, number) in lines.clone().enumerate() {
            for column in 0..image.width {
                (quantity.sample)(number * image.width + column, &mut samples);
                for (place, sample) in places.iter().zip(&samples) {
                    let at = size_of::<f32>() * (row * line + place * image.width + column);
                    bytes[at..][..size_of::<f32>()].copy_from_slice(&sample.to_le_bytes());
                }
            }
        }
    }
    bytes
}

/// The differences of bytes at even places, and then of those at odd places.
fn in_two_halves(block: &[u8]) -> Vec<u8> {
    let even = block.iter().step_by(2);
    let odd = block.iter().skip(1).step_by(2);
    let mut before = None;
    let difference = |byte: &u8| match before.replace(*byte) {
        Some(before) => byte.wrapping_sub(before).wrapping_add(128),
        None => *byte,
    };
    even.chain(odd).map(difference).collect()
}

fn zipped(bytes: &[u8]) -> Result<Vec<u8>, io::Error> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::new(LEVEL));
    encoder.write_all(bytes)?;
    encoder.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_of_each_significance_are_stored_as_differences() {
        assert_eq!(in_two_halves(&[7, 1, 9, 1, 8]), [7, 130, 127, 121, 128]);
        assert!(in_two_halves(&[]).is_empty());
    }

    #[test]
    fn noise_is_stored_as_it_is() {
        let mut image = LazyImage::new(8, 3);
        // Bits without any pattern: 24 numbers that a hash makes of their place.
        let noise = |texel: usize| (texel as u32 + 1).wrapping_mul(0x9e37_79b9);
        image.add_scalar("noise", move |texel| {
            f64::from(f32::from_bits(noise(texel) & 0x7f7f_ffff))
        });
        let mut blocks = Vec::new();
        deflate(&image, |start, bytes| -> Result<(), io::Error> {
            blocks.push((start, bytes));
            Ok(())
        })
        .unwrap();
        let expected: Vec<u8> = (0..24)
            .flat_map(|texel| (noise(texel) & 0x7f7f_ffff).to_le_bytes())
            .collect();
        assert_eq!(blocks, [(0, expected)]);
    }
}
