//! `OpenEXR` files: one part, `f32` channels with dotted names, lossless.
//!
//! One part, since Mitsuba and others read only the first. Viewers show channel names like `LTTD.stderr.R` as
//! layers. The same image gives the same bytes on any machine and number of threads.

use std::fs::File;
use std::io::{self, BufWriter, Cursor, Read as _, Seek as _, Write as _};
use std::path::{Path, PathBuf};

use ::exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock};
use ::exr::block::write as write_blocks;
use ::exr::block::writer::ChunksWriter as _;
use ::exr::error::{Error::Invalid, UnitResult};
use ::exr::meta::BlockDescription;
use ::exr::meta::attribute::SampleType;
use ::exr::meta::header::Header;
use ::exr::prelude::{
    AnyChannels, AttributeValue, ChannelDescription, Compression, FlatSamples, Layer,
    LayerAttributes, LineOrder, MetaData, ReadChannels as _, ReadLayers as _, Text, Vec2,
    read as read_exr,
};

use super::atomic::{self, WriteError};
use super::exr_blocks;
use super::image::{Channel, Image, ImageError};
use super::lazy::LazyImage;

pub use super::exr_blocks::encoding_bytes;

/// Prefix of this program's attributes in a file.
const PREFIX: &str = "nephroid:";

/// Bytes of samples allowed for a byte of file; one that claims more is damaged or made to exhaust memory.
///
/// This is the most that each compression reaches for an image of one colour. Two bytes of RLE stand for 128,
/// zlib shrinks to 1/1032, B44 to 14 and B44A to 3 bytes for 16 halves. PIZ's Huffman code has a run of 255
/// numbers of 16 bits in 9 bits at least, which is 1/453.
fn max_expansion(compression: Compression) -> u64 {
    match compression {
        Compression::Uncompressed => 1,
        Compression::RLE => 64,
        Compression::B44 | Compression::B44A => 11,
        // PXR24 leaves out a byte in four before it is deflated.
        Compression::ZIP1 | Compression::ZIP16 | Compression::PXR24 => 1376,
        _ => 454,
    }
}

/// Smallest size of a block in bytes: 8 in the table of blocks, its line and length, and a byte.
const LEAST_BLOCK: usize = 17;

/// Reason why an image was not written.
///
/// # Example: a folder that cannot be
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
/// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
/// // A file cannot hold another file.
/// let error = rendering.write_exr(&scene, "Cargo.toml/light.exr".as_ref()).unwrap_err();
/// assert!(error.to_string().contains("Cargo.toml"));
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, thiserror::Error)]
pub enum ExrWriteError {
    /// Channels that do not make an image.
    #[error("cannot write {}: {cause}", path.display())]
    Image {
        /// The file that was to be written.
        path: PathBuf,
        /// The defect of the image.
        #[doc(hidden)]
        cause: ImageError,
    },
    /// The encoder refused.
    #[error("cannot encode {}: {message}", path.display())]
    Encode {
        /// The file that was to be written.
        path: PathBuf,
        /// The encoder's message.
        message: String,
    },
    /// The system refused.
    #[error(transparent)]
    Write(
        #[doc(hidden)]
        #[from]
        WriteError,
    ),
}

/// Reason why an image was not read.
///
/// # Example: a file that is no image
///
/// ```
/// let error = nephroid::read_exr("Cargo.toml".as_ref()).unwrap_err();
/// assert_eq!(error.path.as_os_str(), "Cargo.toml");
/// println!("{error}");
/// ```
#[derive(Debug, thiserror::Error)]
#[error("cannot read {}: {message}", path.display())]
pub struct ExrReadError {
    /// The file.
    pub path: PathBuf,
    /// A description of its defect.
    pub message: String,
}

/// Writes an image, whole or not at all: ZIP in blocks of 16 lines, channels sorted by name, metadata as
/// string attributes `nephroid:key`.
///
/// # Errors
///
/// If [`Image::check`] fails or the file cannot be written; the former content of `path` stays.
pub fn write(path: &Path, image: &Image) -> Result<(), ExrWriteError> {
    image.check().map_err(|cause| ExrWriteError::Image {
        path: path.to_owned(),
        cause,
    })?;
    write_lazily(path, &LazyImage::from(image))
}

