//! `nephroid validate` as a user meets it: reports, figures, candidates, limits, interruption.

#[cfg(unix)]
mod action;
mod course;
mod folder;
mod poses;
mod report;
mod sensors;
mod shards;
mod units;
mod verdicts;
mod watched;
