//! Named channels of one size whose samples are computed while they are written.
//!
//! An estimate of eleven layers with bounds takes a kilobyte a texel. Its image, a copy for the encoder and
//! the file's bytes would take as much again, all at once.

use super::Rounding;
use super::image::{Channel, Image, ImageError, check_names, check_size, rgb_names};

/// Writes the samples of a texel as they are in the file, one a channel. Several threads ask for it.
type WriteSamples<'a> = Box<dyn Fn(usize, &mut [f32]) + Sync + 'a>;

/// Channels whose samples are computed together.
pub(super) struct LazyQuantity<'a> {
    /// The names of its channels.
    pub names: Vec<String>,
    pub write_samples: WriteSamples<'a>,
}

/// An image that is nowhere as a whole.
pub struct LazyImage<'a> {
    /// Number of samples a row.
    pub width: usize,
    /// Number of rows.
    pub height: usize,
    pub(super) quantities: Vec<LazyQuantity<'a>>,
    pub(super) metadata: Vec<(String, String)>,
}

impl<'a> LazyImage<'a> {
    /// An image without channels and metadata.
    pub const fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            quantities: Vec::new(),
            metadata: Vec::new(),
        }
    }

    /// Adds a channel; rounds to the nearest `f32`. `value` gives the value of each texel, row by row.
    pub fn add_scalar(
        &mut self,
        name: impl Into<String>,
        value: impl Fn(usize) -> f64 + Sync + 'a,
    ) {
        self.quantities.push(LazyQuantity {
            names: vec![name.into()],
            write_samples: Box::new(move |texel, samples| {
                samples.fill(Rounding::Nearest.apply(value(texel)));
            }),
        });
    }

    /// Adds the channels `layer.R`, `layer.G`, `layer.B`, rounded as given; for an empty `layer` just `R`,
    /// `G`, `B`.
    pub fn add_rgb(
        &mut self,
        layer: &str,
        value: impl Fn(usize) -> [f64; 3] + Sync + 'a,
        rounding: Rounding,
    ) {
        self.quantities.push(LazyQuantity {
            names: rgb_names(layer).collect(),
            write_samples: Box::new(move |texel, samples| {
                samples.copy_from_slice(&value(texel).map(|one| rounding.apply(one)));
            }),
        });
    }

    /// Adds a key and its value.
    pub fn add_metadata(&mut self, key: impl Into<String>, value: impl Into<String>) {
        self.metadata.push((key.into(), value.into()));
    }

    /// The names of its channels.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        let names = self.quantities.iter().flat_map(|one| &one.names);
        names.map(String::as_str)
    }

    /// The numbers of its channels in the order of their names, as a file has them.
    pub(super) fn order(&self) -> Vec<usize> {
        let names: Vec<&str> = self.names().collect();
        let mut order: Vec<usize> = (0..names.len()).collect();
        order.sort_by_key(|channel| names[*channel]);
        order
    }

    /// All its samples at once.
    pub fn to_image(&self) -> Image {
        let texels = self.width * self.height;
        let mut image = Image::new(self.width, self.height);
        image.metadata.clone_from(&self.metadata);
        for LazyQuantity {
            names,
            write_samples,
        } in &self.quantities
        {
            let channels = names.iter().map(|name| Channel {
                name: name.clone(),
                samples: Vec::with_capacity(texels),
            });
            let mut channels: Vec<Channel> = channels.collect();
            let mut samples = vec![0.0; names.len()];
            for texel in 0..texels {
                write_samples(texel, &mut samples);
                for (channel, one) in channels.iter_mut().zip(&samples) {
                    channel.samples.push(*one);
                }
            }
            image.channels.extend(channels);
        }
        image
    }

    /// Checks that a file can hold this image: see [`Image::check`].
    ///
    /// # Errors
    ///
    /// As there; any number of samples can be had.
    pub(super) fn check(&self) -> Result<(), ImageError> {
        check_size(self.width, self.height, self.names().count())?;
        check_names(self.names())?;
        check_names(self.metadata.iter().map(|(key, _)| key.as_str()))
    }
}

impl<'a> From<&'a Image> for LazyImage<'a> {
    /// An image that is there; each of its channels must have all samples.
    fn from(image: &'a Image) -> Self {
        let quantities = image.channels.iter().map(|channel| LazyQuantity {
            names: vec![channel.name.clone()],
            write_samples: Box::new(|texel, samples| samples.fill(channel.samples[texel])),
        });
        Self {
            width: image.width,
            height: image.height,
            quantities: quantities.collect(),
            metadata: image.metadata.clone(),
        }
    }
}
