//! The default study of a sensor, for all that a study's file leaves open.

use crate::method::Method;
use crate::scene::{Emitter, Scene, Sensor};
use crate::setting::Given;
use crate::study::file::StudyMethod;

/// The default study of a sensor.
pub(super) struct DefaultStudy {
    pub truth: StudyMethod,
    pub methods: Vec<StudyMethod>,
}

impl DefaultStudy {
    /// The study that the scene allows: see the list at [`StudyPlan::new`](super::StudyPlan::new).
    pub fn of(scene: &Scene, sensor: &Sensor) -> Self {
        if sensor.is_camera() {
            return Self::of_camera(scene, sensor);
        }
        let suits = Method::choose(scene, sensor);
        if suits.is_ok_and(|choice| choice.method.name() == "beams") {
            return Self::of_beams(scene, sensor);
        }
        let truth = StudyMethod::swept("photons", "photons", &["16777216"]);
        if is_without_size(scene) {
            // Beams would not end soon.
            let mut methods = techniques(scene, sensor);
            methods.push(StudyMethod::swept(
                "photons",
                "photons",
                &["4096", "16384", "65536", "262144", "1048576"],
            ));
            return Self { truth, methods };
        }
        Self {
            truth: truth.with("direct-samples", LAMP_SAMPLES),
            methods: vec![StudyMethod::swept(
                "photons",
                "photons",
                &["4096", "16384", "65536", "262144", "1048576"],
            )],
        }
    }

    fn of_beams(scene: &Scene, sensor: &Sensor) -> Self {
        let mut methods = techniques(scene, sensor);
        methods.extend([
            StudyMethod::swept("beams", "error", &["10%", "3%"]),
            StudyMethod::swept(
                "photons",
                "photons",
                &["16384", "65536", "262144", "1048576", "4194304"],
            ),
        ]);
        Self {
            truth: StudyMethod::swept("beams", "error", &["0.05%"]),
            methods,
        }
    }

    /// Paths find no caustics of lights without size: one row of them shows what is missing, and more would
    /// show it again.
    fn of_camera(scene: &Scene, sensor: &Sensor) -> Self {
        let samples: &[&str] = if is_without_size(scene) {
            &["8"]
        } else {
            &["2", "8", "32"]
        };
        let paths = StudyMethod::swept("path", "spp", samples);
        if !supports("full", scene, sensor) {
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

/// True if a method with its default settings supports a sensor.
fn supports(name: &str, scene: &Scene, sensor: &Sensor) -> bool {
    let method = Method::new(name, &Given::new());
    method.is_ok_and(|method| method.supports(scene, sensor).is_ok())
}

/// The techniques that support a sensor, each with its sweep.
fn techniques(scene: &Scene, sensor: &Sensor) -> Vec<StudyMethod> {
    let all = Method::names().into_iter();
    let swept = all.filter_map(|name| {
        let (key, values) = Method::new(name, &Given::new()).ok()?.sweep()?;
        supports(name, scene, sensor).then(|| StudyMethod::swept(name, key, values))
    });
    swept.collect()
}

/// True if no light of a scene shines from a surface or from all round.
fn is_without_size(scene: &Scene) -> bool {
    let is_small = |emitter: &Emitter| emitter.is_delta() && emitter.shape().is_none();
    let has_size = |emitter: &Emitter| !is_small(emitter) && !emitter.strength().is_black();
    !scene.emitters().iter().any(has_size)
}
