//! Named channels of one size, as a file holds them.

use super::Grid;

/// Named `f32` channels of one size, and what is to be known of them.
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Samples a row.
    pub width: usize,
    /// Rows; row 0 is the first in the file and the top of the picture.
    pub height: usize,
    /// In any order; a file holds them sorted by name.
    pub channels: Vec<Channel>,
    /// Keys and values, all of them text; a file holds them sorted by key.
    pub metadata: Vec<(String, String)>,
}

/// One named channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Layer and component joined by dots: `E.R`, `LTTD.stderr.G`.
    pub name: String,
    /// Row by row.
    pub samples: Vec<f32>,
}

/// Why channels do not make an image.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// Nothing to see.
    #[error(
        "an image of {width} x {height} texels: allowed are 1..={} each way",
        Image::MAX_SIZE
    )]
    Size {
        /// Samples a row.
        width: usize,
        /// Rows.
        height: usize,
    },
    /// No channel at all.
    #[error("an image needs at least one channel")]
    NoChannel,
    /// A channel with too many or too few samples.
    #[error("channel `{name}` has {found} samples where width x height is {expected}")]
    SampleCount {
        /// The channel's name.
        name: String,
        /// How many samples it has.
        found: usize,
        /// How many it should have.
        expected: usize,
    },
    /// A name that a file cannot hold.
    #[error("name `{0}`: allowed are 1..={max} bytes without NUL", max = Image::MAX_NAME_LENGTH)]
    Name(String),
    /// A name given twice.
    #[error("name `{0}` is given twice")]
    Duplicate(String),
}

impl Image {
    /// The largest width and height.
    pub const MAX_SIZE: usize = 1 << 20;
    /// The longest name of a channel or key in bytes: EXR's 255 less a prefix.
    pub const MAX_NAME_LENGTH: usize = 240;

    /// An image without channels and metadata.
    pub const fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            channels: Vec::new(),
            metadata: Vec::new(),
        }
    }

    /// Adds a channel; rounds to `f32`.
    pub fn add_scalar(&mut self, name: impl Into<String>, values: impl IntoIterator<Item = f64>) {
        self.channels.push(Channel {
            name: name.into(),
            samples: values.into_iter().map(|value| value as f32).collect(),
        });
    }

    /// Adds the channels `layer.R`, `layer.G`, `layer.B`; for an empty `layer` just `R`, `G`, `B`.
    /// Rounds to `f32`.
    pub fn add_rgb(&mut self, layer: &str, values: &[[f64; 3]]) {
        let dot = if layer.is_empty() { "" } else { "." };
        for (c, component) in ["R", "G", "B"].into_iter().enumerate() {
            let name = format!("{layer}{dot}{component}");
            self.add_scalar(name, values.iter().map(|value| value[c]));
        }
    }

    /// Adds what is to be known.
    pub fn add_metadata(&mut self, key: impl Into<String>, value: impl Into<String>) {
        self.metadata.push((key.into(), value.into()));
    }

    /// The channel of a name.
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// The channel of a name as a grid.
    pub fn grid(&self, name: &str) -> Option<Grid<f32>> {
        let channel = self.channel(name)?;
        Grid::from_vec(self.width, self.height, channel.samples.clone())
    }

    /// The value of a key.
    pub fn metadata(&self, key: &str) -> Option<&str> {
        self.metadata
            .iter()
            .find(|(k, _)| k == key)
            .map(|(_, value)| value.as_str())
    }

    /// Checks that a file can hold this image.
    ///
    /// # Errors
    ///
    /// For a size of zero or beyond [`Image::MAX_SIZE`], no channel, a channel with too many or
    /// too few samples, and names that are empty, too long, given twice or hold a NUL.
    pub fn check(&self) -> Result<(), ImageError> {
        let sizes = 1..=Self::MAX_SIZE;
        if !sizes.contains(&self.width) || !sizes.contains(&self.height) {
            return Err(ImageError::Size {
                width: self.width,
                height: self.height,
            });
        }
        if self.channels.is_empty() {
            return Err(ImageError::NoChannel);
        }
        let expected = self.width * self.height;
        for channel in &self.channels {
            if channel.samples.len() != expected {
                return Err(ImageError::SampleCount {
                    name: channel.name.clone(),
                    found: channel.samples.len(),
                    expected,
                });
            }
        }
        check_names(self.channels.iter().map(|channel| channel.name.as_str()))?;
        check_names(self.metadata.iter().map(|(key, _)| key.as_str()))
    }
}

fn check_names<'a>(names: impl Iterator<Item = &'a str>) -> Result<(), ImageError> {
    let mut seen = std::collections::HashSet::new();
    for name in names {
        if name.is_empty() || name.len() > Image::MAX_NAME_LENGTH || name.contains('\0') {
            return Err(ImageError::Name(name.to_owned()));
        }
        if !seen.insert(name) {
            return Err(ImageError::Duplicate(name.to_owned()));
        }
    }
    Ok(())
}
