//! The surfaces that chains go on from.

use crate::scene::Material;

/// The surfaces from which chains go on: each level holds those before it.
///
/// Coats lie over a matt base (`plastic`, `roughplastic`). At a smooth one light has one more direction, and
/// camera paths cannot find it from a light that is a point. A rough coat and its base share one density:
/// camera paths find both, and do not tell one from the other. So an image that camera paths and photons
/// share leaves rough coats to the former.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Followed {
    /// Mirrors and glass without blur.
    Smooth,
    /// Rough mirrors, rough glass and smooth coats.
    Rough,
    /// Rough coats.
    All,
}

impl Followed {
    /// True if chains go on from a material among `all`, looking through its wrappers.
    pub fn holds(self, material: &Material, all: &[Material]) -> bool {
        self.holds_bare(material, all)
            || self >= Self::Rough && material.has_smooth_coat(all)
            || self >= Self::All && material.has_rough_coat(all)
    }

    /// The same without coats, which reflect a few percent.
    pub fn holds_bare(self, material: &Material, all: &[Material]) -> bool {
        material.is_specular(all) || self >= Self::Rough && material.is_glossy(all)
    }
}
