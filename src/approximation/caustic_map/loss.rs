//! Reasons for which photons come to nothing.

use super::variants::Step;
use crate::setting::words::words;

words! {
    /// The reason for which a photon, or a beam's corner, comes to nothing.
    Loss {
        /// Light would enter a closed object by its back
        EntersBehind = "enters by a back face",
        /// A position is beyond the largest number of the buffer
        TooLarge = "beyond the buffer's largest number",
        /// The surface does not let light go on this way, at this angle or on this side
        Opaque = "the surface lets no light go on",
        /// The picture has no back face where one is needed
        NoBackFace = "no back face",
        /// The exit would reflect all
        TotalReflection = "total reflection at the exit",
        /// Inside, the ray meets no second interface
        NoSecondInterface = "no second interface",
        /// Behind the object, the ray meets another specular surface
        Specular = "meets another specular surface",
        /// The march left the light's picture, or ended before it met a receiver
        NoReceiver = "meets no receiver",
        /// It lands where no map has texels
        OutsideMap = "lands outside the map",
        /// It lands beside the sensor, or behind it
        BesideSensor = "lands beside the sensor, or behind it",
    }
}

impl Loss {
    /// The stage at which it happens.
    pub fn step(self) -> Step {
        match self {
            Self::EntersBehind | Self::TooLarge => Step::View,
            Self::Opaque | Self::NoBackFace | Self::TotalReflection | Self::NoSecondInterface => {
                Step::Refraction
            }
            Self::Specular | Self::NoReceiver => Step::Hit,
            Self::OutsideMap => Step::Splat,
            Self::BesideSensor => Step::Lookup,
        }
    }
}
