//! The flux of a frame, from the light to the image.

use super::beam::Beam;
use super::cull::Draw;
use super::variants::Step;
use super::volume::{Lit, LitVertex};
use crate::radiometry::Rgb;
use crate::run::FluxEntry;
use crate::setting::Words;

/// An amount of flux \[W\], and of how many beams.
#[derive(Clone, Copy, Debug, Default)]
struct Amount {
    flux: Rgb,
    beams: u64,
}

impl Amount {
    fn add(&mut self, flux: Rgb) {
        self.flux += flux;
        self.beams += 1;
    }
}

/// The flux of a frame, by what becomes of it.
#[derive(Clone, Copy, Debug, Default)]
pub struct Flow {
    /// Falls on the water.
    set_out: Amount,
    /// Change by stage `flux`.
    literal: Rgb,
    /// Not let through.
    reflected: Rgb,
    /// In shadow.
    shaded: Rgb,
    /// Of beams that shadow culling leaves out.
    culled: Amount,
    /// Of beams that are in no receiver's box, out of view or too faint.
    not_drawn: Amount,
    /// What is left before the sensor.
    drawn: Rgb,
    /// All that the image has.
    image: Rgb,
}

/// Flux of less than this share of all is a rounding error.
const ROUNDING: f64 = 1e-12;

impl Flow {
    /// Books the beams of one light, by its strength and the water's colour.
    pub fn add_light(
        &mut self,
        lit: &Lit,
        vertices: &[Option<LitVertex>],
        beams: &[Option<Beam>],
        is_lit: &[bool],
        draws: &[Draw],
        colour: Rgb,
    ) {
        let mut is_drawn = vec![false; beams.len()];
        for draw in draws {
            is_drawn[draw.beam as usize] = true;
        }
        for (place, beam) in beams.iter().enumerate() {
            let Some(beam) = beam else {
                continue;
            };
            let Some(flux) = lit.flux(beam, vertices) else {
                continue;
            };
            self.set_out.add(colour * flux.falling);
            self.literal += colour * (flux.begun - flux.falling);
            self.reflected += colour * (flux.transmitted - flux.begun);
            self.shaded += colour * (flux.lit - flux.transmitted);
            if !is_lit[place] {
                self.culled.add(colour * -flux.lit);
            } else if is_drawn[place] {
                self.drawn += colour * flux.lit;
            } else {
                self.not_drawn.add(colour * -flux.lit);
            }
        }
    }

    /// Books all that the image has.
    pub fn end(&mut self, image: Rgb) {
        self.image = image;
    }

    /// Beams that were begun, and the flux that falls on them.
    pub fn set_out(&self) -> (u64, Rgb) {
        (self.set_out.beams, self.set_out.flux)
    }

    /// Beams that shadow culling left out.
    pub fn culled(&self) -> u64 {
        self.culled.beams
    }

    /// Flux of the beams that are drawn.
    pub fn drawn(&self) -> Rgb {
        self.drawn
    }

    /// The entries, in the order of stages: together what the image has.
    pub fn entries(&self) -> Vec<FluxEntry> {
        let rounding = ROUNDING * self.set_out.flux.max_channel();
        let rest = self.image - self.drawn;
        let all = [
            (
                Step::Surface,
                "falls on the water",
                self.set_out.flux,
                self.set_out.beams,
            ),
            (
                Step::Flux,
                "without the cosine of incidence",
                self.literal,
                0,
            ),
            (Step::Fresnel, "reflected by the water", self.reflected, 0),
            (Step::Shadow, "in shadow", self.shaded, 0),
            (
                Step::ShadowCull,
                "culled in shadow",
                self.culled.flux,
                self.culled.beams,
            ),
            (
                Step::Clamp,
                "in no box of a receiver, or too faint",
                self.not_drawn.flux,
                self.not_drawn.beams,
            ),
            (
                Step::Lookup,
                "beside the sensor, and what later stages change",
                rest,
                0,
            ),
        ];
        let is_there = |flux: &Rgb| flux.0.iter().any(|watts| watts.abs() > rounding);
        all.into_iter()
            .filter(|(.., flux, beams)| is_there(flux) || *beams > 0)
            .map(|(step, reason, flux, photons)| FluxEntry {
                stage: step.word(),
                reason,
                flux,
                photons,
            })
            .collect()
    }
}
