//! Settings as text: `key=value`, and what is said of those that cannot be.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

/// Settings by key, as they were typed.
pub type Settings = BTreeMap<String, String>;

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

/// Takes settings one by one; what nobody took is unknown.
pub struct Keys<'a> {
    method: &'static str,
    given: &'a Settings,
    known: Vec<&'static str>,
}

impl<'a> Keys<'a> {
    /// The settings given to a method.
    pub fn new(method: &'static str, given: &'a Settings) -> Self {
        Self {
            method,
            given,
            known: Vec::new(),
        }
    }

    fn text(&mut self, key: &'static str) -> Option<&'a str> {
        self.known.push(key);
        self.given.get(key).map(String::as_str)
    }

    /// A whole number in a range, if it is given.
    ///
    /// # Errors
    ///
    /// For what is none.
    pub fn whole<T: FromStr + PartialOrd + Display>(
        &mut self,
        key: &'static str,
        range: RangeInclusive<T>,
    ) -> Result<Option<T>, SettingError> {
        let Some(text) = self.text(key) else {
            return Ok(None);
        };
        let number = text.parse().ok().filter(|number| range.contains(number));
        number.map(Some).ok_or_else(|| {
            let allowed = format!("whole numbers {}..={}", range.start(), range.end());
            SettingError::value(key, text, allowed)
        })
    }

    /// A positive number, or a percentage, if it is given.
    ///
    /// # Errors
    ///
    /// For what is none.
    pub fn fraction(&mut self, key: &'static str) -> Result<Option<f64>, SettingError> {
        let Some(text) = self.text(key) else {
            return Ok(None);
        };
        fraction(text).map(Some).ok_or_else(|| {
            SettingError::value(
                key,
                text,
                "numbers > 0, as a fraction (0.01) or in percent (1%)",
            )
        })
    }

    /// One of several names, if it is given.
    ///
    /// # Errors
    ///
    /// For another name.
    pub fn choice<T: Copy>(
        &mut self,
        key: &'static str,
        choices: &[(&str, T)],
    ) -> Result<Option<T>, SettingError> {
        let Some(text) = self.text(key) else {
            return Ok(None);
        };
        let found = choices.iter().find(|(name, _)| *name == text);
        found.map(|(_, value)| Some(*value)).ok_or_else(|| {
            let names: Vec<&str> = choices.iter().map(|(name, _)| *name).collect();
            SettingError::value(key, text, names.join(", "))
        })
    }

    /// Refuses what nobody took.
    ///
    /// # Errors
    ///
    /// For the first such key.
    pub fn finish(self) -> Result<(), SettingError> {
        let unknown = self
            .given
            .keys()
            .find(|key| !self.known.contains(&key.as_str()));
        unknown.map_or(Ok(()), |key| {
            let what = format!("setting of {}", self.method);
            Err(SettingError::unknown(what, key, self.known))
        })
    }
}

/// A positive number from a fraction (`0.01`) or a percentage (`1%`).
pub fn fraction(text: &str) -> Option<f64> {
    let (number, factor) = match text.strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text, 1.0),
    };
    let value: f64 = number.trim().parse().ok()?;
    (value > 0.0 && value.is_finite()).then_some(value * factor)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn given(pairs: &[(&str, &str)]) -> Settings {
        let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
        pairs.iter().map(owned).collect()
    }

    #[test]
    fn a_key_that_nobody_took_is_refused_and_the_nearest_one_suggested() {
        let settings = given(&[("fotons", "7")]);
        let mut keys = Keys::new("photons", &settings);
        assert_eq!(keys.whole::<u64>("photons", 1..=9), Ok(None));
        let error = keys.finish().unwrap_err().to_string();
        assert!(error.contains("did you mean \"photons\"?"), "{error}");
    }

    #[test]
    fn nothing_is_suggested_that_is_another_word() {
        assert_eq!(suggestion("colour", &["photons", "seed"]), "");
    }

    #[test]
    fn numbers_out_of_range_are_refused_with_the_range() {
        let settings = given(&[("seed", "-1")]);
        let error = Keys::new("photons", &settings).whole::<u64>("seed", 0..=5);
        assert_eq!(
            error.unwrap_err().to_string(),
            "seed is \"-1\"; allowed are whole numbers 0..=5"
        );
    }
}
