//! Layers of the light on the film, each made anew until it is fine enough.

use std::collections::BTreeMap;

use super::pass::{PassLayer, SignatureReport};
use super::schedule::{self, Known};
use super::selection::Found;
use super::sums::Sums;
use crate::reference::target::{LitTexels, Target};
use crate::transport::signature::Signature;

/// The ratio of a layer's error, as a finer one shows it, to its estimated error: an estimate may be too
/// small if the layer overlooked light, but it is not trusted less for one that turned out too large.
const CALIBRATION: std::ops::RangeInclusive<f64> = 1.0..=16.0;

/// Ratio of tolerances after which every cell has been divided once more: misplaced flux falls like the
/// fourth power of a cell's size. Only such layers can be compared.
const DIVIDED_AGAIN: f64 = 16.0;

/// Part of an error that is left after all cells were divided once more, above which more divisions do not
/// help.
const STUCK: f64 = 0.9;

/// The light of one signature, or of several, as far as it is known.
pub(super) struct BeamLayer {
    /// The signature; `None` for the layer of all those without one of their own.
    pub name: Option<Signature>,
    /// Its signatures, as the discovery found them.
    pub members: Vec<Found>,
    /// The largest relative error of all light for which it must be made.
    pub needed_for: f64,
    /// The error asked for of this layer alone, relative to its own mean.
    pub asked: Option<f64>,
    /// The result of the last pass; `None` before the first.
    pub made: Option<MadeLayer>,
}

/// A layer as a pass made it.
pub(super) struct MadeLayer {
    pub sums: Sums,
    /// One entry a signature.
    pub reports: Vec<SignatureReport>,
    /// Misplaced flux that a cell may have, relative to all flux.
    pub tolerance: f64,
    /// Rays and cells.
    pub work: f64,
    /// Factor of its likely error.
    pub calibration: f64,
    /// True if a finer tolerance would not help.
    pub is_stuck: bool,
}

/// A layer of which some signatures are made.
#[derive(Default)]
pub(super) struct Made {
    sums: Option<Sums>,
    reports: Vec<SignatureReport>,
    work: u64,
}

impl Made {
    /// Adds a signature.
    pub fn add(&mut self, one: PassLayer) {
        match &mut self.sums {
            Some(sums) => sums.add(&one.sums),
            none => *none = Some(one.sums),
        }
        self.work += one.counters.rays + one.report.cells;
        self.reports.push(one.report);
    }

    /// The layer, once it has all of its signatures.
    pub fn layer(self, tolerance: f64) -> Option<MadeLayer> {
        Some(MadeLayer {
            sums: self.sums?,
            reports: self.reports,
            tolerance,
            work: self.work as f64,
            calibration: 1.0,
            is_stuck: false,
        })
    }
}

impl BeamLayer {
    /// Layers of the first `named` signatures and of those that an error is `asked` of, and one of all
    /// others, if any. Each signature is needed for an error.
    pub fn divide(
        followed: impl Iterator<Item = (Found, f64)>,
        named: usize,
        asked: &BTreeMap<Signature, f64>,
    ) -> Vec<Self> {
        let (mut layers, mut others): (Vec<Self>, Option<Self>) = (Vec::new(), None);
        for (index, (found, needed_for)) in followed.enumerate() {
            let asked = asked.get(&found.0).copied();
            let new = |name: Option<Signature>| Self {
                name,
                members: Vec::new(),
                needed_for: 0.0,
                asked,
                made: None,
            };
            let layer = if index < named || asked.is_some() {
                layers.push(new(Some(found.0)));
                layers.last_mut()
            } else {
                Some(others.get_or_insert_with(|| new(None)))
            };
            if let Some(layer) = layer {
                layer.members.push(found);
                layer.needed_for = layer.needed_for.max(needed_for);
            }
        }
        layers.extend(others);
        layers
    }

    /// True if the discovery saw all its light fall beside the film.
    fn is_beside(&self) -> bool {
        self.members.iter().all(|(_, light)| light.is_beside())
    }

    /// True if its cells show the same: they leave neither light nor a bar on the film.
    pub fn is_all_beside(&self) -> bool {
        let is_dark = |made: &MadeLayer| {
            let mut both = made.sums.flux.iter().chain(&made.sums.bar);
            both.all(|light| light.is_black())
        };
        self.is_beside() && self.made.as_ref().is_some_and(is_dark)
    }

