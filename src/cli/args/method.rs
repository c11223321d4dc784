//! Settings of the methods: what all share, and what photons and paths have alone.

use clap::ValueEnum;

use super::render::given;

use crate::numeric::StreamKind;
use crate::reference::beams::BeamSettings;
use crate::reference::path::{LightSampling, PathSettings};
use crate::reference::photon_map::{PhotonMapSettings, Seen};
use crate::reference::photons::PhotonSettings;
use crate::scene::Integrator;
use crate::transport::chain::ChainSettings;
use crate::transport::path_class::PathClasses;
use crate::transport::scatter::ShadingNormals;

/// Settings of all methods.
#[derive(Debug, clap::Args)]
pub struct SharedArgs {
    /// Seed of all random choices (of photons and paths, and of places on area lights) [default: 0]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,

    /// Independent randomisations; their scatter is the error bar [default: 32 of photons and
    /// paths, 16 of beams from area lights]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=255))]
    pub replicates: Option<u32>,

    /// Specular events after which flux is cut off, up to 127; of paths the most legs from light to
    /// camera, as Mitsuba's `max_depth` (full: legs) [default: 16; of paths the scene file's, else no limit]
    #[arg(long, value_name = "N")]
    pub max_depth: Option<u32>,

    /// What interpolated normals do to flux (path and full: adjoint)
    #[arg(long, value_enum, default_value_t = ShadingNormalsArg::Flux)]
    pub shading_normals: ShadingNormalsArg,

    /// Path signatures with a layer of their own: the brightest (path and full: a layer a class)
    #[arg(long, value_name = "N", default_value_t = DEFAULT_LAYERS, value_parser = clap::value_parser!(u32).range(0..=1024))]
    pub layers: u32,
}

/// Settings that only photons have, but for the samples.
#[derive(Debug, clap::Args)]
pub struct PhotonArgs {
    /// How sample points are laid out (of photons and paths) [default: sobol]
    #[arg(long, value_enum)]
    pub samples: Option<Samples>,

    /// Specular events up to which photons follow every branch, later one at random [default: 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=31))]
    pub split_depth: Option<u32>,

    /// Samples of a texel and an area light for direct light on a receiver, where it is hard to measure [default: 128]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(128..=1 << 24))]
    pub direct_samples: Option<u32>,
}

/// Settings that only paths have.
#[derive(Debug, clap::Args)]
pub struct PathArgs {
    /// Samples a pixel (of paths), all replicates together [default: 256 where no other limit is given]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=super::MAX_COUNT))]
    pub spp: Option<u64>,

    /// Leg from which on Russian roulette may end paths [default: the scene file's, else 5]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub rr_depth: Option<u32>,

    /// Whether the camera looks through emitters (of paths) [default: the scene file's, else false]
    #[arg(long, value_name = "BOOL", num_args = 0..=1, default_missing_value = "true")]
    pub hide_emitters: Option<bool>,

    /// How paths find light: by sampling emitters, surfaces, or both [default: power]
    #[arg(long, value_enum)]
    pub light_sampling: Option<LightSamplingArg>,

    /// Leave out light that meets mirrors or glass before anything else (of paths): what photons and
    /// beams measure
    #[arg(long)]
    pub without_caustics: bool,
}

/// How paths find light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum LightSamplingArg {
    /// Both, weighted by squared densities
    Power,
    /// Both, weighted by densities
    Balance,
    /// Emitters only
    Emitters,
    /// Surfaces only: point and parallel lights are not found
    Surfaces,
}

impl From<LightSamplingArg> for LightSampling {
    fn from(typed: LightSamplingArg) -> Self {
        match typed {
            LightSamplingArg::Power => Self::Power,
            LightSamplingArg::Balance => Self::Balance,
            LightSamplingArg::Emitters => Self::Emitters,
            LightSamplingArg::Surfaces => Self::Surfaces,
        }
    }
}

/// Settings that only photon maps have.
#[derive(Debug, clap::Args)]
pub struct PhotonMapArgs {
    /// Photons of one map (of photon maps) [default: 65536]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 24))]
    pub map_photons: Option<u64>,

    /// Radius of the first map's lookups in pixels (of photon maps) [default: 1]
    #[arg(long, value_name = "PIXELS")]
    pub radius: Option<f64>,

    /// Which caustics are measured (of photon maps) [default: by-specular]
    #[arg(long, value_enum)]
    pub seen: Option<SeenArg>,
}

/// How the camera sees the surface that a caustic falls on.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SeenArg {
    /// Without mirror or glass in between
    Directly,
    /// By way of mirrors or glass
    BySpecular,
    /// Either way
    Anyhow,
}

