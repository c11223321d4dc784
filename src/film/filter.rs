//! Reconstruction filters, which spread a sample over the pixels near it.

use std::f64::consts::PI;

use crate::numeric::math;
use crate::numeric::quadrature::GaussLegendre;

/// The weight of a sample on the pixels near it, with Mitsuba's parameters.
///
/// A filter f is separable, symmetric and zero from its [radius](Self::radius) on. It need not integrate to
/// one: its users divide by the weights that were given (see [`splat`](super::splat)).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ReconstructionFilter {
    /// All weight on the pixel that a sample falls in.
    Box,
    /// A triangle.
    Tent {
        /// Half width in pixels.
        radius: f64,
    },
    /// A Gaussian, cut off at four standard deviations and shifted down to reach zero there.
    Gaussian {
        /// The standard deviation in pixels.
        stddev: f64,
    },
    /// Mitchell and Netravali's cubic.
    Mitchell {
        /// Their B.
        b: f64,
        /// Their C.
        c: f64,
    },
    /// Catmull and Rom's cubic.
    CatmullRom,
    /// A windowed sinc.
    Lanczos {
        /// Half width in lobes.
        lobes: u32,
    },
}

impl ReconstructionFilter {
    /// The name of Mitsuba's plugin.
    pub fn plugin(&self) -> &'static str {
        match self {
            Self::Box => "box",
            Self::Tent { .. } => "tent",
            Self::Gaussian { .. } => "gaussian",
            Self::Mitchell { .. } => "mitchell",
            Self::CatmullRom => "catmullrom",
            Self::Lanczos { .. } => "lanczos",
        }
    }

    /// Half the filter's width \[pixels\], beyond which it is zero.
    pub fn radius(&self) -> f64 {
        match *self {
            Self::Box => 0.5,
            Self::Tent { radius } => radius,
            Self::Gaussian { stddev } => GAUSSIAN_CUT * stddev,
            Self::Mitchell { .. } | Self::CatmullRom => 2.0,
            Self::Lanczos { lobes } => f64::from(lobes),
        }
    }

    /// True if it may be negative in places, so that a pixel's sum may be, too.
    pub fn has_negative_lobes(&self) -> bool {
        match *self {
            Self::Box | Self::Tent { .. } | Self::Gaussian { .. } => false,
            // Beyond one pixel, y = 2 − x, it is y² (B y − 6 C (1 − y)) / 6. For C = 0 it is linear in B, and
            // positive for 0 and 1.
            Self::Mitchell { b, c } => c != 0.0 || !(0.0..=1.0).contains(&b),
            Self::CatmullRom | Self::Lanczos { .. } => true,
        }
    }

    /// The least light that a pixel can have: 0, or any number if the filter has negative lobes.
    pub fn least_light(&self) -> f64 {
        if self.has_negative_lobes() {
            f64::NEG_INFINITY
        } else {
            0.0
        }
    }

    /// The integral of f over `from` ≤ x ≤ `to` \[pixels\].
    ///
    /// All filters are smooth between whole numbers and their radius. There the rule of 20 nodes is exact for
    /// the tent and the cubics, and for the others to rounding.
    pub fn integral(&self, from: f64, to: f64) -> f64 {
        let radius = self.radius();
        let (from, to) = (from.max(-radius), to.min(radius));
        if *self == Self::Box {
            return (to - from).max(0.0);
        }
        let Some(rule) = GaussLegendre::new(NODES) else {
            return f64::NAN;
        };
        let (mut sum, mut start) = (0.0, from);
        while start < to {
            let end = (start.floor() + 1.0).min(to);
            sum += rule.integrate(start, end, |x| self.eval(x));
            start = end;
        }
        sum
    }

    /// Number of pixels, each way, that a sample may reach beyond the one it falls in.
    pub fn border(&self) -> usize {
        // The cast is exact as long as the radius is: no film is wide enough for another.
        (self.radius() - 0.5).ceil().max(0.0) as usize
    }

    /// The weight f(x), dimensionless, of a sample `x` pixels from a pixel's centre along one axis.
    ///
    /// With x = |x|, r the radius:
    ///
    /// ```text
    /// box         1 for −½ ≤ x < ½
    /// tent        1 − x/r
    /// gaussian    exp(−x²/2σ²) − exp(−r²/2σ²)        r = 4σ
    /// mitchell    Mitchell and Netravali 1988, equation (8)
    /// catmullrom  the same with B = 0, C = ½
    /// lanczos     sinc(x) sinc(x/r)                  sinc x = sin πx / πx
    /// ```
    ///
    /// The filters are those of Mitsuba 3.9.1, except for two approximations of its own. Its Gaussian is a
    /// polynomial (at most 4.2e-4 away), and its scalar variants look all filters but the box up in a table
    /// of 31 steps.
    pub fn eval(&self, x: f64) -> f64 {
        // Half open: a sample between two pixels belongs to one of them.
        if *self == Self::Box {
            return f64::from(u8::from((-0.5..0.5).contains(&x)));
        }
        let (x, radius) = (x.abs(), self.radius());
        if x >= radius {
            return 0.0;
        }
        match *self {
            Self::Box => 1.0,
            Self::Tent { radius } => 1.0 - x / radius,
            Self::Gaussian { stddev } => {
                let bell = |x: f64| math::exp(-0.5 * math::powi(x / stddev, 2));
                bell(x) - bell(radius)
            }
            Self::Mitchell { b, c } => cubic(x, b, c),
            Self::CatmullRom => cubic(x, 0.0, 0.5),
            Self::Lanczos { .. } => sinc(x) * sinc(x / radius),
        }
    }
}

/// Nodes of a rule over a pixel. A Gaussian a tenth of a pixel wide is then as smooth as they are dense.
const NODES: usize = 20;

