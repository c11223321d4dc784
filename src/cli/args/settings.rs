//! Settings of methods as flags: made from the table of methods.

use anyhow::bail;
use clap::{Arg, ArgMatches, Command, Error, FromArgMatches};

use crate::method::table::flags;
use crate::setting::{Given, Kind, SettingError};

/// Settings of references, a flag each. Which of them a method has is for the method to say.
#[derive(Clone, Debug, Default)]
pub struct SettingArgs {
    /// Values by key, as typed.
    pub given: Given,
}

impl SettingArgs {
    /// These settings and those of `--set`.
    ///
    /// # Errors
    ///
    /// If a setting is given twice, with both values.
    pub fn and(&self, set: &[(String, String)]) -> anyhow::Result<Given> {
        let mut given = self.given.clone();
        for (key, value) in set {
            if let Some(first) = given.insert(key.clone(), value.clone()) {
                bail!("{key} is given twice, as \"{first}\" and as \"{value}\"; allowed is once");
            }
        }
        Ok(given)
    }

    /// A key as it was typed: a flag has dashes.
    pub fn typed(&self, key: &str) -> String {
        let dashes = if self.given.contains_key(key) {
            "--"
        } else {
            ""
        };
        format!("{dashes}{key}")
    }

    /// The same error with the setting as it was typed.
    pub fn retold(&self, mut error: SettingError) -> SettingError {
        match &mut error {
            SettingError::Value { key, .. } | SettingError::Unknown { name: key, .. } => {
                *key = self.typed(key);
            }
        }
        error
    }
}

impl clap::Args for SettingArgs {
    fn augment_args(command: Command) -> Command {
        flags().into_iter().fold(command, |command, flag| {
            let kind = flag.rows.first().map_or(Kind::Flag, |(_, row)| row.kind);
            let argument = Arg::new(flag.key)
                .long(flag.key)
                .value_name(kind.placeholder())
                .help(flag.help())
                .help_heading(if flag.is_limit {
                    "End of a run, at the first limit that it reaches"
                } else {
                    "Settings of methods (`nephroid methods NAME` tells the meanings of words)"
                });
            command.arg(match kind {
                // With an equals sign, so that what follows is never taken for the value.
                Kind::Flag => argument
                    .num_args(0..=1)
                    .require_equals(true)
                    .default_missing_value("true"),
                _ => argument.allow_hyphen_values(true),
            })
        })
    }

    fn augment_args_for_update(command: Command) -> Command {
        Self::augment_args(command)
    }
}

impl FromArgMatches for SettingArgs {
    fn from_arg_matches(matches: &ArgMatches) -> Result<Self, Error> {
        let mut given = Given::new();
        for flag in flags() {
            if let Some(value) = matches.get_one::<String>(flag.key) {
                given.insert(flag.key.to_owned(), value.clone());
            }
        }
        Ok(Self { given })
    }

    fn update_from_arg_matches(&mut self, matches: &ArgMatches) -> Result<(), Error> {
        *self = Self::from_arg_matches(matches)?;
        Ok(())
    }
}