impl From<SeenArg> for Seen {
    fn from(typed: SeenArg) -> Self {
        match typed {
            SeenArg::Directly => Self::Directly,
            SeenArg::BySpecular => Self::BySpecular,
            SeenArg::Anyhow => Self::Anyhow,
        }
    }
}

impl PhotonMapArgs {
    /// An option given that only photon maps have.
    pub fn given(&self) -> Option<&'static str> {
        given([
            ("--map-photons", self.map_photons.is_some()),
            ("--radius", self.radius.is_some()),
            ("--seen", self.seen.is_some()),
        ])
    }
}

/// How sample points are laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Samples {
    /// Owen-scrambled Sobol' points
    Sobol,
    /// Independent random points
    Random,
}

/// What interpolated normals do to flux.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum ShadingNormalsArg {
    /// Nothing: the ledger closes
    Flux,
    /// Veach's factor, as Mitsuba's ptracer
    Adjoint,
}

impl From<ShadingNormalsArg> for ShadingNormals {
    fn from(typed: ShadingNormalsArg) -> Self {
        match typed {
            ShadingNormalsArg::Flux => Self::Flux,
            ShadingNormalsArg::Adjoint => Self::Adjoint,
        }
    }
}

impl From<Samples> for StreamKind {
    fn from(typed: Samples) -> Self {
        match typed {
            Samples::Sobol => Self::Sobol,
            Samples::Random => Self::Random,
        }
    }
}

/// Signatures with a layer of their own, unless told otherwise.
pub const DEFAULT_LAYERS: u32 = 8;

/// Specular events of photons and beams, unless asked otherwise.
const DEFAULT_EVENTS: u32 = 16;

impl SharedArgs {
    /// What the flags mean to beams.
    pub fn beams(&self) -> BeamSettings {
        let default = BeamSettings::default();
        BeamSettings {
            max_depth: self.max_depth.unwrap_or(DEFAULT_EVENTS),
            shading_normals: self.shading_normals.into(),
            max_layers: self.layers as usize,
            replicates: self.replicates.unwrap_or(default.replicates),
            seed: self.seed.unwrap_or(default.seed),
        }
    }

    /// What the flags mean to photons, with those that only photons have.
    pub fn photons(&self, photon: &PhotonArgs) -> PhotonSettings {
        let default = PhotonSettings::default();
        PhotonSettings {
            stream: photon.samples.map_or(default.stream, Into::into),
            seed: self.seed.unwrap_or(default.seed),
            replicates: self.replicates.unwrap_or(default.replicates),
            chains: ChainSettings {
                max_depth: self.max_depth.unwrap_or(DEFAULT_EVENTS),
                split_depth: photon.split_depth.unwrap_or(default.chains.split_depth),
                shading_normals: self.shading_normals.into(),
            },
            max_layers: self.layers as usize,
            direct_samples: photon.direct_samples.unwrap_or(default.direct_samples),
        }
    }

    /// What the flags mean to paths, beside what the scene file's integrator says.
    pub fn path(
        &self,
        samples: Option<Samples>,
        path: &PathArgs,
        integrator: Option<&Integrator>,
    ) -> PathSettings {
        let default = PathSettings::default().of_integrator(integrator);
        let classes = if path.without_caustics {
            default.classes.without(PathClasses::CAUSTICS)
        } else {
            default.classes
        };
        PathSettings {
            stream: samples.map_or(default.stream, Into::into),
            seed: self.seed.unwrap_or(default.seed),
            replicates: self.replicates.unwrap_or(default.replicates),
            max_depth: self.max_depth.or(default.max_depth),
            rr_depth: path.rr_depth.unwrap_or(default.rr_depth),
            hide_emitters: path.hide_emitters.unwrap_or(default.hide_emitters),
            light_sampling: path
                .light_sampling
                .map_or(default.light_sampling, Into::into),
            classes,
        }
    }

    /// What the flags mean to photon maps.
    pub fn photon_maps(&self, photon: &PhotonArgs, map: &PhotonMapArgs) -> PhotonMapSettings {
        let default = PhotonMapSettings::default();
        PhotonMapSettings {
            photons: PhotonSettings {
                replicates: self.replicates.unwrap_or(default.photons.replicates),
                ..self.photons(photon)
            },
            map_photons: map.map_photons.unwrap_or(default.map_photons),
            radius: map.radius.unwrap_or(default.radius),
            seen: map.seen.map_or(default.seen, Into::into),
            ..default
        }
    }
}
