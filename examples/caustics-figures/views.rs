//! Level of detail: slabs by the distance of the camera.

use nephroid::internals::run::format::three_digits;
use nephroid::internals::scene::Scene;

use crate::judge::{OBJECTS, values};
use crate::support::figures::{compared, shown, table};
use crate::support::light_volume::sensor;
use nephroid::internals::metric::Figure;

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
            cells.push(found.flip.map_or("-".into(), |it| three_digits(it.mean)));
            cells.push(shown(&found.fidelity, Figure::L1));
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
