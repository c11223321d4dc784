//! The estimate from sums on the film.
//!
//! The answer on the film, B + q/3, is an extrapolation: beside bright texels it may be a little below zero,
//! as no light is. A texel's value is the nearest one within its layer's bounds, which begin at zero. That
//! brings it nearer to the truth wherever the bounds hold. The sum of a layer's texels is then a little more
//! than the sum of its cells. The ledger has the texels' sums, and [`SignatureReport`] the cells'.
//!
//! [`SignatureReport`]: super::pass::SignatureReport

use super::layers::{BeamLayer, MadeLayer};
use super::selection::LeftOut;
use super::sums::Sums;
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::reference::Target;
use crate::run::{Estimate, Layer, LayerName, Quantity};
use crate::scene::Scene;
use crate::transport::direct::Direct;
use crate::transport::ledger::{FluxByFate, Ledger};
use crate::transport::signature::Signature;

/// The outcome of a run.
pub(super) struct RunOutcome<'a> {
    pub scene: &'a Scene,
    pub target: &'a Target,
    /// The layers that were made, the brightest first.
    pub layers: Vec<BeamLayer>,
    /// Light of signatures that were not followed.
    pub left_out: LeftOut,
    /// All light of signatures that were not followed, as photons measured it.
    pub rest: Option<Estimate>,
    /// Flux \[W\] that may be on any texel although no light was found; `None` if light was found.
    pub unseen: Option<Rgb>,
    /// Direct light, for a receiver.
    pub direct: Option<&'a Direct>,
    pub relative_error: Option<f64>,
    pub counters: TraversalCounters,
    pub incomplete: bool,
}

