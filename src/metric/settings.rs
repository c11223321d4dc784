//! Settings of a comparison.

use serde::Serialize;

use super::flip;

/// One of two images.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize)]
pub enum ImageSide {
    /// The first.
    #[default]
    A,
    /// The second.
    B,
}

/// How to compare.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CompareSettings {
    /// Which image is the truth.
    pub reference: ImageSide,
    /// Layers to compare; all that both images have where empty.
    pub layers: Vec<String>,
    /// The difference that matters, as a fraction of the reference's mean.
    pub margin: f64,
    /// How often a test may say of equal images that they differ (and of images a margin apart
    /// that they are equivalent).
    pub level: f64,
    /// Pixels a degree of vision for FLIP; `None` leaves FLIP out.
    pub pixels_per_degree: Option<f32>,
}

impl Default for CompareSettings {
    /// Against the first image, all layers, a margin of 1 %, a level of 5 %, with FLIP at 0.7 m from
    /// a 4K screen.
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
