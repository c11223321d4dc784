//! The command line: one file a command.
//!
//! `args` says what can be typed; each command turns that into what is meant, calls the floors
//! below, and shows the result. Exit codes: 0 the command did what was asked; 1 it was stopped
//! early and its result is marked incomplete, `compare` found more than the margin,
//! or `validate` more than a limit; 2 it could not (bad usage, bad input, no space).

/// Prints a line. Whoever reads it may have heard enough: a closed pipe is no error.
macro_rules! say {
    ($($text:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stdout(), $($text)*);
    }};
}

pub mod args;
pub mod attribute;
pub mod choice;
pub mod compare;
pub mod frames;
pub mod generate;
pub mod inspect;
pub mod manual;
pub mod merge;
pub mod methods;
pub mod outcome;
pub mod output;
pub mod probe;
pub mod progress;
pub mod render;
mod resident;
pub mod run;
mod scene;
pub mod summary;
pub mod tables;
pub mod validate;

use std::process::ExitCode;

use clap::Parser;

use args::{Args, Command};
use outcome::Outcome;

/// Runs the program on the process' arguments.
pub fn main() -> ExitCode {
    let args = Args::parse();
    let outcome = match &args.command {
        Command::Render(args) => render::render(args),
        Command::Inspect(args) => inspect::inspect(args),
        Command::Probe(args) => probe::probe(args),
        Command::Merge(args) => merge::merge(args),
        Command::Compare(args) => compare::compare(args),
        Command::Validate(args) => validate::validate(args),
        Command::Attribute(args) => attribute::attribute(args),
        Command::Tables(args) => tables::tables(args),
        Command::Methods(args) => methods::methods(args),
        Command::Generate(args) => generate::generate(args),
        Command::Manual(args) => manual::manual(args),
    };
    match outcome {
        Ok(Outcome::Complete) => ExitCode::SUCCESS,
        Ok(Outcome::Incomplete | Outcome::Apart) => ExitCode::from(1),
        Err(error) => {
            eprintln!("error: {error:#}");
            ExitCode::from(2)
        }
    }
}
