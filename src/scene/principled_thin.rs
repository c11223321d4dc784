//! Disney's principled material for thin sheets, as Mitsuba has it.

use super::texture::{Color, Scalar};

/// A sheet without thickness, the same on both sides: Mitsuba's `principledthin` (Burley 2015). It has a matt
/// part, light that leaves matt on its other side, and a rough mirror with what passes it unbent. All numbers
/// are in 0..=1, but for `eta` and `diff_trans`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PrincipledThin {
    /// The colour of the matt parts and of light that passes through.
    pub base_color: Color,
    /// The roughness of the mirror: α is its square. That of light that passes is 0.65 `eta` − 0.35 times as
    /// much.
    pub roughness: Scalar,
    /// The ratio of the roughness along both tangents: 0 for the same, 1 for √10 and 1/√10 times as much.
    pub anisotropic: Scalar,
    /// The share of the mirror and of what passes it; the rest is matt.
    pub spec_trans: Scalar,
    /// The index inside divided by that outside.
    pub eta: f64,
    /// The share of the reflection that has the base's hue.
    pub spec_tint: Scalar,
    /// The strength of the glow at grazing angles, as of cloth.
    pub sheen: Scalar,
    /// The share of the sheen that has the base's hue.
    pub sheen_tint: Scalar,
    /// The share of the matt part that looks flat, as if light entered it.
    pub flatness: Scalar,
    /// Of the matt part, twice the share that leaves on the other side: 0..=2.
    pub diff_trans: Scalar,
}

impl PrincipledThin {
    /// All its shares that may vary, with their names in a file.
    pub fn shares(&self) -> [(&'static str, Scalar); 7] {
        [
            ("roughness", self.roughness),
            ("anisotropic", self.anisotropic),
            ("spec_trans", self.spec_trans),
            ("spec_tint", self.spec_tint),
            ("sheen", self.sheen),
            ("sheen_tint", self.sheen_tint),
            ("flatness", self.flatness),
        ]
    }

    /// All its numbers that may vary.
    pub fn scalars(&self) -> impl Iterator<Item = Scalar> {
        let shares = self.shares().map(|(_, share)| share);
        shares.into_iter().chain([self.diff_trans])
    }

    /// True if it may mirror.
    pub fn is_interface(&self) -> bool {
        self.spec_trans.may_exceed_zero()
    }
}
