//! The flux of a frame, from the light to the image.

use std::ops::AddAssign;

use super::loss::Loss;
use super::tally::Tally;
use super::variants::Step;
use crate::radiometry::Rgb;
use crate::run::FluxEntry;
use crate::setting::Words;

/// What a frame did with its flux \[W\].
#[derive(Clone, Copy, Debug, Default)]
pub struct Flow {
    /// Photons, or corners of beams, up to the map.
    pub tally: Tally,
    /// What kernels add whose weights do not sum up to 1.
    pub kernel: Rgb,
    /// What splats lose beyond the borders of maps.
    pub beyond_map: Rgb,
    /// What a choice among several maps adds.
    pub chosen: Rgb,
    /// What the maps' texels have of light beside the sensor, or on its back.
    pub beside: Rgb,
    /// What look-ups add.
    pub read: Rgb,
}

impl AddAssign for Flow {
    fn add_assign(&mut self, other: Self) {
        self.tally += other.tally;
        self.kernel += other.kernel;
        self.beyond_map += other.beyond_map;
        self.chosen += other.chosen;
        self.beside += other.beside;
        self.read += other.read;
    }
}

/// What sums of a million photons differ by if they are the same, relative to them.
const ROUNDING: f64 = 1e-12;

impl Flow {
    /// The entries of some frames' sum, by frame, in the order of stages; those without flux and photons are
    /// left out.
    pub fn entries(&self, frames: u32) -> Vec<FluxEntry> {
        let tally = &self.tally;
        let mut found = vec![
            (
                Step::View,
                "sets out",
                tally.set_out.flux,
                tally.set_out.photons,
            ),
            (Step::Fresnel, "taken by interfaces", tally.interfaces, 0),
            (Step::Fresnel, "of that not modelled", tally.unmodelled, 0),
            (Step::Flux, "change by normalisation", tally.normalised, 0),
            (Step::Splat, "weights of the kernel", self.kernel, 0),
            (Step::Splat, "choice of splats by density", self.chosen, 0),
            (Step::Lookup, "filtering, areas and shadows", self.read, 0),
        ];
        for &(reason, loss, _) in Loss::WORDS {
            let lost = tally.lost(loss);
            // Light that splats and texels spread there is no photon's.
            let spread = match loss {
                Loss::OutsideMap => self.beyond_map,
                Loss::BesideSensor => self.beside,
                Loss::EntersBehind
                | Loss::TooLarge
                | Loss::Opaque
                | Loss::NoBackFace
                | Loss::TotalReflection
                | Loss::NoSecondInterface
                | Loss::Specular
                | Loss::NoReceiver => Rgb::BLACK,
            };
            found.push((loss.step(), reason, spread - lost.flux, lost.photons));
        }
        // Differences of sums have their rounding.
        let rounding = ROUNDING * tally.set_out.flux.max_channel();
        let is_there = |flux: &Rgb| flux.0.iter().any(|watts| watts.abs() > rounding);
        found.retain(|(.., flux, photons)| is_there(flux) || *photons > 0);
        found.sort_by_key(|(step, ..)| *step as usize);
        let entry = |(step, reason, flux, photons): (Step, _, Rgb, _)| FluxEntry {
            stage: step.word(),
            reason,
            flux: flux / f64::from(frames),
            photons,
        };
        found.into_iter().map(entry).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::tally::Left;
    use super::*;

    #[test]
    fn what_is_lost_added_and_drawn_adds_up() {
        let mut flow = Flow::default();
        let sent = Rgb([2.0, 4.0, 8.0]);
        let half = Left {
            throughput: Rgb::grey(0.5),
            by_fresnel: Rgb::grey(0.25),
        };
        flow.tally.lose(Loss::NoBackFace, sent, Left::ALL);
        flow.tally.lose(Loss::NoReceiver, sent, half);
        flow.tally.land(sent, half, sent * 3.0);
        flow.beside = -Rgb::grey(0.25);
        let entries = flow.entries(2);
        let sum: Rgb = entries.iter().map(|entry| entry.flux).sum();
        // One landed with three times half of its flux, a quarter of a watt is beside; two frames.
        assert_eq!(sum, (sent * 1.5 - Rgb::grey(0.25)) / 2.0);
        let of = |reason: &str| entries.iter().find(|it| it.reason == reason).unwrap();
        assert_eq!(of("sets out").flux, sent * 3.0 / 2.0);
        assert_eq!(of("taken by interfaces").flux, -sent * 1.5 / 2.0);
        assert_eq!(of("of that not modelled").flux, sent * 0.5 / 2.0);
        assert_eq!(of("change by normalisation").flux, sent / 2.0);
        assert_eq!(of("no back face").photons, 1);
        let stages: Vec<_> = entries.iter().map(|entry| entry.stage).collect();
        let order = [
            "view",
            "refraction",
            "hit",
            "flux",
            "fresnel",
            "fresnel",
            "lookup",
        ];
        assert_eq!(stages, order);
    }
}
