//! Patches of charts, and the light that starts in them.

use glam::DVec2;

use crate::geometry::Ray;
use crate::radiometry::Rgb;

/// A rectangle of chart coordinates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ChartPatch {
    /// The lowest coordinates.
    pub from: DVec2,
    /// The highest coordinates.
    pub to: DVec2,
}

impl ChartPatch {
    /// The coordinates at fractions `at` (in 0..=1) across the patch.
    #[inline]
    pub fn at(&self, at: DVec2) -> DVec2 {
        self.from + (self.to - self.from) * at
    }

    /// Its area in chart coordinates.
    #[inline]
    pub fn area(&self) -> f64 {
        let size = self.to - self.from;
        size.x * size.y
    }

    /// Its quarters, in Morton order.
    pub fn quarters(&self) -> [Self; 4] {
        std::array::from_fn(|i| {
            let corner = DVec2::new((i & 1) as f64, (i >> 1) as f64);
            Self {
                from: self.at(0.5 * corner),
                to: self.at(0.5 * corner + 0.5),
            }
        })
    }

    /// Its corners, in order round it.
    pub(super) fn corners(&self) -> [DVec2; 4] {
        [
            self.from,
            DVec2::new(self.to.x, self.from.y),
            self.to,
            DVec2::new(self.from.x, self.to.y),
        ]
    }
}

/// One ray of a patch's light.
#[derive(Clone, Copy, Debug)]
pub struct Emission {
    /// The ray.
    pub ray: Ray,
    /// Flux \[W\] divided by the chart's [strength](super::chart::LightChart::strength): the flux density
    /// there times the patch's measure. Its mean over uniform samples of the patch, times the strength, is
    /// the patch's flux.
    pub measure: f64,
    /// A factor on the strength, where light of a chart has more than one colour.
    pub color: Option<Rgb>,
}
