//! The picture that a viewer sees: all light, with what a method made of its part.

use super::figures::PictureFigures;
use crate::film::{Channel, Image};
use crate::metric::{CompareError, CompareImage, CompareSettings, LayerComparison, compare};

/// Figures of the picture of all light if a film's layer takes the place of the truth's.
///
/// # Errors
///
/// If the picture cannot be compared.
pub(super) fn picture(
    truth: &CompareImage,
    film: &CompareImage,
    layer: &LayerComparison,
) -> Result<PictureFigures, CompareError> {
    if layer.is_total {
        return Ok(figures(layer));
    }
    let Some(image) = with_layer(&truth.image, &film.image, &layer.layer) else {
        return Ok(figures(layer));
    };
    let settings = CompareSettings {
        layers: vec!["E".to_owned(), "L".to_owned()]
            .into_iter()
            .filter(|name| image.channel(&format!("{name}.R")).is_some())
            .collect(),
        ..CompareSettings::default()
    };
    let other = CompareImage::new(film.name.clone(), image);
    let comparison = compare(truth, &other, &settings)?;
    Ok(comparison.layers.first().map_or(figures(layer), figures))
}

fn figures(layer: &LayerComparison) -> PictureFigures {
    let exposures = layer.flip.map(|flip| flip.exposures);
    PictureFigures {
        flip: layer.flip.map(|flip| flip.mean),
        exposures: exposures.map(|it| (it.start, it.stop, it.count)),
        ssim: layer.similarity.map(|it| it.ssim),
    }
}

/// All light of the truth, less its layer, and the film's layer; `None` if one of them lacks a channel.
fn with_layer(truth: &Image, film: &Image, layer: &str) -> Option<Image> {
    let mut image = Image::new(truth.width, truth.height);
    let total = ["E", "L"]
        .into_iter()
        .find(|name| truth.channel(&format!("{name}.R")).is_some())?;
    for component in ["R", "G", "B"] {
        let of = |image: &'_ Image, name: &str| -> Option<Vec<f32>> {
            Some(
                image
                    .channel(&format!("{name}.{component}"))?
                    .samples
                    .clone(),
            )
        };
        let (all, own, made) = (of(truth, total)?, of(truth, layer)?, of(film, layer)?);
        let samples = all.iter().zip(&own).zip(&made);
        image.channels.push(Channel {
            name: format!("{total}.{component}"),
            // Rounded to f32, the difference of sums may be below zero.
            samples: samples
                .map(|((all, own), made)| (all - own).max(0.0) + made)
                .collect(),
        });
    }
    Some(image)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layer_takes_the_place_of_the_truths_and_all_else_stays() {
        let film = |layers: &[(&str, f64)]| {
            let mut image = Image::new(16, 16);
            for (name, value) in layers {
                image.add_rgb(name, &[[*value; 3]; 256]);
            }
            image
        };
        let truth = film(&[("E", 3.0), ("LD", 1.0), ("LTTD", 2.0)]);
        let own = film(&[("E", 0.5), ("LTTD", 0.5)]);
        let made = with_layer(&truth, &own, "LTTD").unwrap();
        assert_eq!(made.channel("E.R").unwrap().samples, vec![1.5; 256]);
        assert!(with_layer(&truth, &own, "LRD").is_none());
        let settings = CompareSettings::default();
        let (truth, own) = (
            CompareImage::new("truth", truth),
            CompareImage::new("own", own),
        );
        let comparison = compare(&truth, &own, &settings).unwrap();
        let layer = comparison.layers.iter().find(|one| one.layer == "LTTD");
        let found = picture(&truth, &own, layer.unwrap()).unwrap();
        // Half the light: less apart than a quarter of it, which the layer alone would be.
        let alone = layer.unwrap().flip.unwrap().mean;
        assert!(found.flip.unwrap() > 0.0 && found.flip.unwrap() < alone);
    }
}
