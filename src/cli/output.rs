//! From an estimate to files.

use std::path::{Path, PathBuf};

use anyhow::Context;

use super::run::Run;
use super::summary::{Summary, Timing};
use crate::film::picture::{self, Content, PictureError, PictureSpec, Scale};
use crate::film::{Grid, LazyImage, atomic, exr};

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

/// All layers with their description.
fn image<'a>(run: &Run<'a>, summary: &Summary) -> anyhow::Result<LazyImage<'a>> {
    let mut image = run.rendering.lazy_image(run.scene);
    image.add_metadata("summary", serde_json::to_string(&summary.without_timing())?);
    image.add_metadata("timing", serde_json::to_string(&Timing::of(run))?);
    Ok(image)
}
