//! What is said of a setting that there is not, or that cannot be so.

/// A setting that there is not, or that cannot be so.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SettingError {
    /// No such name.
    #[error("no {what} is called \"{name}\"{suggestion}; there are {there}")]
    Unknown {
        /// What was named.
        what: String,
        /// The name.
        name: String,
        /// The nearest name there is, as a question.
        suggestion: String,
        /// All names.
        there: String,
    },
    /// No such value.
    #[error("{key} is \"{value}\"; allowed are {allowed}")]
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
    pub fn unknown<'a>(
        what: impl Into<String>,
        name: &str,
        there: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let there: Vec<&str> = there.into_iter().collect();
        Self::Unknown {
            what: what.into(),
            name: name.to_owned(),
            suggestion: suggestion(name, &there),
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

/// `; did you mean "x"?`, or nothing where no name is near: more than a third of the letters wrong is another word.
fn suggestion(name: &str, there: &[&str]) -> String {
    let distance = |known: &&&str| strsim::damerau_levenshtein(name, known);
    let nearest = there.iter().min_by_key(distance);
    nearest
        .filter(|known| 3 * distance(known) <= known.len().max(3))
        .map_or_else(String::new, |known| format!("; did you mean \"{known}\"?"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_suggested_that_is_another_word() {
        assert_eq!(suggestion("colour", &["photons", "seed"]), "");
    }

    #[test]
    fn the_nearest_name_is_suggested() {
        let error = SettingError::unknown("setting", "spalt", ["splat", "photons"]);
        assert!(
            error.to_string().contains("did you mean \"splat\"?"),
            "{error}"
        );
    }
}
