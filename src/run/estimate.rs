//! What every reference delivers.

use std::fmt;

use crate::geometry::TraversalCounters;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::transport::ledger::Ledger;
use crate::transport::path_class::PathClass;
use crate::transport::signature::Signature;

/// What a sensor measures.
///
/// # Example: numbers with their unit
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
/// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
/// let quantity = rendering.estimate.quantity;
/// println!("{} {:.3} {}", quantity.name(), rendering.estimate.total.range().mean, quantity.unit());
/// assert_eq!(quantity.unit(), "W/m²");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Quantity {
    /// Flux that arrives, by area: irradiance E [W/m²] on a surface.
    #[default]
    Irradiance,
    /// Radiance L [W/m²/sr] towards a camera.
    Radiance,
}

impl Quantity {
    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Irradiance => "irradiance",
            Self::Radiance => "radiance",
        }
    }

    /// Its unit.
    pub fn unit(self) -> &'static str {
        match self {
            Self::Irradiance => "W/m²",
            Self::Radiance => "W/m²/sr",
        }
    }

    /// Its letter, which is the name of a file's layer of all light.
    ///
    /// # Example: the channel of all light in a file
    ///
    /// ```
    /// let name = format!("{}.R", nephroid::Quantity::Radiance.symbol());
    /// assert_eq!(name, "L.R");
    /// ```
    pub fn symbol(self) -> &'static str {
        match self {
            Self::Irradiance => "E",
            Self::Radiance => "L",
        }
    }
}

/// A map of irradiance or radiance with its error bar, layer by layer.
///
/// # Example: the texel in column 3 of row 5
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
/// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
/// let estimate = &rendering.estimate;
/// let texel = 5 * estimate.width + 3;
/// println!("{:.3} {}", estimate.total.values[texel].mean(), estimate.quantity.unit());
/// assert_eq!(estimate.total.values.len(), estimate.width * estimate.height);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Estimate {
    /// What is measured.
    pub quantity: Quantity,
    /// Texels a row.
    pub width: usize,
    /// Rows; row 0 is at v = 0 of a receiver, and the top of a camera's image.
    pub height: usize,
    /// The sum of the layers: all light from specular chains and, on a receiver, the direct light.
    pub total: Layer,
    /// `LD` first (on a receiver), then one layer a signature, then what is left.
    pub layers: Vec<Layer>,
    /// Contributions a texel, all specular layers together. With a wide filter, light contributes to several.
    pub counts: Vec<u64>,
    /// Where all traced flux went, as the layers have it. A camera receives none, it sees what surfaces make
    /// of what they absorb; of beams it is empty then.
    pub ledger: Ledger,
    /// How many paths were started.
    pub paths: u64,
    /// Rays, and the work of finding what they hit.
    pub counters: TraversalCounters,
    /// Standard error (of deterministic methods, the likely error) of the specular layers' sum,
    /// relative: √(mean σ²) / mean E over its lit texels; `None` where nothing is lit or no error
    /// is known.
    pub relative_error: Option<f64>,
    /// Whether the run was stopped before its budget was used.
    pub incomplete: bool,
}

