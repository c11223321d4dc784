//! `docs/light-volume.png`: the pool by the defaults, beside the same with all stages exact.

use crate::support::figures::save_picture;
use crate::support::pool::{exact_but, rendered, viewed, volume};

/// Pixels of each half.
const SIZE: [usize; 2] = [480, 360];

/// Radiance [W/m²/sr] that is white.
const WHITE: f64 = 450.0;

/// Writes the picture.
pub fn picture() -> Vec<String> {
    let scene = viewed("disc", SIZE);
    let halves = [volume(&[]), exact_but(&[("accumulate", "f32")])]
        .map(|volume| rendered(&scene, "view-100", &volume).estimate.total.values);
    save_picture("light-volume.png", SIZE, WHITE, &[halves.to_vec()]);
    vec!["`docs/light-volume.png` is written.".to_owned()]
}
