//! Settings as they were typed, checked against a table.

use std::collections::BTreeMap;
use std::time::Duration;

use super::error::SettingError;
use super::parse::{parse_duration, parse_fraction, parse_named_fractions};
use super::table::{Kind, Preset, Setting};
use super::words::Words;

/// Settings by key, as they were typed.
pub type Given = BTreeMap<String, String>;

/// Settings that are all in a table, each with a value that it may have.
///
/// Reading a key gives the value that was typed, else the table's default. Keys whose default is a
/// [rule](Preset::Rule) have no value unless one was typed.
#[derive(Clone, Debug)]
pub struct Values {
    table: Vec<&'static Setting>,
    given: Given,
}

impl PartialEq for Values {
    fn eq(&self, other: &Self) -> bool {
        self.given == other.given
    }
}

impl Values {
    /// Checks settings against a table; `owner` is the method's name, for errors.
    ///
    /// # Errors
    ///
    /// For a key that is not in the table, with the nearest one, and for a value that it cannot have.
    pub fn new(
        owner: &str,
        table: Vec<&'static Setting>,
        given: &Given,
    ) -> Result<Self, SettingError> {
        for (key, text) in given {
            let Some(setting) = table.iter().find(|one| one.key == key) else {
                let keys = table.iter().map(|one| one.key);
                return Err(SettingError::unknown(
                    format!("setting of {owner}"),
                    key,
                    keys,
                ));
            };
            setting.check(text)?;
        }
        Ok(Self {
            table,
            given: given.clone(),
        })
    }

    /// The settings that were typed.
    pub fn given(&self) -> &Given {
        &self.given
    }

    /// The value of a key as text: the one typed, else that of a preset, else the default.
    pub fn text(&self, key: &str) -> Option<&str> {
        if let Some(text) = self.given.get(key) {
            return Some(text);
        }
        if let Some(text) = self.preset(key) {
            return Some(text);
        }
        let setting = self.table.iter().find(|one| one.key == key)?;
        match setting.default {
            Preset::Value(text) => Some(text),
            Preset::Rule(_) => None,
        }
    }

    /// The value that a preset gives a setting; `None` if none does.
    fn preset(&self, key: &str) -> Option<&'static str> {
        self.table.iter().find_map(|setting| {
            let Kind::Presets(named) = setting.kind else {
                return None;
            };
            let word = self.given.get(setting.key).map(String::as_str);
            let word = word.unwrap_or(setting.default.text());
            let values = named.iter().find(|one| one.word == word)?.values;
            values
                .iter()
                .find(|(known, _)| *known == key)
                .map(|(_, value)| *value)
        })
    }

    /// A whole number; `None` without a value, or if `T` cannot hold it.
    pub fn whole<T: TryFrom<u64>>(&self, key: &str) -> Option<T> {
        self.text(key)?.parse::<u64>().ok()?.try_into().ok()
    }

    /// A number; `None` without a value.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.text(key)?.parse().ok()
    }

    /// A fraction; `None` without a value.
    pub fn fraction(&self, key: &str) -> Option<f64> {
        parse_fraction(self.text(key)?)
    }

    /// Names with a fraction each; none without a value.
    pub fn named_fractions(&self, key: &str) -> Vec<(&str, f64)> {
        let parsed = self.text(key).and_then(parse_named_fractions);
        parsed.unwrap_or_default()
    }

    /// A time; `None` without a value.
    pub fn time(&self, key: &str) -> Option<Duration> {
        parse_duration(self.text(key)?)
    }

    /// A word; `None` without a value.
    pub fn word<T: Words>(&self, key: &str) -> Option<T> {
        T::of_word(self.text(key)?)
    }

    /// `true` or `false`; `None` without a value.
    pub fn flag(&self, key: &str) -> Option<bool> {
        self.text(key)?.parse().ok()
    }

    /// All settings that have a value, in the order of the table: numbers as numbers, the rest as text.
    pub fn json(&self) -> serde_json::Value {
        let rows = self.table.iter().filter_map(|setting| {
            let text = self.text(setting.key)?;
            let value = match setting.kind {
                Kind::Whole(..) => self.whole::<u64>(setting.key)?.into(),
                Kind::Number(..) => self.number(setting.key)?.into(),
                Kind::Fraction => self.fraction(setting.key)?.into(),
                Kind::Flag => self.flag(setting.key)?.into(),
                Kind::NamedFractions
                | Kind::Time
                | Kind::Choice(_)
                | Kind::Name
                | Kind::Presets(_) => text.into(),
            };
            Some((setting.key.to_owned(), value))
        });
        serde_json::Value::Object(rows.collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setting::NamedValues;

    const TABLE: [Setting; 2] = [
        Setting {
            key: "photons",
            kind: Kind::Whole(1, 9),
            default: Preset::Value("7"),
            unit: "photons",
            meaning: "Photons started",
        },
        Setting {
            key: "error",
            kind: Kind::Fraction,
            default: Preset::Rule("none"),
            unit: "",
            meaning: "Error to stop at",
        },
    ];

    fn values(pairs: &[(&str, &str)]) -> Result<Values, SettingError> {
        let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
        Values::new(
            "photons",
            TABLE.iter().collect(),
            &pairs.iter().map(owned).collect(),
        )
    }

    #[test]
    fn a_key_that_is_not_in_the_table_is_refused_and_the_nearest_one_suggested() {
        let error = values(&[("fotons", "7")]).unwrap_err().to_string();
        assert!(error.contains("did you mean \"photons\"?"), "{error}");
    }

    #[test]
    fn numbers_out_of_range_are_refused_with_the_range() {
        let error = values(&[("photons", "-1")]).unwrap_err().to_string();
        assert_eq!(error, "photons is \"-1\"; allowed are whole numbers 1..=9");
        assert!(values(&[("photons", "10")]).is_err());
        assert!(values(&[("error", "0")]).is_err());
    }

    #[test]
    fn a_preset_stands_in_for_what_was_not_typed_before_defaults() {
        const NAMED: &[NamedValues] = &[NamedValues {
            word: "few",
            meaning: "a few photons",
            values: &[("photons", "2")],
        }];
        const PRESETS: Setting = Setting {
            key: "preset",
            kind: Kind::Presets(NAMED),
            default: Preset::Rule("none"),
            unit: "",
            meaning: "Values of others",
        };
        let photons = |pairs: &[(&str, &str)]| {
            let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
            let table = TABLE.iter().chain([&PRESETS]).collect();
            let values = Values::new("photons", table, &pairs.iter().map(owned).collect());
            values.unwrap().whole::<u32>("photons")
        };
        assert_eq!(photons(&[]), Some(7));
        assert_eq!(photons(&[("preset", "few")]), Some(2));
        assert_eq!(photons(&[("preset", "few"), ("photons", "3")]), Some(3));
    }

    #[test]
    fn defaults_stand_in_for_what_was_not_typed_but_rules_do_not() {
        let values = values(&[]).unwrap();
        assert_eq!(values.whole::<u32>("photons"), Some(7));
        assert_eq!(values.fraction("error"), None);
        assert_eq!(values.json(), serde_json::json!({ "photons": 7 }));
    }
}