/// A map of one kind of light, in its estimate's quantity: irradiance, or radiance towards a camera.
///
/// # Example: a caustic with its error bars
///
/// ```
/// # use nephroid::{Budget, Context, Method};
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = Method::new("photons", &Default::default())?;
/// # let rendering = method.run(&scene, sensor, &Budget::work(4096), &Context::default())?;
/// let layers = &rendering.estimate.layers;
/// let caustic = layers.iter().find(|layer| layer.name.to_string() == "LTTD").unwrap();
/// for (value, error) in caustic.values.iter().zip(&caustic.standard_error) {
///     println!("{:.3} ± {:.3} W/m²", value.mean(), error.mean());
/// }
/// let bounds = caustic.sampling.as_ref().unwrap();
/// assert!(bounds.high.iter().all(|high| high.mean() > 0.0), "no texel is known to be dark");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug)]
pub struct Layer {
    /// Which kind.
    pub name: LayerName,
    /// Texel averages in the estimate's unit, row by row; NaN where nothing is known.
    pub values: Vec<Rgb>,
    /// One standard error of each: the scatter of random methods, zero for deterministic
    /// ones; NaN where there is no estimate of it.
    pub standard_error: Vec<Rgb>,
    /// Lower and upper bounds of each, where the method gives any.
    pub interval: Option<Interval>,
    /// Bounds of each by its samples alone, with a confidence of 99.9 % each, of methods that know them.
    /// Unlike a standard error they hold where few samples arrived, or none. They are of the same draws as
    /// the standard error: a difference is judged by one of the two.
    pub sampling: Option<Interval>,
}

/// Bounds of a layer, texel by texel: `low` ≤ truth ≤ `high`, as far as the method can know. The
/// layer's own value lies between them, too.
///
/// # Example: bounds of every texel
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
/// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
/// let total = &rendering.estimate.total;
/// let bounds = total.interval.as_ref().unwrap();
/// assert!(bounds.low[0].mean() <= total.values[0].mean());
/// assert!(total.values[0].mean() <= bounds.high[0].mean());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, Default)]
pub struct Interval {
    /// Lower bounds, at least 0 unless a film's filter has negative lobes.
    pub low: Vec<Rgb>,
    /// Upper bounds.
    pub high: Vec<Rgb>,
}

/// A kind of light.
///
/// # Example: the light that crosses the ball
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
/// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
/// let name = nephroid::LayerName::Path("LTTD".parse()?);
/// let layer = rendering.estimate.layers.iter().find(|layer| layer.name == name);
/// assert!(layer.is_some());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum LayerName {
    /// The sum of all layers: `E` (in files of a camera `L`).
    Total,
    /// One path signature: `LD`, `LRD`, `LTTD`, ...
    Path(Signature),
    /// The paths of one signature whose diffuse surface the camera sees by way of mirrors or glass: `LTTDSE`,
    /// ...
    Seen(Signature),
    /// All light by way of mirrors and glass: `specular`.
    Specular,
    /// All signatures that have no layer of their own: `other`.
    Other,
    /// One class of paths from a camera: `direct`, `indirect`, ...
    Class(PathClass),
}

impl Estimate {
    /// True if light by way of mirrors and glass was looked for and none was found.
    pub(crate) fn is_without_caustics(&self) -> bool {
        let direct = LayerName::Path(Signature::DIRECT);
        let mut specular = self.layers.iter().filter(|layer| layer.name != direct);
        !self.incomplete && specular.all(|layer| layer.values.iter().all(|value| value.is_black()))
    }
}

impl LayerName {
    /// The layer's name where `quantity` was measured.
    ///
    /// # Example: the channels of all light
    ///
    /// ```
    /// use nephroid::{LayerName, Quantity};
    ///
    /// assert_eq!(LayerName::Total.of(Quantity::Irradiance), "E");
    /// assert_eq!(LayerName::Total.of(Quantity::Radiance), "L");
    /// ```
    pub fn of(self, quantity: Quantity) -> String {
        match self {
            Self::Total => quantity.symbol().to_owned(),
            name => name.to_string(),
        }
    }
}

impl fmt::Display for LayerName {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Total => formatter.pad("E"),
            Self::Path(signature) => signature.fmt(formatter),
            Self::Seen(signature) => formatter.pad(&format!("{signature}SE")),
            Self::Specular => formatter.pad("specular"),
            Self::Other => formatter.pad("other"),
            Self::Class(class) => class.fmt(formatter),
        }
    }
}

impl Interval {
    /// Adds the ends of another.
    fn add(&mut self, other: &Self) {
        for (sums, values) in [(&mut self.low, &other.low), (&mut self.high, &other.high)] {
            for (sum, value) in sums.iter_mut().zip(values) {
                *sum += *value;
            }
        }
    }
}

