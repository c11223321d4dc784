//! Settings of a run of paths.

use crate::numeric::StreamKind;
use crate::scene::Integrator;
use crate::transport::path_class::PathClasses;

/// Settings of how paths are followed and counted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize)]
pub struct PathSettings {
    /// Layout of sample points.
    pub stream: StreamKind,
    /// Seed of all random choices; every seed gives its own, equally good answer.
    pub seed: u64,
    /// Independent randomisations; their scatter is the error bar, with `replicates - 1` degrees of freedom.
    pub replicates: u32,
    /// The most legs of a path from light to camera, as Mitsuba's `max_depth`; `None` for any number.
    pub max_depth: Option<u32>,
    /// The leg from which on Russian roulette may end a path.
    pub rr_depth: u32,
    /// True if the camera looks through shining shapes, and sees black instead of an environment.
    pub hide_emitters: bool,
    /// The way in which light is found.
    pub light_sampling: LightSampling,
    /// The classes of paths that are counted.
    pub classes: PathClasses,
}

impl Default for PathSettings {
    /// 8 replicates of Sobol' points, seed 0, paths of any length, as Mitsuba's `path`.
    ///
    /// Points of one replicate are even, those of several are not. With fewer replicates an image has less
    /// noise, but Student's quantile for its bounds is larger (docs/accuracy.md has figures).
    fn default() -> Self {
        Self {
            stream: StreamKind::Sobol,
            seed: 0,
            replicates: 8,
            max_depth: None,
            rr_depth: Integrator::DEFAULT_RR_DEPTH,
            hide_emitters: false,
            light_sampling: LightSampling::Power,
            classes: PathClasses::ALL,
        }
    }
}

impl PathSettings {
    /// The same settings with what a scene file's integrator says of paths.
    #[must_use]
    pub fn of_integrator(self, integrator: Option<&Integrator>) -> Self {
        match integrator {
            None => self,
            Some(integrator) => Self {
                max_depth: integrator.max_depth,
                rr_depth: integrator.rr_depth,
                hide_emitters: integrator.hide_emitters,
                ..self
            },
        }
    }
}

/// The way of finding the light that shines on a surface with a scattering density.
///
/// All have the same mean, each a different variance; the last two are there to test the first two.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum LightSampling {
    /// By sampling emitters and the surface, weighted by the squares of their densities (Veach 1997, 9.2.3).
    Power,
    /// By both, weighted by their densities (Veach 1997, 9.2.2).
    Balance,
    /// By sampling emitters.
    Emitters,
    /// By sampling the surface. Emitters that are a point or a direction are never found so.
    Surfaces,
}

impl LightSampling {
    /// True if emitters are sampled.
    #[inline]
    pub fn samples_emitters(self) -> bool {
        self != Self::Surfaces
    }

    /// The weight of light found by sampling an emitter, given the densities of both ways.
    #[inline]
    pub(super) fn weight_of_emitter(self, of_emitter: f64, of_surface: f64) -> f64 {
        match self {
            Self::Power => share(of_emitter * of_emitter, of_surface * of_surface),
            Self::Balance => share(of_emitter, of_surface),
            Self::Emitters => 1.0,
            Self::Surfaces => 0.0,
        }
    }

    /// The weight of light found by sampling the surface. It is 1 if emitter sampling never finds that light.
    #[inline]
    pub(super) fn weight_of_surface(self, of_surface: f64, of_emitter: f64) -> f64 {
        if of_emitter == 0.0 {
            return 1.0;
        }
        match self {
            Self::Power => share(of_surface * of_surface, of_emitter * of_emitter),
            Self::Balance => share(of_surface, of_emitter),
            Self::Emitters => 0.0,
            Self::Surfaces => 1.0,
        }
    }
}

/// a / (a + b), in a form that neither zeros nor infinities make NaN.
#[inline]
fn share(a: f64, b: f64) -> f64 {
    if a > 0.0 { 1.0 / (1.0 + b / a) } else { 0.0 }
}

/// Samples a pixel of a run without any limit.
pub const DEFAULT_SAMPLES: u64 = 256;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_weights_of_both_ways_sum_to_one() {
        let ways = [
            LightSampling::Power,
            LightSampling::Balance,
            LightSampling::Emitters,
            LightSampling::Surfaces,
        ];
        for way in ways {
            for (emitter, surface) in [(1.0, 1.0), (1e-200, 3.0), (2.0, 1e180), (0.3, 1e-300)] {
                let sum = way.weight_of_emitter(emitter, surface)
                    + way.weight_of_surface(surface, emitter);
                // Two quotients.
                assert!((sum - 1.0).abs() < 4.0 * f64::EPSILON, "{way:?}: {sum}");
            }
            // What cannot be found otherwise.
            assert_eq!(way.weight_of_surface(0.5, 0.0), 1.0);
        }
        let close = |found: f64, weight: f64| (found - weight).abs() < 4.0 * f64::EPSILON;
        assert!(close(LightSampling::Power.weight_of_emitter(3.0, 1.0), 0.9));
        assert!(close(
            LightSampling::Balance.weight_of_emitter(3.0, 1.0),
            0.75
        ));
    }
}
