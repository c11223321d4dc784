//! The scene that a command is given.

use super::args::SceneArgs;
use crate::mitsuba::{self, LoadError};
use crate::scene::Scene;

/// Reads a scene.
///
/// # Errors
///
/// As [`mitsuba::load`].
pub fn load(args: &SceneArgs) -> Result<Scene, LoadError> {
    load_with(args, &args.define)
}

/// Reads a scene with other parameters than those of `-D`.
///
/// # Errors
///
/// As [`mitsuba::load`].
pub fn load_with(args: &SceneArgs, define: &[(String, String)]) -> Result<Scene, LoadError> {
    if args.lenient {
        mitsuba::load_leniently(&args.scene, define)
    } else {
        mitsuba::load(&args.scene, define)
    }
}
