//! Settings by name: one table a method serves flags, `--set`, `study.toml`, help, documents and errors.
//!
//! | file | content |
//! |---|---|
//! | [`table`] | a [`Setting`]: its key, kind, range, default, unit and meaning |
//! | [`values`] | [`Values`]: settings as typed, checked against a table, read with their types |
//! | [`parse`] | fractions and times from text |
//! | [`words`] | enums whose values are words |
//! | [`error`] | a setting that does not exist, or a value that it cannot have |

pub mod error;
pub mod parse;
pub mod table;
pub mod values;
pub mod words;

pub use error::{SettingError, did_you_mean};
pub use parse::{parse_duration, parse_fraction};
pub use table::{Kind, NamedValues, Preset, Setting};
pub use values::{Given, Values};
pub use words::{Words, words_of};
