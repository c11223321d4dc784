//! The settings of a caustic map: a key a setting, one enum a stage.

use crate::approximation::interface::Fresnel;
use crate::approximation::{Precision, Stage};
use crate::setting::table::row;
use crate::setting::words::words;
use crate::setting::{Kind, Setting, Values, words_of};

words! {
    /// The light that is modelled.
    Mode {
        /// Through two interfaces of a refractor: `LTTD`
        Refraction = "refraction",
        /// By one mirror reflection: `LRD`
        Reflection = "reflection",
    }
}

words! {
    /// The way in which light leaves the specular object.
    Refraction {
        /// Wyman 2005: the exit point at an interpolated distance, its normal from a picture of back faces
        ImageSpace = "image-space",
        /// The ray is traced through the object
        Exact = "exact",
    }
}

words! {
    /// The way in which a photon meets the receiver.
    Hit {
        /// A march through the receivers' depth map, then bisection
        DepthMap = "depth-map",
        /// The ray is traced
        Exact = "exact",
    }
}

words! {
    /// The light that a photon stands for.
    Flux {
        /// All pixels of the light view alike
        Uniform = "uniform",
        /// By the solid angle of its pixel
        Exact = "exact",
    }
}

words! {
    /// The spread of a photon's light.
    Splat {
        /// One Gaussian for all (Wyman and Davis 2006)
        Fixed = "fixed",
        /// Into one texel; looked up in a chain of box-filtered maps
        Mip = "mip",
        /// Into every level of a chain of maps
        MipSplat = "mip-splat",
        /// Four Gaussians and counts (section 4.1)
        MultiResolution = "multi-resolution",
        /// A Gaussian as wide as a thin lens makes the beam (section 4.2)
        ThinLens = "thin-lens",
        /// A Gaussian as wide as a thick lens makes the beam
        ThickLens = "thick-lens",
        /// An ellipse from the beam's exact derivatives
        TwoCurvatures = "two-curvatures",
        /// No photons: beams between the pixels' corners
        Exact = "exact",
    }
}

words! {
    /// The way in which irradiance is read.
    Lookup {
        /// The texel
        Nearest = "nearest",
        /// Four texels, interpolated
        Bilinear = "bilinear",
        /// Light is dealt out to the sensor's own texels, by area
        Exact = "exact",
    }
}

words! {
    /// The contents of the photon buffer's image.
    Frustum {
        /// Specular objects and receivers, as the caustic map's does
        Scene = "scene",
        /// Specular objects only
        Object = "object",
    }
}

/// The table of settings.
pub(super) const TABLE: &[Setting] = &[
    row!("mode": Kind::Choice(modes), Rule "refraction if anything refracts", "", "Light that is modelled"),
    row!("photons": SIDE, Value "512", "pixels", "Photons a row of the photon buffer, and rows: N"),
    row!("map": SIDE, Value "512", "texels", "Texels a row of the caustic map, and rows: M"),
    row!("frustum": Kind::Choice(words_of::<Frustum>), Value "scene", "",
        "Contents of the photon buffer's image"),
    row!("view": Kind::Choice(words_of::<Precision>), Value "f32", "",
        "Stage: format of the light view's pictures"),
    row!("refraction": Kind::Choice(words_of::<Refraction>), Value "image-space", "",
        "Stage: way in which light leaves the specular object"),
    row!("hit": Kind::Choice(words_of::<Hit>), Value "depth-map", "",
        "Stage: way in which a photon meets the receiver"),
    row!("steps": Kind::Whole(1, 65536), Value "64", "", "Steps of the depth-map march"),
    row!("bisections": Kind::Whole(0, 64), Value "8", "", "Bisections after the march"),
    row!("flux": Kind::Choice(words_of::<Flux>), Value "uniform", "",
        "Stage: light that a photon stands for"),
    row!("fresnel": Kind::Choice(words_of::<Fresnel>), Value "none", "",
        "Stage: share of light that interfaces let through"),
    row!("splat": Kind::Choice(words_of::<Splat>), Value "thin-lens", "",
        "Stage: spread of a photon's light"),
    row!("splat-size": Kind::Number(1.0, 1024.0), Value "7", "texels of the map",
        "Diameter of a fixed splat"),
    row!("base-size": Kind::Number(0.125, 64.0), Value "3", "pixels of the photon buffer",
        "Diameter of a splat of light that nothing refracts: D0 of eq. 7 by N and M"),
    row!("largest-splat": Kind::Number(1.0, 1024.0), Value "63", "texels of the map",
        "Largest diameter of a splat"),
    row!("dense": Kind::Whole(1, 1 << 20), Value "16", "photons a texel",
        "Density from which on there is no noise"),
    row!("border-levels": Kind::Whole(0, 8), Value "3", "",
        "Divisions of a pixel at the border of a beam (exact splats)"),
    row!("lookup": Kind::Choice(words_of::<Lookup>), Value "bilinear", "",
        "Stage: way in which irradiance is read"),
    row!("samples": Kind::Whole(1, 64), Value "4", "", "Look-ups along each side of a sensor's texel"),
    row!("bias": Kind::Number(0.0, 1.0), Value "0.01", "range of depths",
        "Depth below the depth map at which a point is still lit"),
    row!("frames": Kind::Whole(1, 4096), Value "1", "",
        "Frames averaged, each with the photons shifted by a part of a pixel"),
];