/// Black texels in memory that comes as zeros from the system, and is taken only where it is written to.
/// Filling a vector with `Rgb` writes to all of it; numbers that are zero do not.
fn untouched(texels: usize) -> Vec<Rgb> {
    // In place, and so nothing to do.
    vec![[0.0; 3]; texels].into_iter().map(Rgb).collect()
}

impl Layer {
    /// A layer of `texels` texels without light and without error.
    pub(crate) fn dark(name: LayerName, texels: usize) -> Self {
        Self {
            name,
            values: vec![Rgb::BLACK; texels],
            standard_error: untouched(texels),
            interval: None,
            sampling: None,
        }
    }

    /// A dark layer with bounds.
    #[doc(hidden)]
    pub fn bounded(name: LayerName, texels: usize) -> Self {
        Self {
            interval: Some(Interval {
                low: vec![Rgb::BLACK; texels],
                high: vec![Rgb::BLACK; texels],
            }),
            ..Self::dark(name, texels)
        }
    }

    /// Adds another layer: bounds add up; standard errors by squares, as those of independent runs.
    #[doc(hidden)]
    pub fn add(&mut self, other: &Self) {
        for (sum, value) in self.values.iter_mut().zip(&other.values) {
            *sum += *value;
        }
        for (sum, value) in self.standard_error.iter_mut().zip(&other.standard_error) {
            // Memory of errors that are all zero is never touched, and so never taken.
            if !value.is_black() {
                *sum = Rgb(std::array::from_fn(|c| math::hypot(sum.0[c], value.0[c])));
            }
        }
        if let (Some(sum), Some(value)) = (&mut self.interval, &other.interval) {
            sum.add(value);
        }
        match (&mut self.sampling, &other.sampling) {
            (Some(sum), Some(value)) => sum.add(value),
            // The sum would have bounds of a part of its light.
            _ => self.sampling = None,
        }
    }

    /// Says that nothing is known of it. Where there are bounds, it is they that say so, and standard errors,
    /// which deterministic methods have none of, stay.
    pub(crate) fn make_unknown(&mut self) {
        let nothing = Rgb::grey(f64::NAN);
        self.values.fill(nothing);
        if let Some(sampling) = &mut self.sampling {
            sampling.low.fill(nothing);
            sampling.high.fill(nothing);
        }
        if let Some(interval) = &mut self.interval {
            interval.low.fill(nothing);
            interval.high.fill(nothing);
        } else {
            self.standard_error.fill(nothing);
        }
    }

    /// Whether nothing is known of some texel.
    ///
    /// # Example: a layer that can be trusted everywhere
    ///
    /// ```
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
    /// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
    /// assert!(!rendering.estimate.total.is_unknown());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn is_unknown(&self) -> bool {
        self.values.iter().any(|value| value.mean().is_nan())
    }

    /// Smallest, mean and largest value over all texels, channels averaged; NaN where nothing is
    /// known of some texel.
    ///
    /// # Example: the contrast of a caustic
    ///
    /// ```
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
    /// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
    /// let range = rendering.estimate.total.range();
    /// assert!(range.max > 5.0 * range.mean);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn range(&self) -> Range {
        if self.is_unknown() {
            return Range {
                min: f64::NAN,
                mean: f64::NAN,
                max: f64::NAN,
            };
        }
        let mut range = Range {
            min: f64::INFINITY,
            mean: 0.0,
            max: f64::NEG_INFINITY,
        };
        for value in &self.values {
            let value = value.mean();
            range.min = range.min.min(value);
            range.max = range.max.max(value);
            range.mean += value;
        }
        range.mean /= self.values.len() as f64;
        range
    }

    /// √(mean σ²) / mean E over the texels with E > 0; `None` where there are none. E is the mean of
    /// channels, or their root mean square if these have both signs. Of a layer with bounds, σ is half
    /// their distance.
    ///
    /// # Example: the error bar of each layer
    ///
    /// ```
    /// # use nephroid::{Budget, Context, Method};
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// # let method = Method::new("photons", &Default::default())?;
    /// # let rendering = method.run(&scene, sensor, &Budget::work(4096), &Context::default())?;
    /// for layer in &rendering.estimate.layers {
    ///     if let Some(error) = layer.relative_error() {
    ///         println!("{}: ± {:.1} %", layer.name, 100.0 * error);
    ///     }
    /// }
    /// assert!(rendering.estimate.total.relative_error().unwrap() < 0.1);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn relative_error(&self) -> Option<f64> {
        if let Some(Interval { low, high }) = &self.interval {
            let bars = low
                .iter()
                .zip(high)
                .map(|(low, high)| 0.5 * (*high - *low).mean());
            return relative_error(self.values.iter().map(|value| value.mean()).zip(bars));
        }
        relative_error(
            self.values
                .iter()
                .zip(&self.standard_error)
                .map(|(value, error)| brightness(*value, *error)),
        )
    }
}

