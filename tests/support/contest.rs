//! Beams and photons on the same scene: error against rays and seconds.

use std::time::{Duration, Instant};

use nephroid::internals::numeric::StreamKind;
use nephroid::internals::run::Budget;
use nephroid::internals::run::{Estimate, LayerName};
use nephroid::internals::scene::Scene;
use nephroid::internals::transport::chain::ChainSettings;
use nephroid::internals::transport::direct::{AREA_SAMPLES, direct};
use nephroid::internals::transport::receiver::Receiver;

use super::beams::{beams_to, finer_within, forecast_within};
use super::cpu;
use super::oracles::oracle_to;
use super::scenes::{Photons, below_bumps, bundled};

/// The lamp of the bumpy balls, on their axis.
pub const LAMP: [f64; 3] = [0.0, 0.0, 4.0];

/// A scene, and its caustic: the sum of all specular layers.
pub struct Contest {
    /// Its name.
    pub name: &'static str,
    /// The scene.
    pub scene: Scene,
    /// Specular events followed.
    pub depth: u32,
    /// True irradiance [W/m²] by texel, first channel.
    pub truth: Vec<f64>,
    /// The same with the direct light.
    pub truth_of_all: Vec<f64>,
    /// Likely error of a finer beam run, if that is the truth and no closed form is.
    pub finer_run: Option<f64>,
}

/// One run's cost and error.
#[derive(Clone, Copy, Debug)]
pub struct Trial {
    /// Wall clock.
    pub seconds: f64,
    /// Time of all cores \[s\]; no number where the system does not tell.
    pub cpu_seconds: f64,
    /// Rays searched for.
    pub rays: u64,
    /// √(mean squared error) / mean truth over lit texels.
    pub rmse: f64,
    /// The same of all light, the direct one included.
    pub rmse_of_all: f64,
    /// The same as the run itself said.
    pub said: Option<f64>,
}

impl Contest {
    /// A scene whose every texel has a closed form.
    pub fn known(depth: u32, name: &'static str, side: usize) -> Self {
        let oracle = oracle_to(depth, name, side);
        let mut truth = vec![0.0; side * side];
        let mut truth_of_all = truth.clone();
        for layer in &oracle.layers {
            for texel in 0..side * side {
                let light = layer.truth(texel);
                truth_of_all[texel] += light;
                if !layer.signature.is_empty() {
                    truth[texel] += light;
                }
            }
        }
        Self {
            name,
            scene: oracle.scene,
            depth,
            truth,
            truth_of_all,
            finer_run: None,
        }
    }

    /// A scene whose truth is a beam run to `error`, or of two and a half minutes.
    pub fn finer(depth: u32, name: &'static str, side: usize, error: f64) -> Self {
        let scene = match name {
            "smooth mesh" => below_bumps(64, true, LAMP, side),
            "flat mesh" => below_bumps(64, false, LAMP, side),
            _ => bundled(name, side),
        };
        Self::of_scene(depth, name, scene, error)
    }

    /// The same of any scene.
    pub fn of_scene(depth: u32, name: &'static str, scene: Scene, error: f64) -> Self {
        let budget = Budget {
            relative_error: Some(error),
            time: Some(Duration::from_secs(150)),
            ..Budget::default()
        };
        let (finer, _) = finer_within(depth, &scene, &budget);
        Self {
            name,
            scene,
            depth,
            truth: caustic(&finer),
            truth_of_all: all(&finer),
            finer_run: finer.relative_error,
        }
    }

    /// Likely time of a beam run.
    pub fn forecast(&self, error: f64) -> Duration {
        let budget = Budget {
            relative_error: Some(error),
            ..Budget::default()
        };
        forecast_within(self.depth, &self.scene, &budget).time
    }

    /// A beam run.
    pub fn beams(&self, error: f64) -> Trial {
        let start = Start::now();
        let (estimate, _) = beams_to(self.depth, &self.scene, error);
        self.trial(&estimate, &start)
    }

    /// Direct light alone, which is part of every run.
    pub fn direct(&self) {
        let receiver = Receiver::new(&self.scene, &self.scene.sensors()[0]).unwrap();
        direct(&self.scene, &receiver, 0, AREA_SAMPLES, &|| false).unwrap();
    }

    /// A photon run.
    pub fn photons(&self, stream: StreamKind, count: u64) -> Trial {
        let mut photons = Photons::new(count).stream(stream);
        photons.settings.chains = ChainSettings {
            max_depth: self.depth,
            ..ChainSettings::default()
        };
        let start = Start::now();
        let estimate = photons.estimate(&self.scene);
        self.trial(&estimate, &start)
    }

    fn trial(&self, estimate: &Estimate, start: &Start) -> Trial {
        Trial {
            seconds: start.at.elapsed().as_secs_f64(),
            cpu_seconds: cpu::seconds() - start.cpu_seconds,
            rays: estimate.counters.rays,
            rmse: rmse(&caustic(estimate), &self.truth),
            rmse_of_all: rmse(&all(estimate), &self.truth_of_all),
            said: estimate.relative_error,
        }
    }
}

/// The start of a run.
struct Start {
    at: Instant,
    cpu_seconds: f64,
}

impl Start {
    fn now() -> Self {
        Self {
            at: Instant::now(),
            cpu_seconds: cpu::seconds(),
        }
    }
}

/// √(mean squared error) / mean truth over the lit texels.
fn rmse(values: &[f64], truth: &[f64]) -> f64 {
    // 1e-6 of the brightest is the closed forms' uncertainty, no light.
    let brightest = truth.iter().copied().fold(0.0, f64::max);
    let (mut lit, mut sum, mut squares) = (0.0, 0.0, 0.0);
    for (value, truth) in values.iter().zip(truth) {
        if *truth > 1e-6 * brightest {
            lit += 1.0;
            sum += truth;
            squares += (value - truth).powi(2);
        }
    }
    (squares / lit).sqrt() / (sum / lit)
}

/// The sum of all layers, first channel.
fn all(estimate: &Estimate) -> Vec<f64> {
    estimate
        .total
        .values
        .iter()
        .map(|value| value.0[0])
        .collect()
}

/// All specular layers' sum, first channel.
pub fn caustic(estimate: &Estimate) -> Vec<f64> {
    let mut sums = vec![0.0; estimate.width * estimate.height];
    for layer in &estimate.layers {
        if !matches!(layer.name, LayerName::Path(signature) if signature.is_empty()) {
            for (sum, value) in sums.iter_mut().zip(&layer.values) {
                *sum += value.0[0];
            }
        }
    }
    sums
}
