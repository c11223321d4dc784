//! The contents of an image file: layers, and their errors.
//!
//! | channels | meaning |
//! |---|---|
//! | `NAME.R .G .B` or `NAME.Y` | a layer; `E`, `L` or no name at all is all light |
//! | `NAME.stderr.R` ... | one standard error of it |
//! | `NAME.variance.R` ... | its variance: the standard error squared |
//! | `NAME.lo.R` ..., `NAME.hi.R` ... | its lower and upper bounds |
//! | `NAME.X .Y .Z` with `m2_NAME.X` ... | mean, second moment of a sample in CIE XYZ: Mitsuba's `moment` |

use std::borrow::Cow;
use std::collections::BTreeMap;

use super::CompareError;
use crate::film::{Channel, Image};

/// An image to compare, and what is known of its errors beside its own channels.
///
/// # Example: another renderer's image of 256 samples a pixel
///
/// ```
/// use nephroid::{CompareImage, Image};
///
/// let image = Image::new(8, 8); // or nephroid::read_exr(path)
/// let other = CompareImage {
///     samples: Some(256),
///     ..CompareImage::new("other.exr", image)
/// };
/// assert!(other.errors.is_none());
/// ```
#[derive(Clone, Debug)]
pub struct CompareImage {
    /// The name for messages: the file's.
    pub name: String,
    /// The image.
    pub image: Image,
    /// A separate image of standard errors and its name: channels as in a layer (`R`), or named as errors
    /// (`stderr.R`, `variance.R`).
    pub errors: Option<(String, Image)>,
    /// Number of independent values behind each standard error: replicates, or samples a pixel. If it is not
    /// known, standard errors count as exact.
    pub samples: Option<u64>,
    /// The place of the image's upper left texel in its file. Messages and places refer to the file.
    #[doc(hidden)]
    pub corner: [usize; 2],
}

/// A rectangle of texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct Window {
    /// Column and row of its upper left texel.
    pub corner: [usize; 2],
    /// Texels a row and rows.
    pub size: [usize; 2],
}

impl CompareImage {
    /// An image as it is in its file. `samples` are the replicates that the file's settings name.
    ///
    /// # Example: a rendering that was not written, with its replicates
    ///
    /// ```
    /// # use nephroid::{Budget, Context, Method};
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// # let method = Method::new("photons", &Default::default())?;
    /// # let rendering = method.run(&scene, sensor, &Budget::work(4096), &Context::default())?;
    /// let mine = nephroid::CompareImage {
    ///     samples: rendering.replicates.map(u64::from),
    ///     ..nephroid::CompareImage::new("mine", rendering.image(&scene))
    /// };
    /// assert_eq!(mine.samples, Some(32));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn new(name: impl Into<String>, image: Image) -> Self {
        let settings = image.metadata("settings");
        let samples = settings
            .and_then(|text| serde_json::from_str::<serde_json::Value>(text).ok())
            .and_then(|settings| settings.get("replicates")?.as_u64());
        Self {
            name: name.into(),
            image,
            errors: None,
            samples,
            corner: [0, 0],
        }
    }

    /// The part of the image, and of its errors, that lies in a window.
    ///
    /// # Errors
    ///
    /// If the window is empty or leaves the image.
    #[doc(hidden)]
    pub fn cropped(&self, window: Window) -> Result<Self, CompareError> {
        let errors = match &self.errors {
            Some((name, image)) => Some((name.clone(), cropped(image, window)?)),
            None => None,
        };
        Ok(Self {
            name: self.name.clone(),
            image: cropped(&self.image, window)?,
            errors,
            samples: self.samples,
            corner: std::array::from_fn(|i| self.corner[i] + window.corner[i]),
        })
    }

    /// Degrees of freedom of the standard errors; infinite if they count as exact.
    pub(super) fn freedom(&self) -> f64 {
        self.samples
            .map_or(f64::INFINITY, |n| n.saturating_sub(1).max(1) as f64)
    }
}

fn cropped(image: &Image, window: Window) -> Result<Image, CompareError> {
    let Window {
        corner: [left, top],
        size: [width, height],
    } = window;
    let fits = |from: usize, length: usize, size: usize| {
        length > 0 && from.checked_add(length).is_some_and(|end| end <= size)
    };
    if !fits(left, width, image.width) || !fits(top, height, image.height) {
        return Err(CompareError::Window {
            corner: window.corner,
            size: window.size,
            image: [image.width, image.height],
        });
    }
    let rows = |samples: &[f32]| {
        samples
            .chunks_exact(image.width)
            .skip(top)
            .take(height)
            .flat_map(|row| row[left..left + width].iter().copied())
            .collect()
    };
    let channels = image.channels.iter().map(|channel| Channel {
        name: channel.name.clone(),
        samples: rows(&channel.samples),
    });
    Ok(Image {
        width,
        height,
        channels: channels.collect(),
        metadata: image.metadata.clone(),
    })
}

