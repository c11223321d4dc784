//! The path signatures that bring light to surfaces that scatter.

use std::collections::BTreeMap;

use crate::geometry::TraversalCounters;
use crate::numeric::FixedPoint;
use crate::reference::photons::replicate::Recipient;
use crate::transport::chain::Arrival;
use crate::transport::flux::Flux;
use crate::transport::ledger::Fate;
use crate::transport::signature::Signature;

/// A counter of flux by signature, in quanta of `scale`, and of all photons that a map would keep.
pub struct Pilot<'a> {
    pub scatters: &'a [bool],
    pub scale: FixedPoint,
    pub received: BTreeMap<Signature, i128>,
    pub kept: u64,
}

impl Recipient<3> for Pilot<'_> {
    fn emitted(&mut self, _flux: Flux<3>) {}

    fn arrived(&mut self, arrival: &Arrival<3>, _counters: &mut TraversalCounters) -> Fate {
        if self.scatters[arrival.hit.shape as usize] && !arrival.signature.is_empty() {
            // The run itself reports flux that does not fit.
            let quanta = self.scale.quantise(arrival.flux.rgb().mean()).unwrap_or(0);
            *self.received.entry(arrival.signature).or_default() += i128::from(quanta);
            self.kept += 1;
        }
        Fate::Absorbed
    }

    fn ended(&mut self, _signature: Signature, _fate: Fate, _flux: Flux<3>) {}

    fn gained(&mut self, _flux: Flux<3>) {}

    fn finish(&mut self) {}
}
