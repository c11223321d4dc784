//! Memory of a run, before any photon.

use super::chunk::is_fitted;
use super::demands::are_kept;
use super::directions::Samples;
use super::layout::kind;
use super::object::SpecularObject;
use super::settings::Settings;
use super::shoot::TASK;
use super::storage::bytes_each;
use super::tree::BLOCK_BYTES;
use super::variants::{Directions, Noise, Normal, Radii, Space, Symmetry, Tables, Tree};
use crate::run::cost::{TRIPLE, of_frame, texels};
use crate::run::format::megabytes;
use crate::scene::{Scene, Sensor, is_achromatic};

/// Memory \[bytes\] of a run, and its samples.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Values of a frame, and what makes them.
    pub values: u64,
    /// The image while it is written.
    pub film: u64,
    /// Tables.
    pub tables: u64,
    /// Sums of photons, and what makes a table of them.
    pub scratch: u64,
    /// The table that is made last.
    pub last: u64,
    /// Samples, of all objects.
    pub samples: u64,
}

impl Size {
    /// That of a run on a sensor.
    pub fn new(scene: &Scene, sensor: &Sensor, settings: &Settings) -> Self {
        let objects = SpecularObject::groups(scene).len() as u64;
        let channels = if is_achromatic(scene) { 1 } else { 3 };
        let lights = scene.emitters().len() as u64;
        Self {
            film: of_frame(sensor, 0, 0),
            ..Self::of(settings, texels(sensor), lights, objects, channels)
        }
    }

    fn of(settings: &Settings, texels: u64, lights: u64, objects: u64, channels: u64) -> Self {
        let all = match (settings.directions, settings.symmetry) {
            (Directions::Exact, _) => lights,
            (_, Symmetry::Sphere) => 1,
            (_, Symmetry::Axis) => u64::from(settings.axis_samples),
            (_, Symmetry::None) => u64::from(Samples::count(settings)),
        };
        let needed = match settings.tables {
            Tables::Needed if settings.directions != Directions::Harmonics => all.min(3 * lights),
            _ => all,
        };
        let triangles = 20 << (2 * settings.shell_level);
        let cells = parts(settings)
            * match kind(settings) {
                None => texels,
                Some(Tree::Grid) => u64::from(settings.cells).pow(3),
                Some(Tree::Shells) => u64::from(settings.shells) * triangles,
            };
        let coefficients = u64::from(settings.order).pow(2);
        let is_kept = are_kept(settings);
        let is_fitted = is_fitted(settings) && is_kept;
        let each = bytes_each(settings.storage);
        let table = match settings.space {
            _ if is_fitted => cells * coefficients * each,
            Space::ShellHarmonics => u64::from(settings.shells) * coefficients * each,
            // A block has 64 cells, or what a root has of these; whole cubes may be eight times the cells.
            Space::MultiResolution => {
                cells * each + BLOCK_BYTES * (cells / 8 + 20 * u64::from(settings.shells))
            }
            _ => cells * each,
        };
        let fitted = if is_fitted {
            cells * coefficients * TRIPLE
        } else {
            0
        };
        // A tree while it is built: ranges of 88 bytes, in a list that grows. Those of cubes are whole.
        let merged = match (settings.space, settings.tree) {
            (Space::MultiResolution, Tree::Shells) => 160 * cells,
            (Space::MultiResolution, Tree::Grid) => {
                160 * u64::from(settings.cells.next_power_of_two()).pow(3)
            }
            _ => 0,
        };
        // The harmonics in each direction of a fit, the fit, and the products of harmonics.
        let fit = |directions: u64| 8 * coefficients * (2 * directions + coefficients);
        let mut fits = 0;
        if settings.directions == Directions::Harmonics {
            fits += fit(all);
        }
        if settings.space == Space::ShellHarmonics {
            fits += fit(triangles);
        }
        // Of each object: the borders of a shell's triangles, their corners and neighbours, and the ways to
        // them; polygons along the 30 edges of the icosahedron; and for each sample that is read a matrix for
        // each of 20 faces.
        let shell = match kind(settings) {
            Some(Tree::Shells) => {
                280 * triangles + 340 * (30 << settings.shell_level) + 20 * 72 * all.min(3 * lights)
            }
            _ => 0,
        };
        // Tables of one frame are made together: their sums, those of half of the photons more, and a copy.
        let together = match (is_kept, settings.noise) {
            (true, _) => 0,
            (false, Noise::Photons) => 2 * TRIPLE * cells * needed,
            (false, Noise::Exact) => 3 * TRIPLE * cells * needed,
        };
        // The pilot of adapted shells has eight times as many, of 320 triangles.
        let pilot = match (kind(settings), settings.radii) {
            (Some(Tree::Shells), Radii::Adapted) => 8 * u64::from(settings.shells) * 320,
            _ => 0,
        };
        let tables = if is_fitted { 1 } else { needed };
        // Integers of each thread with a task, added up into those of one; of these the values of a sample.
        let tasks = settings.photons.div_ceil(TASK);
        let threads = tasks.min(rayon::current_num_threads() as u64);
        let sums = 8 * channels * cells.max(pilot);
        let values = TRIPLE * cells.max(pilot);
        // Of tables that do not outlive a frame there is an image, which is copied, and its sums.
        let images = if is_kept { 1 } else { 4 };
        // A file is written from its bytes.
        let written = if is_kept { table } else { 0 };
        Self {
            values: texels * images * TRIPLE,
            film: 0,
            tables: objects.saturating_mul(tables).saturating_mul(table),
            scratch: (threads * sums).max(sums + values).max(values + written)
                + fitted
                + merged
                + fits
                + shell.saturating_mul(objects)
                + together.saturating_mul(objects),
            last: if objects > 0 { table } else { 0 },
            samples: objects.saturating_mul(needed),
        }
    }

