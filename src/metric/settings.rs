//! The settings of a comparison.

use serde::Serialize;

use super::flip;

/// One of two images.
///
/// # Example: the second image is the truth
///
/// ```
/// use nephroid::{CompareSettings, ImageSide};
///
/// let settings = CompareSettings { reference: ImageSide::B, ..CompareSettings::default() };
/// assert_ne!(settings.reference, ImageSide::default());
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum ImageSide {
    /// The first.
    #[default]
    A,
    /// The second.
    B,
}

/// Settings of a comparison.
///
/// # Example: one layer, within half a percent
///
/// ```
/// let settings = nephroid::CompareSettings {
///     layers: vec!["LTTD".to_owned()],
///     margin: 0.005,
///     ..Default::default()
/// };
/// assert_eq!(settings.level, 0.05);
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CompareSettings {
    /// The image that is the truth.
    pub reference: ImageSide,
    /// Layers to compare; all that both images have if empty.
    pub layers: Vec<String>,
    /// The difference that matters, as a fraction of the reference's mean.
    pub margin: f64,
    /// The significance level: the probability that a test calls equal images different (and images a margin
    /// apart equivalent).
    pub level: f64,
    /// Pixels a degree of vision for FLIP; `None` leaves FLIP out.
    pub pixels_per_degree: Option<f32>,
}

impl Default for CompareSettings {
    /// The first image as truth, all layers, a margin of 1 %, a level of 5 %, and FLIP at 0.7 m from a 4K
    /// screen.
    fn default() -> Self {
        Self {
            reference: ImageSide::A,
            layers: Vec::new(),
            margin: 0.01,
            level: 0.05,
            pixels_per_degree: Some(flip::PIXELS_PER_DEGREE),
        }
    }
}
