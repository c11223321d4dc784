//! The settings of a caustic map: one list for their keys, types, defaults and meanings.

use super::variants::{
    BackFaces, Flux, Frustum, Hit, Kernel, Lookup, Mode, NoBackFace, Refraction, Splat, Thickness,
    TotalReflection,
};
use crate::approximation::Precision;
use crate::approximation::interface::Fresnel;
use crate::approximation::table::settings;
use crate::setting::{Kind, Values, words_of};

/// The largest side of a photon buffer or a map: 16384² texels of three `f64` are 6.4 GB.
const SIDE: Kind = Kind::Whole(1, 16384);

/// The words of [`Mode`], and the one that leaves it to the scene.
fn modes() -> Vec<(&'static str, &'static str)> {
    let auto = (
        "auto",
        "Refraction if a closed shape refracts, else single-refraction if any does, else reflection",
    );
    [vec![auto], words_of::<Mode>()].concat()
}

settings! {
    /// The settings of a caustic map, with their types. By default, the thin-lens technique of the report at
    /// 512² photons.
    Settings;
    /// The light; `None` leaves it to the scene.
    mode: Option<Mode> = "mode", Kind::Choice(modes), Rule "refraction if anything refracts", "",
        "Light that is modelled", |values: &Values, key| Some(values.word(key));
    /// Photons a row of the photon buffer, and rows: N.
    photons: u32 = "photons", SIDE, Value "512", "pixels",
        "Photons a row of the photon buffer, and rows: N", Values::whole;
    /// Texels a row of the caustic map, and rows: M.
    map: u32 = "map", SIDE, Value "512", "texels", "Texels a row of the caustic map, and rows: M", Values::whole;
    /// Contents of the photon buffer's image.
    frustum: Frustum = "frustum", Kind::Choice(words_of::<Frustum>), Value "scene", "",
        "Contents of the photon buffer's image", Values::word;
    /// Stage `view`.
    view: Precision = "view", Kind::Choice(words_of::<Precision>), Value "f32", "",
        "Stage: format of the light view's pictures", Values::word;
    /// Stage `refraction`.
    refraction: Refraction = "refraction", Kind::Choice(words_of::<Refraction>), Value "image-space", "",
        "Stage: way in which light leaves the specular object", Values::word;
    /// Distance between entry and exit.
    thickness: Thickness = "thickness", Kind::Choice(words_of::<Thickness>), Value "interpolated", "",
        "Distance between entry and exit (image-space)", Values::word;
    /// Back faces in the picture.
    back: BackFaces = "back", Kind::Choice(words_of::<BackFaces>), Value "farthest", "",
        "Back faces in the picture (image-space)", Values::word;
    /// What to do where the picture has no back face.
    no_back_face: NoBackFace = "no-back-face", Kind::Choice(words_of::<NoBackFace>), Value "side", "",
        "Exit point without a back face in the picture (image-space)", Values::word;
    /// What to do where the exit would reflect all.
    total_reflection: TotalReflection = "total-reflection", Kind::Choice(words_of::<TotalReflection>),
        Value "clamp", "", "Exit beyond the critical angle (image-space)", Values::word;
    /// Stage `hit`.
    hit: Hit = "hit", Kind::Choice(words_of::<Hit>), Value "depth-map", "",
        "Stage: way in which a photon meets the receiver", Values::word;
    /// Steps of the depth-map march.
    steps: u32 = "steps", Kind::Whole(1, 65536), Value "64", "", "Steps of the depth-map march", Values::whole;
    /// Bisections after it.
    bisections: u32 = "bisections", Kind::Whole(0, 64), Value "8", "", "Bisections after the march", Values::whole;
    /// Stage `flux`.
    flux: Flux = "flux", Kind::Choice(words_of::<Flux>), Value "density-ratio", "",
        "Stage: light that a photon stands for", Values::word;
    /// Stage `fresnel`.
    fresnel: Fresnel = "fresnel", Kind::Choice(words_of::<Fresnel>), Value "none", "",
        "Stage: share of light that interfaces let through", Values::word;
    /// Stage `splat`.
    splat: Splat = "splat", Kind::Choice(words_of::<Splat>), Value "thin-lens", "",
        "Stage: spread of a photon's light", Values::word;
    /// Form of round splats.
    kernel: Kernel = "kernel", Kind::Choice(words_of::<Kernel>), Value "gaussian", "",
        "Form of fixed, multi-resolution and lens splats", Values::word;
    /// Diameter of a fixed splat, in map texels.
    splat_size: f64 = "splat-size", Kind::Number(1.0, 1024.0), Value "7", "texels of the map",
        "Diameter of a fixed splat", Values::number;
    /// Diameter of a splat of light that nothing refracts, in pixels of the photon buffer: D₀ of eq. 7 by N
    /// and M.
    base_size: f64 = "base-size", Kind::Number(0.125, 64.0), Value "3", "pixels of the photon buffer",
        "Diameter of a splat of light that nothing refracts: D0 of eq. 7 by N and M", Values::number;
    /// The largest diameter of a splat, in map texels.
    largest_splat: f64 = "largest-splat", Kind::Number(1.0, 1024.0), Value "63", "texels of the map",
        "Largest diameter of a splat", Values::number;
    /// Photons a texel, from which on there is no noise.
    dense: u32 = "dense", Kind::Whole(1, 1 << 20), Value "16", "photons a texel",
        "Density from which on there is no noise", Values::whole;
    /// Divisions of a pixel at the border of a beam (exact splats).
    border_levels: u32 = "border-levels", Kind::Whole(0, 8), Value "3", "",
        "Divisions of a pixel at the border of a beam (exact splats)", Values::whole;
    /// Stage `lookup`.
    lookup: Lookup = "lookup", Kind::Choice(words_of::<Lookup>), Value "bilinear", "",
        "Stage: way in which irradiance is read", Values::word;
    /// Look-ups along each side of a sensor's texel.
    samples: u32 = "samples", Kind::Whole(1, 64), Value "4", "",
        "Look-ups along each side of a sensor's texel", Values::whole;
    /// Depth below the depth map at which a point is still lit, as a fraction of the range of depths.
    bias: f64 = "bias", Kind::Number(0.0, 1.0), Value "0.01", "range of depths",
        "Depth below the depth map at which a point is still lit", Values::number;
    /// Frames averaged, each with the photons shifted by a part of a pixel.
    frames: u32 = "frames", Kind::Whole(1, 4096), Value "1", "",
        "Frames averaged, each with the photons shifted by a part of a pixel", Values::whole;
}

