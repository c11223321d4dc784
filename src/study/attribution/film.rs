//! The truth of an attribution from a study's film.

use super::super::layers::{add_specular, colours};
use super::super::store::StoredRun;
use super::ReducedSensor;
use super::truth::{Truth, not_modelled};
use crate::film::Image;
use crate::run::{Error, LayerName, Light, Refusal};

/// The truth of some light on a sensor of fewer texels, from the film of a study's truth.
///
/// # Errors
///
/// If the film does not have the light as a layer.
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
        Light::Path(signature) => {
            let layer = LayerName::Path(signature).to_string();
            colours(&film, &layer).ok_or(layer)
        }
        Light::Specular { .. } => Ok(specular.clone()),
        Light::All => colours(&film, "E")
            .or_else(|| colours(&film, "L"))
            .ok_or_else(String::new),
    };
    let modelled = modelled.map_err(|layer| {
        Refusal::new(format!(
            "its film has no layer {layer}; a truth that tells the paths of light apart, as beams do, has it"
        ))
    })?;
    let sum: f64 = specular.iter().map(|value| value.mean()).sum();
    Ok(Truth {
        not_modelled: not_modelled(&modelled, sum),
        modelled: reduced.means(&modelled),
        relative_error: stored.facts.own_error,
        is_resolved: stored.facts.complete,
    })
}