/// Writes an image as [`write()`] does, computing its samples block by block. Only the blocks that are being
/// deflated are in memory.
///
/// # Errors
///
/// As there.
pub fn write_lazily(path: &Path, image: &LazyImage) -> Result<(), ExrWriteError> {
    image.check().map_err(|cause| ExrWriteError::Image {
        path: path.to_owned(),
        cause,
    })?;
    let mut refusal = None;
    let written = atomic::write(path, |file| {
        encode(image, file).map_err(|error| match error {
            ::exr::error::Error::Io(cause) => cause,
            other => {
                refusal = Some(other.to_string());
                io::ErrorKind::InvalidData.into()
            }
        })
    });
    match refusal {
        Some(message) => Err(ExrWriteError::Encode {
            path: path.to_owned(),
            message,
        }),
        None => Ok(written?),
    }
}

/// Reads the channels of a file of one part; whole numbers and half floats become `f32`.
///
/// `metadata` holds the attributes `nephroid:key`, without their prefix, sorted by key. Data windows that do
/// not start at the origin are moved there.
///
/// # Errors
///
/// If the file is missing, damaged, of several parts, deep, subsampled, or claims more samples than its
/// length can hold.
///
/// # Example: the values of one channel
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
/// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
/// let path = std::env::temp_dir().join("nephroid-read-exr.exr");
/// rendering.write_exr(&scene, &path)?;
/// let image = nephroid::read_exr(&path)?;
/// let red = image.channel("LTTD.R").ok_or("no light through the ball")?;
/// assert_eq!(red.samples.len(), 8 * 8);
/// # std::fs::remove_file(&path)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn read(path: &Path) -> Result<Image, ExrReadError> {
    let failed = |message| ExrReadError {
        path: path.to_owned(),
        message,
    };
    let bytes = std::fs::read(path).map_err(|error| failed(error.to_string()))?;
    parse(path, &bytes)
}

/// The image in a file's bytes, for whoever does more with them than read it: a file may change or vanish
/// before it is read again. The path is for messages.
///
/// # Errors
///
/// As [`read`].
pub fn parse(path: &Path, bytes: &[u8]) -> Result<Image, ExrReadError> {
    decode(bytes, |_, _| Ok(())).map_err(|message| ExrReadError {
        path: path.to_owned(),
        message,
    })
}

fn text(string: &str) -> Text {
    // Not `Text::from`, which takes Latin-1 only: EXR's strings are bytes, and UTF-8 by custom.
    Text::from_slice_unchecked(string.as_bytes())
}

fn encode(image: &LazyImage, file: &mut BufWriter<&File>) -> UnitResult {
    let mut attributes = LayerAttributes::default();
    for (key, value) in &image.metadata {
        let name = text(&format!("{PREFIX}{key}"));
        attributes
            .other
            .insert(name, AttributeValue::Text(text(value)));
    }
    let names: Vec<&str> = image.names().collect();
    let order = image.order();
    let sorted = order.iter().map(|channel| names[*channel]);
    let channels = sorted.map(|name| ChannelDescription::named(text(name), SampleType::F32));
    let size = Vec2(image.width, image.height);
    let header = Header::new(Text::default(), size, channels.collect())
        .with_encoding(
            Compression::ZIP16,
            BlockDescription::ScanLines,
            LineOrder::Increasing,
        )
        .with_attributes(attributes);
    let headers = std::iter::once(header).collect();
    write_blocks(&mut *file, headers, true, |_, chunks| {
        exr_blocks::deflate(image, &order, |start, bytes| {
            let block = CompressedScanLineBlock {
                y_coordinate: i32::try_from(start)
                    .map_err(|_| Invalid("a line beyond 2³¹".into()))?,
                compressed_pixels_le: bytes,
            };
            let chunk = Chunk {
                layer_index: 0,
                compressed_block: CompressedBlock::ScanLine(block),
            };
            chunks.write_chunk(start / exr_blocks::LINES, chunk)
        })
    })?;
    sort_header(file)
}