#[cfg(test)]
mod tests {
    use super::super::variants::STAGES;
    use super::*;
    use crate::setting::{Given, Preset, Setting};

    fn values(pairs: &[(&str, &str)]) -> Result<Values, crate::setting::SettingError> {
        let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
        let given: Given = pairs.iter().map(owned).collect();
        Values::new("caustic-map", TABLE.iter().collect(), &given)
    }

    /// Another value than the default that a setting takes.
    fn another(setting: &Setting) -> String {
        let default = match setting.default {
            Preset::Value(text) => text,
            Preset::Rule(_) => "auto",
        };
        let mut candidates: Vec<String> = (1..9).map(|number| number.to_string()).collect();
        candidates.push("0.5".to_owned());
        let words = setting.kind.words();
        candidates.extend(words.into_iter().map(|(word, _)| word.to_owned()));
        let found = candidates
            .into_iter()
            .find(|it| it != default && setting.kind.holds(it));
        found.unwrap_or_else(|| panic!("{} has one value only", setting.key))
    }

    #[test]
    fn every_default_is_a_value_that_the_setting_takes() {
        for setting in TABLE {
            if let Preset::Value(text) = setting.default {
                assert!(setting.kind.holds(text), "{}={text}", setting.key);
            }
        }
    }

    #[test]
    fn every_key_changes_its_own_field_and_no_other() {
        // Fields as Debug prints them, a line each.
        let lines = |settings: &Settings| -> Vec<String> {
            let text = format!("{settings:#?}").replace("(\n        ", "(");
            text.lines().map(str::to_owned).collect()
        };
        let default = lines(&Settings::of(&values(&[]).unwrap()).unwrap());
        for setting in TABLE {
            let value = another(setting);
            let changed = Settings::of(&values(&[(setting.key, &value)]).unwrap()).unwrap();
            let field = format!("{}:", setting.key.replace('-', "_"));
            let changed = lines(&changed);
            let pairs = default.iter().zip(&changed);
            let differing: Vec<_> = pairs.filter(|(a, b)| a != b).collect();
            let is_own = differing
                .first()
                .is_some_and(|(a, _)| a.trim().starts_with(&field));
            assert!(is_own, "{}={value}: {differing:?}", setting.key);
            // What is optional takes more lines.
            let is_optional = setting.key == "mode";
            assert!(differing.len() == 1 || is_optional, "{differing:?}");
        }
    }

    #[test]
    fn every_stage_can_be_set_exact_by_its_name() {
        let pairs: Vec<_> = STAGES
            .iter()
            .map(|stage| (stage.name, stage.exact))
            .collect();
        let settings = Settings::of(&values(&pairs).unwrap()).unwrap();
        assert_eq!(settings.view, Precision::Exact);
        assert_eq!(settings.refraction, Refraction::Exact);
        assert_eq!(settings.hit, Hit::Exact);
        assert_eq!(settings.flux, Flux::Exact);
        assert_eq!(settings.fresnel, Fresnel::Exact);
        assert_eq!(settings.splat, Splat::Exact);
        assert_eq!(settings.lookup, Lookup::Exact);
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
