//! Rows that the tables of several references share, and the words of their values.

use crate::numeric::StreamKind;
use crate::reference::path::LightSampling;
use crate::reference::photon_map::Seen;
use crate::setting::table::row;
use crate::setting::{Kind, Setting, Words, words_of};
use crate::transport::scatter::ShadingNormals;
use crate::transport::signature::MAX_EVENTS;

/// The largest number of photons, rays or samples that can be asked for: a year's work at ten million a
/// second.
pub const MAX_COUNT: u64 = 1 << 48;

/// A count of work, which limits a run.
pub(super) const COUNT: Kind = Kind::Whole(1, MAX_COUNT);

/// The limit on the relative error of a method that draws at random.
pub(super) const ERROR: Setting = row!("error": Kind::Fraction, Rule "no limit", "", ERROR_MEANING);

/// The standard error of methods that draw at random, and the likely error of beams.
pub(super) const ERROR_MEANING: &str =
    "Stop at this relative error: root mean square over mean, of lit texels";

/// The limit on time.
pub(super) const TIME: Setting =
    row!("time": Kind::Time, Rule "no limit", "", "Stop after this time");

/// The limit on photons.
pub(super) const PHOTONS: Setting = row!("photons": COUNT, Rule "16777216 if nothing else is limited", "photons",
    "Stop after so many photons, all replicates together");

/// The limit on samples.
pub(super) const SPP: Setting = row!("spp": COUNT, Rule "256 if nothing else is limited", "samples a pixel",
    "Stop after so many samples a pixel, all replicates together");

pub(super) const SEED: Setting =
    row!("seed": Kind::Whole(0, u64::MAX), Value "0", "", "Seed of all random choices");

/// The number of replicates; its default differs from method to method.
pub(super) const fn replicates(least: u64, default: &'static str) -> Setting {
    row!("replicates": Kind::Whole(least, 255), Value default, "", "Independent randomisations; their scatter is the error bar")
}

pub(super) const MOST_EVENTS: &str = "Most mirrors and interfaces of a path";

pub(super) const MAX_DEPTH: Setting = row!("max-depth": Kind::Whole(0, MAX_EVENTS as u64), Value "16", "specular events", MOST_EVENTS);

pub(super) const SHADING_NORMALS: Setting = row!("shading-normals": Kind::Choice(words_of::<ShadingNormals>), Value "flux", "",
    "Effect of interpolated normals on flux");

/// Paths from a camera imply Veach's factor.
pub(super) const ADJOINT_NORMALS: Setting = row!("shading-normals": Kind::Choice(adjoint), Value "adjoint", "",
    "Effect of interpolated normals on flux");

fn adjoint() -> Vec<(&'static str, &'static str)> {
    let words = words_of::<ShadingNormals>().into_iter();
    words.filter(|(word, _)| *word == "adjoint").collect()
}

pub(super) const LAYERS: Setting = row!("layers": Kind::Whole(0, 1024), Value "8", "",
    "Path signatures with a layer of their own: the brightest");

pub(super) const SAMPLES: Setting = row!("samples": Kind::Choice(words_of::<StreamKind>), Value "sobol", "", "Layout of sample points");

pub(super) const SPLIT_DEPTH: Setting = row!("split-depth": Kind::Whole(0, 31), Value "2", "specular events",
    "Depth up to which photons follow every branch; later they follow one at random");

pub(super) const DIRECT_SAMPLES: Setting = row!("direct-samples": Kind::Whole(128, 1 << 24), Value "128", "samples",
    "Samples of a texel and an area light or environment for direct light, where it is hard to measure");

/// The most legs of a camera's path.
pub(super) const MAX_LEGS: Setting = row!("max-depth": Kind::Whole(0, u32::MAX as u64), Rule "the scene file's, else no limit", "legs",
    "Most legs from light to camera, as Mitsuba's max_depth");

pub(super) const RR_DEPTH: Setting = row!("rr-depth": Kind::Whole(1, u32::MAX as u64), Rule "the scene file's, else 5", "legs",
    "Leg from which on Russian roulette may end paths");

pub(super) const HIDE_EMITTERS: Setting = row!("hide-emitters": Kind::Flag, Rule "the scene file's, else false", "",
    "The camera looks through emitters");

pub(super) const LIGHT_SAMPLING: Setting = row!("light-sampling": Kind::Choice(words_of::<LightSampling>), Value "power", "",
    "Way in which paths find light: by sampling emitters, surfaces, or both");

pub(super) const MAP_PHOTONS: Setting = row!("map-photons": Kind::Whole(1, 1 << 24), Value "65536", "photons",
    "Photons of one map: memory grows with it");

pub(super) const RADIUS: Setting = row!("radius": Kind::Number(1e-6, 1e6), Value "1", "pixels", "Radius of the first map's look-ups");

impl Words for StreamKind {
    const WORDS: &'static [(&'static str, Self, &'static str)] = &[
        ("sobol", Self::Sobol, "Owen-scrambled Sobol' points"),
        ("random", Self::Random, "Independent random points"),
    ];
}

impl Words for ShadingNormals {
    const WORDS: &'static [(&'static str, Self, &'static str)] = &[
        ("flux", Self::Flux, "None: the ledger closes"),
        (
            "adjoint",
            Self::Adjoint,
            "Veach's factor, as in Mitsuba's ptracer",
        ),
    ];
}

impl Words for LightSampling {
    const WORDS: &'static [(&'static str, Self, &'static str)] = &[
        ("power", Self::Power, "Both, weighted by squared densities"),
        ("balance", Self::Balance, "Both, weighted by densities"),
        ("emitters", Self::Emitters, "Emitters only"),
        (
            "surfaces",
            Self::Surfaces,
            "Surfaces only: point and parallel lights are not found",
        ),
    ];
}

impl Words for Seen {
    const WORDS: &'static [(&'static str, Self, &'static str)] = &[
        (
            "directly",
            Self::Directly,
            "Without mirror or glass between camera and surface",
        ),
        (
            "by-specular",
            Self::BySpecular,
            "By way of mirrors or glass",
        ),
        ("anyhow", Self::Anyhow, "Either way"),
    ];
}
