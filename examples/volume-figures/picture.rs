//! `docs/light-volume.png`: the pool by the defaults, beside the same with all stages exact.

use std::path::Path;

use image::{Rgb, RgbImage};

use crate::support::pool::{exact_but, rendered, viewed, volume};

/// Pixels of each half.
const SIZE: [usize; 2] = [480, 360];

/// Radiance [W/m²/sr] that is white.
const WHITE: f64 = 450.0;

/// Pixels between the halves.
const GAP: usize = 6;

/// Writes the picture.
pub fn picture() -> Vec<String> {
    let scene = viewed("disc", SIZE);
    let [width, height] = SIZE;
    let mut picture = RgbImage::from_pixel(
        (2 * width + GAP) as u32,
        height as u32,
        Rgb([255, 255, 255]),
    );
    for (half, volume) in [volume(&[]), exact_but(&[("accumulate", "f32")])]
        .iter()
        .enumerate()
    {
        let values = rendered(&scene, "view-100", volume).estimate.total.values;
        for (texel, value) in values.iter().enumerate() {
            let (x, y) = (texel % width + half * (width + GAP), texel / width);
            // The curve of sRGB, near enough for a picture.
            let byte =
                |it: f64| (255.0 * (it / WHITE).clamp(0.0, 1.0).powf(1.0 / 2.2)).round() as u8;
            picture.put_pixel(x as u32, y as u32, Rgb(value.0.map(byte)));
        }
    }
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/light-volume.png");
    picture.save(&file).expect("a file that can be written");
    vec!["`docs/light-volume.png` is written.".to_owned()]
}
