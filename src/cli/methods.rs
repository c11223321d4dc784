//! `nephroid methods`: all methods, or the settings of one.

use super::args::MethodsArgs;
use super::outcome::Outcome;
use crate::method::{Method, table};
use crate::setting::Given;

/// Runs the command.
///
/// # Errors
///
/// For a name that is no method's.
pub fn methods(args: &MethodsArgs) -> anyhow::Result<Outcome> {
    let Some(name) = &args.name else {
        for (name, meaning) in table::summary() {
            say!("{name:<14} {meaning}");
        }
        return Ok(Outcome::Complete);
    };
    let method = Method::new(name, &Given::new())?;
    say!("{name}: {}\n", method.meaning());
    say!("{}", table::listing(name).trim_end());
    Ok(Outcome::Complete)
}
