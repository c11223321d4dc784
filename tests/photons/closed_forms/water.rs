//! Light through a pane, and through one wave on water.

use std::fs;

use nephroid::internals::reference::closed_form::{
    FlatSlab, KnownPath, SineWater, SineWave, TexelGrid,
};

use super::bars::STREAMS;
use crate::support::oracles::{PANE, WAVE, one_wave};
use crate::support::scenes::layer;
use crate::support::{Compared, Photons, loaded};

/// Each ray lands (k + 1) d tan t − d tan θ further out than without the pane, with (1 − F)² F^k of its
/// flux after k = 0, 2 reflections inside; nothing else comes through.
#[test]
fn a_pane_shifts_light_and_dims_it_by_fresnels_series() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("pane.xml");
    fs::write(&file, PANE).unwrap();
    let pane = FlatSlab {
        thickness: 0.1,
        ior: 1.5,
    };
    for side in [1, 8] {
        let scene = loaded(&file, side);
        let photons = Photons::new(1 << 21);
        let estimate = photons.estimate(&scene);
        // Light on the floor has met the pane at less than 20°, where (1 − F) F < 0.04.
        for (reflections, largest_share) in [(0, 1.0), (2, 0.04)] {
            let path = KnownPath::Through(reflections);
            let truth = pane
                .sheet(2.0, 100.0, path)
                .map(&TexelGrid::square(0.5, side));
            let it = Compared::new(&scene, &photons, &estimate, &path.signature(), &truth)
                .photons_carry_at_most(largest_share);
            println!("{} {side}: {:?}", it.name, it.agreement());
            it.assert_regions(if reflections == 0 || side == 1 {
                side * side
            } else {
                0
            });
        }
        let odd = layer(&estimate, "LTRTD", 0).0;
        assert!(odd.iter().all(|value| *value == 0.0));
    }
}

/// Longest distance [m] from the smooth wave's light at which the strip's light can land.
///
/// In a cell of width h the height errs by h²/8 · A k², and light turned by u lands that times tan u off. The
/// normal's angle φ = atan(A k cos) errs by h²/8 · max |φ''|, φ'' ≤ A k³ + 2 (A k)(A k²)², plus what
/// interpolating unit vectors instead of angles adds, below (h φ')³/24; the file's `f32` normals and
/// positions add 2⁻²⁴ each (times 2 for roundings of both components). The turn θ − t changes by at most 1 −
/// cos θ/n per unit of φ, and its tangent by 1 + tan² u times that, over the height z.
fn displacement(cells: u32) -> f64 {
    let SineWave {
        depth,
        amplitude,
        wave_number,
        ior,
        half_width,
        ..
    } = WAVE;
    let h = 2.0 * half_width / f64::from(cells);
    let slope = amplitude * wave_number;
    let curvature = slope * wave_number;
    let rounding = 2.0_f64.powi(-23);
    let height_error = h * h / 8.0 * curvature + rounding;
    let bend = curvature * wave_number + 2.0 * slope * curvature * curvature;
    let angle_error = h * h / 8.0 * bend + (h * curvature).powi(3) / 24.0 + rounding;
    let steepest = slope.atan();
    let turn = steepest - (steepest.sin() / ior).asin();
    let tangent_error = angle_error * (1.0 - steepest.cos() / ior) * (1.0 + turn.tan().powi(2));
    height_error * turn.tan() + (depth + amplitude) * tangent_error
}

/// The strip's light lands within δ of the smooth wave's, so what falls into a texel is at most what the
/// smooth wave sends into the texel widened by δ on both sides, and at least what it sends into the narrowed
/// one. The rest of the flux, 1 − F, changes by less than 1e-5 with the angle errors above (|dF/dθ| < 0.01
/// below 13°).
#[test]
fn one_wave_on_water_makes_its_caustic_lines() {
    const CELLS: u32 = 2048;
    const SIDE: usize = 24;
    let scene = one_wave(CELLS, SIDE);
    let wave = SineWater::new(WAVE);
    let grid = TexelGrid::square(0.9, SIDE);
    let truth = wave.map(&grid);
    let delta = displacement(CELLS);
    let width = 1.8 / SIDE as f64;
    assert!(delta < 1e-4 * width, "{delta} blurs the caustic");
    let moved = |by: f64| {
        grid.map(|texel| {
            let mut wider = *texel;
            wider.min.x -= by;
            wider.max.x += by;
            wave.texel_irradiance(&wider) * (wider.max.x - wider.min.x) / width
        })
    };
    let (narrow, wide) = (moved(-delta), moved(delta));
    for stream in STREAMS {
        let photons = Photons::new(1 << 21).stream(stream);
        let estimate = photons.estimate(&scene);
        let mut it = Compared::new(&scene, &photons, &estimate, "LTD", &truth);
        it.low = narrow.iter().map(|low| low * (1.0 - 1e-5)).collect();
        it.high = wide.iter().map(|high| high * (1.0 + 1e-5)).collect();
        println!("{stream:?} {}: {:?}", it.name, it.agreement());
        it.assert_texels(SIDE * SIDE / 2);
    }
}