impl RunOutcome<'_> {
    pub fn estimate(mut self) -> Estimate {
        let texels = self.target.texels();
        let [width, height] = self.target.size();
        let unknown = self.layers.is_empty() && self.rest.is_none() && self.unseen.is_none();
        let direct = self.direct.map(direct_layer);
        let mut total = Layer::bounded(LayerName::Total, texels);
        let mut layers = Vec::new();
        let (mut ledger, mut paths) = (Ledger::default(), 0);
        let mut counts = vec![0; texels];
        let is_known = !self.layers.is_empty() || self.rest.is_some();
        let mut emitted = Rgb::BLACK;
        if !self.layers.is_empty() {
            let reports = || self.made().flat_map(|made| &made.reports);
            paths = reports().map(|one| one.cells).sum();
            layers = self.take_layers();
            for layer in &layers {
                total.add(layer);
            }
        }
        if let Some(rest) = self.rest.take() {
            total.add(&rest.total);
            self.counters += rest.counters;
            counts = rest.counts;
            emitted = rest.ledger.emitted;
            add_layers(&mut layers, rest.layers);
        }
        if is_known && self.target.quantity() == Quantity::Irradiance {
            ledger = self.ledger(&layers, emitted);
        }
        if let Some(interval) = &mut total.interval {
            // The bound is a mean of channels: one of them may have all of it.
            let channels = f64::from(self.target.channels(self.scene));
            for (texel, bound) in self.left_out.bound.iter().enumerate() {
                interval.high[texel] += Rgb::grey(channels * bound * self.scale(texel));
            }
        }
        if let Some(direct) = direct {
            total.add(&direct);
            layers.insert(0, direct);
        }
        if unknown {
            total.make_unknown();
        }
        if let (Some(unseen), Some(interval)) = (self.unseen, &mut total.interval) {
            for (texel, high) in interval.high.iter_mut().enumerate() {
                *high += unseen * self.target.gain(self.scene, texel);
            }
        }
        let incomplete = self.incomplete || total.is_unknown();
        Estimate {
            quantity: self.target.quantity(),
            width,
            height,
            total,
            layers,
            counts,
            ledger,
            paths,
            counters: self.counters,
            relative_error: self.relative_error,
            incomplete,
        }
    }

    fn made(&self) -> impl Iterator<Item = &MadeLayer> + Clone {
        self.layers.iter().filter_map(|layer| layer.made.as_ref())
    }

    /// The layers by signature, the others last. Light that all falls beside the film is no layer, unless an
    /// error is asked of it.
    ///
    /// The sums of each go as its layer comes: both together would take half as much again.
    fn take_layers(&mut self) -> Vec<Layer> {
        let is_shown = |layer: &BeamLayer| layer.asked.is_some() || !layer.is_all_beside();
        let mut order: Vec<usize> = (0..self.layers.len())
            .filter(|at| is_shown(&self.layers[*at]))
            .collect();
        order.sort_by_key(|at| (self.layers[*at].name.is_none(), self.layers[*at].name));
        let mut layers = Vec::new();
        for at in order {
            let layer = &mut self.layers[at];
            let name = layer.name.map_or(LayerName::Other, LayerName::Path);
            if let Some(made) = &mut layer.made {
                let sums = std::mem::replace(&mut made.sums, Sums::dark(0));
                layers.push(self.layer(name, &sums));
            }
        }
        layers
    }

    /// Irradiance of a unit of a texel's flux \[1/m²\]; a texel without any surface gets no light.
    fn scale(&self, texel: usize) -> f64 {
        match self.target.measure(texel) {
            0.0 => 0.0,
            measure => 1.0 / measure,
        }
    }

    /// Values and bounds of one kind of light.
    fn layer(&self, name: LayerName, sums: &Sums) -> Layer {
        let mut result = Layer::bounded(name, sums.texels());
        let interval = result.interval.get_or_insert_default();
        for texel in 0..sums.texels() {
            let scale = self.scale(texel);
            let value = sums.flux[texel] * scale;
            let bar = sums.bar[texel] * scale;
            result.values[texel] = at_least_none(value);
            interval.low[texel] = at_least_none(value - bar);
            interval.high[texel] = at_least_none(value + bar);
        }
        result
    }

    /// The ledger of the flux that met a specular surface first: the layers' texels, and the rest, which is
    /// not followed to its end. If no beams were followed, it has the flux of photons.
    fn ledger(&self, layers: &[Layer], by_photons: Rgb) -> Ledger {
        let mut ledger = Ledger::default();
        for layer in layers {
            let flux = |(texel, value): (usize, &Rgb)| *value * self.target.measure(texel);
            let received = layer.values.iter().enumerate().map(flux).sum();
            let row = FluxByFate {
                received,
                ..FluxByFate::default()
            };
            match layer.name {
                LayerName::Path(signature) => ledger.rows.insert(signature, row),
                _ => Some(std::mem::replace(&mut ledger.other, row)),
            };
        }
        // Each signature's cells sum up the same light, more or less finely. Photons may start beside
        // surfaces.
        let reports = self.made().flat_map(|made| &made.reports);
        let emitted = reports.map(|report| report.emitted).reduce(f64::max);
        ledger.emitted = emitted.map_or(by_photons, Rgb::grey);
        ledger.elsewhere = Some(ledger.emitted.mean() - ledger.sum().received.mean());
        ledger
    }
}

/// Puts layers among others: those of one signature in their order, and one of all that have none.
fn add_layers(layers: &mut Vec<Layer>, others: Vec<Layer>) {
    for layer in others {
        match layers.iter_mut().find(|it| it.name == layer.name) {
            Some(same) => same.add(&layer),
            None => layers.push(layer),
        }
    }
    layers.sort_by_key(|layer| match layer.name {
        LayerName::Path(signature) => (false, Some(signature)),
        _ => (true, None),
    });
}

/// The layer `LD`: its error is a bound.
fn direct_layer(direct: &Direct) -> Layer {
    let name = LayerName::Path(Signature::DIRECT);
    let mut layer = Layer::bounded(name, direct.texels.len());
    let interval = layer.interval.get_or_insert_default();
    for (texel, known) in direct.texels.iter().enumerate() {
        layer.values[texel] = known.irradiance;
        interval.low[texel] = at_least_none(known.irradiance - known.error);
        interval.high[texel] = known.irradiance + known.error;
    }
    layer
}

/// The light, with negative channels set to zero; unknown light stays unknown.
fn at_least_none(light: Rgb) -> Rgb {
    light.map(|channel| if channel < 0.0 { 0.0 } else { channel })
}
