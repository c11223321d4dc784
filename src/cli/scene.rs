//! The scene that a command is given.

use super::args::SceneArgs;
use crate::mitsuba::{self, LoadError};
use crate::scene::{Scene, SourcePosition};

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
/// As [`mitsuba::load`], and for dispersion that the scene cannot have.
pub fn load_with(args: &SceneArgs, define: &[(String, String)]) -> Result<Scene, LoadError> {
    let scene = if args.lenient {
        mitsuba::load_leniently(&args.scene, define)?
    } else {
        mitsuba::load(&args.scene, define)?
    };
    let dispersion = args.dispersion.iter();
    let dispersion: Vec<(&str, &str)> = dispersion.map(|(id, glass)| (&**id, &**glass)).collect();
    scene
        .with_dispersion(&dispersion)
        .map_err(|error| LoadError {
            at: SourcePosition {
                file: args.scene.clone(),
                line: 0,
                column: 0,
            },
            message: format!("--dispersion: {error}"),
            others: Vec::new(),
        })
}
