//! Tables of one frame alone: of its scene, its light or its sensor; or the image itself, without cells.

use std::sync::Arc;

use glam::DMat3;
use rayon::prelude::*;

use super::layout::Layout;
use super::object::SpecularObject;
use super::prepare::{Goal, Lit, Shed, stream};
use super::reads::{Read, Reads, average_leaves, needed, reads_at};
use super::run::Run;
use super::scenery::{Scenery, held};
use super::settings::Settings;
use super::shoot::Tally;
use super::storage::Stored;
use super::table::read_table;
use super::variants::{Noise, Normal, Space, Step, Storage};
use super::work::Work;
use crate::approximation::SensorPoint;
use crate::approximation::clock::Clocked as _;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::run::{Error, Refusal};
use crate::setting::Words as _;
use crate::transport::first_surface::Source;

/// Photons of a sample at which `noise=exact` gives up.
const MOST_PHOTONS: u64 = 1 << 27;

impl Run<'_> {
    /// Tables, or the image itself, of this scene, light and sensor alone.
    pub(super) fn light_up(
        &mut self,
        scenery: &mut Scenery,
        lights: &[&Source],
    ) -> Result<(), Error> {
        let settings = self.settings;
        let reads = self.reads(scenery)?;
        // Of less noise, the difference of the two halves tells what is left.
        let mut photons = match settings.noise {
            Noise::Photons => settings.photons,
            Noise::Exact => settings.photons.div_ceil(2),
        };
        let mut round = 0;
        let mut sheds = self.round(scenery, lights, &reads, round, photons)?;
        loop {
            let exact = self.content(scenery, &reads, &sheds, settings.noise == Noise::Exact);
            if settings.noise == Noise::Photons {
                scenery.image = exact;
                break;
            }
            // As many photons once more.
            round += 1;
            let others = self.round(scenery, lights, &reads, round, photons)?;
            let first = self.image_or_read(scenery, exact);
            let second = self.content(scenery, &reads, &others, true);
            let second = self.image_or_read(scenery, second);
            let error = halves_error(&first, &second, photons);
            for (shed, other) in sheds.iter_mut().flatten().zip(others.into_iter().flatten()) {
                merge(shed, other);
            }
            photons *= 2;
            let is_late = photons >= MOST_PHOTONS || self.context.progress.is_stopped();
            if error <= settings.noise_error || is_late {
                if error > settings.noise_error {
                    scenery.warnings.push(format!(
                        "noise=exact ended at {photons} photons a sample with an error of {:.2} %: noise-error asks \
                         for {:.2} %",
                        100.0 * error,
                        100.0 * settings.noise_error
                    ));
                }
                scenery.image = self.content(scenery, &reads, &sheds, false);
                break;
            }
        }
        for (part, sheds) in scenery.parts.iter_mut().zip(&sheds) {
            part.count(sheds.iter().map(|shed| &shed.tally));
        }
        Ok(())
    }

    /// What the sensor reads of each part's samples, if its own normals count.
    fn reads(&mut self, scenery: &Scenery) -> Result<Vec<Vec<Arc<Reads>>>, Error> {
        let settings = self.settings;
        if settings.normal != Normal::Exact || settings.space == Space::Exact {
            return Ok(Vec::new());
        }
        self.timed(Step::Normal, |this, _| {
            let parts = scenery.parts.iter();
            parts
                .map(|part| {
                    let (object, layout) = &scenery.objects[part.object];
                    let blended = part.blended.iter();
                    blended
                        .map(|(_, map)| Ok(Arc::new(this.reads_of(object, layout, map)?)))
                        .collect()
                })
                .collect()
        })
    }

    fn reads_of(
        &self,
        object: &SpecularObject,
        layout: &Layout,
        map: &DMat3,
    ) -> Result<Reads, Error> {
        let of_batch = |points: Vec<SensorPoint>| {
            let places = points.iter().map(|point| {
                let away = held(layout, point.point.position - object.center);
                [*map * away, *map * point.normal]
            });
            reads_at(layout, self.settings, places)
        };
        let batches: Vec<Vec<Read>> = self.batches().map(of_batch).collect();
        let most = self.most_numbers();
        needed(layout, self.settings, batches.concat(), most).map_err(|count| {
            Refusal::new(format!(
                "normal=exact: {count:.2e} cells and normals are more than fit into the memory ({most:.2e}); allowed \
                 are normal=fixed and vector, other cells than space={}, fewer of them, and receivers with fewer faces",
                self.settings.space.word()
            ))
            .into()
        })
    }

    /// Photons of all parts' samples.
    fn round(
        &mut self,
        scenery: &Scenery,
        lights: &[&Source],
        reads: &[Vec<Arc<Reads>>],
        round: u64,
        photons: u64,
    ) -> Result<Vec<Vec<Shed>>, Error> {
        let (settings, context, scene) = (self.settings, self.context, self.scene);
        let stop = || context.progress.is_stopped();
        self.timed(Step::Deposit, |this, work| {
            let mut all = Vec::new();
            for (index, (part, source)) in scenery.parts.iter().zip(lights).enumerate() {
                let (object, layout) = &scenery.objects[part.object];
                let lit = Lit {
                    settings,
                    scene,
                    object,
                    light: Some((*source, part.towards)),
                    stop: &stop,
                };
                let mut sheds = Vec::new();
                for (number, (blended, _)) in part.blended.iter().enumerate() {
                    let goal = match (settings.space, reads.get(index)) {
                        (Space::Exact, _) => Goal::Sensor(layout, &this.film),
                        (_, Some(reads)) => Goal::Reads(layout, &reads[number]),
                        (_, None) => Goal::Cells(layout),
                    };
                    let random = stream(settings, blended.sample, round);
                    let mut shed = lit.shed(blended, random, 0..photons, goal)?;
                    if let (Some(reads), Space::MultiResolution) =
                        (reads.get(index), settings.space)
                    {
                        // The trees are those of surfaces that face the centre.
                        let cells = lit.shed(blended, random, 0..photons, Goal::Cells(layout))?;
                        shed.work += cells.work;
                        let (trees, _) = layout.merged(settings, &cells.values);
                        average_leaves(layout, &trees, &reads[number], &mut shed.values);
                    }
                    *work += shed.work;
                    sheds.push(shed);
                }
                all.push(sheds);
            }
            Ok(all)
        })
    }

    /// The tables of some sums, set in the scenery's parts; or, if space is exact, the image that they are.
    fn content(
        &mut self,
        scenery: &mut Scenery,
        reads: &[Vec<Arc<Reads>>],
        sheds: &[Vec<Shed>],
        is_unrounded: bool,
    ) -> Option<Vec<Rgb>> {
        let mut settings = self.settings.clone();
        if is_unrounded {
            settings.storage = Storage::Exact;
        }
        if settings.space == Space::Exact {
            return Some(self.texels(scenery, sheds, &settings));
        }
        self.timed(Step::Storage, |_, work| {
            for (index, part) in scenery.parts.iter_mut().enumerate() {
                let layout = &scenery.objects[part.object].1;
                part.tables.clear();
                for (number, shed) in sheds[index].iter().enumerate() {
                    let values = shed.values.clone();
                    let table = match reads.get(index) {
                        None => layout.table(&settings, values, shed.tally),
                        Some(reads) => {
                            read_table(layout, &settings, &reads[number], values, shed.tally)
                        }
                    };
                    work.saturated += table.saturated;
                    part.tables.push(Arc::new(table));
                }
            }
        });
        None
    }

    /// The sensor's values of sums by texel: weighted samples, rounded as tables are.
    fn texels(&self, scenery: &Scenery, sheds: &[Vec<Shed>], settings: &Settings) -> Vec<Rgb> {
        let [width, height] = self.film.size();
        let mut values = vec![Rgb::BLACK; width * height];
        // What an irradiance of 1 is on the sensor: tables have irradiance, and a camera's texels radiance.
        let seen = |_: &SensorPoint, _: &mut Work| Rgb::WHITE;
        let (units, ..) = self.film.evaluate(self.scene, settings.samples, seen);
        for (part, sheds) in scenery.parts.iter().zip(sheds) {
            let mut sums = vec![[0.0; 3]; values.len()];
            for ((blended, _), shed) in part.blended.iter().zip(sheds) {
                for (texel, value) in shed.values.iter().enumerate() {
                    let measure = self.film.measure(texel);
                    let unit = units[texel].0;
                    for c in 0..3 {
                        if measure * unit[c] > 0.0 {
                            sums[texel][c] += blended.weight * value[c] / (measure * unit[c]);
                        } else if measure > 0.0 {
                            // No sample of the pixel met the surface that these photons met.
                            values[texel].0[c] +=
                                blended.weight * value[c] / measure * part.light.irradiance.0[c];
                        }
                    }
                }
            }
            let (stored, _) = Stored::new(sums, settings.storage, settings.range);
            for (texel, value) in values.iter_mut().enumerate() {
                *value += stored.get(texel) * part.light.irradiance * units[texel];
            }
        }
        values
    }

    fn image_or_read(&self, scenery: &Scenery, image: Option<Vec<Rgb>>) -> Vec<Rgb> {
        image.unwrap_or_else(|| self.read(scenery).0)
    }
}

