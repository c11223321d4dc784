//! Views from a texel's points at a delta emitter, and their sums.

use super::texel::DirectTexel;
use crate::radiometry::Rgb;

/// The least and the largest share of an emitter that some points see.
#[derive(Clone, Copy)]
pub(super) struct ShareRange {
    pub(super) least: f64,
    pub(super) most: f64,
}

impl ShareRange {
    pub(super) const NOTHING_SEEN: Self = Self {
        least: f64::INFINITY,
        most: f64::NEG_INFINITY,
    };

    pub(super) fn of(share: f64) -> Self {
        Self {
            least: share,
            most: share,
        }
    }

    pub(super) fn with(self, other: Self) -> Self {
        Self {
            least: self.least.min(other.least),
            most: self.most.max(other.most),
        }
    }

    pub(super) fn with_share(self, share: f64) -> Self {
        self.with(Self::of(share))
    }

    pub(super) fn is_mixed(self) -> bool {
        self.least < self.most
    }
}

/// Light of a leaf's points, weighted by the surface around them.
pub(super) struct LeafLight {
    /// Irradiance times area [W].
    pub(super) flux: Rgb,
    /// The same without shadow.
    pub(super) unshadowed: Rgb,
    /// The leaf's surface [m²], estimated from its points.
    pub(super) area: f64,
    /// The least and the most irradiance without shadow at any point.
    pub(super) range: (Rgb, Rgb),
    pub(super) passed: ShareRange,
    /// Number of points that are on the surface.
    pub(super) found: usize,
    /// True if the points are not on one smooth surface.
    pub(super) is_ragged: bool,
}

/// Number of Gauss points of a leaf.
pub(super) const POINTS: usize = 4;

/// Largest relative uncertainty of a leaf's irradiance, if its faces stretch or lean differently.
///
/// The uncertainty is the spread of irradiances over the leaf times the leaf's share of its texel.
const ROUGH: f64 = 1e-3;

impl LeafLight {
    /// True if smaller leaves than this one, `size` of a texel wide, would find more surface or a better
    /// irradiance.
    ///
    /// A leaf without any surface counts as rough, since a texel has some.
    pub(super) fn is_rough(&self, size: f64) -> bool {
        let spread = (self.range.1 - self.range.0).max_channel() * size * size;
        self.found < POINTS || self.is_ragged && spread > ROUGH * self.range.1.max_channel()
    }
}

/// A texel's sums over its leaves.
pub(super) struct Sum {
    pub(super) flux: Rgb,
    pub(super) error: Rgb,
    pub(super) area: f64,
    /// The part of `area` in leaves that are not on one smooth surface.
    pub(super) ragged: f64,
    pub(super) range: (Rgb, Rgb),
}

/// The range of no irradiance at all.
pub(super) const NO_RANGE: (Rgb, Rgb) = (Rgb::grey(f64::INFINITY), Rgb::grey(f64::NEG_INFINITY));

/// The smallest range that holds both ranges.
pub(super) fn joined(a: (Rgb, Rgb), b: (Rgb, Rgb)) -> (Rgb, Rgb) {
    (
        Rgb(std::array::from_fn(|c| a.0.0[c].min(b.0.0[c]))),
        Rgb(std::array::from_fn(|c| a.1.0[c].max(b.1.0[c]))),
    )
}

impl Sum {
    pub(super) const NOTHING: Self = Self {
        flux: Rgb::BLACK,
        error: Rgb::BLACK,
        area: 0.0,
        ragged: 0.0,
        range: NO_RANGE,
    };

    pub(super) fn add(&mut self, look: &LeafLight) {
        self.flux += look.flux;
        self.area += look.area;
        if look.is_ragged {
            self.ragged += look.area;
        }
        self.range = joined(self.range, look.range);
    }

    /// The average over the surface found; `None` if none was.
    ///
    /// The distribution of irradiance over the surface is uncertain for ragged leaves, as far as these leaves
    /// reach. The irradiance of all of it is in the range seen.
    pub(super) fn average(&self) -> Option<DirectTexel> {
        (self.area > 0.0).then(|| DirectTexel {
            irradiance: self.flux / self.area,
            error: if self.ragged > 0.0 {
                let spread = self.range.1 - self.range.0;
                (self.error + spread * self.ragged) / self.area
            } else {
                self.error / self.area
            },
        })
    }
}
