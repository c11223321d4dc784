//! `docs/caustics-volume.png`: two objects in the box by the defaults, beside the same with all stages exact.

use crate::judge::{OBJECTS, values};
use crate::support::caustics_volume::exact_but;
use crate::support::figures::save_picture;

/// Pixels a row of each part, and rows.
const SIDE: usize = 320;

/// Irradiance [W/m²] that is white.
const WHITE: f64 = 20.0;

/// Writes the picture.
pub fn picture() -> Vec<String> {
    let rows = ["ring", "ball", "blocks"].map(|name| {
        let object = OBJECTS.iter().find(|it| it.name == name).unwrap();
        let scene = object.scene(SIDE);
        let exact = exact_but(&[("photons", "50000"), ("max-depth", object.depth)]);
        [object.volume(&[]), exact].map(|method| values(&method, &scene, "floor"))
    });
    // Columns are objects; above are the defaults.
    let of = |which: usize| rows.iter().map(|it| it[which].clone()).collect();
    save_picture("caustics-volume.png", [SIDE, SIDE], WHITE, &[of(0), of(1)]);
    vec!["`docs/caustics-volume.png` is written.".to_owned()]
}
