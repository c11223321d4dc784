//! From an estimate to files.

use std::path::{Path, PathBuf};
use std::time::Duration;

use anyhow::Context;

use super::summary::{Summary, Timing};
use crate::film::picture::{self, Content, PictureError, PictureSpec, Scale};
use crate::film::{Grid, Image, atomic, exr};
use crate::method::Method;
use crate::run::{Estimate, LayerName, Quantity, Rendering};
use crate::scene::{Scene, Sensor};

/// Everything that describes a result.
pub struct Run<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The sensor filled.
    pub sensor: &'a Sensor,
    /// The method.
    pub method: &'a Method,
    /// The result.
    pub rendering: &'a Rendering,
    /// From the start of the command.
    pub elapsed: Duration,
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
        run.rendering.estimate.width,
        run.rendering.estimate.height,
        run.rendering
            .estimate
            .total
            .values
            .iter()
            .map(|value| value.mean() as f32)
            .collect(),
    )
    .context("the estimate does not fill its grid")?;
    // What is not known is magenta there.
    let unknown = if run.rendering.estimate.total.is_unknown() {
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
        run.rendering.estimate.quantity.name()
    );
    let drawn = picture::write(
        &picture,
        &PictureSpec {
            title: &title,
            unit: run.rendering.estimate.quantity.unit(),
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

/// All layers with their description: `E`, `LD`, `LRD`, ..., each with `.R .G .B` and `.stderr.R .stderr.G .stderr.B`, or with bounds
/// `.lo.R` ... and `.hi.R` ...; further maps of the method.
fn image(run: &Run, summary: &Summary) -> anyhow::Result<Image> {
    let (rendering, estimate) = (run.rendering, &run.rendering.estimate);
    let mut image = estimate.channels();
    for (name, values) in &rendering.scalars {
        image.add_scalar(name, values.iter().copied());
    }
    for (name, values) in &rendering.maps {
        let triples: Vec<[f64; 3]> = values.iter().map(|value| value.0).collect();
        image.add_rgb(name, &triples);
    }
    image.add_metadata("summary", serde_json::to_string(&summary.without_timing())?);
    image.add_metadata("timing", serde_json::to_string(&Timing::of(run))?);
    image.add_metadata("scene", run.scene.path().display().to_string());
    image.add_metadata("scene-hash", run.scene.content_hash());
    image.add_metadata("sensor", run.sensor.id.as_str());
    image.add_metadata("method", run.method.name());
    image.add_metadata("settings", run.method.settings().to_string());
    for (name, value) in &rendering.report {
        image.add_metadata(name, value.to_string());
    }
    image.add_metadata("version", env!("CARGO_PKG_VERSION"));
    image.add_metadata("complete", if estimate.incomplete { "no" } else { "yes" });
    image.add_metadata("warnings", serde_json::to_string(&summary.warnings)?);
    image.add_metadata("quantity", estimate.quantity.name());
    image.add_metadata("unit", estimate.quantity.unit());
    image.add_metadata("conventions", conventions(estimate));
    Ok(image)
}

/// The meaning of the numbers, for whoever finds the file alone.
fn conventions(estimate: &Estimate) -> String {
    let is_of_classes = |name: LayerName| matches!(name, LayerName::Class(_));
    let has_classes = estimate
        .layers
        .iter()
        .any(|layer| is_of_classes(layer.name));
    if has_classes && estimate.total.interval.is_some() {
        return "pixel-averaged radiance [W/m2/sr] towards the camera, linear sRGB; row 0 is the top; L is the sum \
                of the layers, which are classes of paths from light L to camera E, S a mirror or glass, D \
                anything else: emitted L S* E, direct L D S* E, caustic L S+ D E, caustic-sds L S+ D S+ E, \
                indirect L D ... D S* E, caustic-indirect L S+ D ... D S* E; the attribute full says which method \
                measured which class; stderr is one standard error over independent replicates, of methods that \
                draw lots; lo and hi are bounds, with a confidence of 99.9 % a layer as far as they are random, rounded \
                outward, and those of L the sums of the methods'; NaN is not known"
            .to_owned();
    }
    if has_classes {
        return "pixel-averaged radiance [W/m2/sr] towards the camera, linear sRGB; row 0 is the top; L is the sum \
                of the layers, which are classes of paths from light L to camera E, S a mirror or glass, D \
                anything else: emitted L S* E, direct L D S* E, indirect L D ... D S* E; caustic L S+ D E, \
                caustic-sds L S+ D S+ E and caustic-indirect L S+ D ... D S* E as far as paths from a camera \
                find them; stderr is one standard error over independent replicates; NaN is not known"
            .to_owned();
    }
    let measured = match estimate.quantity {
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
