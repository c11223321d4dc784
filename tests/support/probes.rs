//! Shared parts of the tests of probes: points of a bundled scene's receiver, and roots on a line.

use glam::DVec2;
use nephroid::internals::reference::probe::{ProbeSettings, Probed, SpecularPath, probe};
use nephroid::internals::scene::Scene;

use super::scenes::meter;

/// All light at (x, y) of a receiver that is [−half, half]² about the z axis.
pub fn probe_at(scene: &Scene, half: f64, at: DVec2, max_depth: u32) -> Probed {
    let settings = ProbeSettings {
        max_depth,
        ..ProbeSettings::default()
    };
    probe(scene, meter(scene), at / (2.0 * half) + 0.5, &settings).unwrap()
}

/// The paths of one signature.
pub fn of<'a>(probed: &'a Probed, signature: &str) -> Vec<&'a SpecularPath> {
    probed
        .paths
        .iter()
        .filter(|path| path.signature.to_string() == signature)
        .collect()
}

/// Their irradiance, first channel.
pub fn sum(paths: &[&SpecularPath]) -> f64 {
    paths.iter().map(|path| path.irradiance.0[0]).sum()
}

/// Places on [from, to] at which a function changes its sign between `steps` points, by bisection to the last
/// bit. `small` leaves out jumps, at which |f| is not small on both sides.
pub fn sign_changes(
    from: f64,
    to: f64,
    steps: u32,
    small: f64,
    f: impl Fn(f64) -> Option<f64>,
) -> Vec<f64> {
    let at = |i: u32| from + (to - from) * f64::from(i) / f64::from(steps);
    let mut roots = Vec::new();
    for i in 0..steps {
        let (mut a, mut b) = (at(i), at(i + 1));
        let (Some(fa), Some(fb)) = (f(a), f(b)) else {
            continue;
        };
        if (fa < 0.0) == (fb < 0.0) || fa.abs().min(fb.abs()) > small {
            continue;
        }
        loop {
            let middle = 0.5 * (a + b);
            if middle <= a.min(b) || middle >= a.max(b) {
                break;
            }
            match f(middle) {
                Some(value) if (value < 0.0) == (fa < 0.0) => a = middle,
                _ => b = middle,
            }
        }
        roots.push(0.5 * (a + b));
    }
    roots
}