/// The meaning of a group of channels for a layer.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum ChannelKind {
    Value,
    StandardError,
    Variance,
    Low,
    High,
    SecondMoment,
}

impl ChannelKind {
    const SUFFIXES: [(&'static str, Self); 4] = [
        ("stderr", Self::StandardError),
        ("variance", Self::Variance),
        ("lo", Self::Low),
        ("hi", Self::High),
    ];

    /// The layer and the kind that a prefix names.
    fn of(prefix: &str) -> (&str, Self) {
        if let Some(layer) = prefix.strip_prefix("m2_") {
            return (layer, Self::SecondMoment);
        }
        for (suffix, kind) in Self::SUFFIXES {
            if prefix == suffix {
                return ("", kind);
            }
            let layer = prefix.strip_suffix(suffix);
            if let Some(layer) = layer.and_then(|layer| layer.strip_suffix('.')) {
                return (layer, kind);
            }
        }
        (prefix, Self::Value)
    }
}

/// The channels of an image by layer, kind and component.
pub(super) struct Contents<'a> {
    pub(super) name: &'a str,
    image: &'a Image,
    corner: [usize; 2],
    groups: BTreeMap<(&'a str, ChannelKind), BTreeMap<&'a str, &'a Channel>>,
}

/// The names that a layer of all light has.
pub(super) const TOTALS: [&str; 3] = ["E", "L", ""];

/// Names of channels that look like a layer's but hold no light.
pub const NOT_LIGHT: [&str; 2] = ["area", "count"];

impl<'a> Contents<'a> {
    pub(super) fn new(name: &'a str, image: &'a Image, corner: [usize; 2]) -> Self {
        let mut groups: BTreeMap<_, BTreeMap<_, _>> = BTreeMap::new();
        for channel in &image.channels {
            let (prefix, component) = channel.name.rsplit_once('.').unwrap_or(("", &channel.name));
            groups
                .entry(ChannelKind::of(prefix))
                .or_default()
                .insert(component, channel);
        }
        Self {
            name,
            image,
            corner,
            groups,
        }
    }

    /// The channels of a group: red, green, blue, or luminance alone; none if it has neither.
    pub(super) fn colour(&self, layer: &str, kind: ChannelKind) -> Vec<&'a Channel> {
        self.components(layer, kind, &["R", "G", "B"])
            .or_else(|| self.components(layer, kind, &["Y"]))
            .unwrap_or_default()
    }

