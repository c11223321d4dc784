//! Why an image has no light.

use super::ledger::{Fate, Flow};
use crate::approximation::SensorFilm;
use crate::setting::Words;

/// The reason for which a frame has no light, in one sentence that begins with it.
pub fn reason(flow: &Flow, film: &SensorFilm, is_seen: bool) -> String {
    if !is_seen {
        return "the volume is out of the camera's view, and frustum=true leaves it out".to_owned();
    }
    let tally = &flow.tally;
    let begun = tally.photons(Fate::SetsOut);
    if begun == 0 {
        return "no photon enters the volume: all are in shadow, or out of a spot's cone"
            .to_owned();
    }
    let landed = tally.photons(Fate::Landed);
    if landed > 0 {
        let hint = match film {
            SensorFilm::Receiver(_) => "all of it beside the sensor, or on its back",
            SensorFilm::Camera(_) => "no pixel shows a diffuse surface there",
        };
        return format!(
            "{landed} photons land with {:.3e} W: {hint}",
            tally.flux(Fate::Landed).mean()
        );
    }
    let ends = Fate::WORDS
        .iter()
        .filter(|(_, fate, _)| !matches!(fate, Fate::SetsOut | Fate::Taken | Fate::Unmodelled));
    let most = ends.max_by_key(|(_, fate, _)| tally.photons(*fate));
    let (why, number) = most.map_or(("", 0), |(why, fate, _)| (*why, tally.photons(*fate)));
    format!("no photon lands: of {begun} that enter the volume, {number} came to this: {why}")
}
