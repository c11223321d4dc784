//! What a caustic map is asked to do: one enum a stage, each setting by a key and a word.

use std::fmt::Display;
use std::str::FromStr;

use crate::approximation::{SettingError, Stage};

/// Makes an enum whose variants have names, for settings and reports.
macro_rules! variants {
    ($(#[$doc:meta])* $name:ident { $($(#[$variant_doc:meta])* $variant:ident = $text:literal,)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
        pub enum $name { $($(#[$variant_doc])* #[serde(rename = $text)] $variant,)* }

        impl $name {
            /// All of them.
            pub const ALL: &[Self] = &[$(Self::$variant,)*];

            /// Its word.
            pub fn name(self) -> &'static str {
                match self { $(Self::$variant => $text,)* }
            }

            fn parse(key: &str, text: &str) -> Result<Self, SettingError> {
                let found = Self::ALL.iter().copied().find(|one| one.name() == text);
                let all: Vec<&str> = Self::ALL.iter().map(|one| one.name()).collect();
                found.ok_or_else(|| SettingError::value(key, text, all.join(", ")))
            }
        }
    };
}

variants! {
    /// Which light is modelled.
    Mode {
        /// Through two interfaces of a refractor: `LTTD`.
        Refraction = "refraction",
        /// By one mirror reflection: `LRD`.
        Reflection = "reflection",
    }
}

variants! {
    /// What the light view's pictures are stored in: positions, normals and depths.
    Buffers {
        /// Half floats (16 bits); depth in 24 bits, as a depth buffer of a pyramid has them.
        F16 = "f16",
        /// Floats (32 bits); depth in 24 bits.
        F32 = "f32",
        /// As computed.
        Exact = "exact",
    }
}

impl Buffers {
    /// Bytes of a number.
    pub fn bytes(self) -> u64 {
        match self {
            Self::F16 => 2,
            Self::F32 => 4,
            Self::Exact => 8,
        }
    }
}

variants! {
    /// How light leaves the specular object.
    Refraction {
        /// Wyman 2005: the exit point at an interpolated distance, its normal from a picture of back faces.
        ImageSpace = "image-space",
        /// The ray is traced through the object.
        Exact = "exact",
    }
}

variants! {
    /// How a photon meets the receiver.
    Hit {
        /// A march through the receivers' depth map, then bisection.
        DepthMap = "depth-map",
        /// The ray is traced.
        Exact = "exact",
    }
}

variants! {
    /// How much light a photon stands for.
    Flux {
        /// All pixels of the light view alike.
        Uniform = "uniform",
        /// By the solid angle of its pixel.
        Exact = "exact",
    }
}

variants! {
    /// What interfaces let through.
    Fresnel {
        /// All of it.
        None = "none",
        /// Schlick's approximation.
        Schlick = "schlick",
        /// Fresnel's equations.
        Exact = "exact",
    }
}

variants! {
    /// How a photon's light is spread.
    Splat {
        /// One Gaussian for all (Wyman and Davis 2006).
        Fixed = "fixed",
        /// Into one texel; looked up in a chain of box-filtered maps.
        Mip = "mip",
        /// Into every level of a chain of maps.
        MipSplat = "mip-splat",
        /// Four Gaussians and counts (section 4.1).
        MultiResolution = "multi-resolution",
        /// A Gaussian as wide as a thin lens makes the beam (section 4.2).
        ThinLens = "thin-lens",
        /// ... as a thick lens makes it.
        ThickLens = "thick-lens",
        /// An ellipse from the beam's exact derivatives.
        TwoCurvatures = "two-curvatures",
        /// No photons: beams between the pixels' corners.
        Exact = "exact",
    }
}

variants! {
    /// How irradiance is read.
    Lookup {
        /// The texel.
        Nearest = "nearest",
        /// Four texels, interpolated.
        Bilinear = "bilinear",
        /// Light is dealt out to the sensor's own texels, by area.
        Exact = "exact",
    }
}

variants! {
    /// What the photon buffer's image holds.
    Frustum {
        /// Specular objects and receivers, as the caustic map's does.
        Scene = "scene",
        /// Specular objects only.
        Object = "object",
    }
}

/// All settings of a caustic map. The default is the thin-lens technique of the report at 512² photons.
#[derive(Clone, Debug, PartialEq, serde::Serialize)]
pub struct Settings {
    /// Which light; `None` is refraction where something refracts.
    pub mode: Option<Mode>,
    /// Photons a row of the photon buffer, and rows: N.
    pub photons: u32,
    /// Texels a row of the caustic map, and rows: M.
    pub map: u32,
    /// What the photon buffer looks at.
    pub frustum: Frustum,
    /// Stage `view`.
    pub view: Buffers,
    /// Stage `refraction`.
    pub refraction: Refraction,
    /// Stage `hit`.
    pub hit: Hit,
    /// Steps of the depth-map march.
    pub steps: u32,
    /// Bisections after it.
    pub bisections: u32,
    /// Stage `flux`.
    pub flux: Flux,
    /// Stage `fresnel`.
    pub fresnel: Fresnel,
    /// Stage `splat`.
    pub splat: Splat,
    /// Diameter of a fixed splat, in map texels.
    pub splat_size: f64,
    /// Diameter of a splat of light that nothing refracts, in pixels of the photon buffer: D₀ of eq. 7 by N and M.
    pub base_size: f64,
    /// The largest diameter of a splat, in map texels.
    pub largest_splat: f64,
    /// Photons a texel from which on there is no noise.
    pub dense: u32,
    /// How often a pixel at the border of a beam is divided (exact splats).
    pub border_levels: u32,
    /// Stage `lookup`.
    pub lookup: Lookup,
    /// Look-ups along each side of a sensor's texel.
    pub samples: u32,
    /// How much deeper than the depth map a point may be and still be lit, as a fraction of the range of depths.
    pub bias: f64,
    /// Frames averaged, each with the photons shifted by a part of a pixel.
    pub frames: u32,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mode: None,
            photons: 512,
            map: 512,
            frustum: Frustum::Scene,
            view: Buffers::F32,
            refraction: Refraction::ImageSpace,
            hit: Hit::DepthMap,
            steps: 64,
            bisections: 8,
            flux: Flux::Uniform,
            fresnel: Fresnel::None,
            splat: Splat::ThinLens,
            splat_size: 7.0,
            base_size: 3.0,
            largest_splat: 63.0,
            dense: 16,
            border_levels: 3,
            lookup: Lookup::Bilinear,
            samples: 4,
            bias: 0.01,
            frames: 1,
        }
    }
}

impl Settings {
    /// The largest side of a photon buffer or a map: 16384² texels of three `f64` are 6.4 GB.
    pub const LARGEST_SIDE: u32 = 16384;

    /// All keys.
    pub const KEYS: &[&str] = &[
        "mode",
        "photons",
        "map",
        "frustum",
        "view",
        "refraction",
        "hit",
        "steps",
        "bisections",
        "flux",
        "fresnel",
        "splat",
        "splat-size",
        "base-size",
        "largest-splat",
        "dense",
        "border-levels",
        "lookup",
        "samples",
        "bias",
        "frames",
    ];

    /// The stages in the order in which they run.
    pub fn stages(&self) -> Vec<Stage> {
        let stage = |name, variant: &str, exact| Stage {
            name,
            variant: variant.to_owned(),
            exact,
        };
        vec![
            stage("view", self.view.name(), Buffers::Exact.name()),
            stage(
                "refraction",
                self.refraction.name(),
                Refraction::Exact.name(),
            ),
            stage("hit", self.hit.name(), Hit::Exact.name()),
            stage("flux", self.flux.name(), Flux::Exact.name()),
            stage("fresnel", self.fresnel.name(), Fresnel::Exact.name()),
            stage("splat", self.splat.name(), Splat::Exact.name()),
            stage("lookup", self.lookup.name(), Lookup::Exact.name()),
        ]
    }

    /// The value of each key, as [`set`](Self::set) takes it.
    pub fn values(&self) -> Vec<(&'static str, String)> {
        let mode = self.mode.map_or("auto", Mode::name);
        let texts = [
            mode.to_owned(),
            self.photons.to_string(),
            self.map.to_string(),
            self.frustum.name().to_owned(),
            self.view.name().to_owned(),
            self.refraction.name().to_owned(),
            self.hit.name().to_owned(),
            self.steps.to_string(),
            self.bisections.to_string(),
            self.flux.name().to_owned(),
            self.fresnel.name().to_owned(),
            self.splat.name().to_owned(),
            self.splat_size.to_string(),
            self.base_size.to_string(),
            self.largest_splat.to_string(),
            self.dense.to_string(),
            self.border_levels.to_string(),
            self.lookup.name().to_owned(),
            self.samples.to_string(),
            self.bias.to_string(),
            self.frames.to_string(),
        ];
        Self::KEYS.iter().copied().zip(texts).collect()
    }

    /// Changes one setting.
    ///
    /// # Errors
    ///
    /// For a key that is none of [`KEYS`](Self::KEYS), and for a value that it cannot have.
    pub fn set(&mut self, key: &str, value: &str) -> Result<(), SettingError> {
        match key {
            "mode" if value == "auto" => self.mode = None,
            "mode" => self.mode = Some(Mode::parse(key, value)?),
            "photons" => self.photons = number(key, value, 1, Self::LARGEST_SIDE)?,
            "map" => self.map = number(key, value, 1, Self::LARGEST_SIDE)?,
            "frustum" => self.frustum = Frustum::parse(key, value)?,
            "view" => self.view = Buffers::parse(key, value)?,
            "refraction" => self.refraction = Refraction::parse(key, value)?,
            "hit" => self.hit = Hit::parse(key, value)?,
            "steps" => self.steps = number(key, value, 1, 65536)?,
            "bisections" => self.bisections = number(key, value, 0, 64)?,
            "flux" => self.flux = Flux::parse(key, value)?,
            "fresnel" => self.fresnel = Fresnel::parse(key, value)?,
            "splat" => self.splat = Splat::parse(key, value)?,
            "splat-size" => self.splat_size = number(key, value, 1.0, 1024.0)?,
            "base-size" => self.base_size = number(key, value, 0.125, 64.0)?,
            "largest-splat" => self.largest_splat = number(key, value, 1.0, 1024.0)?,
            "dense" => self.dense = number(key, value, 1, 1 << 20)?,
            "border-levels" => self.border_levels = number(key, value, 0, 8)?,
            "lookup" => self.lookup = Lookup::parse(key, value)?,
            "samples" => self.samples = number(key, value, 1, 64)?,
            "bias" => self.bias = number(key, value, 0.0, 1.0)?,
            "frames" => self.frames = number(key, value, 1, 4096)?,
            _ => {
                let keys = Self::KEYS.iter().copied();
                return Err(SettingError::unknown("setting", key, keys));
            }
        }
        Ok(())
    }

    /// Checks what fields that were set directly may hold.
    ///
    /// # Errors
    ///
    /// For the first that [`set`](Self::set) would not have taken.
    pub fn check(&self) -> Result<(), SettingError> {
        let mut copy = self.clone();
        self.values()
            .iter()
            .try_for_each(|(key, value)| copy.set(key, value))
    }
}

/// A number between two.
fn number<T: FromStr + PartialOrd + Display + Copy>(
    key: &str,
    text: &str,
    low: T,
    high: T,
) -> Result<T, SettingError> {
    match text.parse::<T>() {
        Ok(value) if value >= low && value <= high => Ok(value),
        _ => Err(SettingError::value(
            key,
            text,
            format!("numbers from {low} to {high}"),
        )),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_key_takes_the_value_that_it_has() {
        let settings = Settings::default();
        let values = settings.values();
        assert_eq!(values.len(), Settings::KEYS.len());
        settings.check().unwrap();
        let mut copy = Settings {
            photons: 7,
            bias: 0.5,
            ..Settings::default()
        };
        for (key, value) in &values {
            copy.set(key, value).unwrap();
        }
        assert_eq!(copy, settings);
    }

    #[test]
    fn every_stage_can_be_set_exact_by_its_name() {
        let mut settings = Settings::default();
        for stage in Settings::default().stages() {
            settings.set(stage.name, stage.exact).unwrap();
        }
        assert!(settings.stages().iter().all(Stage::is_exact));
    }

    #[test]
    fn hostile_values_are_refused_with_what_is_allowed() {
        let mut settings = Settings::default();
        for (key, value) in [
            ("photons", "0"),
            ("photons", "-1"),
            ("map", "0"),
            ("map", "99999"),
            ("bias", "nan"),
            ("bias", "inf"),
            ("splat", "gaussian"),
            ("samples", ""),
        ] {
            let error = settings.set(key, value).unwrap_err().to_string();
            assert!(error.contains("allowed are"), "{key}={value}: {error}");
        }
        settings.photons = 0;
        assert!(settings.check().is_err());
    }
}
