//! Errors about names that do not exist and values that are not allowed.

/// A name that does not exist, or a value that a setting cannot have.
///
/// # Example: a slip in a name
///
/// ```
/// let error = nephroid::Method::new("foton", &Default::default()).unwrap_err();
/// assert!(error.to_string().starts_with("no method is called \"foton\""));
/// ```
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SettingError {
    /// No such name.
    #[error("no {what} is called \"{name}\"{suggestion}; there are {there}")]
    Unknown {
        /// The thing named.
        what: String,
        /// The name.
        name: String,
        /// The nearest name there is, as a question, or those who have this one.
        suggestion: String,
        /// All names.
        there: String,
    },
    /// No such value.
    #[error("{key} is \"{value}\"; allowed are {allowed}")]
    Value {
        /// The setting.
        key: String,
        /// The value asked for.
        value: String,
        /// The values allowed.
        allowed: String,
    },
}

impl SettingError {
    /// A name that is none of `there`, and perhaps the one that was meant.
    pub(crate) fn unknown<'a>(
        what: impl Into<String>,
        name: &str,
        there: impl IntoIterator<Item = &'a str>,
    ) -> Self {
        let there: Vec<&str> = there.into_iter().collect();
        Self::Unknown {
            what: what.into(),
            name: name.to_owned(),
            suggestion: did_you_mean(name, there.iter().copied()),
            there: there.join(", "),
        }
    }

    /// The same error with those who have the name, instead of a suggestion, if anyone has.
    #[must_use]
    pub fn of_others(mut self, owners: impl Fn(&str) -> Vec<&'static str>) -> Self {
        if let Self::Unknown {
            name, suggestion, ..
        } = &mut self
        {
            let owners = owners(name);
            if !owners.is_empty() {
                *suggestion = format!("; it is one of {}", owners.join(", "));
            }
        }
        self
    }

    /// A value that `key` cannot have.
    pub(crate) fn value(key: &str, value: &str, allowed: impl Into<String>) -> Self {
        Self::Value {
            key: key.to_owned(),
            value: value.to_owned(),
            allowed: allowed.into(),
        }
    }
}

/// Bytes of the longest name that is compared with others: a file may hold a "name" of any length.
const LONGEST_NAME: usize = 64;

/// `; did you mean "x"?` with the name nearest to the one written, or nothing if none is near.
///
/// A name is near if at most a third of its letters are inserted, removed, replaced or swapped with their
/// neighbour. That is one slip in three to five letters and two in six to eight; with more slips, short names
/// begin to resemble unrelated words. Case, `_`, `-` and spaces do not count. Among names equally near, the
/// first by alphabet is taken, whatever the order of `there`.
pub fn did_you_mean<'a>(name: &str, there: impl IntoIterator<Item = &'a str>) -> String {
    if name.len() > LONGEST_NAME {
        return String::new();
    }
    let plain = |name: &str| name.to_lowercase().replace(['_', '-', ' '], "");
    let written = plain(name);
    let nearest = there
        .into_iter()
        .map(|known| {
            let letters = plain(known);
            let distance = strsim::osa_distance(&written, &letters);
            (distance, known, letters.chars().count())
        })
        .min();
    match nearest {
        Some((distance, known, letters)) if 3 * distance <= letters => {
            format!("; did you mean \"{known}\"?")
        }
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_is_suggested_that_is_another_word() {
        assert_eq!(did_you_mean("colour", ["photons", "seed"]), "");
        assert_eq!(did_you_mean("caustic_receiver", ["int_ior"]), "");
        assert_eq!(did_you_mean(&"x".repeat(1_000_000), ["int_ior"]), "");
    }

    #[test]
    fn a_third_of_the_letters_may_be_wrong_and_no_more() {
        let is_near = |name, known| !did_you_mean(name, [known]).is_empty();
        assert!(is_near("glas", "glass"));
        assert!(!is_near("gla", "glass"));
        assert!(is_near("fotons", "photons"));
        assert!(!is_near("fotonz", "photons"));
        assert!(!is_near("y", "x"));
    }

    #[test]
    fn case_and_separators_do_not_count_and_swapped_neighbours_count_once() {
        let suggestion = did_you_mean("intIOR", ["ext_ior", "int_ior"]);
        assert_eq!(suggestion, "; did you mean \"int_ior\"?");
        assert_eq!(did_you_mean("IOR", ["roi"]), "");
        assert_eq!(did_you_mean("sede", ["seed"]), "; did you mean \"seed\"?");
    }

    #[test]
    fn the_order_of_the_names_does_not_matter() {
        let suggestion = "; did you mean \"bell\"?";
        assert_eq!(did_you_mean("tell", ["cell", "bell"]), suggestion);
        assert_eq!(did_you_mean("tell", ["bell", "cell"]), suggestion);
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