/// The relative standard error of the mean of two halves of some photons each: half their distance by its
/// length. Two black halves are believed if they are of many photons.
fn halves_error(first: &[Rgb], second: &[Rgb], photons: u64) -> f64 {
    const MANY: u64 = 1 << 17;
    let (mut apart, mut whole) = (0.0, 0.0);
    for (a, b) in first.iter().zip(second) {
        for c in 0..3 {
            apart += math::powi(a.0[c] - b.0[c], 2);
            whole += math::powi(a.0[c] + b.0[c], 2);
        }
    }
    if whole > 0.0 {
        (apart / whole).sqrt()
    } else if photons < MANY {
        f64::INFINITY
    } else {
        0.0
    }
}

/// The mean of sums, by the photons that they are of: a run that was stopped has fewer, or none.
fn merge(shed: &mut Shed, other: Shed) {
    let all = shed.tally.photons + other.tally.photons;
    if all == 0 {
        return;
    }
    let part = other.tally.photons as f64 / all as f64;
    for (value, other) in shed.values.iter_mut().zip(other.values) {
        for c in 0..3 {
            value[c] = value[c] * (1.0 - part) + other[c] * part;
        }
    }
    let mut tally = Tally::default();
    tally.add_scaled(&shed.tally, 1.0 - part);
    tally.add_scaled(&other.tally, part);
    shed.tally = tally;
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shed(photons: u64, value: f64) -> Shed {
        Shed {
            values: vec![[value; 3]],
            tally: Tally {
                photons,
                left: [value; 3],
                ..Tally::default()
            },
            work: Work::default(),
        }
    }

    #[test]
    fn rounds_count_by_the_photons_that_they_had_time_for() {
        for (photons, expected) in [(100, 2.0), (0, 1.0), (50, 5.0 / 3.0)] {
            let mut whole = shed(100, 1.0);
            merge(&mut whole, shed(photons, 3.0));
            assert_eq!(whole.tally.photons, 100 + photons);
            for found in [whole.values[0][0], whole.tally.left[2]] {
                assert!((found - expected).abs() < 1e-15, "{photons}: {found}");
            }
        }
        let mut none = shed(0, 0.0);
        merge(&mut none, shed(0, 0.0));
        assert_eq!(none.values, [[0.0; 3]]);
    }

    #[test]
    fn few_photons_do_not_prove_darkness() {
        let black = [Rgb::BLACK; 4];
        assert!(halves_error(&black, &black, 1024) > 1.0);
        assert_eq!(halves_error(&black, &black, 1 << 20), 0.0);
        let lit = [Rgb::WHITE; 4];
        assert!((halves_error(&lit, &black, 1024) - 1.0).abs() < 1e-15);
    }
}