/// Sorts the attributes in the header of a file that was just written.
fn sort_header(file: &mut BufWriter<&File>) -> UnitResult {
    file.flush()?;
    let mut file: &File = file.get_ref();
    // The header's length is not known: as much as is needed is read.
    let mut bytes = Vec::new();
    let mut length = 1 << 16;
    loop {
        file.rewind()?;
        bytes.clear();
        file.take(length).read_to_end(&mut bytes)?;
        if sort_attributes(&mut bytes).is_some() {
            break;
        }
        if (bytes.len() as u64) < length {
            return Err(Invalid("header without an end".into()));
        }
        length *= 4;
    }
    file.rewind()?;
    Ok(file.write_all(&bytes)?)
}

/// Sorts a header's attributes by name, as `OpenEXR`'s own library writes them; `None` if the header does not
/// end within the bytes, which then stay as they are.
///
/// The crate keeps attributes in a `HashMap`, whose order changes from run to run. The header's
/// length, and so each block's position in the file, stays the same.
fn sort_attributes(file: &mut [u8]) -> Option<()> {
    const MAGIC_AND_VERSION: usize = 8;
    let mut attributes = Vec::new();
    let mut start = MAGIC_AND_VERSION;
    while *file.get(start)? != 0 {
        let end_of = |from: usize| Some(from + file.get(from..)?.iter().position(|&b| b == 0)?);
        let end_of_name = end_of(start)?;
        let end_of_type = end_of(end_of_name + 1)?;
        let size = file.get(end_of_type + 1..end_of_type + 5)?;
        let size = u32::from_le_bytes([size[0], size[1], size[2], size[3]]) as usize;
        let end = end_of_type + 5 + size;
        attributes.push((
            file[start..end_of_name].to_vec(),
            file.get(start..end)?.to_vec(),
        ));
        start = end;
    }
    attributes.sort();
    let sorted = attributes.into_iter().flat_map(|(_, bytes)| bytes);
    for (place, byte) in file[MAGIC_AND_VERSION..start].iter_mut().zip(sorted) {
        *place = byte;
    }
    Some(())
}

/// Reads an image whose width and height pass a check, which comes before memory is taken for them.
pub(super) fn decode(
    bytes: &[u8],
    check_size: impl FnOnce(u64, u64) -> Result<(), String>,
) -> Result<Image, String> {
    let header = MetaData::read_from_buffered(bytes, false).map_err(|error| error.to_string())?;
    let [part] = header.headers.as_slice() else {
        return Err(format!("{} parts: allowed is one", header.headers.len()));
    };
    if part.deep {
        return Err("deep samples: allowed are flat ones".to_owned());
    }
    let Vec2(width, height) = part.layer_size;
    // Numbers of 2 or 4 bytes.
    let texel: usize = part
        .channels
        .list
        .iter()
        .map(|c| c.sample_type.bytes_per_sample())
        .sum();
    let needed = (width as u64)
        .saturating_mul(height as u64)
        .saturating_mul(texel as u64);
    // Each block has a place in a table, a header and contents.
    let is_too_large = needed / max_expansion(part.compression) > bytes.len() as u64
        || part.chunk_count > bytes.len() / LEAST_BLOCK;
    if is_too_large {
        return Err(format!(
            "damaged: claims {width} x {height} texels of {} channels in a file of {} bytes",
            part.channels.list.len(),
            bytes.len()
        ));
    }
    check_size(width as u64, height as u64)?;
    if let Some(channel) = part.channels.list.iter().find(|c| c.sampling != Vec2(1, 1)) {
        return Err(format!(
            "channel `{}` is subsampled: allowed are full ones",
            channel.name
        ));
    }
    let image = read_exr()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(|error| error.to_string())?;
    Ok(from_layer(image.layer_data))
}

fn from_layer(layer: Layer<AnyChannels<FlatSamples>>) -> Image {
    let mut image = Image::new(layer.size.0, layer.size.1);
    for channel in layer.channel_data.list {
        let name = String::from_utf8_lossy(channel.name.as_slice()).into_owned();
        let samples = match channel.sample_data {
            FlatSamples::F32(samples) => samples,
            other => other.values_as_f32().collect(),
        };
        image.channels.push(Channel { name, samples });
    }
    for (name, value) in layer.attributes.other {
        let name = String::from_utf8_lossy(name.as_slice()).into_owned();
        if let (Some(key), AttributeValue::Text(value)) = (name.strip_prefix(PREFIX), value) {
            let value = String::from_utf8_lossy(value.as_slice()).into_owned();
            image.metadata.push((key.to_owned(), value));
        }
    }
    image.metadata.sort();
    image
}
