//! The bundled scenes, and their files.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use glam::DVec2;

use crate::film::atomic::{self, WriteError};
use crate::geometry::MeshParts;

use super::{
    ball::geodesic_sphere,
    facets::{BrilliantCut, equilateral_prism, round_brilliant},
    height_field::{Wave, height_field},
    ply::write_ply,
    revolution::{paraboloid, plano_convex_lens},
};

/// The waves of the scene `water`; their slopes sum to less than 0.5.
pub const WATER: [Wave; 5] = [
    wave(0.0120, 9.0, 3.0, 0.3),
    wave(0.0090, -6.0, 11.0, 1.9),
    wave(0.0055, 14.0, -8.0, 4.1),
    wave(0.0030, 5.0, 21.0, 2.2),
    wave(0.0020, -23.0, -9.0, 5.5),
];

const fn wave(amplitude: f64, x: f64, y: f64, phase: f64) -> Wave {
    Wave {
        amplitude,
        wave: DVec2::new(x, y),
        phase,
    }
}

/// A scene that comes with the program.
#[derive(Clone, Copy, Debug)]
pub struct BundledScene {
    /// The file's name without its ending; the mesh, if any, has the same name and the ending `.ply`.
    pub name: &'static str,
    /// The scene file's text.
    pub xml: &'static str,
    mesh: Option<fn(detail: u32) -> MeshParts>,
}

/// Settings of the generators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GenerateOptions {
    /// A factor on the number of cuts along every direction of a curved mesh: `detail`² times the
    /// triangles of the bundled one. 1 to [`GenerateOptions::MAX_DETAIL`]. Flat-faceted meshes do not change.
    pub detail: u32,
}

impl GenerateOptions {
    /// Above this a mesh would have more than 20 million triangles.
    pub const MAX_DETAIL: u32 = 26;
}

impl Default for GenerateOptions {
    fn default() -> Self {
        Self { detail: 1 }
    }
}

/// Reason why a scene cannot be generated.
#[derive(Debug, thiserror::Error)]
pub enum GenerateError {
    /// No bundled scene has this name.
    #[error("there is no scene {name:?}; allowed: {}", scene_names().collect::<Vec<_>>().join(", "))]
    UnknownScene {
        /// The name asked for.
        name: String,
    },
    /// The detail is out of range.
    #[error("detail = {detail}: allowed are 1 to {}", GenerateOptions::MAX_DETAIL)]
    Detail {
        /// The detail asked for.
        detail: u32,
    },
    /// The folder cannot be made.
    #[error("{}: {error}", path.display())]
    Folder {
        /// The folder.
        path: PathBuf,
        /// The system's error.
        #[source]
        error: io::Error,
    },
    /// A file cannot be written.
    #[error(transparent)]
    Write(#[from] WriteError),
}

macro_rules! bundled {
    ($name:literal, $mesh:expr) => {
        BundledScene {
            name: $name,
            xml: include_str!(concat!("../../scenes/", $name, ".xml")),
            mesh: $mesh,
        }
    };
}

/// All bundled scenes, in the order of `scenes/README.md`.
pub const SCENES: [BundledScene; 12] = [
    bundled!("glass-ball", None),
    bundled!(
        "glass-ball-mesh",
        Some(|detail| geodesic_sphere(1.0, 32 * detail))
    ),
    bundled!("glass-ball-behind-pane", None),
    bundled!("coffee-cup", None),
    bundled!("mirror-ring", None),
    bundled!(
        "water",
        Some(|detail| height_field(1.05, 0.8, &WATER, 119 * detail + 1))
    ),
    bundled!("prism", Some(|_| equilateral_prism(0.1, 0.2))),
    bundled!("cube", None),
    bundled!(
        "diamond",
        Some(|_| round_brilliant(0.325, BrilliantCut::TOLKOWSKY))
    ),
    bundled!(
        "lens",
        Some(|detail| plano_convex_lens(0.06, 0.05, 28 * detail))
    ),
    bundled!("cornell-glass", None),
    bundled!(
        "parabolic-mirror",
        Some(|detail| paraboloid(0.5, 0.5, 28 * detail))
    ),
];

/// The names that [`generate`] knows.
pub fn scene_names() -> impl Iterator<Item = &'static str> {
    SCENES.iter().map(|scene| scene.name)
}