/// Smallest, mean and largest of a map.
///
/// # Example: smallest, mean and largest
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
/// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
/// let nephroid::Range { min, mean, max } = rendering.estimate.total.range();
/// assert!(min < mean && mean < max);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Range {
    /// Smallest.
    pub min: f64,
    /// Mean over texels.
    pub mean: f64,
    /// Largest.
    pub max: f64,
}

/// The mean over channels of a value and of its standard error. If channels have both signs, as of light that
/// is dispersed, the two are root mean squares: the mean may be nothing where there is light.
pub(crate) fn brightness(value: Rgb, error: Rgb) -> (f64, f64) {
    let is_any = |of: fn(f64) -> bool| value.0.iter().any(|channel| of(*channel));
    if is_any(|channel| channel < 0.0) && is_any(|channel| channel > 0.0) {
        let size = |channels: Rgb| (channels * channels).mean().sqrt();
        (size(value), size(error))
    } else {
        (value.mean(), error.mean())
    }
}

/// √(mean σ²) / mean E over pairs (E, σ) with E > 0.
pub(crate) fn relative_error(texels: impl Iterator<Item = (f64, f64)>) -> Option<f64> {
    let (mut lit, mut sum, mut squares) = (0_u64, 0.0, 0.0);
    for (value, error) in texels {
        if value > 0.0 {
            lit += 1;
            sum += value;
            squares += error * error;
        }
    }
    if lit == 0 || squares.is_nan() {
        return None;
    }
    let lit = lit as f64;
    Some((squares / lit).sqrt() / (sum / lit))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_of_both_signs_has_an_error_by_root_mean_squares() {
        let error = Rgb([0.1, 0.2, 0.3]);
        // Light that is nowhere below zero: means of channels, as ever.
        let (value, of_value) = brightness(Rgb([1.0, 2.0, 6.0]), error);
        assert!((value - 3.0).abs() < 1e-15 && (of_value - 0.2).abs() < 1e-15);
        // A mean of nothing, and yet light.
        let (value, of_value) = brightness(Rgb([-3.0, 0.0, 3.0]), error);
        assert!((value - 6.0_f64.sqrt()).abs() < 1e-15);
        assert!((of_value - (0.14_f64 / 3.0).sqrt()).abs() < 1e-15);
        // Two of these texels: √0.14/3 of each by √6.
        let all = [brightness(Rgb([-3.0, 0.0, 3.0]), error); 2];
        let relative = relative_error(all.into_iter()).unwrap();
        assert!((relative - (0.14_f64 / 18.0).sqrt()).abs() < 1e-15);
        // A filter's negative lobe is no light.
        let (value, of_value) = brightness(Rgb::grey(-1.0), error);
        assert!(value == -1.0 && (of_value - 0.2).abs() < 1e-15);
    }
}
