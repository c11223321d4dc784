//! Light directions between samples: popping and ghosting.

use crate::judge::{floor, l1, percent, turntable};
use crate::support::figures::table;
use crate::support::local_irradiance::exact_but;

/// Poses of the sun.
const POSES: u32 = 16;

/// Azimuth and elevation [degrees] of poses: Sobol' points, evenly over the sky above 30°.
pub fn poses() -> Vec<[String; 2]> {
    let point = |index: u32| {
        // Van der Corput's points, and those of the second primitive polynomial.
        let (mut second, mut column) = (0u32, 1u32 << 31);
        for bit in 0..32 {
            if index >> bit & 1 == 1 {
                second ^= column;
            }
            column ^= column >> 1;
        }
        [index.reverse_bits(), second].map(|it| f64::from(it) / 2.0f64.powi(32))
    };
    (0..POSES)
        .map(|index| {
            let [u, v] = point(index).map(|it| it + 0.5 / f64::from(POSES));
            let elevation = (0.5 + 0.5 * v).asin().to_degrees();
            [360.0 * u, elevation].map(|it| format!("{it:.4}"))
        })
        .collect()
}

/// Errors by samples and by how they are read, all else exact.
pub fn directions() -> Vec<String> {
    let mut lines = Vec::new();
    for name in ["ball", "cube", "prism", "ring", "bumpy"] {
        let photons = if name == "bumpy" { "2048" } else { "8192" };
        let given = [("photons", photons), ("scene", "alone")];
        let variants = ["nearest", "barycentric", "aligned"];
        let frequencies = ["1", "2", "4", "8", "16"];
        // L1 of pairs of images: sums of differences and of light over all poses.
        let mut sums = vec![0.0; variants.len() * frequencies.len() + 1];
        let mut light = 0.0;
        for [azimuth, elevation] in poses() {
            let scene = turntable(
                name,
                &[
                    ("size", "24"),
                    ("azimuth", &azimuth),
                    ("elevation", &elevation),
                ],
            );
            let image =
                |own: &[(&str, &str)]| floor(&exact_but(&[&given[..], own].concat()), &scene);
            let truth = image(&[]);
            let weight = crate::judge::sum(&truth);
            light += weight;
            let last = sums.len() - 1;
            sums[last] += weight * l1(&truth, &image(&[("seed", "1")]));
            for (row, variant) in variants.iter().enumerate() {
                for (column, frequency) in frequencies.iter().enumerate() {
                    let own = image(&[
                        ("directions", variant),
                        ("frequency", frequency),
                        ("seed", "1"),
                    ]);
                    sums[row * frequencies.len() + column] += weight * l1(&truth, &own);
                }
            }
        }
        let noise = percent(sums[sums.len() - 1] / light);
        for (row, variant) in variants.iter().enumerate() {
            let mut cells = vec![format!("`{name}`"), format!("`{variant}`")];
            let own = &sums[row * frequencies.len()..(row + 1) * frequencies.len()];
            cells.extend(own.iter().map(|sum| percent(sum / light)));
            cells.push(noise.clone());
            lines.push(cells);
        }
        eprintln!("{}", table(&["scene"], &lines));
    }
    vec![table(
        &[
            "scene",
            "read",
            ">f = 1 (12)",
            ">2 (42)",
            ">4 (162)",
            ">8 (642)",
            ">16 (2562)",
            ">noise alone",
        ],
        &lines,
    )]
}
