//! From an estimate to the channels of a file.

use super::{Estimate, Layer, Quantity};
use crate::film::{Image, LazyImage, Rounding};
use crate::metric::bars::CONFIDENCE;
use crate::radiometry::Rgb;

impl Estimate {
    /// Its layers as channels, in its unit: `E` (of a camera `L`), `LD`, `LRD`, ..., each with `.R .G .B` and
    /// `.stderr.R .stderr.G .stderr.B`; of methods with bounds `.lo.R` ... and `.hi.R` ... instead, or both
    /// if they also draw at random. If the bounds are of the same draws as the standard errors, the attribute
    /// `confidence` has theirs; there is no other.
    ///
    /// # Example: names of the channels
    ///
    /// ```
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
    /// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
    /// let image = rendering.estimate.channels();
    /// assert!(image.channel("LTTD.R").is_some() && image.channel("LTTD.hi.R").is_some());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn channels(&self) -> Image {
        self.lazy_channels().to_image()
    }

    /// Its layers as [`channels`](Self::channels), computed when they are asked for.
    pub(super) fn lazy_channels(&self) -> LazyImage<'_> {
        let mut image = LazyImage::new(self.width, self.height);
        for layer in std::iter::once(&self.total).chain(&self.layers) {
            add_layer(&mut image, layer, self.quantity);
        }
        if self.total.interval.is_none() && self.total.sampling.is_some() {
            image.add_metadata(CONFIDENCE, "0.999 of each texel, of the draws of stderr");
        }
        image
    }
}

fn add_layer<'a>(image: &mut LazyImage<'a>, layer: &'a Layer, quantity: Quantity) {
    let mut add = |name: &str, values: &'a [Rgb], rounding| {
        image.add_rgb(name, move |texel| values[texel].0, rounding);
    };
    let name = layer.name.of(quantity);
    add(&name, &layer.values, Rounding::Nearest);
    if let Some(interval) = layer.interval.as_ref().or(layer.sampling.as_ref()) {
        // What bounds a number bounds it as it is in the file, too.
        add(&format!("{name}.lo"), &interval.low, Rounding::Down);
        add(&format!("{name}.hi"), &interval.high, Rounding::Up);
    }
    // Deterministic methods have bounds of their own alone; light drawn at random may have both.
    let is_random = layer.standard_error.iter().any(|error| !error.is_black());
    if layer.interval.is_none() || is_random {
        let error = format!("{name}.stderr");
        add(&error, &layer.standard_error, Rounding::Nearest);
    }
}
