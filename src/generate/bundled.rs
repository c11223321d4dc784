//! The bundled scenes, and their files.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use crate::film::atomic::{self, WriteError};
use crate::geometry::MeshParts;

use super::{
    ball::{bumpy_ball, geodesic_sphere},
    block::bumpy_block,
    facets::{BrilliantCut, equilateral_prism, round_brilliant, subdivided_facets},
    fence::{Picket, picket_fence},
    height_field::{Wave, height_field, terrain},
    ply::ply_bytes,
    revolution::{paraboloid, plano_convex_lens},
    tube::{band, ring, trefoil_knot},
};

/// The waves of the scene `water`; their slopes sum to less than 0.5.
pub const WATER: [Wave; 5] = [
    wave(0.0120, 9.0, 3.0, 0.3),
    wave(0.0090, -6.0, 11.0, 1.9),
    wave(0.0055, 14.0, -8.0, 4.1),
    wave(0.0030, 5.0, 21.0, 2.2),
    wave(0.0020, -23.0, -9.0, 5.5),
];

/// The waves of the scene `pool`; their slopes sum to less than 0.5.
///
/// Their curvatures sum to 4.2 / m. Water of index 1.33 focuses light from above at the floor's depth of
/// 1.5 m where its crests curve by 1.33 / (0.33 · 1.5 m) = 2.7 / m.
pub const POOL: [Wave; 5] = [
    wave(0.0200, 4.6, 2.0, 0.7),
    wave(0.0163, -3.4, 6.1, 2.6),
    wave(0.0123, 8.1, -3.9, 4.4),
    wave(0.0069, 3.6, 11.4, 1.2),
    wave(0.0040, -13.6, -6.3, 5.0),
];

/// The waves of the hills in the scene `turntable-terrain`. Their slopes sum to less than tan 30°, and their
/// amplitudes to less than 0.32 m.
pub const HILLS: [Wave; 4] = [
    wave(0.16, 1.3, 0.5, 0.6),
    wave(0.10, -0.9, 1.6, 2.2),
    wave(0.035, 2.6, 1.7, 4.0),
    wave(0.015, -1.9, 3.4, 1.1),
];

/// The boards of the fence over the scene `pool`, in metres.
const PICKET: Picket = Picket {
    width: 0.12,
    height: 2.0,
    tip: 0.1,
    thickness: 0.02,
};

/// The largest detail of the knot of `cornell-caustics`, 97,020 triangles at detail 1.
const KNOT_DETAIL: u32 = 14;

/// The largest detail of the ball of `turntable-bumpy`, 81,920 triangles at detail 1.
const BUMPY_DETAIL: u32 = 15;

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
    /// The main file's name without its ending.
    pub name: &'static str,
    /// All files that it needs: the main one first, then those that it includes, then meshes.
    pub files: &'static [BundledFile],
}

/// A file of a bundled scene.
#[derive(Clone, Copy, Debug)]
pub struct BundledFile {
    /// The file's name, with its ending.
    pub name: &'static str,
    content: Content,
}

