//! Maps of differences as PNG.

use std::path::Path;

use anyhow::Context;

use crate::film::Grid;
use crate::film::picture::{self, BarRange, Content, PictureSpec};
use crate::metric::maps::{Maps, reach};
use crate::metric::{LayerPair, Pairing};

/// The end of the bar of z: of 10⁶ normal numbers less than one is beyond.
const LARGEST_Z: f64 = 5.0;

/// Writes the maps of all layers into a folder. Returns their paths.
///
/// # Errors
///
/// If the folder cannot be made or a file not written.
pub(super) fn write(pairing: &Pairing, unit: &str, folder: &Path) -> anyhow::Result<Vec<String>> {
    std::fs::create_dir_all(folder)
        .with_context(|| format!("cannot make the folder {}", folder.display()))?;
    let mut files = Vec::new();
    for pair in &pairing.pairs {
        let maps = Maps::of(pair);
        let around_zero = |reach: f64| BarRange {
            low: -reach,
            high: reach,
        };
        let mut draw = |kind: &str, map: &Grid<f32>, unit: &str, range: Option<BarRange>| {
            let path = folder.join(format!("{}-{kind}.png", file_name(pair)));
            let spec = PictureSpec {
                title: &format!("{} · {kind}", pair.name),
                unit,
                content: Content::Signed { values: map },
                range,
            };
            files.push(path.display().to_string());
            picture::write(&path, &spec)
        };
        let scaled = |map: &Grid<f32>| reach(map).map(around_zero);
        draw(
            "difference",
            &maps.difference,
            unit,
            scaled(&maps.difference),
        )?;
        let percent = maps.relative.map(|value| 100.0 * value);
        draw("relative", &percent, "%", scaled(&percent))?;
        if let Some(z) = &maps.z {
            draw("z", z, "sigma", Some(around_zero(LARGEST_Z)))?;
        }
    }
    Ok(files)
}

/// The layer's name, with every character replaced that a file name cannot hold.
fn file_name(pair: &LayerPair) -> String {
    let allowed = |c: char| c.is_ascii_alphanumeric() || "-_.".contains(c);
    let replaced = |c: char| if allowed(c) { c } else { '_' };
    pair.name.chars().map(replaced).collect()
}
