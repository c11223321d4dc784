//! What cannot be run, and why.

use crate::transport::camera::CameraError;
use crate::transport::receiver::ReceiverError;

/// A setting that there is not, or that cannot be so.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SettingError {
    /// No such name.
    #[error("no {what} is called \"{name}\"{suggestion}; there are {there}")]
    Unknown {
        /// What was named.
        what: &'static str,
        /// The name.
        name: String,
        /// The nearest name there is, as a question.
        suggestion: String,
        /// All names.
        there: String,
    },
    /// No such value.
    #[error("{key}={value}: allowed are {allowed}")]
    Value {
        /// The setting.
        key: String,
        /// What was asked for.
        value: String,
        /// What can be.
        allowed: String,
    },
}

impl SettingError {
    /// A name that is none of `there`, and perhaps the one that was meant.
    pub fn unknown(
        what: &'static str,
        name: &str,
        there: impl IntoIterator<Item = &'static str>,
    ) -> Self {
        let there: Vec<&str> = there.into_iter().collect();
        let nearest = there
            .iter()
            .map(|known| (distance(name, known), known))
            .min_by_key(|(distance, _)| *distance);
        // More than half of the letters wrong is another word; a swap of two is two wrong ones.
        let suggestion = nearest
            .filter(|(distance, known)| 2 * distance <= known.len())
            .map(|(_, known)| format!("; did you mean {known}?"))
            .unwrap_or_default();
        Self::Unknown {
            what,
            name: name.to_owned(),
            suggestion,
            there: there.join(", "),
        }
    }

    /// A value that `key` cannot have.
    pub fn value(key: &str, value: &str, allowed: impl Into<String>) -> Self {
        Self::Value {
            key: key.to_owned(),
            value: value.to_owned(),
            allowed: allowed.into(),
        }
    }
}

/// How many letters to insert, delete or replace (Levenshtein 1966).
fn distance(one: &str, other: &str) -> usize {
    let other: Vec<char> = other.chars().collect();
    let mut row: Vec<usize> = (0..=other.len()).collect();
    for (i, letter) in one.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &same) in other.iter().enumerate() {
            let replaced = diagonal + usize::from(letter != same);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[other.len()]
}

/// Why a technique cannot fill a sensor.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ApproximationError {
    /// A setting.
    #[error(transparent)]
    Setting(#[from] SettingError),
    /// The sensor cannot receive.
    #[error(transparent)]
    Receiver(#[from] ReceiverError),
    /// The camera cannot be looked through.
    #[error(transparent)]
    Camera(#[from] CameraError),
    /// An emitter that has no view.
    #[error(
        "an emitter is of plugin {plugin}: caustic maps are rendered from one point or direction; emitters of \
         plugin point, spot and directional are allowed"
    )]
    Emitter {
        /// Mitsuba's name of it.
        plugin: &'static str,
    },
    /// Nothing shines.
    #[error(
        "no emitter shines: a caustic map is rendered from one of plugin point, spot or directional"
    )]
    NoEmitter,
    /// Nothing refracts, or mirrors.
    #[error("no shape {does}: mode={mode} needs one of plugin {plugins}")]
    NoSpecular {
        /// The mode.
        mode: &'static str,
        /// What is missing.
        does: &'static str,
        /// What would do.
        plugins: &'static str,
    },
    /// The light view sees refractors from inside only.
    #[error(
        "the emitter at ({}, {}, {}) is inside shape \"{shape}\": a caustic map's light crosses two interfaces, from outside in and out again",
        position[0], position[1], position[2]
    )]
    LightInside {
        /// The emitter's place.
        position: [f64; 3],
        /// The shape's id.
        shape: String,
    },
    /// A sum does not fit.
    #[error(
        "the light on one texel or pixel is beyond what can be summed: allowed are emitters of 1e-250 to 1e250 W, and \
         cameras no nearer to what they see than 1/64 of the typical distance"
    )]
    Overflow,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_name_is_suggested_and_a_far_one_is_not() {
        let error = SettingError::unknown("setting", "spalt", ["splat", "photons"]);
        assert!(error.to_string().contains("did you mean splat?"), "{error}");
        let error = SettingError::unknown("setting", "zebra", ["splat", "photons"]);
        assert!(!error.to_string().contains("did you mean"), "{error}");
    }

    #[test]
    fn distances_are_levenshteins() {
        for (one, other, expected) in [("kitten", "sitting", 3), ("", "abc", 3), ("a", "a", 0)] {
            assert_eq!(distance(one, other), expected);
        }
    }
}
