//! The references as methods of a study.

use serde_json::{Value, json};

use super::keys::{Keys, SettingError, Settings};
use super::product::Product;
use crate::numeric::StreamKind;
use crate::reference::beams::{self, BeamBudget, BeamError, BeamSettings};
use crate::reference::full::{self, FullBudget, FullError, FullSettings};
use crate::reference::path::{self, LightSampling, PathBudget, PathError, PathSettings};
use crate::reference::photon_map::{self, PhotonMapError, PhotonMapSettings, Seen};
use crate::reference::photons::{self, Budget, PhotonSettings, RunError};
use crate::reference::{Estimate, Progress, Quantity};
use crate::scene::{Scene, Sensor};
use crate::transport::chain_limits::{left_out, left_out_of_image};
use crate::transport::scatter::ShadingNormals;

/// The largest number of photons or samples: as of `nephroid render`.
const MAX_COUNT: u64 = 1 << 48;

/// Samples of a texel and an area light: as of `nephroid render`.
const DIRECT_SAMPLES: std::ops::RangeInclusive<u32> = 128..=1 << 24;

const SAMPLES: [(&str, StreamKind); 2] =
    [("sobol", StreamKind::Sobol), ("random", StreamKind::Random)];

const SHADING_NORMALS: [(&str, ShadingNormals); 2] = [
    ("flux", ShadingNormals::Flux),
    ("adjoint", ShadingNormals::Adjoint),
];

const LIGHT_SAMPLING: [(&str, LightSampling); 4] = [
    ("power", LightSampling::Power),
    ("balance", LightSampling::Balance),
    ("emitters", LightSampling::Emitters),
    ("surfaces", LightSampling::Surfaces),
];

const SEEN: [(&str, Seen); 3] = [
    ("directly", Seen::Directly),
    ("by-specular", Seen::BySpecular),
    ("anyhow", Seen::Anyhow),
];

/// Beams to an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beams {
    /// The likely error to stop at, relative.
    pub error: f64,
    /// How they are followed.
    pub settings: BeamSettings,
}

/// A number of photons.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Photons {
    /// Photons started.
    pub photons: u64,
    /// How they are followed.
    pub settings: PhotonSettings,
}

/// A number of paths a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Path {
    /// Samples a pixel.
    pub spp: u64,
    /// How they are followed; depths are the scene file's.
    pub settings: PathSettings,
}

/// Maps of so many photons, all together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PhotonMap {
    /// Photons started.
    pub photons: u64,
    /// How maps are made and looked up.
    pub settings: PhotonMapSettings,
}

/// An image of all light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Full {
    /// Samples a pixel, of paths.
    pub spp: u64,
    /// Photons connected to the camera, and in maps, each.
    pub photons: u64,
    /// Seed of all random choices.
    pub seed: u64,
}

/// What a scene's photons and beams leave out of a sensor's light.
fn unmodelled(scene: &Scene, estimate: &Estimate, is_dark: bool) -> Vec<String> {
    let mut warnings = left_out(scene);
    if is_dark {
        warnings.push(
            "no light gets to the sensor by way of a mirror or glass: there is no caustic"
                .to_owned(),
        );
    }
    if estimate.quantity == Quantity::Radiance {
        warnings.extend(left_out_of_image(scene));
        warnings.push(
            "direct light (LD) is not in the image: only light by way of mirrors and glass is"
                .to_owned(),
        );
    }
    warnings
}

impl Beams {
    pub(super) fn new(given: &Settings) -> Result<Self, SettingError> {
        let mut keys = Keys::new("beams", given);
        let default = BeamSettings::default();
        let made = Self {
            error: keys.fraction("error")?.unwrap_or(BeamBudget::DEFAULT_ERROR),
            settings: BeamSettings {
                max_depth: keys
                    .whole("max-depth", 0..=31)?
                    .unwrap_or(default.max_depth),
                shading_normals: keys
                    .choice("shading-normals", &SHADING_NORMALS)?
                    .unwrap_or_default(),
                replicates: keys
                    .whole("replicates", 2..=255)?
                    .unwrap_or(default.replicates),
                seed: keys.whole("seed", 0..=u64::MAX)?.unwrap_or(default.seed),
                ..default
            },
        };
        keys.finish()?;
        Ok(made)
    }

