//! The risk of a false alarm, and what all comparisons share.

use nephroid::internals::numeric::StreamKind;
use nephroid::internals::run::Estimate;

use crate::support::Compared;
use crate::support::scenes::layer;

/// Probability that a right program fails this folder.
pub const ALPHA: f64 = 1e-6;

/// More than the comparisons of this folder: about 60 layers of at most 256 regions, and a handful
/// of moments. [`ALPHA`] is shared among them.
pub const COMPARISONS: usize = 20_000;

/// Regions a side of a coarse grid: large enough for thousands of photons each.
pub const REGIONS: usize = 16;

impl Compared {
    pub fn assert_regions(&self, least: usize) {
        self.assert_every_texel_agrees(least, ALPHA, COMPARISONS);
    }

    pub fn assert_texels(&self, least: usize) {
        self.assert_every_texel_agrees(least, ALPHA, COMPARISONS);
        self.assert_honest_errors(least, ALPHA, COMPARISONS);
    }
}

/// Both kinds of sample points.
pub const STREAMS: [StreamKind; 2] = [StreamKind::Sobol, StreamKind::Random];

/// Direct light is no random estimate: its error is a bound, and the closed form must lie within.
///
/// 2 x 2 Gauss points on leaves below 1/64 of the distance err by less than 1e-8 of the irradiance. A corner
/// of a shadow may hide between two points that are 1/16 of a texel apart: at most a right-angled triangle of
/// (1/16)²/4 of the texel.
pub fn assert_direct_light_is_within_its_bound(estimate: &Estimate, truth: &[f64]) {
    let (values, bounds) = layer(estimate, "LD", 0);
    let brightest = truth.iter().fold(0.0, |most: f64, value| most.max(*value));
    assert!(brightest > 0.0);
    let hidden = brightest / 1024.0;
    let mut error = 0.0;
    for texel in 0..truth.len() {
        let off = (values[texel] - truth[texel]).abs();
        let allowed = bounds[texel] + 1e-8 * truth[texel] + hidden;
        error += bounds[texel];
        assert!(
            off <= allowed,
            "texel {texel}: {} ± {}, the closed form {}: off by {off:e}, allowed {allowed:e}",
            values[texel],
            bounds[texel],
            truth[texel]
        );
    }
    // Bounds that allow anything would prove nothing. A texel on an edge is uncertain by about 1e-4 of its
    // light (`tests/lights/direct.rs`), where edges of several things run by 1/64 of it.
    let lit: f64 = truth.iter().sum();
    println!("LD: the bounds are {:.1e} of all light", error / lit);
    assert!(error < 2e-3 * lit, "{error} of {lit}");
}