    /// The channels of these components, if all are there.
    pub(super) fn components(
        &self,
        layer: &str,
        kind: ChannelKind,
        names: &[&str],
    ) -> Option<Vec<&'a Channel>> {
        let group = self.groups.get(&(layer, kind))?;
        names.iter().map(|name| group.get(name).copied()).collect()
    }

    /// The name of the layer of all light.
    pub(super) fn total(&self) -> Result<&'static str, CompareError> {
        TOTALS
            .into_iter()
            .find(|name| !self.colour(name, ChannelKind::Value).is_empty())
            .ok_or_else(|| CompareError::NoTotal {
                file: self.name.to_owned(),
                channels: names(self.image.channels.iter()),
            })
    }

    /// The layers beside that of all light, sorted by name.
    pub(super) fn layers(&self) -> Vec<&'a str> {
        self.groups
            .keys()
            .filter(|(name, kind)| {
                *kind == ChannelKind::Value
                    && !TOTALS.contains(name)
                    && !NOT_LIGHT.contains(name)
                    && !self.groups.contains_key(&(name, ChannelKind::SecondMoment))
                    && !self.colour(name, ChannelKind::Value).is_empty()
            })
            .map(|(name, _)| *name)
            .collect()
    }

    /// Mean and second moment of one sample in X, Y and Z, if the file has them: three channels each.
    pub(super) fn moments(&self) -> Option<[Vec<&'a Channel>; 2]> {
        const XYZ: [&str; 3] = ["X", "Y", "Z"];
        self.groups
            .keys()
            .filter(|(_, kind)| *kind == ChannelKind::SecondMoment)
            .find_map(|(name, _)| {
                Some([
                    self.components(name, ChannelKind::Value, &XYZ)?,
                    self.components(name, ChannelKind::SecondMoment, &XYZ)?,
                ])
            })
    }

    /// Refuses channels that hold anything but finite numbers.
    pub(super) fn check_finite(&self, channels: &[&Channel]) -> Result<(), CompareError> {
        self.check(channels, f32::is_finite, not_finite)
    }

    /// Standard errors, or `None` if there are none or all are NaN, which says "not known".
    pub(super) fn standard_errors(
        &self,
        layer: &str,
    ) -> Result<Option<Vec<Cow<'a, [f32]>>>, CompareError> {
        let errors = self.colour(layer, ChannelKind::StandardError);
        if !errors.is_empty() {
            return self.errors_from(&errors, false);
        }
        self.errors_from(&self.colour(layer, ChannelKind::Variance), true)
    }

    /// Channels as standard errors.
    pub(super) fn errors_from(
        &self,
        channels: &[&'a Channel],
        are_variances: bool,
    ) -> Result<Option<Vec<Cow<'a, [f32]>>>, CompareError> {
        if channels.is_empty() || are_unknown(channels) {
            return Ok(None);
        }
        self.check_finite(channels)?;
        self.check(
            channels,
            |value| value >= 0.0,
            |file, channel, [x, y], value| CompareError::NegativeError {
                file,
                channel,
                x,
                y,
                value,
            },
        )?;
        let errors = channels.iter().map(|channel| {
            if are_variances {
                Cow::Owned(channel.samples.iter().map(|v| v.sqrt()).collect())
            } else {
                Cow::Borrowed(channel.samples.as_slice())
            }
        });
        Ok(Some(errors.collect()))
    }

    /// Lower and upper bounds of each channel, or `None` if there are none or all are NaN.
    pub(super) fn bounds(&self, layer: &str) -> Result<Option<Vec<[&'a [f32]; 2]>>, CompareError> {
        let [lows, highs] =
            [ChannelKind::Low, ChannelKind::High].map(|kind| self.colour(layer, kind));
        if lows.is_empty() || lows.len() != highs.len() || are_unknown(&lows) {
            return Ok(None);
        }
        self.check_finite(&lows)?;
        self.check_finite(&highs)?;
        let mut bounds = Vec::new();
        for (low, high) in lows.into_iter().zip(highs) {
            let crossed = low
                .samples
                .iter()
                .zip(&high.samples)
                .position(|(l, h)| l > h);
            if let Some(texel) = crossed {
                let [x, y] = self.place(texel);
                return Err(CompareError::Bounds {
                    file: self.name.to_owned(),
                    channel: low.name.clone(),
                    x,
                    y,
                    low: low.samples[texel],
                    high: high.samples[texel],
                });
            }
            bounds.push([low.samples.as_slice(), high.samples.as_slice()]);
        }
        Ok(Some(bounds))
    }

    fn check(
        &self,
        channels: &[&Channel],
        is_fine: impl Fn(f32) -> bool,
        error: impl Fn(String, String, [usize; 2], f32) -> CompareError,
    ) -> Result<(), CompareError> {
        for channel in channels {
            if let Some(texel) = channel.samples.iter().position(|&value| !is_fine(value)) {
                let value = channel.samples[texel];
                let place = self.place(texel);
                return Err(error(
                    self.name.to_owned(),
                    channel.name.clone(),
                    place,
                    value,
                ));
            }
        }
        Ok(())
    }

    fn place(&self, texel: usize) -> [usize; 2] {
        let [left, top] = self.corner;
        let width = self.image.width;
        [left + texel % width, top + texel / width]
    }
}

fn not_finite(file: String, channel: String, [x, y]: [usize; 2], value: f32) -> CompareError {
    CompareError::NotFinite {
        file,
        channel,
        x,
        y,
        value,
    }
}

fn are_unknown(channels: &[&Channel]) -> bool {
    channels
        .iter()
        .all(|channel| channel.samples.iter().all(|value| value.is_nan()))
}

/// Channels' names with commas between them.
pub(super) fn names<'a>(channels: impl Iterator<Item = &'a Channel>) -> String {
    let names: Vec<&str> = channels.map(|channel| channel.name.as_str()).collect();
    names.join(", ")
}

/// The last part of a channel's name.
pub(super) fn component(name: &str) -> &str {
    name.rsplit_once('.')
        .map_or(name, |(_, component)| component)
}
