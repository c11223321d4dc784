//! The program as a user meets it: exit codes, messages, files.

mod ends;
mod folder;
mod refusals;
mod results;
