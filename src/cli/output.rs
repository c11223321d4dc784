//! From an estimate to files.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;

use super::summary::{Summary, Timing};
use crate::approximation::{CausticMap, Rendering};
use crate::film::picture::{self, Content, PictureError, PictureSpec, Scale};
use crate::film::{Grid, Image, atomic, exr};
use crate::radiometry::Rgb;
use crate::reference::beams::{BeamReport, BeamSettings};
use crate::reference::full::{FullReport, FullSettings};
use crate::reference::path::{PathReport, PathSettings};
use crate::reference::photon_map::{PhotonMapReport, PhotonMapSettings};
use crate::reference::photons::PhotonSettings;
use crate::reference::{Estimate, Quantity};
use crate::scene::{Scene, Sensor};

/// Everything a result is described by.
pub struct Run<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The sensor filled.
    pub sensor: &'a Sensor,
    /// How it was computed.
    pub method: Settings<'a>,
    /// The result.
    pub estimate: &'a Estimate,
    /// From the start of the command.
    pub elapsed: Duration,
    /// What is to be known beside the scene's own warnings.
    pub warnings: Vec<String>,
}

/// How a result was computed.
#[derive(Clone, Copy)]
pub enum Settings<'a> {
    /// By photons.
    Photons(&'a PhotonSettings),
    /// By beams.
    Beams(&'a BeamSettings, &'a BeamReport),
    /// By paths from a camera.
    Path(&'a PathSettings, &'a PathReport),
    /// By photon maps.
    PhotonMap(&'a PhotonMapSettings, &'a PhotonMapReport),
    /// By all methods, each its part.
    Full(&'a FullSettings, &'a FullReport),
    /// By caustic maps, an approximation.
    CausticMap(&'a CausticMap, &'a Rendering),
}

impl Settings<'_> {
    /// The method's name.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Photons(_) => "photons",
            Self::Beams(..) => "beams",
            Self::Path(..) => "path",
            Self::PhotonMap(..) => "photon-map",
            Self::Full(..) => "full",
            Self::CausticMap(..) => "caustic-map",
        }
    }

    /// What does the work, in a sentence.
    pub fn plural(&self) -> &'static str {
        match self {
            Self::Path(..) => "paths",
            Self::PhotonMap(..) => "photon maps",
            Self::Full(..) => "all methods",
            Self::CausticMap(..) => "caustic maps",
            _ => self.name(),
        }
    }
}

/// The extension of pictures.
const PICTURE: &str = "png";

/// Where the result goes: as the user says, or `out/SCENE.exr`, making that folder.
///
/// # Errors
///
/// Where the folder is missing, cannot be made or takes no file, or the name has another extension:
/// better known now than after the run.
pub fn output_path(asked: Option<&Path>, scene: &Path, extension: &str) -> anyhow::Result<PathBuf> {
    if let Some(path) = asked {
        anyhow::ensure!(
            path.extension().is_some_and(|found| found == extension),
            "{}: the output's name must end in .{extension}",
            path.display()
        );
        let folder = path.parent().unwrap_or(Path::new(""));
        anyhow::ensure!(
            folder == Path::new("") || folder.is_dir(),
            "{}: the folder {} does not exist",
            path.display(),
            folder.display()
        );
        check_writable(path)?;
        return Ok(path.to_owned());
    }
    let folder = Path::new("out");
    std::fs::create_dir_all(folder).context("cannot make the folder out")?;
    // Not `with_extension`, which would cut the name of `pool.calm.xml` short.
    let mut name = scene.file_stem().unwrap_or_default().to_owned();
    name.push(".");
    name.push(extension);
    let path = folder.join(name);
    check_writable(&path)?;
    Ok(path)
}

/// Whether the result, and the picture beside it, could be written.
fn check_writable(path: &Path) -> anyhow::Result<()> {
    atomic::check(path)?;
    Ok(atomic::check(&path.with_extension(PICTURE))?)
}

/// Writes the EXR at `path` and the picture beside it, each whole or not at all. Returns the
/// paths of what was written: no picture of a film that is too large for one. Texels of which nothing is known are NaN in the one and magenta in the other.
///
/// # Errors
///
/// Where a file cannot be written.
pub fn write(run: &Run, summary: &Summary, path: &Path) -> anyhow::Result<Vec<PathBuf>> {
    exr::write(path, &image(run, summary)?)?;
    let picture = path.with_extension(PICTURE);
    let values = Grid::from_vec(
        run.estimate.width,
        run.estimate.height,
        run.estimate
            .total
            .irradiance
            .iter()
            .map(|value| value.mean() as f32)
            .collect(),
    )
    .context("the estimate does not fill its grid")?;
    // What is not known is magenta there.
    let unknown = if run.estimate.total.is_unknown() {
        " · unknown"
    } else {
        ""
    };
    let title = format!(
        "{} · {} · {}{unknown}",
        run.scene
            .path()
            .file_stem()
            .unwrap_or_default()
            .to_string_lossy(),
        run.sensor.id,
        run.estimate.quantity.name()
    );
    let drawn = picture::write(
        &picture,
        &PictureSpec {
            title: &title,
            unit: run.estimate.quantity.unit(),
            content: Content::FalseColour {
                values: &values,
                scale: Scale::Logarithmic,
            },
            range: None,
        },
    );
    match drawn {
        Ok(()) => Ok(vec![path.to_owned(), picture]),
        Err(PictureError::Size { .. }) => Ok(vec![path.to_owned()]),
        Err(error) => Err(error.into()),
    }
}

