//! Level of detail: slabs by the distance of the camera.

use nephroid::internals::run::format::three_digits;
use nephroid::internals::scene::Scene;

use crate::judge::{OBJECTS, values};
use crate::support::figures::{compared, table};
use crate::support::light_volume::sensor;

/// Pixels a row of the camera, and rows.
const PIXELS: usize = 256;

/// What fewer slabs change, at distances of 1, 2 and 4.
pub fn views() -> Vec<String> {
    let mut lines = Vec::new();
    for object in &OBJECTS {
        // A camera that is `n` times as far away sees the box on films with an n-th of the pixels.
        let mut cells = vec![object.row()];
        for (times, slabs) in [(1, "2"), (1, "1"), (2, "2"), (4, "1")] {
            let scene: Scene = object.scene(PIXELS / times);
            let [few, all] = [slabs, "3"].map(|slabs| {
                let method = object.volume(&[("slabs", slabs)]);
                values(&method, &scene, "view")
            });
            let found = compared(&scene, sensor(&scene, "view"), &all, &few);
            let flip = found.flip.map_or(f64::NAN, |it| it.mean);
            let l1 = found.fidelity.l1.map_or(f64::NAN, |it| 100.0 * it.value);
            // Sums of one set of discs in another order differ in their last bits.
            cells.extend([flip, l1].map(|it| {
                if it < 1e-5 {
                    "0".into()
                } else {
                    three_digits(it)
                }
            }));
        }
        lines.push(cells);
    }
    vec![table(
        &[
            "scene",
            ">2 slabs, near: FLIP",
            ">L1, %",
            ">1 slab, near: FLIP",
            ">L1, %",
            ">2 slabs, twice as far: FLIP",
            ">L1, %",
            ">1 slab, four times: FLIP",
            ">L1, %",
        ],
        &lines,
    )]
}
