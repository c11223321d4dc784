//! Light that a ball focuses on its axis, and that fades at its rim, in layers of few cells: bounds hold on a large
//! film.

use nephroid::internals::reference::closed_form::{GlassBall, KnownPath, TexelRect};
use nephroid::internals::run::LayerName;
use rayon::prelude::*;

use crate::support::beams::beams_to;
use crate::support::bundled;

const SIDE: usize = 512;

/// Texels through the middle of the film, where rings of light meet; from corner to corner, where cells are large;
/// and those about the rim of `LTTD`, which is 142 texels from the middle.
fn looked_at() -> Vec<[usize; 2]> {
    let middle = SIDE / 2;
    let lines = (0..SIDE).flat_map(|at| [[at, middle], [at, middle - 1], [at, (at + 3) % SIDE]]);
    let from_middle = |at: usize| (at as f64 + 0.5 - middle as f64).powi(2);
    let is_at_rim = |at: &[usize; 2]| {
        let radius = (from_middle(at[0]) + from_middle(at[1])).sqrt();
        (136.0..148.0).contains(&radius)
    };
    let all = (0..SIDE * SIDE).map(|index| [index % SIDE, index / SIDE]);
    lines.chain(all.filter(is_at_rim)).collect()
}

#[test]
fn bounds_hold_where_faint_light_is_focused_on_an_axis() {
    let scene = bundled("glass-ball", SIDE);
    let size = 4.0 / SIDE as f64;
    for (error, least) in [(3e-2, 1), (1e-2, 2), (1e-3, 4)] {
        let (estimate, _) = beams_to(16, &scene, error);
        let mut layers = 0;
        for reflections in 0..8 {
            let name = format!("LT{}TD", "R".repeat(reflections));
            let wanted = LayerName::Path(name.parse().unwrap());
            let Some(layer) = estimate.layers.iter().find(|one| one.name == wanted) else {
                continue;
            };
            layers += 1;
            let sheet = GlassBall::SHIPPED.sheet(KnownPath::Through(reflections as u32));
            let bounds = layer.interval.as_ref().unwrap();
            let mean = layer.values.iter().map(|one| one.0[0]).sum::<f64>() / (SIDE * SIDE) as f64;
            let out: Vec<_> = looked_at()
                .into_par_iter()
                .filter_map(|[column, row]| {
                    let [x, y] = [column, row].map(|at| at as f64 * size - 2.0);
                    let truth = sheet.texel_irradiance(&TexelRect::new(x, y, x + size, y + size));
                    let index = row * SIDE + column;
                    let (low, high) = (bounds.low[index].0[0], bounds.high[index].0[0]);
                    // The quadrature of the closed form is good to 1e-9.
                    let rounding = 1e-9 * (truth + mean);
                    (truth < low - rounding || truth > high + rounding).then_some((
                        [column, row],
                        truth / mean,
                        low / mean,
                        high / mean,
                    ))
                })
                .collect();
            assert!(out.is_empty(), "{error}, {name}: {out:?}");
        }
        assert!(layers >= least, "{error}: {layers} layers");
    }
}
