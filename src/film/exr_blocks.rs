//! Blocks of lines of an `OpenEXR` file, deflated.
//!
//! A block holds its lines one after the other, and of each line all channels in the order of their names.
//! Its bytes of even places come before those of odd places. Each is stored as the difference to the one
//! before, plus 128 (`OpenEXR`'s "ZIP" compression). That is where neighbours are alike. A block that
//! deflating does not make smaller is stored as it is.

use std::io::{self, Write as _};
use std::num::NonZero;
use std::ops::Range;
use std::panic::resume_unwind;
use std::thread;

use flate2::Compression;
use flate2::write::ZlibEncoder;

use super::lazy::LazyImage;

/// Lines of a block: they are deflated together.
pub(super) const LINES: usize = 16;

/// Level of deflate. From 4 to 6, files of beams become smaller by some thousandths.
const LEVEL: u32 = 4;

/// Copies of a block that a thread holds: its samples, these in the order for deflating, and the result.
const COPIES: u64 = 3;

/// Memory \[bytes\] of a thread's deflation, and more.
const DEFLATING: u64 = 1 << 19;

/// Memory \[bytes\] in which so many channels of `f32` are encoded.
pub fn encoding_bytes([width, height]: [u64; 2], channels: u64) -> u64 {
    let lines = LINES as u64;
    let busy = (threads() as u64).min(height.div_ceil(lines));
    let block = width * lines.min(height) * channels * 4;
    (block * COPIES + DEFLATING) * busy
}

/// Number of threads that deflate: as many as the pool has that encodes, or as the machine has. They are the
/// encoder's own, as the pool of a whole process would be left to its forks, without its threads.
fn threads() -> usize {
    match rayon::current_thread_index() {
        Some(_) => rayon::current_num_threads(),
        None => thread::available_parallelism().map_or(1, NonZero::get),
    }
}

/// Writes all blocks of an image in the order of their lines, each with the number of its first line. Its
/// channels are in this [order](LazyImage::order). A block for each thread is in memory at a time.
///
/// # Errors
///
/// As `write`, and if a block cannot be deflated.
pub(super) fn deflate<E: From<io::Error>>(
    image: &LazyImage,
    order: &[usize],
    mut write: impl FnMut(usize, Vec<u8>) -> Result<(), E>,
) -> Result<(), E> {
    let places = places(order);
    let starts: Vec<usize> = (0..image.height).step_by(LINES).collect();
    for some in starts.chunks(threads()) {
        let blocks: io::Result<Vec<Vec<u8>>> = thread::scope(|scope| {
            let deflated = some.iter().map(|&start| {
                let places = places.as_slice();
                let work = move || {
                    let lines = start..(start + LINES).min(image.height);
                    smaller(block(image, places, lines))
                };
                // Without another thread, this one does it.
                thread::Builder::new()
                    .spawn_scoped(scope, work)
                    .map_err(|_| work())
            });
            let deflated: Vec<_> = deflated.collect();
            let ended = deflated.into_iter().map(|one| match one {
                Ok(thread) => thread.join().unwrap_or_else(|panic| resume_unwind(panic)),
                Err(done) => done,
            });
            ended.collect()
        });
        for (start, bytes) in some.iter().zip(blocks?) {
            write(*start, bytes)?;
        }
    }
    Ok(())
}

/// The place of each channel in a line, by the order of channels.
fn places(order: &[usize]) -> Vec<usize> {
    let mut places = vec![0; order.len()];
    for (place, channel) in order.iter().enumerate() {
        places[*channel] = place;
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
                (quantity.write_samples)(number * image.width + column, &mut samples);
                for (place, sample) in places.iter().zip(&samples) {
                    let at = size_of::<f32>() * (row * line + place * image.width + column);
                    bytes[at..][..size_of::<f32>()].copy_from_slice(&sample.to_le_bytes());
                }
            }
        }
    }
    bytes
}

/// A block deflated, or as it is if that is no shorter.
fn smaller(block: Vec<u8>) -> io::Result<Vec<u8>> {
    // What cannot be deflated grows by a few bytes in 16,384.
    let most = block.len() + block.len() / 1024 + 64;
    let mut encoder = ZlibEncoder::new(Vec::with_capacity(most), Compression::new(LEVEL));
    encoder.write_all(&in_two_halves(&block))?;
    Ok(shorter(encoder.finish()?, block))
}

/// The deflated block if it is shorter. Readers take bytes of the block's length for the block itself.
fn shorter(deflated: Vec<u8>, block: Vec<u8>) -> Vec<u8> {
    if deflated.len() < block.len() {
        deflated
    } else {
        block
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    fn blocks(image: &LazyImage) -> Vec<(usize, Vec<u8>)> {
        let mut blocks = Vec::new();
        deflate(image, &image.order(), |start, bytes| -> io::Result<()> {
            blocks.push((start, bytes));
            Ok(())
        })
        .unwrap();
        blocks
    }

    /// Bytes without any pattern, that a hash makes of their place.
    fn noise(place: usize) -> u8 {
        let mut bits = place as u32;
        for _ in 0..2 {
            bits = (bits ^ (bits >> 15))
                .wrapping_add(1)
                .wrapping_mul(0x85eb_ca6b);
        }
        (bits >> 24) as u8
    }

    #[test]
    fn bytes_of_each_significance_are_stored_as_differences() {
        assert_eq!(in_two_halves(&[7, 1, 9, 1, 8]), [7, 130, 127, 121, 128]);
        assert!(in_two_halves(&[]).is_empty());
    }

    #[test]
    fn noise_is_stored_as_it_is() {
        let block: Vec<u8> = (0..1024).map(noise).collect();
        assert_eq!(smaller(block.clone()).unwrap(), block);
    }

    #[test]
    fn a_block_that_is_deflated_is_shorter() {
        let block = vec![1, 2, 3];
        assert_eq!(shorter(vec![4, 5], block.clone()), [4, 5]);
        assert_eq!(shorter(vec![4, 5, 6], block.clone()), block);
    }

    #[test]
    fn a_block_begins_every_sixteen_lines_and_the_last_one_is_shorter() {
        let mut image = LazyImage::new(3, 35);
        image.add_scalar("row", |texel| (texel / 3) as f64);
        let starts: Vec<usize> = blocks(&image).iter().map(|(start, _)| *start).collect();
        assert_eq!(starts, [0, 16, 32]);
        let (_, last) = blocks(&image).pop().unwrap();
        let rows: Vec<u8> = [32.0_f32, 33.0, 34.0]
            .into_iter()
            .flat_map(|row| [row; 3])
            .flat_map(f32::to_le_bytes)
            .collect();
        assert_eq!(last, smaller(rows).unwrap());
    }
}