impl BundledScene {
    /// The bytes of the scene's mesh file at this detail; `None` if the scene has none.
    pub fn ply(&self, detail: u32) -> Option<Vec<u8>> {
        let mesh = self.mesh?(detail.max(1));
        let comment = format!("nephroid generate {}: detail {detail}", self.name);
        let mut bytes = Vec::new();
        // Writing to memory cannot fail.
        write_ply(&mesh, &comment, &mut bytes).ok()?;
        Some(bytes)
    }
}

/// Writes the scene `name` (its XML file and its mesh, if it has one) into the folder `out_dir`, which is
/// made if it is missing, and returns the files written.
///
/// Each file is written under a temporary name and then renamed: a failed run leaves no half file and no
/// damaged old one.
///
/// # Errors
///
/// If the name or the detail is not allowed, or a file cannot be written.
pub fn generate(
    name: &str,
    out_dir: &Path,
    options: GenerateOptions,
) -> Result<Vec<PathBuf>, GenerateError> {
    let Some(scene) = SCENES.iter().find(|scene| scene.name == name) else {
        return Err(GenerateError::UnknownScene {
            name: name.to_owned(),
        });
    };
    if !(1..=GenerateOptions::MAX_DETAIL).contains(&options.detail) {
        return Err(GenerateError::Detail {
            detail: options.detail,
        });
    }
    fs::create_dir_all(out_dir).map_err(|error| GenerateError::Folder {
        path: out_dir.to_owned(),
        error,
    })?;
    let mut files = vec![(
        out_dir.join(format!("{name}.xml")),
        scene.xml.as_bytes().to_vec(),
    )];
    if let Some(bytes) = scene.ply(options.detail) {
        files.push((out_dir.join(format!("{name}.ply")), bytes));
    }
    for (path, bytes) in &files {
        atomic::write(path, |file| file.write_all(bytes))?;
    }
    Ok(files.into_iter().map(|(path, _)| path).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_waters_slopes_sum_to_less_than_one_half() {
        let slope: f64 = WATER
            .iter()
            .map(|wave| wave.amplitude * wave.wave.length())
            .sum();
        assert!(slope < 0.5, "{slope}");
    }

    #[test]
    fn an_unknown_name_is_answered_with_the_allowed_ones() {
        let folder = tempfile::tempdir().unwrap();
        let message = generate("teapot", folder.path(), GenerateOptions::default())
            .unwrap_err()
            .to_string();
        assert!(
            message.contains("\"teapot\"") && message.contains("glass-ball, glass-ball-mesh"),
            "{message}"
        );
    }

    #[test]
    fn a_detail_out_of_range_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        for detail in [0, GenerateOptions::MAX_DETAIL + 1, u32::MAX] {
            let message = generate("water", folder.path(), GenerateOptions { detail })
                .unwrap_err()
                .to_string();
            assert!(
                message.contains(&detail.to_string()) && message.contains("1 to 26"),
                "{message}"
            );
        }
    }

    #[test]
    fn the_largest_detail_stays_below_20_million_triangles() {
        let detail = GenerateOptions::MAX_DETAIL;
        assert!(20 * (32 * detail).pow(2) < 20_000_000);
        assert!(2 * (119 * detail).pow(2) < 20_000_000);
    }

    #[test]
    fn twice_the_detail_is_four_times_the_triangles() {
        let folder = tempfile::tempdir().unwrap();
        let written = generate(
            "parabolic-mirror",
            folder.path(),
            GenerateOptions { detail: 2 },
        )
        .unwrap();
        let bytes = fs::read(&written[1]).unwrap();
        let text = String::from_utf8_lossy(&bytes);
        assert!(text.contains(&format!("element face {}\n", 6 * 56 * 56)));
    }
}
