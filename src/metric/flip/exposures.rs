//! The range of exposures of HDR-FLIP.

use rayon::prelude::*;

use super::colour::luminance;
use super::display::ACES;
use super::images::Planes;
use crate::numeric::math::single;

/// The exposures of HDR-FLIP \[stops\].
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Exposures {
    /// The lowest: the brightest texel of the reference just keeps its contrast.
    pub start: f32,
    /// The highest: the median of the reference just keeps its contrast.
    pub stop: f32,
    /// Number of exposures, evenly spaced, both ends included.
    pub count: usize,
}

impl Exposures {
    /// The luminance that ACES maps to 0.85, above which it has little contrast left.
    ///
    /// It is the positive root of (2.51 a² x² + 0.03 a x) = 0.85 (2.43 a² x² + 0.59 a x + 0.14), where a =
    /// 0.6 undoes the exposure built into Narkowicz' fit.
    fn brightest_shown() -> f32 {
        const SHOWN: f32 = 0.85;
        let a = ACES[0] - SHOWN * ACES[2];
        let b = ACES[1] - SHOWN * ACES[3];
        let c = -SHOWN * ACES[4];
        (-b + (b * b - 4.0 * a * c).sqrt()) / (2.0 * a)
    }

    /// The authors' choice for a reference (Andersson et al. 2021, section 3.2).
    ///
    /// Exposures go from log₂(x/max) to log₂(x/median) of its luminance, one exposure a stop, two at least.
    /// If the median is not positive (an image more than half dark), that of the positive texels takes its
    /// place. The authors' choice would be infinite. `None` if no texel has a positive luminance.
    pub fn of(reference: Planes) -> Option<Self> {
        let [red, green, blue] = reference;
        let mut luminances: Vec<f32> = (red, green, blue)
            .into_par_iter()
            .map(|(&r, &g, &b)| luminance([r, g, b]))
            .collect();
        let brightest = luminances.iter().copied().fold(0.0, f32::max);
        if brightest <= 0.0 || !brightest.is_finite() {
            return None;
        }
        let mut median = median_of(&mut luminances);
        if median <= 0.0 {
            luminances.retain(|luminance| *luminance > 0.0);
            median = median_of(&mut luminances);
        }
        let shown = Self::brightest_shown();
        // A median so dark that the quotient is infinite has a number of stops nevertheless; an exposure that
        // is a number has 127 at most.
        let stops = |luminance: f32| {
            let stops = single::log2(shown / luminance);
            let stops = if stops.is_finite() {
                stops
            } else {
                single::log2(shown) - single::log2(luminance)
            };
            stops.min(f32::MAX_EXP as f32 - 1.0)
        };
        let (start, stop) = (stops(brightest), stops(median));
        Some(Self {
            start,
            stop,
            count: (stop - start).ceil().max(2.0) as usize,
        })
    }
}

/// The upper median; `values` are not empty and not NaN.
fn median_of(values: &mut [f32]) -> f32 {
    let middle = values.len() / 2;
    *values.select_nth_unstable_by(middle, f32::total_cmp).1
}