    pub(super) fn settings(&self) -> Value {
        json!({ "error": self.error, "beams": self.settings })
    }

    pub(super) fn run(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        progress: &Progress,
    ) -> Result<Product, BeamError> {
        let mut setup = beams::run::Setup::new(scene, sensor, self.settings, progress)?;
        let budget = BeamBudget {
            relative_error: Some(self.error),
            ..BeamBudget::default()
        };
        let (estimate, report) = setup.run(&budget)?;
        let mut warnings = unmodelled(scene, &estimate, setup.is_dark());
        if estimate.incomplete {
            warnings.push("the error asked for was not reached".to_owned());
        }
        let replicates = report.lamps.map(|lamps| lamps.replicates);
        Ok(Product::of_estimate(
            &estimate, replicates, "roots", warnings,
        ))
    }
}

impl Photons {
    pub(super) fn new(given: &Settings) -> Result<Self, SettingError> {
        let mut keys = Keys::new("photons", given);
        let mut settings = photon_settings(&mut keys, PhotonSettings::default())?;
        settings.direct_samples = keys
            .whole("direct-samples", DIRECT_SAMPLES)?
            .unwrap_or(settings.direct_samples);
        let made = Self {
            photons: keys
                .whole("photons", 1..=MAX_COUNT)?
                .unwrap_or(Budget::DEFAULT_PHOTONS),
            settings,
        };
        keys.finish()?;
        Ok(made)
    }

    pub(super) fn settings(&self) -> Value {
        json!({ "photons": self.photons, "photon": self.settings })
    }

    pub(super) fn run(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        progress: &Progress,
    ) -> Result<Product, RunError> {
        let setup = photons::run::Setup::new(scene, sensor, self.settings, progress)?;
        let estimate = setup.run(&Budget {
            photons: Some(self.photons),
            ..Budget::default()
        })?;
        let warnings = unmodelled(scene, &estimate, setup.light().is_empty());
        let replicates = Some(self.settings.replicates);
        Ok(Product::of_estimate(
            &estimate, replicates, "photons", warnings,
        ))
    }
}

fn photon_settings(
    keys: &mut Keys,
    default: PhotonSettings,
) -> Result<PhotonSettings, SettingError> {
    let mut settings = default;
    settings.stream = keys.choice("samples", &SAMPLES)?.unwrap_or(default.stream);
    settings.seed = keys.whole("seed", 0..=u64::MAX)?.unwrap_or(default.seed);
    settings.replicates = keys
        .whole("replicates", 1..=255)?
        .unwrap_or(default.replicates);
    let chains = &mut settings.chains;
    chains.max_depth = keys.whole("max-depth", 0..=31)?.unwrap_or(chains.max_depth);
    chains.split_depth = keys
        .whole("split-depth", 0..=31)?
        .unwrap_or(chains.split_depth);
    chains.shading_normals = keys
        .choice("shading-normals", &SHADING_NORMALS)?
        .unwrap_or(chains.shading_normals);
    Ok(settings)
}

impl Path {
    pub(super) fn new(given: &Settings) -> Result<Self, SettingError> {
        let mut keys = Keys::new("path", given);
        let default = PathSettings::default();
        let made = Self {
            spp: keys
                .whole("spp", 1..=MAX_COUNT)?
                .unwrap_or(PathBudget::DEFAULT_SAMPLES),
            settings: PathSettings {
                stream: keys.choice("samples", &SAMPLES)?.unwrap_or(default.stream),
                seed: keys.whole("seed", 0..=u64::MAX)?.unwrap_or(default.seed),
                replicates: keys
                    .whole("replicates", 1..=255)?
                    .unwrap_or(default.replicates),
                light_sampling: keys
                    .choice("light-sampling", &LIGHT_SAMPLING)?
                    .unwrap_or(default.light_sampling),
                ..default
            },
        };
        keys.finish()?;
        Ok(made)
    }

