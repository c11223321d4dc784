//! Tables as raw volumes for other programs, with a description in JSON.

use std::collections::HashSet;
use std::fs;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde_json::{Value, json};

use super::cells::Cells;
use super::chunk::{Content, Key, is_fitted};
use super::directions::Samples;
use super::file::raw_numbers;
use super::layout::Layout;
use super::object::SpecularObject;
use super::scenery::Kept;
use super::settings::Settings;
use super::storage::Stored;
use super::table::{Form, Table};
use super::variants::{Directions, Normal, Region, Space, Storage, Symmetry};
use crate::film::atomic::{self, WriteError};
use crate::scene::Scene;
use crate::setting::Words as _;

/// The file that describes the others.
const DESCRIPTION: &str = "tables.json";

/// Writes the tables of the last scene's objects: a `.raw` file each, and `tables.json`.
///
/// # Errors
///
/// If the folder cannot be made, or a file not be written.
pub fn write(
    settings: &Settings,
    kept: &Kept,
    scene: &Scene,
    folder: &Path,
) -> Result<Vec<PathBuf>, WriteError> {
    fs::create_dir_all(folder).map_err(|cause| WriteError::Io {
        path: folder.to_owned(),
        cause,
    })?;
    let (Some(scenery), Some(samples)) = (&kept.last, Samples::new(settings)) else {
        return Ok(Vec::new());
    };
    let mut files = Vec::new();
    let mut objects = Vec::new();
    let mut written = HashSet::new();
    for (object, layout) in &scenery.objects {
        let form = object.form(settings);
        let mut tables = Vec::new();
        for content in Content::tables(settings, &samples) {
            let Some(table) = kept.tables.get(&Key::new(&form, content)) else {
                continue;
            };
            // Objects of one form share files.
            let name = format!("{}-{}.raw", &form[..16], content.name());
            if written.insert(name.clone()) {
                let path = folder.join(&name);
                atomic::write(&path, |file| file.write_all(&volume(layout, table)))?;
                files.push(path);
            }
            let direction = match content {
                Content::Sample(sample) => samples.all().get(sample),
                Content::Harmonics | Content::Shells => None,
            };
            tables.push(json!({
                "file": name,
                "direction_to_light": direction.map(DVec3::to_array),
            }));
        }
        objects.push(described(settings, scene, (object, layout), &form, &tables));
    }
    let directions: Vec<[f64; 3]> = samples.all().iter().map(DVec3::to_array).collect();
    let description = json!({
        "format": "tables of local precomputed irradiance, version 1",
        "byte_order": "little-endian",
        "value": value(settings),
        "numbers": numbers(settings),
        "directions_to_light": directions,
        "objects": objects,
    });
    let path = folder.join(DESCRIPTION);
    atomic::write(&path, |file| {
        serde_json::to_writer_pretty(&mut *file, &description).map_err(io::Error::from)?;
        writeln!(file)
    })?;
    files.push(path);
    Ok(files)
}

/// The cells in the order in which they are written: cubes row by row, not block by block as tables have
/// them.
fn row_by_row(layout: &Layout) -> Vec<u32> {
    match &layout.cells {
        None => Vec::new(),
        Some(Cells::Grid(grid)) => {
            let n = grid.side();
            let places = (0..n * n * n).map(|place| [place % n, place / n % n, place / (n * n)]);
            places.map(|place| grid.index(place)).collect()
        }
        Some(cells) => (0..cells.count() as u32).collect(),
    }
}

/// The numbers of a table in the order of cells: trees are written out.
fn volume(layout: &Layout, table: &Table) -> Vec<u8> {
    let mut bytes = Vec::new();
    let cells = row_by_row(layout);
    match &table.form {
        Form::Shells(stored) => raw_numbers(stored, &mut bytes),
        Form::Cells(stored) => {
            let places = cells.iter().map(|cell| *cell as usize);
            raw_numbers(&gathered(stored, places), &mut bytes);
        }
        Form::Harmonics(stored) | Form::Vectors(stored) => {
            let each = stored.count() / cells.len().max(1);
            let places = cells.iter().map(|cell| *cell as usize * each);
            let all = places.flat_map(|first| first..first + each);
            raw_numbers(&gathered(stored, all), &mut bytes);
        }
        Form::Trees { trees, leaves } => {
            let places = cells.iter().map(|cell| {
                let (root, path) = layout.path(*cell);
                trees.leaf(root, path)
            });
            raw_numbers(&gathered(leaves, places), &mut bytes);
        }
        // Tables of a frame alone are not kept.
        Form::Reads(..) | Form::ReadShells(_) => {}
    }
    bytes
}

/// The numbers at some places.
fn gathered(stored: &Stored, places: impl Iterator<Item = usize>) -> Stored {
    match stored {
        Stored::U8 { steps, step } => Stored::U8 {
            steps: places.map(|place| steps[place]).collect(),
            step: *step,
        },
        Stored::Rgb9e5(words) => Stored::Rgb9e5(places.map(|place| words[place]).collect()),
        Stored::F16(all) => Stored::F16(places.map(|place| all[place]).collect()),
        Stored::F32(all) => Stored::F32(places.map(|place| all[place]).collect()),
        Stored::F64(all) => Stored::F64(places.map(|place| all[place]).collect()),
    }
}

