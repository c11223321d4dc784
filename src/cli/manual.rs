//! `nephroid manual`: man pages and completions of shells, from the arguments as they are declared.

use std::fs;

use anyhow::Context as _;
use clap::CommandFactory as _;
use clap_complete::Shell;

use super::args::{Args, ManualArgs};
use super::outcome::Outcome;

/// Shells whose completions are written.
const SHELLS: [Shell; 4] = [Shell::Bash, Shell::Zsh, Shell::Fish, Shell::PowerShell];

/// Runs the command: a page for the program and one for each command, and a file for each shell.
///
/// # Errors
///
/// If a file cannot be written.
pub fn manual(args: &ManualArgs) -> anyhow::Result<Outcome> {
    let folder = &args.output;
    fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    clap_mangen::generate_to(Args::command(), folder)
        .with_context(|| format!("man pages in {}", folder.display()))?;
    say!("wrote man pages to {}", folder.display());
    let mut command = Args::command();
    let name = command.get_name().to_owned();
    for shell in SHELLS {
        let file = clap_complete::generate_to(shell, &mut command, &name, folder)
            .with_context(|| format!("completions of {shell} in {}", folder.display()))?;
        say!("wrote {}", file.display());
    }
    Ok(Outcome::Complete)
}
