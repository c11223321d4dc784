//! Light from more than one direction, or through an image: randomised quasi-Monte Carlo over a texel and the
//! light together.

use glam::DVec2;

use super::glance::Glance;
use super::light::DirectLight;
use super::look::ShareRange;
use super::texel::DirectTexel;
use crate::geometry::SurfacePoint;
use crate::numeric::Stream;
use crate::numeric::math;
use crate::radiometry::Rgb;

/// Replicates of the quadrature over a light; their scatter is the error.
pub(super) const REPLICATES: u32 = 16;

/// Samples of a texel and a light, in each replicate, if no more are asked for.
pub(super) const SAMPLES: u32 = 8;

/// Samples between two looks at `stop`: some milliseconds of work.
const ASK_EVERY: u32 = 4096;

/// Average irradiance of a light over a texel, in `N` channels.
pub(super) struct Sampled<const N: usize> {
    /// The mean of all samples.
    pub(super) mean: [f64; N],
    /// Its standard error.
    pub(super) error: [f64; N],
    /// The mean without shadow.
    pub(super) unshadowed: [f64; N],
    /// The shares of light that samples see.
    pub(super) passed: ShareRange,
}

/// Part of a light's samples that may all be wrong although they agree, times their number, by the standard
/// error that its bar is a multiple of. If a part p of the light is hidden, n samples see all of it with the
/// probability (1 − p)ⁿ. That is 1/2000 for p = ln 2000 / n, and bars are 3.29 standard errors.
const UNSEEN: f64 = UNSEEN_PART / 3.29;

/// The same part of the light itself, times the number of samples.
const UNSEEN_PART: f64 = 7.6;

/// The part of a light that all samples may have missed, with `each` in each replicate.
pub(super) fn unseen_part(each: u32) -> f64 {
    UNSEEN_PART / f64::from(REPLICATES * each)
}

/// True if no light is missing but for the rounding of sums of up to 2²⁴ samples.
fn sees_all(seen: f64, unshadowed: f64) -> bool {
    seen >= unshadowed * (1.0 - 1e-9)
}

impl<const N: usize> Sampled<N> {
    /// The same for a light that is not known to be free: if all samples see it, or none does, all that they
    /// may have missed counts as error.
    pub(super) fn with_unseen(mut self, each: u32) -> Self {
        for c in 0..N {
            let (mean, all) = (self.mean[c], self.unshadowed[c]);
            if mean == 0.0 || sees_all(mean, all) {
                let unseen = all * UNSEEN / f64::from(REPLICATES * each);
                self.error[c] = math::hypot(self.error[c], unseen);
            }
        }
        self
    }
}

impl Sampled<3> {
    /// The same if light of an irradiance up to `most` may have been missed.
    pub(super) fn with_missed(mut self, most: Rgb) -> Self {
        for (error, most) in self.error.iter_mut().zip(most.0) {
            *error = math::hypot(*error, most * (UNSEEN / UNSEEN_PART));
        }
        self
    }
}

impl From<Sampled<3>> for Glance {
    fn from(found: Sampled<3>) -> Self {
        Self {
            value: DirectTexel {
                irradiance: Rgb(found.mean),
                error: Rgb(found.error),
            },
            passed: found.passed,
        }
    }
}

impl DirectLight<'_> {
    /// The mean of `sample` over a texel and a light, with `each` samples in each replicate.
    ///
    /// `sample` gives irradiance without shadow at a point, for a place on the light in [0, 1)². It also
    /// gives the share (0..=1) that passes.
    pub(super) fn sampled<const N: usize>(
        &mut self,
        texel: usize,
        stream: &Stream,
        each: u32,
        sample: impl Fn(&mut Self, &SurfacePoint, DVec2) -> ([f64; N], f64),
    ) -> Sampled<N> {
        let mut found = Sampled {
            mean: [0.0; N],
            error: [0.0; N],
            unshadowed: [0.0; N],
            passed: ShareRange::NOTHING_SEEN,
        };
        if !self.receiver.has_surface(texel) {
            return found;
        }
        let texel_area = self.receiver.texel_area(texel);
        let mut sum = [0.0; N];
        let mut sum_squares = [0.0; N];
        let mut unshadowed = [0.0; N];
        let mut is_found = false;
        'replicates: for replicate in 0..REPLICATES {
            let stream = stream.split(u64::from(replicate));
            let mut mean = [0.0; N];
            for number in 0..each {
                if number % ASK_EVERY == ASK_EVERY - 1 && (self.stop)() {
                    break 'replicates;
                }
                let [u, v, s, t] = stream.point4(u64::from(number));
                let Some(patch) = self.patch(texel, DVec2::new(u, v)) else {
                    continue;
                };
                is_found = true;
                let (arriving, passed) = sample(self, &patch.point, DVec2::new(s, t));
                let arriving = arriving.map(|it| it * (patch.density / texel_area));
                if arriving.iter().any(|it| *it > 0.0) {
                    found.passed = found.passed.with_share(passed);
                }
                for c in 0..N {
                    mean[c] += arriving[c] * passed;
                    unshadowed[c] += arriving[c];
                }
            }
            for c in 0..N {
                let mean = mean[c] / f64::from(each);
                sum[c] += mean;
                sum_squares[c] += mean * mean;
            }
        }
        if !is_found {
            return self.sampled_at_home(texel, stream, found, sample);
        }
        let n = f64::from(REPLICATES);
        let samples = n * f64::from(each);
        for c in 0..N {
            let variance = ((sum_squares[c] - sum[c] * sum[c] / n) / (n - 1.0)).max(0.0);
            // Stratified samples often agree, in all replicates, on how many of them see the light. Their
            // scatter is zero then, but the edge is known to one sample only.
            let seen = sum[c] * f64::from(each);
            let is_mixed = seen > 0.0 && !sees_all(seen, unshadowed[c]);
            let one_sample = if is_mixed {
                unshadowed[c] / (samples * samples)
            } else {
                0.0
            };
            found.mean[c] = sum[c] / n;
            found.unshadowed[c] = unshadowed[c] / samples;
            found.error[c] = math::hypot((variance / n).sqrt(), one_sample);
        }
        found
    }

    /// The same as [`sampled`](Self::sampled), for a texel of which a mesh covers so little that no sample
    /// found it.
    ///
    /// One point stands for the texel, and its irradiance without shadow for the error.
    fn sampled_at_home<const N: usize>(
        &mut self,
        texel: usize,
        stream: &Stream,
        mut found: Sampled<N>,
        sample: impl Fn(&mut Self, &SurfacePoint, DVec2) -> ([f64; N], f64),
    ) -> Sampled<N> {
        let Some(point) = self.receiver.home(self.scene, texel) else {
            found.mean = [f64::NAN; N];
            found.error = [f64::NAN; N];
            return found;
        };
        let samples = REPLICATES * SAMPLES;
        for number in 0..samples {
            let [s, t, ..] = stream.point4(u64::from(number));
            let (arriving, passed) = sample(self, &point, DVec2::new(s, t));
            let sums = found.mean.iter_mut().zip(&mut found.error);
            for ((mean, error), arriving) in sums.zip(arriving) {
                *mean += arriving * passed;
                *error += arriving;
            }
        }
        let by_samples = |sum: f64| sum / f64::from(samples);
        found.mean = found.mean.map(by_samples);
        found.error = found.error.map(by_samples);
        found
    }
}