/// What a number is.
fn value(settings: &Settings) -> &'static str {
    match settings.normal {
        Normal::Vector => {
            "vector irradiance V by that of parallel light, along the object's own axes: red, green, blue of x, then of \
             y, then of z, cell by cell. On a surface of normal N: max(0, -N.V), colour by colour"
        }
        Normal::Fixed | Normal::Exact => {
            "irradiance by that of parallel light, on a surface that faces the object's centre; red, green, \
             blue one after the other. On a surface of normal N at the place D: times max(0, -N.D / |D|)"
        }
    }
}

fn numbers(settings: &Settings) -> Value {
    match settings.storage {
        Storage::U8 => json!({
            "type": "u8",
            "range": [0.0, settings.range],
            "meaning": "value = number / 255 * range[1]",
        }),
        Storage::Rgb9e5 => json!({
            "type": "rgb9e5",
            "meaning": "a word of 32 bits for red, green and blue: mantissas in bits 0 to 8, 9 to 17 and 18 to 26, \
                        and an exponent e in bits 27 to 31; value = mantissa * 2^(e - 24)",
        }),
        Storage::F16 => json!({"type": "f16"}),
        Storage::F32 => json!({"type": "f32"}),
        Storage::Exact => json!({"type": "f64"}),
    }
}

fn described(
    settings: &Settings,
    scene: &Scene,
    (object, layout): (&SpecularObject, &Layout),
    form: &str,
    tables: &[Value],
) -> Value {
    let name = |shape: &u32| scene.objects()[*shape as usize].id.clone();
    let axis = |axis: DVec3| axis.to_array().to_vec();
    json!({
        "shapes": object.shapes.iter().map(name).collect::<Vec<String>>(),
        "form": form,
        "centre": object.center.to_array(),
        "radius": object.radius,
        "region_radius": layout.radius,
        "axes_in_world": {
            "x": axis(object.turn.x_axis),
            "y": axis(object.turn.y_axis),
            "z": axis(object.turn.z_axis),
        },
        "place": "along the object's own axes, by its centre [m]; farther than region_radius: that at the border, \
                  towards the place",
        "beyond_region": beyond(settings),
        "symmetry": symmetry(settings),
        "layout": cells(settings, layout),
        "tables": tables,
    })
}

/// What a frame does with places beyond the region.
fn beyond(settings: &Settings) -> &'static str {
    match settings.region {
        Region::Clamp | Region::Exact => "the value at the border",
        Region::Fade => {
            "values are multiplied by x * x * (3 - 2 * x), x = 10 * (1 - distance / region_radius) from 0 to 1"
        }
    }
}

/// How a place is turned before the samples of a symmetric object serve its light.
fn symmetry(settings: &Settings) -> Value {
    match settings.symmetry {
        Symmetry::None => Value::Null,
        Symmetry::Sphere => json!("turn the light, and places with it, to the only direction"),
        Symmetry::Axis => json!({
            "axis": settings.axis.word(),
            "how": "turn the light, and places with it, about the axis into the half plane of the directions",
        }),
    }
}

/// The harmonics that coefficients are of.
const HARMONICS: &str = "coefficient l * l + l + m is that of Y(l, m), orthonormal over the sphere: \
    sqrt(2) K P(l, |m|)(z) cos(m phi) for m > 0, sin(|m| phi) for m < 0, K P(l, 0)(z) for m = 0, without (-1)^m";

fn cells(settings: &Settings, layout: &Layout) -> Value {
    let order = settings.order;
    let mut described = match &layout.cells {
        Some(Cells::Grid(grid)) => json!({
            "kind": "grid",
            "cells_a_side": grid.side(),
            "half_edge": grid.half(),
            "index": "(z * cells_a_side + y) * cells_a_side + x; cell 0 begins at -half_edge along each axis",
        }),
        Some(Cells::Shells(shells)) => json!({
            "kind": "shells",
            "radii": shells.radii(),
            "frequency": shells.geodesic().frequency(),
            "triangles_a_shell": shells.triangles(),
            "index": "shell * triangles_a_shell + triangle, shells from the innermost",
            "triangle": "Take the face of the icosahedron (face_corners) whose middle is nearest to the direction, \
                 and the direction's weights by its three corners, scaled so that they sum to f = frequency. With \
                 the whole parts a, b, c of these (at most f - 1): if a + b + c + 1 >= f, the triangle is \
                 face * f * f + a * f - a * (a - 1) / 2 + b, else it is \
                 face * f * f + f * (f + 1) / 2 + a * (f - 1) - a * (a - 1) / 2 + b.",
            "face_corners": face_corners(),
        }),
        None => Value::Null,
    };
    if is_fitted(settings) {
        described["coefficients"] = json!({
            "order": order,
            "of": "real spherical harmonics of the direction to the light, all of a cell together",
            "harmonics": HARMONICS,
        });
    } else if matches!(settings.space, Space::ShellHarmonics) {
        described["coefficients"] = json!({
            "order": order,
            "of": "real spherical harmonics of the place's direction, all of a shell together, instead of triangles",
            "harmonics": HARMONICS,
        });
    } else if settings.directions == Directions::Harmonics {
        described["blend"] =
            json!("samples by harmonics of the direction to the light, fitted to all of them");
    }
    described
}

/// The corners of the icosahedron's faces, by which triangles are numbered.
fn face_corners() -> Vec<[[f64; 3]; 3]> {
    let geodesic = crate::geometry::Geodesic::new(1);
    (0..20)
        .map(|face| geodesic.corners(face).map(|corner| corner.to_array()))
        .collect()
}