    pub(super) fn settings(&self) -> Value {
        json!({ "spp": self.spp, "path": self.settings })
    }

    pub(super) fn run(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        progress: &Progress,
    ) -> Result<Product, PathError> {
        let settings = self.settings.of_integrator(scene.integrator());
        let budget = PathBudget {
            samples: Some(self.spp),
            ..PathBudget::default()
        };
        let (estimate, report) = path::run(scene, sensor, settings, &budget, progress)?;
        let mut warnings = Vec::new();
        if report.cut_off > 0 {
            warnings.push(format!(
                "{} paths were cut off after 65536 surfaces",
                report.cut_off
            ));
        }
        let replicates = Some(settings.replicates);
        Ok(Product::of_estimate(
            &estimate, replicates, "paths", warnings,
        ))
    }
}

impl PhotonMap {
    pub(super) fn new(given: &Settings) -> Result<Self, SettingError> {
        let mut keys = Keys::new("photon-map", given);
        let default = PhotonMapSettings::default();
        let made = Self {
            photons: keys
                .whole("photons", 1..=MAX_COUNT)?
                .unwrap_or(Budget::DEFAULT_PHOTONS),
            settings: PhotonMapSettings {
                photons: photon_settings(&mut keys, default.photons)?,
                map_photons: keys
                    .whole("map-photons", 1..=1 << 24)?
                    .unwrap_or(default.map_photons),
                radius: keys.fraction("radius")?.unwrap_or(default.radius),
                seen: keys.choice("seen", &SEEN)?.unwrap_or(default.seen),
                ..default
            },
        };
        keys.finish()?;
        Ok(made)
    }

    pub(super) fn settings(&self) -> Value {
        json!({ "photons": self.photons, "photon-map": self.settings })
    }

    pub(super) fn run(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        progress: &Progress,
    ) -> Result<Product, PhotonMapError> {
        let setup = photon_map::run::Setup::new(scene, sensor, self.settings, progress)?;
        let (estimate, _) = setup.run(&Budget {
            photons: Some(self.photons),
            ..Budget::default()
        })?;
        let warnings = unmodelled(scene, &estimate, setup.light().is_empty());
        let replicates = Some(self.settings.photons.replicates);
        Ok(Product::of_estimate(
            &estimate, replicates, "photons", warnings,
        ))
    }
}

impl Full {
    pub(super) fn new(given: &Settings) -> Result<Self, SettingError> {
        let mut keys = Keys::new("full", given);
        let made = Self {
            spp: keys
                .whole("spp", 1..=MAX_COUNT)?
                .unwrap_or(PathBudget::DEFAULT_SAMPLES),
            photons: keys
                .whole("photons", 1..=MAX_COUNT)?
                .unwrap_or(Budget::DEFAULT_PHOTONS),
            seed: keys.whole("seed", 0..=u64::MAX)?.unwrap_or(0),
        };
        keys.finish()?;
        Ok(made)
    }

    pub(super) fn settings(&self) -> Value {
        json!({ "spp": self.spp, "photons": self.photons, "seed": self.seed })
    }

    pub(super) fn run(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        progress: &Progress,
    ) -> Result<Product, FullError> {
        let default = FullSettings::default();
        let settings = FullSettings {
            path: PathSettings {
                seed: self.seed,
                ..default.path.of_integrator(scene.integrator())
            },
            ..default
        };
        let budget = FullBudget {
            samples: Some(self.spp),
            photons: Some(self.photons),
            time: None,
            relative_error: None,
        };
        let (estimate, report) = full::run(scene, sensor, settings.agreeing(), &budget, progress)?;
        Ok(Product::of_estimate(
            &estimate,
            None,
            "paths",
            report.notices,
        ))
    }
}
