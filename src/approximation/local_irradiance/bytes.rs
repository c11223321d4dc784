//! Settings by the bytes that tables may take: those that err least, by pilots.
//!
//! Light directions, cells and numbers share the bytes. Pilots fill the sensor with one of the three as it
//! might be chosen and the other two as fine as pilots go. The error of each is the L1 of its image against
//! one with all three so fine, and with more photons. Errors of two are as good as independent, so that a
//! choice of three is likely to have
//!
//! ```text
//! e² = e²(directions) + e²(cells) + e²(numbers)
//! ```
//!
//! How many shells there are is not chosen: what they err is left out.
//!
//! Pilots have the light of the scene alone. It may be on a sample by chance: so directions count no less
//! than finer ones do.

use super::demands;
use super::layout::kind;
use super::run::Run;
use super::scenery::Kept;
use super::settings::Settings;
use super::size::Size;
use super::variants::{Directions, Space, Storage, Symmetry, Tables, Tree};
use crate::approximation::{TableChoice, TableChoices};
use crate::radiometry::Rgb;
use crate::run::format::megabytes;
use crate::run::{Context, Error, Refusal};
use crate::scene::{Scene, Sensor};
use crate::setting::{Given, Words as _};

/// Parts of an icosahedron's edge that may be chosen.
const FREQUENCIES: [u32; 5] = [1, 2, 4, 8, 16];
/// Cubes along a side that may be chosen; the reference has twice the most.
const CELLS: [u32; 4] = [8, 16, 32, 64];
/// Levels of shells that may be chosen; the reference has one more.
const LEVELS: [u32; 4] = [1, 2, 3, 4];
/// Numbers that may be chosen.
const STORAGES: [Storage; 4] = [Storage::U8, Storage::Rgb9e5, Storage::F16, Storage::F32];
/// Photons of the reference by those of a pilot.
const MORE_PHOTONS: u64 = 8;

/// The part of an error that is left at most where more bytes are worth while: pilots know it no better.
const GAIN: f64 = 0.99;

/// A value of a setting with the error that it makes.
#[derive(Clone, Copy, Debug)]
struct Measured<T> {
    value: T,
    error: f64,
}

/// Settings that may be chosen.
#[derive(Clone, Debug)]
struct Choice {
    settings: Settings,
    bytes: u64,
    likely: f64,
    measured: Option<f64>,
}

impl Choice {
    /// It by the keys of its settings.
    fn told(self) -> TableChoice {
        let mut settings = self.settings;
        let mut told = Vec::new();
        if settings.symmetry == Symmetry::None {
            told.push(("frequency", settings.frequency.to_string()));
        }
        told.push((key(&settings), resolution(&mut settings).to_string()));
        told.push(("storage", settings.storage.word().to_owned()));
        TableChoice {
            settings: told,
            bytes: self.bytes,
            likely: self.likely,
            measured: self.measured,
        }
    }
}

/// Pilots of a scene.
struct Pilots<'a> {
    scene: &'a Scene,
    sensor: &'a Sensor,
    context: Context,
    settings: Settings,
    given: &'a Given,
}

/// The settings whose tables take up to `bytes` and are likely to err least. Settings that were `given` stay.
///
/// # Errors
///
/// If no choice takes so few bytes, if tables of these settings do not outlive a frame, or as a run.
pub fn choices(
    scene: &Scene,
    sensor: &Sensor,
    (settings, given): (&Settings, &Given),
    bytes: u64,
    context: &Context,
) -> Result<TableChoices, Error> {
    let mut settings = settings.clone();
    settings.tables = Tables::Needed;
    if !given.contains_key("storage") {
        // It is chosen among those that go with the others: this one does.
        settings.storage = Storage::F32;
    }
    demands::check_kept(&settings)?;
    if settings.directions == Directions::Harmonics {
        return Err(Refusal::new(
            "directions=harmonics and a choice by bytes: a pilot would take as many photons as all tables; allowed are \
             directions=aligned, barycentric and nearest",
        )
        .into());
    }
    if settings.space == Space::MultiResolution {
        return Err(Refusal::new(
            "space=multi-resolution and a choice by bytes: what a tree takes is known only from its light; allowed are \
             space=grid, shells and shell-harmonics",
        )
        .into());
    }
    let pilots = Pilots {
        scene,
        sensor,
        // What pilots make is of no use to anyone else.
        context: Context {
            cache: None,
            ..context.clone()
        },
        settings,
        given,
    };
    let (all, truth) = pilots.all()?;
    let mut front = front(all);
    let Some(chosen) = front.iter().rposition(|one| one.bytes <= bytes) else {
        let least = front.first().map_or(0, |one| one.bytes);
        return Err(Refusal::new(format!(
            "there are no tables of {bytes} bytes: the smallest that can be chosen take {least}"
        ))
        .into());
    };
    // What was likely is measured where it decides.
    let beside = chosen.saturating_sub(1)..(chosen + 2).min(front.len());
    for one in &mut front[beside] {
        one.measured = Some(l1(&pilots.image(&one.settings)?, &truth));
    }
    Ok(TableChoices {
        front: front.into_iter().map(Choice::told).collect(),
        chosen,
    })
}