    /// What there is of it at once: tables with what makes the last of them, or with the image.
    pub fn bytes(&self) -> u64 {
        let making = self.scratch.saturating_sub(self.last);
        let stages = making.saturating_add(self.values);
        self.tables.saturating_add(stages.max(self.film))
    }

    /// What it takes, and which settings would fit into `available` bytes.
    pub fn refusal(scene: &Scene, sensor: &Sensor, settings: &Settings, available: u64) -> String {
        let size = Self::new(scene, sensor, settings);
        let fits = |settings: &Settings| Self::new(scene, sensor, settings).bytes() <= available;
        let mut fitting = Vec::new();
        let mut largest = |key: &str, from: u32, least: u32, set: &dyn Fn(&mut Settings, u32)| {
            let mut smaller = settings.clone();
            let found = (least..from).rev().find(|value| {
                set(&mut smaller, *value);
                fits(&smaller)
            });
            fitting.extend(found.map(|value| format!("{key}={value}")));
        };
        match kind(settings) {
            Some(Tree::Grid) => largest("cells", settings.cells, 1, &|all, n| all.cells = n),
            Some(Tree::Shells) => {
                largest("shell-level", settings.shell_level, 0, &|all, n| {
                    all.shell_level = n;
                });
            }
            None => {}
        }
        if settings.symmetry == Symmetry::None && settings.directions != Directions::Exact {
            largest("frequency", settings.frequency, 1, &|all, n| {
                all.frequency = n;
            });
        }
        if settings.tables == Tables::All {
            let needed = Settings {
                tables: Tables::Needed,
                ..settings.clone()
            };
            fitting.extend(fits(&needed).then(|| "tables=needed".to_owned()));
        }
        let would = if fitting.is_empty() {
            "a smaller film or fewer cells would take less".to_owned()
        } else {
            format!("what would fit: {}", fitting.join(", or "))
        };
        format!(
            "sensor \"{}\": tables of {} light directions take {}, photons' sums {} while they are made, and the \
             film {}: {} resident in all, and {} are free; {would}",
            sensor.id,
            size.samples,
            megabytes(size.tables),
            megabytes(size.scratch),
            megabytes(size.film),
            megabytes(size.bytes()),
            megabytes(available),
        )
    }
}
/// Numbers of a cell: a vector has three where irradiance has one.
pub fn parts(settings: &Settings) -> u64 {
    match (settings.normal, kind(settings)) {
        (Normal::Vector, Some(_)) => 3,
        _ => 1,
    }
}