    /// Its result, its error and the one asked for of it; `None` if nothing more is asked.
    fn unmet(&self, target: &Target) -> Option<(&MadeLayer, f64, f64)> {
        let (asked, made) = (self.asked?, self.made.as_ref()?);
        let error = match lit(std::slice::from_ref(self), &[], target) {
            Some(lit) => made.known(lit, target).error,
            // However fine, nothing has no mean to be relative to: its error counts as a part of all light's.
            None if self.is_beside() => return None,
            None => f64::INFINITY,
        };
        (error > asked).then_some((made, error, asked))
    }

    /// True if its error is larger than asked for of it, and a finer tolerance may help. True, too, if it
    /// stays dark although the discovery saw light of it on the film.
    pub fn is_unmet(&self, target: &Target) -> bool {
        let unmet = self.unmet(target);
        unmet.is_some_and(|(made, error, _)| !made.is_stuck || error.is_infinite())
    }

    /// The tolerance that makes its error the one asked for of it; `None` if it is, if none was asked for, or
    /// if a finer one would not help.
    pub fn own_tolerance(&self, target: &Target) -> Option<f64> {
        let (made, error, asked) = self.unmet(target).filter(|(made, ..)| !made.is_stuck)?;
        schedule::finer(made.tolerance, error, asked)
    }

    /// Takes over a finer result.
    pub fn take(&mut self, mut finer: MadeLayer, target: &Target) {
        if let Some(before) = &self.made
            && before.tolerance >= DIVIDED_AGAIN * finer.tolerance
        {
            let said = squares(&before.sums, target).sqrt();
            let left = squares(&finer.sums, target).sqrt();
            let distance = distance(&before.sums, &finer.sums, target);
            if said > 0.0 {
                let found = distance / said;
                finer.calibration = found.clamp(*CALIBRATION.start(), *CALIBRATION.end());
            }
            // No less than nothing is left, too: of a layer that stays dark.
            finer.is_stuck = left >= STUCK * said;
        }
        self.made = Some(finer);
    }
}

impl MadeLayer {
    /// What the schedule asks of a layer: its error is relative to the lit texels' mean.
    pub fn known(&self, lit: LitTexels, target: &Target) -> Known {
        let error = lit.relative_error(squares(&self.sums, target));
        Known {
            tolerance: self.tolerance,
            error: self.calibration * error,
            work: self.work,
            is_stuck: self.is_stuck,
        }
    }
}

/// The texels that are lit by all layers together, or by light of no layer that reaches some of them;
/// `None` if no layer lights any.
pub(super) fn lit(layers: &[BeamLayer], others: &[bool], target: &Target) -> Option<LitTexels> {
    let (mut texels, mut sum) = (0.0, 0.0);
    for texel in 0..target.texels() {
        let made = layers.iter().filter_map(|layer| layer.made.as_ref());
        let flux: f64 = made.map(|made| made.sums.flux[texel].mean()).sum();
        let measure = target.measure(texel);
        let is_lit = flux > 0.0 || others.get(texel).is_some_and(|reached| *reached);
        if is_lit && measure > 0.0 {
            texels += 1.0;
            sum += flux / measure;
        }
    }
    let mean = sum / texels;
    (sum > 0.0).then_some(LitTexels { texels, mean })
}

/// Sum over texels of the squared likely error.
fn squares(sums: &Sums, target: &Target) -> f64 {
    over_texels(target, |texel| sums.variance[texel])
}

/// Root of the sum over texels of the squared difference.
fn distance(a: &Sums, b: &Sums, target: &Target) -> f64 {
    over_texels(target, |texel| {
        let difference = a.flux[texel].mean() - b.flux[texel].mean();
        difference * difference
    })
    .sqrt()
}

/// Sum of squared fluxes \[W²\] as squared irradiances.
fn over_texels(target: &Target, square: impl Fn(usize) -> f64) -> f64 {
    let of = |texel: usize| match target.measure(texel) {
        0.0 => 0.0,
        measure => square(texel) / (measure * measure),
    };
    (0..target.texels()).map(of).sum()
}
