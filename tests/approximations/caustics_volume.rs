//! Caustics volumes: with all stages exact they are the truth, and each stage does what it says.

use crate::support::approximation::bundled;
use crate::support::caustics_volume::{error, exact_but, truth};

#[test]
#[ignore = "figures"]
fn explore() {
    for (name, photons) in [
        ("glass-ball", ["16384", "65536", "262144"]),
        ("cube", ["16384", "65536", "262144"]),
        ("prism", ["16384", "65536", "262144"]),
        ("mirror-ring", ["16384", "65536", "262144"]),
        ("coffee-cup", ["16384", "65536", "262144"]),
        ("lens", ["16384", "65536", "262144"]),
        ("water", ["16384", "65536", "262144"]),
        ("diamond", ["16384", "65536", "262144"]),
    ] {
        let scene = bundled(name, 128);
        let start = std::time::Instant::now();
        let truth = truth(&scene, 1e-3);
        println!("{name}: truth {:.1} s", start.elapsed().as_secs_f64());
        for photons in photons {
            let start = std::time::Instant::now();
            let e = error(&exact_but(&[("photons", photons)]), &scene, &truth);
            println!(
                "  {photons}: {:.3} %  {:.1} s",
                100.0 * e,
                start.elapsed().as_secs_f64()
            );
        }
    }
}
