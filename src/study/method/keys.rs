//! Settings as text: `key=value`, and what is said of those that cannot be.

use std::collections::BTreeMap;
use std::fmt::Display;
use std::ops::RangeInclusive;
use std::str::FromStr;

pub use crate::setting::SettingError;

/// Settings by key, as they were typed.
pub type Settings = BTreeMap<String, String>;

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
    fn numbers_out_of_range_are_refused_with_the_range() {
        let settings = given(&[("seed", "-1")]);
        let error = Keys::new("photons", &settings).whole::<u64>("seed", 0..=5);
        assert_eq!(
            error.unwrap_err().to_string(),
            "seed is \"-1\"; allowed are whole numbers 0..=5"
        );
    }
}