impl Pilots<'_> {
    /// The settings of the reference: more photons, and finer cells unless these were typed.
    fn reference(&self) -> Settings {
        let mut settings = self.fine();
        settings.photons *= MORE_PHOTONS;
        if self.given.contains_key(key(&settings)) {
            return settings;
        }
        let is_shells = kind(&settings) == Some(Tree::Shells);
        let fineness = resolution(&mut settings);
        *fineness = if is_shells {
            *fineness + 1
        } else {
            2 * *fineness
        };
        settings
    }

    /// The settings of pilots that are about none of the three.
    fn fine(&self) -> Settings {
        let mut settings = Settings {
            directions: Directions::Exact,
            storage: Storage::Exact,
            ..self.settings.clone()
        };
        let finest = self.finenesses().into_iter().fold(0, u32::max);
        *resolution(&mut settings) = finest;
        settings
    }

    /// The finenesses of cells that may be chosen.
    fn finenesses(&self) -> Vec<u32> {
        let mut own = self.settings.clone();
        let all = match kind(&own) {
            Some(Tree::Shells) => LEVELS,
            Some(Tree::Grid) | None => CELLS,
        };
        let mut open = self.open(key(&own), *resolution(&mut own), &all);
        open.retain(|value| {
            *resolution(&mut own) = *value;
            demands::check(&own).is_ok()
        });
        open
    }

    /// The values of a setting that may be chosen: the one that was given, or all of a list.
    fn open<T: Copy>(&self, key: &str, own: T, all: &[T]) -> Vec<T> {
        if self.given.contains_key(key) {
            vec![own]
        } else {
            all.to_vec()
        }
    }

    /// The sensor's values by some settings.
    fn image(&self, settings: &Settings) -> Result<Vec<Rgb>, Error> {
        demands::check(settings)?;
        let bytes = Size::new(self.scene, self.sensor, settings).bytes();
        if let Some(free) = self.context.available_bytes().filter(|free| bytes > *free) {
            return Err(Refusal::new(format!(
                "a pilot takes {}, and {} are free: fewer cells (cells, shell-level) or a smaller film take less",
                megabytes(bytes),
                megabytes(free)
            ))
            .into());
        }
        let mut kept = Kept::default();
        let mut run = Run::new(settings, &self.context, self.scene, self.sensor)?;
        run.make(&mut kept, self.sensor)?;
        if self.context.progress.is_stopped() {
            return Err(
                Refusal::new("stopped before all pilots were done: nothing is chosen").into(),
            );
        }
        Ok(run.frame(&kept).values)
    }

    /// The errors of some values. The image of the `finest` pilot is there.
    fn measured<T: Copy>(
        &self,
        values: &[T],
        truth: &[Rgb],
        (fine, finest): (&Settings, &[Rgb]),
        with: impl Fn(T) -> Settings,
    ) -> Result<Vec<Measured<T>>, Error> {
        let measure = |value: &T| {
            let settings = with(*value);
            let error = if settings == *fine {
                l1(finest, truth)
            } else {
                l1(&self.image(&settings)?, truth)
            };
            Ok(Measured {
                value: *value,
                error,
            })
        };
        values.iter().map(measure).collect()
    }

    /// All choices that settings allow, with their bytes and likely errors; and the reference's image.
    fn all(&self) -> Result<(Vec<Choice>, Vec<Rgb>), Error> {
        let own = &self.settings;
        let fine = self.fine();
        let truth = self.image(&self.reference())?;
        if truth.iter().all(|value| value.is_black()) {
            return Err(Refusal::new(
                "a choice by bytes: no light of the objects falls on the sensor, so that no table errs; allowed are \
                 sensors and lights of which a render has light",
            )
            .into());
        }
        let finest = self.image(&fine)?;
        let pilot = (&fine, finest.as_slice());
        // Without turns, every direction has tables of its own.
        let has_directions = own.symmetry == Symmetry::None;
        let frequencies = if has_directions {
            self.open("frequency", own.frequency, &FREQUENCIES)
        } else {
            vec![own.frequency]
        };
        let mut directions = self.measured(&frequencies, &truth, pilot, |frequency| Settings {
            frequency,
            directions: own.directions,
            ..fine.clone()
        })?;
        for index in (1..directions.len()).rev() {
            let finer = directions[index].error;
            directions[index - 1].error = directions[index - 1].error.max(finer);
        }
        let finenesses = self.finenesses();
        let cells = self.measured(&finenesses, &truth, pilot, |value| {
            let mut settings = fine.clone();
            *resolution(&mut settings) = value;
            settings
        })?;
        // Numbers are rounded whatever else there is: what they add to the finest pilot is theirs.
        let storages = self.open("storage", own.storage, &STORAGES);
        let fitting = |storage: &Storage| {
            let settings = Settings {
                storage: *storage,
                ..own.clone()
            };
            demands::check(&settings).is_ok()
        };
        let storages: Vec<Storage> = storages.into_iter().filter(fitting).collect();
        let storages = self.measured(&storages, &finest, pilot, |storage| Settings {
            storage,
            ..fine.clone()
        })?;
        let mut all = Vec::new();
        for frequency in &directions {
            for cells in &cells {
                for storage in &storages {
                    let mut settings = Settings {
                        frequency: frequency.value,
                        storage: storage.value,
                        ..own.clone()
                    };
                    *resolution(&mut settings) = cells.value;
                    let squares = [frequency.error, cells.error, storage.error].map(|e| e * e);
                    let whole = Settings {
                        tables: Tables::All,
                        ..settings.clone()
                    };
                    all.push(Choice {
                        settings,
                        bytes: Size::new(self.scene, self.sensor, &whole).tables,
                        likely: squares.iter().sum::<f64>().sqrt(),
                        measured: None,
                    });
                }
            }
        }
        Ok((all, truth))
    }
}

