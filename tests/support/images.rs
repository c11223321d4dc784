//! Images made from formulas, for the tests of comparison.

use nephroid::internals::film::Image;
use nephroid::internals::metric::CompareImage;
use nephroid::internals::numeric::{Stream, StreamKind};

/// An image of one grey channel `Y` by the value at (x, y), and of its standard errors, if any.
pub fn grey(
    [width, height]: [usize; 2],
    value: impl Fn(usize, usize) -> f64,
    error: Option<&dyn Fn(usize, usize) -> f64>,
) -> Image {
    let mut image = Image::new(width, height);
    let texels = || (0..width * height).map(|i| (i % width, i / width));
    image.add_scalar("Y", texels().map(|(x, y)| value(x, y)));
    if let Some(error) = error {
        image.add_scalar("stderr.Y", texels().map(|(x, y)| error(x, y)));
    }
    image
}

/// A source that messages call `name`.
pub fn source(name: &str, image: Image) -> CompareImage {
    CompareImage::new(name, image)
}

/// Independent standard normal numbers, by seed and index.
pub struct Normal(Stream);

impl Normal {
    pub fn new(seed: u64) -> Self {
        Self(Stream::new(StreamKind::Random, seed))
    }

    /// Box and Muller's transform (1958).
    pub fn at(&self, index: u64) -> f64 {
        let [u, v] = self.0.point2(index);
        (-2.0 * (1.0 - u).ln()).sqrt() * (std::f64::consts::TAU * v).cos()
    }
}

/// The counts of n trials of probability p that are credible: those outside on either side have a
/// probability below `alpha` together, by the binomial distribution itself.
pub fn credible(trials: u32, p: f64, alpha: f64) -> std::ops::RangeInclusive<u32> {
    let n = f64::from(trials);
    let mut mass = n * (1.0 - p).ln();
    let mut below = 0.0;
    let (mut first, mut last) = (None, trials);
    for k in 0..=trials {
        let probability = mass.exp();
        if first.is_none() && below + probability > 0.5 * alpha {
            first = Some(k);
        }
        below += probability;
        if 1.0 - below < 0.5 * alpha {
            last = k;
            break;
        }
        let k = f64::from(k);
        mass += ((n - k) / (k + 1.0)).ln() + (p / (1.0 - p)).ln();
    }
    first.unwrap_or(0)..=last
}
