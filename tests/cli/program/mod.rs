//! The program as a user meets it: exit codes, messages, files.

mod dispersion;
mod ends;
mod folder;
mod refusals;
mod results;
