//! Accumulators as bytes, in which the shards of a run pass on their sums.

use std::io::{BufRead, BufWriter, IntoInnerError, Read as _, Write};
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use flate2::Compression;
use flate2::bufread::GzDecoder;
use flate2::write::GzEncoder;
use rayon::prelude::*;

use super::sums::{Accumulator, AccumulatorError, zeros};
use crate::numeric::FixedPoint;
use crate::numeric::wide::Wide;

/// The first bytes of a written accumulator, version included.
const MAGIC: [u8; 8] = *b"nphACC\x00\x01";

/// Bytes that are deflated at once.
const BLOCK: usize = 1 << 16;

/// The start of a written accumulator after its magic bytes, little-endian.
struct AccumulatorHeader {
    texels: u64,
    channels: u32,
    has_counts: u32,
    exponent: i32,
    replicates: u32,
}

impl AccumulatorHeader {
    const LENGTH: usize = 24;

    fn to_bytes(&self) -> Vec<u8> {
        let mut bytes = Vec::with_capacity(Self::LENGTH);
        bytes.extend(self.texels.to_le_bytes());
        bytes.extend(self.channels.to_le_bytes());
        bytes.extend(self.has_counts.to_le_bytes());
        bytes.extend(self.exponent.to_le_bytes());
        bytes.extend(self.replicates.to_le_bytes());
        bytes
    }

    fn from_bytes(bytes: &[u8; Self::LENGTH]) -> Self {
        let word = |i: usize| [bytes[i], bytes[i + 1], bytes[i + 2], bytes[i + 3]];
        let low = u64::from(u32::from_le_bytes(word(0)));
        let high = u64::from(u32::from_le_bytes(word(4)));
        Self {
            texels: high << 32 | low,
            channels: u32::from_le_bytes(word(8)),
            has_counts: u32::from_le_bytes(word(12)),
            exponent: i32::from_le_bytes(word(16)),
            replicates: u32::from_le_bytes(word(20)),
        }
    }

    /// Length in bytes of ΣS, ΣS² and counts; `None` if no memory could hold them.
    fn body_length(&self) -> Option<usize> {
        let texels = usize::try_from(self.texels).ok()?;
        let sums = texels
            .checked_mul(self.channels as usize)?
            .checked_mul(32)?;
        sums.checked_add(texels.checked_mul(8 * self.has_counts as usize)?)
    }
}

impl Accumulator {
    /// Writes the sums: magic bytes, then a header, ΣS, ΣS² and counts, little-endian, as gzip.
    ///
    /// # Errors
    ///
    /// If a replicate is under way, or the writer fails.
    pub fn write_to(&self, mut writer: impl Write) -> Result<(), AccumulatorError> {
        if self.is_under_way() {
            return Err(AccumulatorError::ReplicateUnderWay);
        }
        let header = AccumulatorHeader {
            texels: self.texels as u64,
            channels: self.channels as u32,
            has_counts: self.counts.is_some().into(),
            exponent: self.scale.exponent(),
            replicates: self.replicates,
        };
        writer.write_all(&MAGIC)?;
        // In blocks: the encoder clears all of its buffer at each call.
        let encoder = GzEncoder::new(writer, Compression::fast());
        let mut encoder = BufWriter::with_capacity(BLOCK, encoder);
        encoder.write_all(&header.to_bytes())?;
        for sum in &self.sums {
            encoder.write_all(&sum.to_le_bytes())?;
        }
        for sum in &self.sums_of_squares {
            encoder.write_all(&sum.to_le_bytes())?;
        }
        for count in self.counts.iter().flatten() {
            encoder.write_all(&count.load(Ordering::Relaxed).to_le_bytes())?;
        }
        let encoder = encoder.into_inner().map_err(IntoInnerError::into_error)?;
        encoder.finish()?.flush()?;
        Ok(())
    }

    /// Reads the output of [`Accumulator::write_to`] and checks it, its CRC-32 included.
    ///
    /// Memory grows with the bytes read, not with the size that the header claims.
    ///
    /// # Errors
    ///
    /// If the bytes are not a written accumulator, or the reader fails.
    pub fn read_from(mut reader: impl BufRead) -> Result<Self, AccumulatorError> {
        let malformed = |message: &str| AccumulatorError::Malformed(message.to_owned());
        let mut magic = [0; MAGIC.len()];
        reader.read_exact(&mut magic)?;
        if magic != MAGIC {
            return Err(malformed("wrong magic bytes or version"));
        }
        let mut decoder = GzDecoder::new(reader);
        let mut bytes = [0; AccumulatorHeader::LENGTH];
        decoder.read_exact(&mut bytes)?;
        let header = AccumulatorHeader::from_bytes(&bytes);
        if ![1, 3].contains(&header.channels) {
            return Err(AccumulatorError::Malformed(format!(
                "{} channels: allowed are 1 and 3",
                header.channels
            )));
        }
        if header.has_counts > 1 {
            return Err(malformed("the flag for counts is neither 0 nor 1"));
        }
        let scale = FixedPoint::new(header.exponent)
            .map_err(|error| AccumulatorError::Malformed(error.to_string()))?;
        let expected = header
            .body_length()
            .ok_or_else(|| malformed("too many texels"))?;
        let mut body = Vec::new();
        decoder
            .take((expected as u64).saturating_add(1))
            .read_to_end(&mut body)?;
        if body.len() != expected {
            return Err(malformed("the sums are more or fewer than the header says"));
        }
        Self::from_parts(&header, scale, &body)
            .ok_or_else(|| malformed("sums that no replicates can have"))
    }

    /// The sums in `body`. `None` if R ΣS² < (ΣS)², which contradicts Cauchy and Schwarz, or if anything is
    /// not zero without replicates.
    fn from_parts(header: &AccumulatorHeader, scale: FixedPoint, body: &[u8]) -> Option<Self> {
        let texels = header.texels as usize;
        let channels = header.channels as usize;
        let (sums, rest) = body.split_at(16 * texels * channels);
        let (squares, counts) = rest.split_at(16 * texels * channels);
        let sums = words(sums, i128::from_le_bytes);
        let sums_of_squares = words(squares, u128::from_le_bytes);
        let possible = sums
            .par_iter()
            .zip(&sums_of_squares)
            .all(|(sum, &squares)| {
                let squared_sum = Wide::product(sum.unsigned_abs(), sum.unsigned_abs());
                Wide::product(squares, header.replicates.into()) >= squared_sum
                    && (header.replicates > 0 || squares == 0)
            });
        let counts = (header.has_counts == 1)
            .then(|| words(counts, |bytes| AtomicU64::new(u64::from_le_bytes(bytes))));
        possible.then(|| Self {
            texels,
            channels,
            scale,
            replicates: header.replicates,
            current: zeros(sums.len()),
            current_overflowed: AtomicBool::new(false),
            sums,
            sums_of_squares,
            counts,
        })
    }
}

/// The words of `LENGTH` bytes that `bytes` holds.
fn words<const LENGTH: usize, T>(bytes: &[u8], word: impl Fn([u8; LENGTH]) -> T) -> Vec<T> {
    bytes
        .as_chunks()
        .0
        .iter()
        .map(|&bytes| word(bytes))
        .collect()
}
