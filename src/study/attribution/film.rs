//! The truth of an attribution from a study's film.

use super::super::layers::{add_specular, colours};
use super::super::store::StoredRun;
use super::ReducedSensor;
use super::truth::{Truth, not_modelled};
use crate::film::Image;
use crate::radiometry::Rgb;
use crate::run::{Error, LayerName, Light};

/// The truth of some light on a sensor of fewer texels, from the film of a study's truth. Dark if the film
/// does not have the light.
///
/// # Errors
///
/// None: an attribution asks for a truth that may fail.
pub fn truth_of_film(
    film: &Image,
    stored: &StoredRun,
    reduced: &ReducedSensor,
    light: Light,
) -> Result<Truth, Error> {
    let mut film = film.clone();
    add_specular(&mut film);
    let specular = colours(&film, &LayerName::Specular.to_string()).unwrap_or_default();
    let modelled = match light {
        Light::Path(signature) => colours(&film, &LayerName::Path(signature).to_string()),
        Light::Specular { .. } => Some(specular.clone()),
        Light::All => colours(&film, "E").or_else(|| colours(&film, "L")),
    };
    let sum: f64 = specular.iter().map(|value| value.mean()).sum();
    let texels = film.width * film.height;
    let modelled = modelled.unwrap_or_else(|| vec![Rgb::BLACK; texels]);
    Ok(Truth {
        not_modelled: not_modelled(&modelled, sum),
        modelled: reduced.means(&modelled),
        relative_error: stored.facts.own_error,
        is_resolved: stored.facts.complete,
    })
}