/// The setting that says how fine cells are.
fn key(settings: &Settings) -> &'static str {
    match kind(settings) {
        Some(Tree::Shells) => "shell-level",
        Some(Tree::Grid) | None => "cells",
    }
}

/// Its value.
fn resolution(settings: &mut Settings) -> &mut u32 {
    match kind(settings) {
        Some(Tree::Shells) => &mut settings.shell_level,
        Some(Tree::Grid) | None => &mut settings.cells,
    }
}

/// The choices than which none errs noticeably less for as many bytes, by their bytes.
fn front(mut all: Vec<Choice>) -> Vec<Choice> {
    all.sort_by(|a, b| a.bytes.cmp(&b.bytes).then(a.likely.total_cmp(&b.likely)));
    let mut front: Vec<Choice> = Vec::new();
    for one in all {
        if front
            .last()
            .is_none_or(|last| one.likely < GAIN * last.likely)
        {
            front.push(one);
        }
    }
    front
}

/// The L1 distance of an image from another, by that one's light.
fn l1(image: &[Rgb], truth: &[Rgb]) -> f64 {
    let (mut apart, mut whole) = (0.0, 0.0);
    for (a, b) in image.iter().zip(truth) {
        apart += a.0.iter().zip(b.0).map(|(a, b)| (a - b).abs()).sum::<f64>();
        whole += b.0.iter().map(|b| b.abs()).sum::<f64>();
    }
    if whole > 0.0 { apart / whole } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setting::Values;

    #[test]
    fn a_front_has_no_choice_that_another_beats() {
        let table = super::super::settings::TABLE.iter().collect();
        let values = Values::new("tables", table, &Given::new()).unwrap();
        let settings = Settings::of(&values).unwrap();
        let choice = |(bytes, likely): (u64, f64)| Choice {
            settings: settings.clone(),
            bytes,
            likely,
            measured: None,
        };
        let all = [
            (30, 0.1),
            (10, 0.5),
            (20, 0.6),
            (20, 0.4),
            (30, 0.2),
            (40, 0.0995),
        ];
        let found = front(all.map(choice).to_vec()).into_iter();
        let found: Vec<(u64, f64)> = found.map(|one| (one.bytes, one.likely)).collect();
        assert_eq!(found, [(10, 0.5), (20, 0.4), (30, 0.1)]);
    }

    #[test]
    fn a_distance_is_by_the_light_of_the_truth() {
        let truth = [Rgb::grey(2.0), Rgb::grey(0.0)];
        let image = [Rgb::grey(1.0), Rgb::grey(0.5)];
        assert_eq!(l1(&image, &truth), 0.75);
        assert_eq!(l1(&[Rgb::BLACK; 2], &truth), 1.0);
    }
}
