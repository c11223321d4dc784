//! Settings of the methods: what photons and beams share, and what photons have alone.

use clap::ValueEnum;

use super::render::given;

use crate::numeric::StreamKind;
use crate::reference::beams::BeamSettings;
use crate::reference::photon_map::{PhotonMapSettings, Seen};
use crate::reference::photons::PhotonSettings;
use crate::transport::chain::ChainSettings;
use crate::transport::scatter::ShadingNormals;

/// Settings of photons and of beams.
#[derive(Debug, clap::Args)]
pub struct SharedArgs {
    /// Seed of all random choices (of photons, and of places on area lights) [default: 0]
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,

    /// Independent randomisations; their scatter is the error bar [default: 32 of photons, 16 of
    /// beams from area lights]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=255))]
    pub replicates: Option<u32>,

    /// Specular events after which flux is cut off
    #[arg(long, value_name = "N", default_value_t = 16, value_parser = clap::value_parser!(u32).range(0..=31))]
    pub max_depth: u32,

    /// What interpolated normals do to flux
    #[arg(long, value_enum, default_value_t = ShadingNormalsArg::Flux)]
    pub shading_normals: ShadingNormalsArg,

    /// Path signatures with a layer of their own: the brightest
    #[arg(long, value_name = "N", default_value_t = 8, value_parser = clap::value_parser!(u32).range(0..=1024))]
    pub layers: u32,
}

/// Settings that only photons have.
#[derive(Debug, clap::Args)]
pub struct PhotonArgs {
    /// How sample points are laid out (of photons) [default: sobol]
    #[arg(long, value_enum)]
    pub samples: Option<Samples>,

    /// Specular events up to which photons follow every branch, later one at random [default: 2]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=31))]
    pub split_depth: Option<u32>,
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

impl SharedArgs {
    /// What the flags mean to beams.
    pub fn beams(&self) -> BeamSettings {
        let default = BeamSettings::default();
        BeamSettings {
            max_depth: self.max_depth,
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
            stream: match photon.samples {
                None => default.stream,
                Some(Samples::Sobol) => StreamKind::Sobol,
                Some(Samples::Random) => StreamKind::Random,
            },
            seed: self.seed.unwrap_or(default.seed),
            replicates: self.replicates.unwrap_or(default.replicates),
            chains: ChainSettings {
                max_depth: self.max_depth,
                split_depth: photon.split_depth.unwrap_or(default.chains.split_depth),
                shading_normals: self.shading_normals.into(),
            },
            max_layers: self.layers as usize,
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
