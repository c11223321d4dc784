//! A map as a distribution of light: shares of texels that add up to one.

use glam::DVec2;

/// Shares of the light, texel by texel; they are not negative and add up to one.
pub(super) struct Measure {
    /// Texels a row and rows.
    pub(super) size: [usize; 2],
    /// Row by row.
    pub(super) shares: Vec<f64>,
}

impl Measure {
    /// The shares of values; those below zero, which no light has, count as zero. `None` if none is above.
    pub(super) fn new(size: [usize; 2], value: impl Fn(usize) -> f64) -> Option<Self> {
        let mut shares: Vec<f64> = (0..size[0] * size[1]).map(|i| value(i).max(0.0)).collect();
        let sum: f64 = shares.iter().sum();
        if sum <= 0.0 || !sum.is_finite() {
            return None;
        }
        for share in &mut shares {
            *share /= sum;
        }
        Some(Self { size, shares })
    }

    /// The centre of a texel, if texels are so wide and high.
    pub(super) fn place(&self, texel: usize, spacing: [f64; 2]) -> DVec2 {
        let [width, _] = self.size;
        DVec2::new(
            spacing[0] * ((texel % width) as f64 + 0.5),
            spacing[1] * ((texel / width) as f64 + 0.5),
        )
    }

    /// The centre of all light.
    pub(super) fn centre(&self, spacing: [f64; 2]) -> DVec2 {
        let shares = self.shares.iter().enumerate();
        shares.fold(DVec2::ZERO, |sum, (texel, share)| {
            sum + *share * self.place(texel, spacing)
        })
    }
}
