//! One row of a method's table of settings.

use super::error::SettingError;
use super::parse::{parse_duration, parse_fraction, parse_named_fractions};

/// A setting: everything that flags, files, help, documents and errors say of it.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// The key in `--set KEY=VALUE` and `study.toml`; the flag is `--KEY`.
    pub key: &'static str,
    /// The values that it may have.
    pub kind: Kind,
    /// The value if none is given.
    pub default: Preset,
    /// The unit of its value; empty for plain numbers and words.
    pub unit: &'static str,
    /// One line: what changes with it.
    pub meaning: &'static str,
}

/// The values that a setting may have.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A whole number, both ends included.
    Whole(u64, u64),
    /// A number, both ends included.
    Number(f64, f64),
    /// A number above 0, as a fraction (0.01) or in percent (1%).
    Fraction,
    /// Names with a fraction each: LRD=1%,LTTD=0.1%.
    NamedFractions,
    /// A time with its unit: 250ms, 30s, 2m, 1h.
    Time,
    /// One of a few words.
    Choice(fn() -> Vec<(&'static str, &'static str)>),
    /// `true` or `false`.
    Flag,
    /// A name that the scene gives, at least a letter long.
    Name,
    /// A word for values of other settings, which these have where they are not given.
    Presets(&'static [NamedValues]),
}

/// A word for values of other settings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NamedValues {
    /// The word.
    pub word: &'static str,
    /// Its meaning, in a few words.
    pub meaning: &'static str,
    /// Keys and values.
    pub values: &'static [(&'static str, &'static str)],
}

/// The value of a setting that nobody gave.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Preset {
    /// A value, as text.
    Value(&'static str),
    /// A rule in words: the value depends on the scene, or on other settings.
    Rule(&'static str),
}

/// A [`Setting`] in a line or two: `row!("key": kind, Value "default", "unit", "meaning")`.
macro_rules! row {
    ($key:literal: $kind:expr, $preset:ident $default:tt, $unit:literal, $meaning:expr) => {
        $crate::setting::Setting {
            key: $key,
            kind: $kind,
            default: $crate::setting::Preset::$preset($default),
            unit: $unit,
            meaning: $meaning,
        }
    };
}

pub(crate) use row;

impl Setting {
    /// Refuses a value that the setting cannot have.
    ///
    /// # Errors
    ///
    /// Names the key, the value and what is allowed.
    pub fn check(&self, text: &str) -> Result<(), SettingError> {
        if self.kind.holds(text) {
            Ok(())
        } else {
            Err(SettingError::value(self.key, text, self.kind.allowed()))
        }
    }
}

impl Kind {
    /// True if the text is one of its values.
    pub fn holds(self, text: &str) -> bool {
        match self {
            Self::Whole(low, high) => {
                let number = text.parse::<u64>();
                number.is_ok_and(|number| (low..=high).contains(&number))
            }
            Self::Number(low, high) => {
                let number = text.parse::<f64>();
                number.is_ok_and(|number| (low..=high).contains(&number))
            }
            Self::Fraction => parse_fraction(text).is_some(),
            Self::NamedFractions => parse_named_fractions(text).is_some(),
            Self::Time => parse_duration(text).is_some(),
            Self::Choice(words) => words().iter().any(|(word, _)| *word == text),
            Self::Presets(named) => named.iter().any(|one| one.word == text),
            Self::Flag => matches!(text, "true" | "false"),
            Self::Name => !text.is_empty(),
        }
    }

    /// Its values in words.
    pub fn allowed(self) -> String {
        match self {
            Self::Whole(low, high) if high == u64::MAX => format!("whole numbers from {low} on"),
            Self::Whole(low, high) => format!("whole numbers {low}..={high}"),
            Self::Number(low, high) => format!("numbers from {low} to {high}"),
            Self::Fraction => "numbers > 0, as a fraction (0.01) or in percent (1%)".to_owned(),
            Self::NamedFractions => {
                "names with a number > 0 each, as in LRD=1%,LTTD=0.001".to_owned()
            }
            Self::Time => "times >= 0 with a unit (ms, s, m or h), as in 30s".to_owned(),
            Self::Choice(_) | Self::Presets(_) => {
                let words: Vec<&str> = self.words().iter().map(|(word, _)| *word).collect();
                words.join(", ")
            }
            Self::Flag => "true, false".to_owned(),
            Self::Name => "names".to_owned(),
        }
    }

    /// The same, as short as a column of a table.
    pub fn column(self) -> String {
        match self {
            // Counts of work end at a power of two that is too long to read, or at the type's end.
            Self::Whole(low, high) if high > 1 << 32 && high.is_power_of_two() => {
                format!("{low}..=2^{}", high.ilog2())
            }
            Self::Whole(low, high) if high >= u64::from(u32::MAX) => format!("from {low} on"),
            Self::Whole(low, high) => format!("{low}..={high}"),
            Self::Number(low, high) => format!("{low} to {high}"),
            Self::Fraction => "> 0, or in %".to_owned(),
            Self::NamedFractions => "NAME=> 0, ...".to_owned(),
            Self::Time => "ms, s, m, h".to_owned(),
            Self::Choice(_) | Self::Presets(_) => "word".to_owned(),
            Self::Flag => "true, false".to_owned(),
            Self::Name => "names".to_owned(),
        }
    }

    /// The words that it may be, with their meanings; none for numbers.
    pub fn words(self) -> Vec<(&'static str, &'static str)> {
        match self {
            Self::Choice(words) => words(),
            Self::Presets(named) => named.iter().map(|one| (one.word, one.meaning)).collect(),
            _ => Vec::new(),
        }
    }

    /// The placeholder for a value in help texts.
    pub fn placeholder(self) -> &'static str {
        match self {
            Self::Whole(..) => "N",
            Self::Number(..) => "NUMBER",
            Self::Fraction => "ERROR",
            Self::NamedFractions => "NAME=ERROR,...",
            Self::Time => "TIME",
            Self::Choice(_) | Self::Presets(_) => "WORD",
            Self::Flag => "BOOL",
            Self::Name => "NAME",
        }
    }
}

impl Preset {
    /// The default as help texts show it.
    pub fn text(self) -> &'static str {
        match self {
            Self::Value(text) | Self::Rule(text) => text,
        }
    }
}