#[derive(Clone, Copy, Debug)]
enum Content {
    Xml(&'static str),
    Mesh(fn(detail: u32) -> MeshParts),
}

/// Settings of the generators.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct GenerateOptions {
    /// A factor on the number of cuts along every direction of a curved mesh: `detail`² times the
    /// triangles of the bundled one. 1 to [`GenerateOptions::MAX_DETAIL`]. Flat-faceted meshes do not change.
    /// The finest meshes stay the same above a detail: the knot of `cornell-caustics` above 14, the ball of
    /// `turntable-bumpy` above 15.
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

/// The files of one scene: XML files by their names, the main one first, then generators of meshes by theirs.
macro_rules! bundled {
    ($name:literal $(, include $include:literal)* $(, mesh $mesh:literal = $generator:expr)*) => {
        BundledScene {
            name: $name,
            files: &[
                bundled!(@xml $name),
                $(bundled!(@xml $include),)*
                $(BundledFile {
                    name: concat!($mesh, ".ply"),
                    content: Content::Mesh($generator),
                },)*
            ],
        }
    };
    (@xml $name:literal) => {
        BundledFile {
            name: concat!($name, ".xml"),
            content: Content::Xml(include_str!(concat!("../../scenes/", $name, ".xml"))),
        }
    };
}

/// All bundled scenes, in the order of `scenes/README.md`.
pub const SCENES: [BundledScene; 21] = [
    bundled!("glass-ball"),
    bundled!(
        "glass-ball-mesh",
        mesh "glass-ball-mesh" = |detail| geodesic_sphere(1.0, 32 * detail)
    ),
    bundled!("glass-ball-behind-pane"),
    bundled!("coffee-cup"),
    bundled!("mirror-ring"),
    bundled!(
        "water",
        mesh "water" = |detail| height_field(DVec2::splat(1.05), 0.8, &WATER, 119 * detail + 1)
    ),
    bundled!(
        "pool",
        include "pool-none",
        include "pool-disc",
        include "pool-fence",
        mesh "pool" = |detail| height_field(DVec2::new(2.25, 1.75), 1.5, &POOL, 119 * detail + 1),
        mesh "pool-fence" = |_| picket_fence(PICKET, 0.25, 16)
    ),
    bundled!("prism", mesh "prism" = |_| equilateral_prism(0.1, 0.2)),
    bundled!("rainbow", mesh "rainbow" = |_| equilateral_prism(0.03, 0.1)),
    bundled!("cube"),
    bundled!(
        "diamond",
        mesh "diamond" = |_| round_brilliant(0.325, BrilliantCut::TOLKOWSKY)
    ),
    bundled!(
        "lens",
        mesh "lens" = |detail| plano_convex_lens(0.06, 0.05, 28 * detail)
    ),
    bundled!("cornell-glass"),
    bundled!(
        "cornell-caustics",
        include "cornell-caustics-diamond",
        include "cornell-caustics-ring",
        include "cornell-caustics-ball",
        include "cornell-caustics-knot",
        include "cornell-caustics-blocks",
        mesh "cornell-caustics-diamond" = |_| {
            subdivided_facets(&round_brilliant(0.35, BrilliantCut::TOLKOWSKY), 4)
        },
        mesh "cornell-caustics-ring" = |detail| ring(0.35, 0.03, 0.1, 60 * detail, 24 * detail),
        mesh "cornell-caustics-ball" = |detail| geodesic_sphere(0.35, 14 * detail),
        mesh "cornell-caustics-knot" = |detail| {
            let detail = detail.min(KNOT_DETAIL);
            trefoil_knot(0.23, 0.115, 0.055, 0.06, 735 * detail, 66 * detail)
        },
        mesh "cornell-caustics-blocks" = |detail| {
            bumpy_block(DVec3::new(0.2, 0.15, 0.11), 24 * detail)
        }
    ),
    bundled!(
        "parabolic-mirror",
        mesh "parabolic-mirror" = |detail| paraboloid(0.5, 0.5, 28 * detail)
    ),
    bundled!("turntable-ball", include "turntable-floor", include "turntable-stage"),
    bundled!("turntable-cube", include "turntable-floor", include "turntable-stage"),
    bundled!(
        "turntable-prism",
        include "turntable-floor",
        include "turntable-stage",
        mesh "turntable-prism" = |_| equilateral_prism(1.0, 1.6)
    ),
    bundled!(
        "turntable-ring",
        include "turntable-floor",
        include "turntable-stage",
        mesh "turntable-ring" = |detail| band(0.85, 0.92, 0.3, 240 * detail)
    ),
    bundled!(
        "turntable-bumpy",
        include "turntable-floor",
        include "turntable-stage",
        mesh "turntable-bumpy" = |detail| bumpy_ball(0.93, 64 * detail.min(BUMPY_DETAIL))
    ),
    bundled!(
        "turntable-terrain",
        include "turntable-stage",
        mesh "turntable-terrain-prism" = |_| equilateral_prism(1.0, 1.6),
        mesh "turntable-terrain" = |detail| terrain(DVec2::splat(3.0), &HILLS, 64 * detail + 1)
    ),
];

/// The names that [`generate`] knows.
pub fn scene_names() -> impl Iterator<Item = &'static str> {
    SCENES.iter().map(|scene| scene.name)
}

impl BundledScene {
    /// The main file's text.
    pub fn xml(&self) -> &'static str {
        let mut texts = self.files.iter().filter_map(|file| match file.content {
            Content::Xml(text) => Some(text),
            Content::Mesh(_) => None,
        });
        texts.next().unwrap_or_default()
    }

    /// Every file's name and its bytes, meshes at this detail (0 counts as 1).
    pub fn contents(&self, detail: u32) -> impl Iterator<Item = (&'static str, Vec<u8>)> {
        let detail = detail.max(1);
        let comment = format!("nephroid generate {}: detail {detail}", self.name);
        self.files
            .iter()
            .map(move |file| (file.name, file.content.bytes(detail, &comment)))
    }
}

impl Content {
    fn bytes(self, detail: u32, comment: &str) -> Vec<u8> {
        match self {
            Self::Xml(text) => text.as_bytes().to_vec(),
            Self::Mesh(generator) => ply_bytes(&generator(detail), comment),
        }
    }
}

/// Writes the scene `name` (its XML files and its meshes) into the folder `out_dir`, which is
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
    let mut written = Vec::with_capacity(scene.files.len());
    for (name, bytes) in scene.contents(options.detail) {
        let path = out_dir.join(name);
        atomic::write(&path, |file| file.write_all(&bytes))?;
        written.push(path);
    }
    Ok(written)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::math;

    #[test]
    fn the_waters_slopes_sum_to_less_than_one_half() {
        for waves in [WATER, POOL] {
            let slope: f64 = waves
                .iter()
                .map(|wave| wave.amplitude * wave.wave.length())
                .sum();
            assert!(slope < 0.5, "{slope}");
        }
    }

    #[test]
    fn hills_are_lower_and_flatter_than_their_scene_says() {
        let sum = |of: fn(&Wave) -> f64| HILLS.iter().map(of).sum::<f64>();
        assert!(sum(|wave| wave.amplitude) < 0.32);
        let slope = sum(|wave| wave.amplitude * wave.wave.length());
        assert!(slope < math::tan(30.0_f64.to_radians()), "{slope}");
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
        assert!(2 * 735 * 66 * KNOT_DETAIL.pow(2) < 20_000_000);
        assert!(20 * (64 * BUMPY_DETAIL).pow(2) < 20_000_000);
        assert!(2 * (64 * detail).pow(2) < 20_000_000);
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
