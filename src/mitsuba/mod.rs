//! Reader of Mitsuba 3 scene files: they become a [`Scene`].
//!
//! It takes two steps, each in its own folder. `syntax` understands tags, parameters, includes and numbers,
//! and knows the place of everything. `meaning` knows plugins, their parameters and units. `mesh_files` reads
//! OBJ, PLY and Mitsuba's serialized meshes.
//!
//! The aim is that a file means the same light here as in Mitsuba 3.9 (`rgb` variants). Else it fails with an
//! error that names the place, the plugin and the parameter. Contents that make no difference to any result
//! are reported as [`Ignored`](crate::scene::Ignored): samplers, and integrators except for what
//! [`Integrator`](crate::scene::Integrator) keeps of them.
//!
//! Files older than version 2.0 are upgraded as Mitsuba 3 does. Some things that Mitsuba 3 refuses are read,
//! because Mitsuba 0.6 documents their meaning:
//!
//! - `<srgb>`, `<lookAt>`, and `<spectrum>` with three numbers;
//! - `ldrfilm`, and parameters of films for storing an image;
//! - `extEta` of `conductor`, and the texture `scale` on a diffuse surface.

mod error;
mod files;
mod meaning;
mod mesh_files;
mod syntax;

use std::path::{Path, PathBuf};

pub use error::LoadError;
use files::Files;
use meaning::Meaning;

use crate::scene::{Scene, SceneParts};

/// Reads a scene file and all files it names.
///
/// `parameters` are the values of `$name` in the file, by name; they win over `<default>`.
///
/// # Errors
///
/// See [`load_parts`]; also if the parts contradict each other.
pub fn load(path: &Path, parameters: &[(String, String)]) -> Result<Scene, LoadError> {
    Ok(Scene::new(load_parts(path, parameters)?)?)
}

/// Reads a scene file and all files it names, without checking the scene as a whole.
///
/// The parts' `content_hash` covers the parameters and the contents of every file read, in the order of first
/// use. It covers no paths, so that a copied scene has the same hash.
///
/// # Errors
///
/// If a file is missing or malformed, or asks for a feature that is not modelled.
pub fn load_parts(path: &Path, parameters: &[(String, String)]) -> Result<SceneParts, LoadError> {
    parts(path, parameters, Unknown::Refused, &[]).map(|(parts, _)| parts)
}

/// As [`load`], but parameters that a plugin does not know become [warnings](Scene::warnings), as files for
/// other renderers and research forks need. Plugins that are not modelled stay errors.
///
/// # Errors
///
/// As [`load`].
pub fn load_leniently(path: &Path, parameters: &[(String, String)]) -> Result<Scene, LoadError> {
    let (parts, _) = parts(path, parameters, Unknown::LeftOut, &[])?;
    Ok(Scene::new(parts)?)
}

/// As [`load`], or as [`load_leniently`], with files in memory: contents by path, which win over the disk.
///
/// The scene has the content hash of the same files on the disk. Beside it are the paths of all files read,
/// those in memory among them.
///
/// # Errors
///
/// As [`load`].
pub fn load_held(
    path: &Path,
    parameters: &[(String, String)],
    held: &[(PathBuf, Vec<u8>)],
    is_lenient: bool,
) -> Result<(Scene, Vec<PathBuf>), LoadError> {
    let unknown = if is_lenient {
        Unknown::LeftOut
    } else {
        Unknown::Refused
    };
    let (parts, paths) = parts(path, parameters, unknown, held)?;
    Ok((Scene::new(parts)?, paths))
}

/// What becomes of parameters that a plugin does not know.
#[derive(Clone, Copy, PartialEq)]
enum Unknown {
    Refused,
    LeftOut,
}

fn parts(
    path: &Path,
    parameters: &[(String, String)],
    unknown: Unknown,
    held: &[(PathBuf, Vec<u8>)],
) -> Result<(SceneParts, Vec<PathBuf>), LoadError> {
    let mut files = Files::new(parameters);
    for (path, contents) in held {
        files.hold(path.clone(), contents);
    }
    let Meaning { forms, mut parts } = read(path, parameters, unknown, &mut files)?;
    parts.shapes = Meaning::build_shapes(forms, &parts.objects)?;
    path.clone_into(&mut parts.path);
    parts.content_hash = files.content_hash();
    Ok((parts, files.paths()))
}

/// Runs both steps; mesh files are not yet parsed.
fn read(
    path: &Path,
    parameters: &[(String, String)],
    unknown: Unknown,
    files: &mut Files,
) -> Result<Meaning, LoadError> {
    let mut tree = syntax::read(path, parameters, files)?;
    if unknown == Unknown::LeftOut {
        tree.be_lenient();
    }
    meaning::read(&tree, files)
}
