//! Named channels of one size, as in a file.

use super::Grid;

/// Named `f32` channels of one size, and their metadata.
///
/// # Example: an image of one's own, to compare with
///
/// ```
/// let mut image = nephroid::Image::new(2, 1);
/// image.add_rgb("E", &[[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]]);
/// image.add_metadata("unit", "W/m²");
/// assert_eq!(image.channel("E.G").unwrap().samples, [2.0, 5.0]);
/// assert_eq!(image.metadata("unit"), Some("W/m²"));
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Image {
    /// Number of samples a row.
    pub width: usize,
    /// Number of rows; row 0 is the first in the file and the top of the picture.
    pub height: usize,
    /// The channels, in any order; a file holds them sorted by name.
    pub channels: Vec<Channel>,
    /// Keys and values, all of them text; a file holds them sorted by key.
    pub metadata: Vec<(String, String)>,
}

/// One named channel.
///
/// # Example: the brightest texel
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
/// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
/// let image = rendering.image(&scene);
/// let green = image.channel("E.G").ok_or("no green")?;
/// let brightest = green.samples.iter().copied().fold(0.0, f32::max);
/// assert!(brightest > 1.0);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Channel {
    /// Layer and component joined by dots: `E.R`, `LTTD.stderr.G`.
    pub name: String,
    /// Row by row.
    pub samples: Vec<f32>,
}

/// The rounding of a number to the `f32` of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Rounding {
    /// The nearest `f32`: for values.
    Nearest,
    /// The largest `f32` that is not above: for lower bounds.
    Down,
    /// The smallest `f32` that is not below: for upper bounds.
    Up,
}

impl Rounding {
    /// A number as `f32`; NaN stays NaN.
    pub fn apply(self, value: f64) -> f32 {
        let nearest = value as f32;
        let found = f64::from(nearest);
        match self {
            Self::Down if found > value => nearest.next_down(),
            Self::Up if found < value => nearest.next_up(),
            _ => nearest,
        }
    }
}