/// The largest side of a photon buffer or a map: 16384² texels of three `f64` are 6.4 GB.
const SIDE: Kind = Kind::Whole(1, 16384);

/// The words of [`Mode`], and the one that leaves it to the scene.
fn modes() -> Vec<(&'static str, &'static str)> {
    let auto = ("auto", "Refraction if anything refracts, else reflection");
    [vec![auto], words_of::<Mode>()].concat()
}

/// The stages in the order in which they run.
pub(super) const STAGES: &[Stage] = &[
    Stage {
        name: "view",
        exact: "exact",
    },
    Stage {
        name: "refraction",
        exact: "exact",
    },
    Stage {
        name: "hit",
        exact: "exact",
    },
    Stage {
        name: "flux",
        exact: "exact",
    },
    Stage {
        name: "fresnel",
        exact: "exact",
    },
    Stage {
        name: "splat",
        exact: "exact",
    },
    Stage {
        name: "lookup",
        exact: "exact",
    },
];

/// The settings of a caustic map, with their types. By default, the thin-lens technique of the report at 512²
/// photons.
#[derive(Clone, Debug, PartialEq)]
pub struct Settings {
    /// The light; `None` is refraction if anything refracts.
    pub mode: Option<Mode>,
    /// Photons a row of the photon buffer, and rows: N.
    pub photons: u32,
    /// Texels a row of the caustic map, and rows: M.
    pub map: u32,
    /// Contents of the photon buffer's image.
    pub frustum: Frustum,
    /// Stage `view`.
    pub view: Precision,
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
    /// Diameter of a splat of light that nothing refracts, in pixels of the photon buffer: D₀ of eq. 7 by N
    /// and M.
    pub base_size: f64,
    /// The largest diameter of a splat, in map texels.
    pub largest_splat: f64,
    /// Photons a texel, from which on there is no noise.
    pub dense: u32,
    /// Divisions of a pixel at the border of a beam (exact splats).
    pub border_levels: u32,
    /// Stage `lookup`.
    pub lookup: Lookup,
    /// Look-ups along each side of a sensor's texel.
    pub samples: u32,
    /// Depth below the depth map at which a point is still lit, as a fraction of the range of depths.
    pub bias: f64,
    /// Frames averaged, each with the photons shifted by a part of a pixel.
    pub frames: u32,
}

impl Settings {
    /// The typed settings of checked values. `None` if a key is missing, which the table does not allow.
    pub(super) fn of(values: &Values) -> Option<Self> {
        Some(Self {
            mode: values.word("mode"),
            photons: values.whole("photons")?,
            map: values.whole("map")?,
            frustum: values.word("frustum")?,
            view: values.word("view")?,
            refraction: values.word("refraction")?,
            hit: values.word("hit")?,
            steps: values.whole("steps")?,
            bisections: values.whole("bisections")?,
            flux: values.word("flux")?,
            fresnel: values.word("fresnel")?,
            splat: values.word("splat")?,
            splat_size: values.number("splat-size")?,
            base_size: values.number("base-size")?,
            largest_splat: values.number("largest-splat")?,
            dense: values.whole("dense")?,
            border_levels: values.whole("border-levels")?,
            lookup: values.word("lookup")?,
            samples: values.whole("samples")?,
            bias: values.number("bias")?,
            frames: values.whole("frames")?,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setting::Given;
    use crate::setting::Preset;

    fn values(pairs: &[(&str, &str)]) -> Result<Values, crate::setting::SettingError> {
        let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
        let given: Given = pairs.iter().map(owned).collect();
        Values::new("caustic-map", TABLE.iter().collect(), &given)
    }

    #[test]
    fn every_default_is_a_value_that_the_setting_takes() {
        for setting in TABLE {
            if let Preset::Value(text) = setting.default {
                assert!(setting.kind.holds(text), "{}={text}", setting.key);
            }
        }
        let default = Settings::of(&values(&[]).unwrap()).unwrap();
        assert_eq!((default.photons, default.splat), (512, Splat::ThinLens));
    }

    #[test]
    fn every_stage_can_be_set_exact_by_its_name() {
        let pairs: Vec<_> = STAGES
            .iter()
            .map(|stage| (stage.name, stage.exact))
            .collect();
        let settings = Settings::of(&values(&pairs).unwrap()).unwrap();
        assert_eq!(settings.view, Precision::Exact);
        assert_eq!(settings.lookup, Lookup::Exact);
        assert_eq!(settings.fresnel, Fresnel::Exact);
    }

    #[test]
    fn hostile_values_are_refused_with_what_is_allowed() {
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
            let error = values(&[(key, value)]).unwrap_err().to_string();
            assert!(error.contains("allowed are"), "{key}={value}: {error}");
        }
    }
}
