//! Disney's principled material, as Mitsuba has it.

use super::texture::{Color, Scalar};

/// A matt base, a main interface with metallic and transparent parts, sheen, and a second coat: Mitsuba's
/// `principled` (Burley 2012 and 2015). All numbers are in 0..=1, but for the index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Principled {
    /// The colour of the base, of metal, and of light that passes through (by its square root at each
    /// interface).
    pub base_color: Color,
    /// The roughness of the main interface: α is its square.
    pub roughness: Scalar,
    /// The ratio of its roughness along both tangents: 0 for the same, 1 for √10 and 1/√10 times as much.
    pub anisotropic: Scalar,
    /// The share of metal.
    pub metallic: Scalar,
    /// Of what is no metal, the share that light passes through.
    pub spec_trans: Scalar,
    /// The index inside divided by that outside.
    pub eta: f64,
    /// The share of the main reflection that has the base's hue.
    pub spec_tint: Scalar,
    /// The strength of the glow at grazing angles, as of cloth.
    pub sheen: Scalar,
    /// The share of the sheen that has the base's hue.
    pub sheen_tint: Scalar,
    /// The share of the base that looks flat, as if light entered it.
    pub flatness: Scalar,
    /// The strength of the second coat.
    pub clearcoat: Scalar,
    /// How sharp the second coat's reflection is: α from 0.1 to 0.001.
    pub clearcoat_gloss: Scalar,
}

impl Principled {
    /// All its numbers that may vary, with their names in a file.
    pub fn scalars(&self) -> [(&'static str, Scalar); 10] {
        [
            ("roughness", self.roughness),
            ("anisotropic", self.anisotropic),
            ("metallic", self.metallic),
            ("spec_trans", self.spec_trans),
            ("spec_tint", self.spec_tint),
            ("sheen", self.sheen),
            ("sheen_tint", self.sheen_tint),
            ("flatness", self.flatness),
            ("clearcoat", self.clearcoat),
            ("clearcoat_gloss", self.clearcoat_gloss),
        ]
    }

    /// True if most of its light may be that of an interface: metal, or what light passes through.
    pub fn is_interface(&self) -> bool {
        self.metallic.may_exceed_zero() || self.spec_trans.may_exceed_zero()
    }
}
