//! The test that the truth is good enough to judge by.
//!
//! A row's error is known only as far as the truth is: the truth's own error must be a tenth of it at most.
//! Otherwise the report says "not resolved" in that row, and no order is fitted to it.

use super::facts::Facts;
use crate::film::Image;
use crate::metric::LayerComparison;
use crate::numeric::math;

/// The largest ratio of the truth's error to an error that it judges. At this ratio it changes the error by
/// 10 % if both have one sign everywhere. If they are independent it changes it by √(1 + 0.01), half a
/// percent.
pub const LARGEST_SHARE: f64 = 0.1;

/// The truth's likely error in the terms of a row: of L1, as a part of the truth's light.
///
/// With σ the root mean square over all texels of the truth's known error and r̄ its mean over them,
///
/// ```text
/// e = σ / r̄
/// ```
///
/// which L1 does not exceed: a mean is no larger than the root of the mean square. References share a
/// quadrature: direct light can be the same in both films to the last bit. It then has no part in their
/// difference, and none in σ. `None` if the truth does not know its error, or is dark.
pub fn error(truth: &Facts, is_direct_shared: bool, comparison: &LayerComparison) -> Option<f64> {
    let direct = if is_direct_shared {
        0.0
    } else {
        truth.spread.direct
    };
    let sigma = math::hypot(truth.spread.specular?, direct);
    let mean = comparison.difference.mean_reference;
    (mean > 0.0).then(|| sigma / mean)
}

/// True if a truth with this error resolves an error.
pub fn resolves(truth: Option<f64>, error: Option<f64>) -> bool {
    matches!((truth, error), (Some(truth), Some(error)) if truth <= LARGEST_SHARE * error && error > 0.0)
}

/// True if two films have the same direct light, bit by bit.
pub fn shares_direct(one: &Image, other: &Image) -> bool {
    ["LD.R", "LD.G", "LD.B"].iter().all(|name| {
        matches!((one.channel(name), other.channel(name)), (Some(a), Some(b)) if a.samples == b.samples)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::{CompareImage, CompareSettings, compare};
    use crate::study::facts::Spread;

    #[test]
    fn the_truths_error_is_its_spread_by_the_mean_of_all_texels() {
        let mut image = Image::new(4, 1);
        image.add_rgb("E", &[[0.0; 3], [0.0; 3], [2.0; 3], [6.0; 3]]);
        let source = CompareImage::new("film", image);
        let settings = CompareSettings {
            pixels_per_degree: None,
            ..CompareSettings::default()
        };
        let comparison = compare(&source, &source, &settings).unwrap();
        let layer = &comparison.layers[0];
        let facts = Facts {
            judged: "E".to_owned(),
            replicates: None,
            counters: Vec::new(),
            own_error: None,
            spread: Spread {
                specular: Some(0.3),
                direct: 0.4,
            },
            ledger: None,
            stage_flux: Vec::new(),
            complete: true,
            warnings: Vec::new(),
        };
        // The mean is 2; √(0.3² + 0.4²) = 0.5.
        assert_eq!(error(&facts, true, layer), Some(0.15));
        assert_eq!(error(&facts, false, layer), Some(0.25));
        assert!(resolves(Some(0.1), Some(1.0)));
        assert!(!resolves(Some(0.1001), Some(1.0)) && !resolves(None, Some(1.0)));
    }
}
