//! The folder for what later runs can use again.

use std::path::PathBuf;

use crate::run::Context;

/// The folder for what later runs can use again.
#[derive(Debug, clap::Args)]
pub struct CacheArgs {
    /// Keep tables of techniques in this folder, and use those that are there; made where missing. Results
    /// do not depend on it
    #[arg(long, value_name = "DIR")]
    pub cache: Option<PathBuf>,
}

impl CacheArgs {
    /// The surroundings of a run with this folder.
    pub fn context(&self) -> Context {
        Context {
            cache: self.cache.clone(),
            ..Context::default()
        }
    }
}
