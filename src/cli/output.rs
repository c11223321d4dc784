//! From an estimate to files.

use std::path::{Path, PathBuf};

use anyhow::Context;

use super::run::Run;
use super::summary::{Summary, Timing};
use crate::film::picture::{self, BarRange, Content, PictureError, PictureSpec, Scale};
use crate::film::{Grid, LazyImage, atomic, exr};
use crate::radiometry::Rgb;

/// The extension of pictures.
const PICTURE: &str = "png";

/// The path of the result: as the user says, or `out/SCENE.exr`, making that folder.
///
/// # Errors
///
/// If the folder is missing, cannot be made or takes no file, or the name has another extension:
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

/// Refuses a result that could not be written, or whose picture could not.
fn check_writable(path: &Path) -> anyhow::Result<()> {
    atomic::check(path)?;
    Ok(atomic::check(&path.with_extension(PICTURE))?)
}

/// Writes the EXR at `path` and the picture beside it, each whole or not at all. Returns the paths written: a
/// film that is too large for a picture has none. Unknown texels are NaN in the EXR and magenta in the
/// picture.
///
/// # Errors
///
/// If a file cannot be written.
pub fn write(run: &Run, summary: &Summary, path: &Path) -> anyhow::Result<Vec<PathBuf>> {
    exr::write_lazily(path, &image(run, summary)?)?;
    let picture = path.with_extension(PICTURE);
    let colours = (!run.scene.dispersion().is_empty())
        .then(|| grid(run, |value| value.0.map(|channel| channel as f32)))
        .transpose()?;
    let means = grid(run, |value| value.mean() as f32)?;
    // A rainbow is its colours; of all else the picture says how much light there is.
    let (content, range) = if let Some(values) = &colours {
        (Content::ToneMapped { values }, exposure(values))
    } else {
        let (values, scale) = (&means, Scale::Logarithmic);
        (Content::FalseColour { values, scale }, None)
    };
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
            content,
            range,
        },
    );
    match drawn {
        Ok(()) => Ok(vec![path.to_owned(), picture]),
        Err(PictureError::Size { .. }) => Ok(vec![path.to_owned()]),
        Err(error) => Err(error.into()),
    }
}

/// The total, texel by texel.
fn grid<T>(run: &Run, shown: impl Fn(&Rgb) -> T) -> anyhow::Result<Grid<T>> {
    let estimate = &run.rendering.estimate;
    let shown = estimate.total.values.iter().map(shown).collect();
    Grid::from_vec(estimate.width, estimate.height, shown)
        .context("the estimate does not fill its grid")
}

/// From black to full: the channel that one in a hundred lit texels exceeds. `None` if nothing is lit.
fn exposure(values: &Grid<[f32; 3]>) -> Option<BarRange> {
    let brightest = values
        .iter()
        .map(|rgb| rgb.iter().copied().fold(0.0, f32::max));
    let mut lit: Vec<f32> = brightest
        .filter(|value| *value > 0.0 && value.is_finite())
        .collect();
    let exceeded = lit.len().checked_sub(1)? * 99 / 100;
    let high = f64::from(*lit.select_nth_unstable_by(exceeded, f32::total_cmp).1);
    Some(BarRange { low: 0.0, high })
}

/// All layers with their description.
fn image<'a>(run: &Run<'a>, summary: &Summary) -> anyhow::Result<LazyImage<'a>> {
    let mut image = run.rendering.lazy_image(run.scene);
    image.add_metadata("summary", serde_json::to_string(&summary.without_timing())?);
    image.add_metadata("timing", serde_json::to_string(&Timing::of(run))?);
    Ok(image)
}
