//! Named channels of one size whose samples are computed while they are written.
//!
//! An estimate of eleven layers with bounds takes a kilobyte a texel. Its image, a copy for the encoder and
//! the file's bytes would take as much again, all at once.

use super::Rounding;
use super::image::{Channel, Image, ImageError, check_names, check_size, rgb_names};

/// A channel's sample in a texel, as it is in the file. It is asked for from several threads.
pub(super) type Sample<'a> = Box<dyn Fn(usize) -> f32 + Sync + 'a>;

/// An image that is nowhere as a whole.
pub struct LazyImage<'a> {
    /// Number of samples a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    pub(super) channels: Vec<(String, Sample<'a>)>,
    pub(super) metadata: Vec<(String, String)>,
}

impl<'a> LazyImage<'a> {
    /// An image without channels and metadata.
    pub const fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            channels: Vec::new(),
            metadata: Vec::new(),
        }
    }

    /// Adds a channel; rounds to the nearest `f32`. `value` gives the value of each texel, row by row.
    pub fn add_scalar(
        &mut self,
        name: impl Into<String>,
        value: impl Fn(usize) -> f64 + Sync + 'a,
    ) {
        let sample = move |texel| Rounding::Nearest.apply(value(texel));
        self.channels.push((name.into(), Box::new(sample)));
    }

    /// Adds the channels `layer.R`, `layer.G`, `layer.B`, rounded as given; for an empty `layer` just `R`,
    /// `G`, `B`.
    pub fn add_rgb(
        &mut self,
        layer: &str,
        value: impl Fn(usize) -> [f64; 3] + Copy + Sync + 'a,
        rounding: Rounding,
    ) {
        for (c, name) in rgb_names(layer).enumerate() {
            let sample = move |texel| rounding.apply(value(texel)[c]);
            self.channels.push((name, Box::new(sample)));
        }
    }

    /// Adds a key and its value.
    pub fn add_metadata(&mut self, key: impl Into<String>, value: impl Into<String>) {
        self.metadata.push((key.into(), value.into()));
    }

    /// All its samples at once.
    pub fn to_image(&self) -> Image {
        let texels = self.width * self.height;
        let channels = self.channels.iter().map(|(name, sample)| Channel {
            name: name.clone(),
            samples: (0..texels).map(sample).collect(),
        });
        Image {
            width: self.width,
            height: self.height,
            channels: channels.collect(),
            metadata: self.metadata.clone(),
        }
    }

    /// Checks that a file can hold this image: see [`Image::check`].
    ///
    /// # Errors
    ///
    /// As there; any number of samples can be had.
    pub(super) fn check(&self) -> Result<(), ImageError> {
        check_size(self.width, self.height, self.channels.len())?;
        check_names(self.channels.iter().map(|(name, _)| name.as_str()))?;
        check_names(self.metadata.iter().map(|(key, _)| key.as_str()))
    }
}

impl<'a> From<&'a Image> for LazyImage<'a> {
    /// An image that is there; each of its channels must have all samples.
    fn from(image: &'a Image) -> Self {
        let channels = image.channels.iter().map(|channel| {
            let sample = |texel: usize| channel.samples[texel];
            (channel.name.clone(), Box::new(sample) as Sample<'a>)
        });
        Self {
            width: image.width,
            height: image.height,
            channels: channels.collect(),
            metadata: image.metadata.clone(),
        }
    }
}