/// The distance at which a Gaussian is cut off, in standard deviations.
const GAUSSIAN_CUT: f64 = 4.0;

/// The family of cubics of Mitchell and Netravali, *Reconstruction Filters in Computer Graphics*
/// (SIGGRAPH 1988), equation (8), for 0 ≤ x < 2.
fn cubic(x: f64, b: f64, c: f64) -> f64 {
    let value = if x < 1.0 {
        ((12.0 - 9.0 * b - 6.0 * c) * x + (-18.0 + 12.0 * b + 6.0 * c)) * x * x + (6.0 - 2.0 * b)
    } else {
        (((-b - 6.0 * c) * x + (6.0 * b + 30.0 * c)) * x + (-12.0 * b - 48.0 * c)) * x
            + (8.0 * b + 24.0 * c)
    };
    value / 6.0
}

fn sinc(x: f64) -> f64 {
    if x == 0.0 {
        1.0
    } else {
        math::sin(PI * x) / (PI * x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The filters, with Mitsuba's default parameters.
    const FILTERS: [ReconstructionFilter; 6] = [
        ReconstructionFilter::Box,
        ReconstructionFilter::Tent { radius: 1.0 },
        ReconstructionFilter::Gaussian { stddev: 0.5 },
        ReconstructionFilter::Mitchell {
            b: 1.0 / 3.0,
            c: 1.0 / 3.0,
        },
        ReconstructionFilter::CatmullRom,
        ReconstructionFilter::Lanczos { lobes: 3 },
    ];

    /// The places at which [`MITSUBA`] was evaluated.
    const PLACES: [f64; 12] = [0.0, 0.1, 0.25, 0.5, 0.9, 1.0, 1.2, 1.9, 2.0, 2.4, 2.9, 3.1];

    /// `mi.load_dict({'type': name}).eval(x)` of Mitsuba 3.9.1 (`scalar_rgb`) at `PLACES`, by filter.
    #[rustfmt::skip]
    const MITSUBA: [[f64; 12]; 6] = [
        [1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [1.0, 0.899_999_976, 0.75, 0.5, 0.100_000_024, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        [0.999_247_134, 0.979_533_315, 0.882_166_743, 0.606_423_020, 0.197_471_097, 0.134_960_487,
         0.055_808_447, 0.000_387_882, 0.000_001_907, 0.0, 0.0, 0.0],
        [0.888_888_955, 0.870_055_616, 0.782_118_082, 0.534_722_268, 0.119_388_930, 0.055_555_623,
         -0.014_222_255, -0.002_944_246, 0.0, 0.0, 0.0, 0.0],
        [1.0, 0.976_500_034, 0.867_187_5, 0.562_5, 0.068_499_967, 0.0, -0.064_000_130, -0.004_500_230,
         0.0, 0.0, 0.0, 0.0],
        [1.0, 0.981_834_829, 0.890_067_041, 0.607_927_084, 0.093_815_930, 0.0, -0.118_000_582,
         -0.023_769_867, 0.0, 0.029_500_125, 0.001_167_455, 0.0],
    ];

    #[test]
    fn filters_are_mitsubas_at_every_place() {
        for (filter, values) in FILTERS.iter().zip(MITSUBA) {
            // Mitsuba computes in f32: sums of terms up to 10, a few roundings of 6e-8 each. Its Gaussian is
            // a polynomial, which for its own default parameters is 4.2e-4 away from the bell at x = 0.
            let tolerance = match filter {
                ReconstructionFilter::Gaussian { .. } => 4.3e-4,
                _ => 4.0 * 10.0 * 6e-8,
            };
            for (x, value) in PLACES.into_iter().zip(values) {
                for x in [x, -x] {
                    // A box is half open: one of its two ends is in it.
                    if *filter == ReconstructionFilter::Box && x == -0.5 {
                        assert_eq!(filter.eval(x), 1.0);
                        continue;
                    }
                    let difference = (filter.eval(x) - value).abs();
                    assert!(difference <= tolerance, "{filter:?} at {x}: {difference:e}");
                }
            }
        }
    }

    #[test]
    fn radii_and_borders_are_mitsubas() {
        // `radius()` and `border_size()` of the same objects.
        let radii = [0.5, 1.0, 2.0, 2.0, 2.0, 3.0];
        let borders = [0, 1, 2, 2, 2, 3];
        for ((filter, radius), border) in FILTERS.iter().zip(radii).zip(borders) {
            assert_eq!(filter.radius(), radius, "{filter:?}");
            assert_eq!(filter.border(), border, "{filter:?}");
        }
    }

    #[test]
    fn a_filter_is_continuous_and_zero_at_its_radius() {
        for filter in &FILTERS[1..] {
            // The steepest slope of any of them is below 2.
            let inside = filter.eval(filter.radius() - 1e-9);
            assert!(inside.abs() < 2e-9, "{filter:?}: {inside:e}");
            assert_eq!(filter.eval(filter.radius()), 0.0);
        }
    }

    #[test]
    fn the_weights_of_the_pixels_round_a_point_sum_to_one_where_they_should() {
        for step in 0..100 {
            let at = f64::from(step) / 100.0;
            let sum = |filter: &ReconstructionFilter| -> f64 {
                (-5..=5)
                    .map(|pixel| filter.eval(f64::from(pixel) - at))
                    .sum()
            };
            // Box, tent and the cubics are partitions of unity, which is algebra: a dozen roundings.
            for filter in [0, 1, 3, 4].map(|index| &FILTERS[index]) {
                assert!((sum(filter) - 1.0).abs() < 1e-14, "{filter:?} at {at}");
            }
        }
    }
}
