//! The flux of a frame, from the light to the image, and why an image has none.

use super::shoot::Tally;
use super::variants::Step;
use crate::approximation::SensorFilm;
use crate::radiometry::Rgb;
use crate::run::FluxEntry;
use crate::setting::Words;

/// The entries, in the order of stages: together what the image has.
///
/// What photons bring to an object and take away is known. Tables do not keep flux: their cells, blends and
/// normals, and all that passes beside the sensor, are one entry.
pub fn entries(tally: &Tally, image: Rgb) -> Vec<FluxEntry> {
    let left = Rgb(tally.left);
    let all = [
        (
            Step::Light,
            "sets out towards objects",
            Rgb(tally.set_out),
            0,
        ),
        (
            Step::Light,
            "passes beside them, or belongs to others",
            Rgb(tally.missed) * -1.0,
            0,
        ),
        (
            Step::Deposit,
            "taken by interfaces",
            Rgb(tally.absorbed) * -1.0,
            0,
        ),
        (
            Step::Deposit,
            "has too many events",
            Rgb(tally.cut_off) * -1.0,
            0,
        ),
        (
            Step::Space,
            "beside the sensor, and the form of tables",
            image - left,
            0,
        ),
    ];
    all.into_iter()
        .filter(|(_, _, flux, _)| !flux.is_black())
        .map(|(step, reason, flux, photons)| FluxEntry {
            stage: step.word(),
            reason,
            flux,
            photons,
        })
        .collect()
}

/// The reason for which a frame has no light, in one sentence that begins with it.
pub fn darkness(tally: &Tally, film: &SensorFilm) -> String {
    let left = Rgb(tally.left).mean();
    if tally.photons == 0 {
        return "no photon was traced".to_owned();
    }
    if left == 0.0 {
        return format!(
            "no light leaves an object: of {:.3e} W towards it, {:.3e} W pass beside it",
            Rgb(tally.set_out).mean(),
            Rgb(tally.missed).mean()
        );
    }
    let hint = match film {
        SensorFilm::Receiver(_) => "the sensor faces away, or none of it comes there",
        SensorFilm::Camera(_) => "no pixel shows a diffuse surface that faces it",
    };
    format!("{left:.3e} W leave objects: {hint}")
}
