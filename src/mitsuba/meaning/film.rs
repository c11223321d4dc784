//! The meaning of `<film>` and `<rfilter>`.

use super::plugin::Plugin;
use crate::mitsuba::error::LoadError;
use crate::mitsuba::syntax::{ObjectIndex, ObjectKind, Tree};
use crate::scene::{Crop, Film, ReconstructionFilter};

const DEFAULT_WIDTH: u32 = 768;
const DEFAULT_HEIGHT: u32 = 576;
/// The filter of Mitsuba's film if the file gives none.
const DEFAULT_FILTER: ReconstructionFilter = ReconstructionFilter::Gaussian { stddev: 0.5 };

/// Parameters of Mitsuba 0.6' films for storing or showing the image: known in old files.
const OLD_STORAGE: [&str; 11] = [
    "attach_log",
    "high_quality_edges",
    "gamma",
    "tonemap_method",
    "exposure",
    "key",
    "burn",
    "filename",
    "digits",
    "variable",
    "has_alpha",
];

/// The film, or Mitsuba's default film if the sensor has none.
///
/// In old files `ldrfilm` is known, too: it has the same grid and stores it otherwise.
pub fn read(tree: &Tree, film: Option<ObjectIndex>) -> Result<Film, LoadError> {
    let Some(film) = film else {
        return Ok(Film {
            width: DEFAULT_WIDTH,
            height: DEFAULT_HEIGHT,
            crop: whole(DEFAULT_WIDTH, DEFAULT_HEIGHT),
            filter: DEFAULT_FILTER,
            sample_border: false,
        });
    };
    let plugin = Plugin::new(tree, film);
    match plugin.name() {
        "hdrfilm" => {}
        "ldrfilm" if plugin.is_old() => {}
        _ => return Err(plugin.error("is not modelled; the modelled film is hdrfilm")),
    }
    let width = plugin.integer_or("width", 1, DEFAULT_WIDTH)?;
    let height = plugin.integer_or("height", 1, DEFAULT_HEIGHT)?;
    let crop = Crop {
        offset_x: plugin.integer_or("crop_offset_x", 0, 0)?,
        offset_y: plugin.integer_or("crop_offset_y", 0, 0)?,
        width: plugin.integer_or("crop_width", 1, width)?,
        height: plugin.integer_or("crop_height", 1, height)?,
    };
    let fits =
        |offset: u32, size: u32, full: u32| u64::from(offset) + u64::from(size) <= u64::from(full);
    if !fits(crop.offset_x, crop.width, width) || !fits(crop.offset_y, crop.height, height) {
        return Err(plugin.error(format!(
            "has a crop of {} x {} at ({}, {}) that does not fit into its {width} x {height} pixels",
            crop.width, crop.height, crop.offset_x, crop.offset_y
        )));
    }
    let filter = match plugin.child(ObjectKind::ReconstructionFilter)? {
        None => DEFAULT_FILTER,
        Some(filter) => read_filter(tree, filter)?,
    };
    let sample_border = plugin.boolean_or("sample_border", false)?;
    plugin.accept(&[
        "banner",
        "compensate",
        "component_format",
        "file_format",
        "pixel_format",
    ]);
    if plugin.is_old() {
        plugin.accept(&OLD_STORAGE);
    }
    plugin.finish()?;
    Ok(Film {
        width,
        height,
        crop,
        filter,
        sample_border,
    })
}

fn whole(width: u32, height: u32) -> Crop {
    Crop {
        offset_x: 0,
        offset_y: 0,
        width,
        height,
    }
}

fn read_filter(tree: &Tree, filter: ObjectIndex) -> Result<ReconstructionFilter, LoadError> {
    let plugin = Plugin::new(tree, filter);
    let result = match plugin.name() {
        "box" => ReconstructionFilter::Box,
        "tent" => ReconstructionFilter::Tent {
            radius: plugin.positive_or("radius", 1.0)?,
        },
        "gaussian" => ReconstructionFilter::Gaussian {
            stddev: plugin.positive_or("stddev", 0.5)?,
        },
        "mitchell" => ReconstructionFilter::Mitchell {
            b: plugin.float_or("B", 1.0 / 3.0)?,
            c: plugin.float_or("C", 1.0 / 3.0)?,
        },
        "catmullrom" => ReconstructionFilter::CatmullRom,
        "lanczos" => ReconstructionFilter::Lanczos {
            lobes: plugin.integer_or("lobes", 1, 3)?,
        },
        _ => {
            let message =
                "is not known; known are: box, tent, gaussian, mitchell, catmullrom, lanczos";
            return Err(plugin.error(message));
        }
    };
    let radius = result.radius();
    if !RADII.contains(&radius) {
        return Err(plugin.error(format!(
            "has a radius of {radius} pixels; allowed are {} to {}",
            RADII.start(),
            RADII.end()
        )));
    }
    plugin.finish()?;
    Ok(result)
}

/// Radii of filters \[pixels\]. Of a narrower one nearly all light falls between the pixels' middles; a wider
/// one spreads each photon over tens of thousands of pixels.
const RADII: std::ops::RangeInclusive<f64> = 0.05..=100.0;
