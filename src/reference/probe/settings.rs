//! Settings of a probe.

use std::time::Duration;

use crate::setting::{Given, Kind, Preset, Setting, SettingError, Values, words_of};
use crate::transport::scatter::ShadingNormals;
use crate::transport::signature::MAX_EVENTS;

/// The most divisions of all light before a search.
pub const MAX_REFINE: u32 = 6;

/// The most rays of a search.
pub const MAX_RAYS: u64 = 1 << 48;

/// Settings as text.
const TABLE: [Setting; 5] = [
    Setting {
        key: "max-depth",
        kind: Kind::Whole(0, MAX_EVENTS as u64),
        default: Preset::Rule("16"),
        unit: "specular events",
        meaning: "Specular events after which light is cut off",
    },
    Setting {
        key: "shading-normals",
        kind: Kind::Choice(words_of::<ShadingNormals>),
        default: Preset::Rule("flux"),
        unit: "",
        meaning: "Effect of interpolated normals on flux",
    },
    Setting {
        key: "refine",
        kind: Kind::Whole(0, MAX_REFINE as u64),
        default: Preset::Rule("0"),
        unit: "",
        meaning: "Divisions of all light before the search",
    },
    Setting {
        key: "rays",
        kind: Kind::Whole(1, MAX_RAYS),
        default: Preset::Rule("33554432"),
        unit: "rays",
        meaning: "Rays after which the search ends",
    },
    Setting {
        key: "time",
        kind: Kind::Time,
        default: Preset::Rule("none"),
        unit: "",
        meaning: "Time after which the search ends",
    },
];

/// Limits of a probe: the depth of its paths, and the fineness and cost of its search.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct ProbeSettings {
    /// Specular events after which light is cut off, at most
    /// [`MAX_EVENTS`](crate::transport::signature::MAX_EVENTS).
    pub max_depth: u32,
    /// Effect of interpolated normals on flux.
    pub shading_normals: ShadingNormals,
    /// Number of times that every cell of light space is divided before anything is decided.
    pub first_level: u32,
    /// Rays after which no more patches are divided.
    pub max_rays: u64,
}

impl Default for ProbeSettings {
    /// 16 events, undivided cells, 2²⁵ rays (some seconds): more than a search away from foci takes in most
    /// scenes. In the shipped `glass-ball`, where three sheets of light meet, it takes 2²⁴·³.
    fn default() -> Self {
        Self {
            max_depth: 16,
            shading_normals: ShadingNormals::Flux,
            first_level: 0,
            max_rays: 1 << 25,
        }
    }
}

impl ProbeSettings {
    /// From settings as text, by the keys of `nephroid probe`'s flags, with the time that the search may
    /// take.
    ///
    /// # Errors
    ///
    /// For a key or a value that does not exist.
    pub fn of(given: &Given) -> Result<(Self, Option<Duration>), SettingError> {
        let values = Values::new("probe", TABLE.iter().collect(), given)?;
        let default = Self::default();
        let normals = values.word("shading-normals");
        let settings = Self {
            max_depth: values.whole("max-depth").unwrap_or(default.max_depth),
            shading_normals: normals.unwrap_or(default.shading_normals),
            first_level: values.whole("refine").unwrap_or(default.first_level),
            max_rays: values.whole("rays").unwrap_or(default.max_rays),
        };
        Ok((settings, values.time("time")))
    }
}
