//! Renderings of meters against the truth by beams.

use std::collections::BTreeMap;

use nephroid::internals::method::Method;
use nephroid::internals::metric::Figure;
use nephroid::internals::metric::fidelity::Fidelity;
use nephroid::internals::run::{Budget, Context, Light, Rendering};
use nephroid::internals::scene::{Scene, Sensor};
use nephroid::internals::study::attribution::{Truth, truth_by_beams};

use crate::support::approximation::bundled;
use crate::support::figures::{figures, shown};
use crate::support::pool::{metered, rendered, sensor};

/// Texels a row of meters, and rows.
pub const SIDE: usize = 128;

/// Likely error of the truth.
pub const TRUTH: f64 = 0.003;

/// Meters with their truths, made once.
#[derive(Default)]
pub struct Judge {
    known: BTreeMap<String, Case>,
}

/// A meter and its truth.
pub struct Case {
    pub scene: Scene,
    pub meter: &'static str,
    pub truth: Truth,
}

impl Judge {
    /// The floor of `water`.
    pub fn water(&mut self) -> &Case {
        self.case("water", "floor", || bundled("water", SIDE))
    }

    /// A meter of the pool.
    pub fn pool(&mut self, occluder: &str, meter: &'static str) -> &Case {
        self.case(&format!("pool {occluder}"), meter, || {
            metered(occluder, SIDE)
        })
    }

    fn case(&mut self, name: &str, meter: &'static str, scene: impl FnOnce() -> Scene) -> &Case {
        self.known
            .entry(format!("{name} {meter}"))
            .or_insert_with(|| {
                let scene = scene();
                let light = Light::Path("LTD".parse().expect("a signature"));
                let budget = Budget::error(TRUTH);
                let context = Context::default();
                let truth = truth_by_beams(&scene, sensor(&scene, meter), light, &budget, &context);
                Case {
                    truth: truth.expect("a truth by beams"),
                    scene,
                    meter,
                }
            })
    }
}

impl Case {
    pub fn sensor(&self) -> &Sensor {
        sensor(&self.scene, self.meter)
    }

    /// What a light volume makes of it, and its figures.
    pub fn judged(&self, volume: &Method) -> (Rendering, Fidelity) {
        let rendering = rendered(&self.scene, self.meter, volume);
        let found = figures(
            &self.scene,
            self.sensor(),
            &self.truth.modelled,
            &rendering.estimate.total.values,
        );
        (rendering, found)
    }

    /// A figure in percent, or in texels.
    pub fn figure(&self, volume: &Method, figure: Figure) -> String {
        shown(&self.judged(volume).1, figure)
    }
}