/// Reason why channels do not make an image.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ImageError {
    /// A width or height out of range.
    #[error(
        "an image of {width} x {height} texels: allowed are 1..={} each way",
        Image::MAX_SIZE
    )]
    Size {
        /// Number of samples a row.
        width: usize,
        /// Number of rows.
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
        /// Number of its samples.
        found: usize,
        /// Number of samples that it should have.
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
    pub(crate) const MAX_SIZE: usize = 1 << 20;
    /// The longest name of a channel or key in bytes: EXR's 255 less a prefix.
    pub(crate) const MAX_NAME_LENGTH: usize = 240;

    /// An image without channels and metadata.
    ///
    /// # Example: a film of 4 x 3 texels
    ///
    /// ```
    /// let image = nephroid::Image::new(4, 3);
    /// assert!(image.channels.is_empty());
    /// ```
    pub const fn new(width: usize, height: usize) -> Self {
        Self {
            width,
            height,
            channels: Vec::new(),
            metadata: Vec::new(),
        }
    }

    /// Adds a channel; rounds to the nearest `f32`.
    ///
    /// # Example: a map of distances
    ///
    /// ```
    /// let mut image = nephroid::Image::new(2, 1);
    /// image.add_scalar("distance.Y", [0.5, 1.5]);
    /// assert_eq!(image.channels[0].samples, [0.5, 1.5]);
    /// ```
    pub fn add_scalar(&mut self, name: impl Into<String>, values: impl IntoIterator<Item = f64>) {
        let samples = values
            .into_iter()
            .map(|value| Rounding::Nearest.apply(value));
        self.channels.push(Channel {
            name: name.into(),
            samples: samples.collect(),
        });
    }

    /// Adds the channels `layer.R`, `layer.G`, `layer.B`; for an empty `layer` just `R`, `G`, `B`.
    /// Rounds to the nearest `f32`.
    ///
    /// # Example: light with its error bar
    ///
    /// ```
    /// let mut image = nephroid::Image::new(1, 1);
    /// image.add_rgb("E", &[[1.0; 3]]);
    /// image.add_rgb("E.stderr", &[[0.01; 3]]);
    /// assert_eq!(image.channels[3].name, "E.stderr.R");
    /// ```
    pub fn add_rgb(&mut self, layer: &str, values: &[[f64; 3]]) {
        for (c, name) in rgb_names(layer).enumerate() {
            self.add_scalar(name, values.iter().map(|value| value[c]));
        }
    }

    /// Adds a key and its value.
    ///
    /// # Example: the name of the program
    ///
    /// ```
    /// let mut image = nephroid::Image::new(1, 1);
    /// image.add_metadata("program", "mine");
    /// assert_eq!(image.metadata[0].0, "program");
    /// ```
    pub fn add_metadata(&mut self, key: impl Into<String>, value: impl Into<String>) {
        self.metadata.push((key.into(), value.into()));
    }

    /// The channel of a name.
    ///
    /// # Example: a layer that may be missing
    ///
    /// ```
    /// let image = nephroid::Image::new(1, 1);
    /// assert!(image.channel("LTTD.R").is_none());
    /// ```
    pub fn channel(&self, name: &str) -> Option<&Channel> {
        self.channels.iter().find(|channel| channel.name == name)
    }

    /// The channel of a name as a grid.
    #[doc(hidden)]
    pub fn grid(&self, name: &str) -> Option<Grid<f32>> {
        let channel = self.channel(name)?;
        Grid::from_vec(self.width, self.height, channel.samples.clone())
    }

    /// The value of a key.
    ///
    /// # Example: the settings behind a rendering
    ///
    /// ```
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
    /// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
    /// let image = rendering.image(&scene);
    /// assert_eq!(image.metadata("complete"), Some("yes"));
    /// assert_eq!(image.metadata("quantity"), Some("irradiance"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
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
    /// For a size of zero or beyond [`Image::MAX_SIZE`], no channel, a channel with too many or too few
    /// samples, and names that are empty, too long, given twice or hold a NUL.
    #[doc(hidden)]
    pub fn check(&self) -> Result<(), ImageError> {
        check_size(self.width, self.height, self.channels.len())?;
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

/// The names of a layer's channels; for an empty `layer` just `R`, `G`, `B`.
pub(super) fn rgb_names(layer: &str) -> impl Iterator<Item = String> {
    let dot = if layer.is_empty() { "" } else { "." };
    ["R", "G", "B"]
        .map(|component| format!("{layer}{dot}{component}"))
        .into_iter()
}

/// Checks the size and the number of channels.
pub(super) fn check_size(width: usize, height: usize, channels: usize) -> Result<(), ImageError> {
    let sizes = 1..=Image::MAX_SIZE;
    if !sizes.contains(&width) || !sizes.contains(&height) {
        return Err(ImageError::Size { width, height });
    }
    if channels == 0 {
        return Err(ImageError::NoChannel);
    }
    Ok(())
}

pub(super) fn check_names<'a>(names: impl Iterator<Item = &'a str>) -> Result<(), ImageError> {
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bounds_are_rounded_away_from_what_they_enclose() {
        let (tiny, huge) = (1e-300, 1e300);
        for value in [
            0.1,
            -0.1,
            1.0 / 3.0,
            1e-40,
            tiny,
            -tiny,
            huge,
            -huge,
            0.5,
            0.0,
        ] {
            let (low, high) = (Rounding::Down.apply(value), Rounding::Up.apply(value));
            assert!(
                f64::from(low) <= value && value <= f64::from(high),
                "{value}"
            );
            // One of them is the nearest, and there is no f32 between them.
            let nearest = value as f32;
            assert!(low == nearest || high == nearest, "{value}");
            assert!(low == high || low.next_up() == high, "{value}");
        }
        assert!(Rounding::Down.apply(f64::NAN).is_nan() && Rounding::Up.apply(f64::NAN).is_nan());
    }
}
