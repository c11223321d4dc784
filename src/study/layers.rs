//! Layers of a film, and all light by way of mirrors and glass as one of them.

use crate::film::{Channel, Image};
use crate::radiometry::Rgb;
use crate::run::LayerName;
use crate::transport::signature::Signature;

/// A layer's colours, texel by texel; `None` if the film does not have it.
pub fn colours(image: &Image, layer: &str) -> Option<Vec<Rgb>> {
    let channel = |end: &str| image.channel(&format!("{layer}.{end}"));
    let (red, green, blue) = (channel("R")?, channel("G")?, channel("B")?);
    let colours = red.samples.iter().zip(&green.samples).zip(&blue.samples);
    Some(
        colours
            .map(|((r, g), b)| Rgb([*r, *g, *b].map(f64::from)))
            .collect(),
    )
}

/// Adds the layer `specular` to a film that lacks it: its total less its direct light (`LD`).
///
/// The total of a film without `LD` is such light alone. A film of classes of light paths has it as
/// `caustic`.
///
/// The layer has no error bars of its own.
pub fn add_specular(image: &mut Image) {
    let direct = LayerName::Path(Signature::DIRECT).to_string();
    let specular = LayerName::Specular.to_string();
    let mut layer = Vec::new();
    for component in ["R", "G", "B"] {
        let channel = |name: &str| image.channel(&format!("{name}.{component}"));
        let total = ["caustic", "E", "L"].into_iter().find_map(channel);
        let (Some(total), None) = (total, channel(&specular)) else {
            return;
        };
        let samples = match channel(&direct) {
            Some(direct) => {
                let pairs = total.samples.iter().zip(&direct.samples);
                pairs.map(|(total, direct)| total - direct).collect()
            }
            None => total.samples.clone(),
        };
        layer.push(Channel {
            name: format!("{specular}.{component}"),
            samples,
        });
    }
    image.channels.extend(layer);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::metric::{CompareImage, CompareSettings, compare};

    fn film(layers: &[(&str, [f64; 2])]) -> Image {
        let mut image = Image::new(2, 1);
        for (name, values) in layers {
            image.add_rgb(name, &values.map(|value| [value; 3]));
        }
        image
    }

    #[test]
    fn a_method_of_all_specular_light_is_judged_by_the_truths_total_less_its_direct_light() {
        let mut truth = film(&[
            ("E", [5.0, 3.0]),
            ("LD", [1.0, 2.0]),
            ("LTTD", [3.0, 1.0]),
            ("other", [1.0, 0.0]),
        ]);
        let judged = film(&[("E", [4.0, 2.0]), ("specular", [4.0, 2.0])]);
        add_specular(&mut truth);
        let comparison = compare(
            &CompareImage::new("truth", truth.clone()),
            &CompareImage::new("judged", judged.clone()),
            &CompareSettings::default(),
        )
        .unwrap();
        let mut layers = comparison.layers.iter();
        let layer = layers.find(|one| one.layer == "specular").unwrap();
        // Off by 0 and 1, of a mean of 2.5.
        let error = layer.difference.relative_rmse.unwrap();
        assert!((error - 0.5f64.sqrt() / 2.5).abs() < 1e-7, "{error}");
        // Films that have the layer stay as they are.
        let mut again = truth.clone();
        add_specular(&mut again);
        assert_eq!(again.channels.len(), truth.channels.len());
    }
}
