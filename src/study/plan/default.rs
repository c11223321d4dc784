//! The default study of a sensor, for all that a study's file leaves open.

use super::sensors::is_camera;
use crate::approximation::{Approximation, CausticMap};
use crate::reference::path::PathSettings;
use crate::reference::{beams, full};
use crate::scene::{Scene, Sensor};
use crate::study::file::StudyMethod;

/// The default study of a sensor.
pub(super) struct DefaultStudy {
    pub truth: StudyMethod,
    pub methods: Vec<StudyMethod>,
}

impl DefaultStudy {
    /// The study that the scene allows: see the list at [`StudyPlan::new`](super::StudyPlan::new).
    pub fn of(scene: &Scene, sensor: &Sensor) -> Self {
        if is_camera(sensor) {
            return Self::of_camera(scene, sensor);
        }
        if beams::is_deterministic(scene) && beams::supports(scene).is_ok() {
            return Self::of_beams(scene, sensor);
        }
        Self {
            truth: StudyMethod::swept("photons", "photons", &["16777216"])
                .with("direct-samples", LAMP_SAMPLES),
            methods: vec![StudyMethod::swept(
                "photons",
                "photons",
                &["4096", "16384", "65536", "262144", "1048576"],
            )],
        }
    }

    fn of_beams(scene: &Scene, sensor: &Sensor) -> Self {
        let mut methods = vec![
            StudyMethod::swept("beams", "error", &["10%", "3%", "1%"]),
            StudyMethod::swept(
                "photons",
                "photons",
                &["16384", "65536", "262144", "1048576", "4194304"],
            ),
        ];
        if can_be_mapped(scene, sensor) {
            let counts = ["128", "256", "512", "1024"];
            methods.insert(0, StudyMethod::swept("caustic-map", "photons", &counts));
        }
        Self {
            truth: StudyMethod::swept("beams", "error", &["0.05%"]),
            methods,
        }
    }

    /// Paths find no caustics of lights without size: one row of them shows what is missing, and more would
    /// show it again.
    fn of_camera(scene: &Scene, sensor: &Sensor) -> Self {
        let samples: &[&str] = if beams::is_deterministic(scene) {
            &["8"]
        } else {
            &["2", "8", "32"]
        };
        let paths = StudyMethod::swept("path", "spp", samples);
        if full::Plan::new(scene, sensor, &PathSettings::default()).is_err() {
            return Self {
                truth: StudyMethod::swept("path", "spp", &["1024"]),
                methods: vec![paths],
            };
        }
        let mut full = StudyMethod::swept("full", "spp", &["2", "8", "32"]);
        // In proportion: four times the work each.
        for (settings, photons) in full.settings.iter_mut().zip(["8192", "32768", "131072"]) {
            settings.insert("photons".to_owned(), photons.to_owned());
        }
        Self {
            truth: StudyMethod::swept("full", "spp", &["256"]).with("photons", "1048576"),
            methods: vec![paths, full],
        }
    }
}

/// Samples of a texel and an area light for the truth's direct light, 64 times those of the runs that it
/// judges. For an indicator function in d dimensions the error of scrambled nets goes as
/// N^(−1/2 − 1/(4d − 2)), here N^(−4/7). The source is He and Wang 2015, "On the convergence rate of
/// randomized quasi–Monte Carlo for discontinuous functions". So 64 times the samples have 10.8 times less
/// error, and a tenth resolves a row.
const LAMP_SAMPLES: &str = "8192";

/// True if caustic maps can be made of a scene: a very small one is made.
fn can_be_mapped(scene: &Scene, sensor: &Sensor) -> bool {
    let mut small = CausticMap::default();
    small.settings.photons = 4;
    small.settings.map = 4;
    small.settings.samples = 1;
    small.run(scene, sensor).is_ok()
}
