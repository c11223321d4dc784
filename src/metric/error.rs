//! Reasons why two images cannot be compared.

/// Reason why two images cannot be compared. Files are named as the caller names them.
///
/// # Example: images of different size
///
/// ```
/// use nephroid::{CompareError, CompareImage, CompareSettings, Image, compare};
///
/// let image = |side: usize| {
///     let mut image = Image::new(side, side);
///     image.add_rgb("E", &vec![[1.0; 3]; side * side]);
///     CompareImage::new("image", image)
/// };
/// let error = compare(&image(2), &image(3), &CompareSettings::default()).unwrap_err();
/// assert!(matches!(error, CompareError::Size { .. }));
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum CompareError {
    /// Images of different size.
    #[error("{file} has {} x {} texels, {other} has {} x {}: they must be the same", size[0], size[1], other_size[0], other_size[1])]
    Size {
        /// One file.
        file: String,
        /// Its texels a row and rows.
        size: [usize; 2],
        /// The other file.
        other: String,
        /// Its texels a row and rows.
        other_size: [usize; 2],
    },
    /// No image in the file.
    #[error(
        "{file}: no layer of all light: allowed are channels E.R E.G E.B, L.R L.G L.B, R G B, or Y; found are {channels}"
    )]
    NoTotal {
        /// The file.
        file: String,
        /// Its channels.
        channels: String,
    },
    /// Irradiance beside radiance.
    #[error("{file} holds {quantity}, {other} holds {other_quantity}: they cannot be compared")]
    Quantity {
        /// One file.
        file: String,
        /// Its layer of all light.
        quantity: String,
        /// The other file.
        other: String,
        /// Its layer of all light.
        other_quantity: String,
    },
    /// A layer with other channels in one file than in the other.
    #[error("layer {layer} has channels {channels} in {file}, but {other_channels} in {other}")]
    Channels {
        /// The layer.
        layer: String,
        /// One file.
        file: String,
        /// Its channels.
        channels: String,
        /// The other file.
        other: String,
        /// Its channels.
        other_channels: String,
    },
    /// A requested layer that is not in both.
    #[error("layer \"{layer}\" is not in both images; those in both are {there}")]
    NoLayer {
        /// The name.
        layer: String,
        /// The layers in both.
        there: String,
    },
    /// A value that is NaN or infinite.
    #[error("{file}: channel {channel} is {value} at pixel ({x}, {y}): allowed are finite numbers")]
    NotFinite {
        /// The file.
        file: String,
        /// The channel.
        channel: String,
        /// Column.
        x: usize,
        /// Row.
        y: usize,
        /// The value there.
        value: f32,
    },
    /// A standard error below zero.
    #[error(
        "{file}: channel {channel}, a standard error or variance, is {value} at pixel ({x}, {y}): allowed are numbers >= 0"
    )]
    NegativeError {
        /// The file.
        file: String,
        /// The channel.
        channel: String,
        /// Column.
        x: usize,
        /// Row.
        y: usize,
        /// The value there.
        value: f32,
    },
    /// A lower bound above the upper.
    #[error("{file}: channel {channel} is {low} at pixel ({x}, {y}), above its upper bound {high}")]
    Bounds {
        /// The file.
        file: String,
        /// The lower bound's channel.
        channel: String,
        /// Column.
        x: usize,
        /// Row.
        y: usize,
        /// The lower bound.
        low: f32,
        /// The upper bound.
        high: f32,
    },
    /// A separate image of errors without the channels expected.
    #[error("{file}: no errors of layer {layer}: expected are channels {expected}")]
    NoErrors {
        /// The file.
        file: String,
        /// The layer of the image.
        layer: String,
        /// The channels expected.
        expected: String,
    },
    /// Second moments without the number of samples that they are of.
    #[error(
        "{file} has second moments ({channel}): say how many samples each pixel has, at least 2"
    )]
    Samples {
        /// The file.
        file: String,
        /// A channel of moments.
        channel: String,
    },
    /// A part that is not in the image.
    #[error("a window of {} x {} texels at ({}, {}) is not within {} x {}", size[0], size[1], corner[0], corner[1], image[0], image[1])]
    Window {
        /// Its upper left texel.
        corner: [usize; 2],
        /// Its texels a row and rows.
        size: [usize; 2],
        /// The image's.
        image: [usize; 2],
    },
}