/// All layers and what describes them: `E`, `LD`, `LRD`, ..., each with `.R .G .B` and
/// `.stderr.R .stderr.G .stderr.B`, and `count.Y`; of beams with `.lo.R` ... and `.hi.R` ... instead.
fn image(run: &Run, summary: &Summary) -> anyhow::Result<Image> {
    let estimate = run.estimate;
    let mut image = estimate.channels();
    if matches!(run.method, Settings::Photons(_)) {
        image.add_scalar("count.Y", estimate.counts.iter().map(|count| *count as f64));
    }
    image.add_metadata("summary", serde_json::to_string(&summary.without_timing())?);
    image.add_metadata("timing", serde_json::to_string(&Timing::of(run))?);
    image.add_metadata("scene", run.scene.path().display().to_string());
    image.add_metadata("scene-hash", run.scene.content_hash());
    image.add_metadata("sensor", run.sensor.id.as_str());
    image.add_metadata("method", run.method.name());
    match run.method {
        Settings::Photons(settings) => {
            image.add_metadata("settings", serde_json::to_string(settings)?);
            image.add_metadata("seed", settings.seed.to_string());
            image.add_metadata("photons", estimate.paths.to_string());
        }
        Settings::Beams(settings, report) => {
            image.add_metadata("settings", serde_json::to_string(settings)?);
            image.add_metadata("beams", serde_json::to_string(report)?);
        }
        Settings::Path(settings, report) => {
            image.add_metadata("settings", serde_json::to_string(settings)?);
            image.add_metadata("seed", settings.seed.to_string());
            image.add_metadata("path", serde_json::to_string(report)?);
        }
        Settings::PhotonMap(settings, report) => {
            let triples = |values: &[Rgb]| values.iter().map(|value| value.0).collect::<Vec<_>>();
            image.add_rgb("bias", &triples(&report.bias));
            image.add_rgb("bias.stderr", &triples(&report.bias_standard_error));
            image.add_metadata("settings", serde_json::to_string(settings)?);
            image.add_metadata("photon-map", serde_json::to_string(report)?);
            image.add_metadata("seed", settings.photons.seed.to_string());
            image.add_metadata("photons", estimate.paths.to_string());
        }
        Settings::Full(settings, report) => {
            image.add_metadata("settings", serde_json::to_string(settings)?);
            image.add_metadata("seed", settings.path.seed.to_string());
            image.add_metadata("full", serde_json::to_string(report)?);
        }
        Settings::CausticMap(map, rendering) => {
            image.add_metadata("settings", serde_json::to_string(&map.settings)?);
            // Seconds differ from run to run: they are in the timing.
            let work: Vec<_> = rendering
                .work
                .iter()
                .map(|one| (one.name, one.work))
                .collect();
            image.add_metadata("work", serde_json::to_string(&work)?);
        }
    }
    image.add_metadata("version", env!("CARGO_PKG_VERSION"));
    image.add_metadata("complete", if estimate.incomplete { "no" } else { "yes" });
    image.add_metadata("warnings", serde_json::to_string(&summary.warnings)?);
    image.add_metadata("quantity", estimate.quantity.name());
    image.add_metadata("unit", estimate.quantity.unit());
    image.add_metadata("conventions", conventions(&run.method, estimate.quantity));
    Ok(image)
}

/// What the numbers mean, for whoever finds the file alone.
fn conventions(method: &Settings, quantity: Quantity) -> String {
    if matches!(method, Settings::Full(..)) {
        return "pixel-averaged radiance [W/m2/sr] towards the camera, linear sRGB; row 0 is the top; L is the sum \
                of the layers, which are classes of paths from light L to camera E, S a mirror or glass, D \
                anything else: emitted L S* E, direct L D S* E, caustic L S+ D E, caustic-sds L S+ D S+ E, \
                indirect L D ... D S* E, caustic-indirect L S+ D ... D S* E; the attribute full says which method \
                measured which class; stderr is one standard error over independent replicates, of methods that \
                draw lots; lo and hi are bounds, with a confidence of 99.9 % a layer as far as they are random, rounded \
                outward, and those of L the sums of the methods'; NaN is not known"
            .to_owned();
    }
    if matches!(method, Settings::Path(..)) {
        return "pixel-averaged radiance [W/m2/sr] towards the camera, linear sRGB; row 0 is the top; L is the sum \
                of the layers, which are classes of paths from light L to camera E, S a mirror or glass, D \
                anything else: emitted L S* E, direct L D S* E, indirect L D ... D S* E; caustic L S+ D E, \
                caustic-sds L S+ D S+ E and caustic-indirect L S+ D ... D S* E as far as paths from a camera \
                find them; stderr is one standard error over independent replicates; NaN is not known"
            .to_owned();
    }
    let measured = match quantity {
        Quantity::Irradiance => {
            "texel-averaged irradiance [W/m2], linear sRGB; row 0 is at v = 0, column 0 at u = 0 of the \
             receiver; E is the sum of the layers"
        }
        Quantity::Radiance => {
            "pixel-averaged radiance [W/m2/sr] of diffuse surfaces that the camera sees, linear sRGB, by light \
             that mirrors and glass brought there (direct light, LD, is not measured); row 0 is the top; \
             L is the sum of the layers, of which those in SE are seen by way of mirrors or glass; bias, of photon \
             maps, is what their blur adds to L where light is smooth"
        }
    };
    format!(
        "{measured}; layers are path signatures: L emitter, R mirror or total internal reflection, T \
         refraction, D diffuse surface; stderr is one standard error over independent replicates (for LD the \
         quadrature's bound or standard error); lo and hi are lower and upper bounds, rounded \
         outward (where there is stderr, too: with the confidence that the attribute beams says); NaN is not known"
    )
}
