//! Light that photons measure in the place of beams.
//!
//! Light that is mirrored again and again within a mesh parts at every face. It falls into as many cells as
//! there are ways from face to face: a hundredth of all light may take nearly all the work. Photons do not
//! mind, and little light needs few of them. Of n photons, the light of signatures S has a variance of about
//!
//! ```text
//! Σ σ² = (n₀ / n) Σ q        over texels, and over S
//! ```
//!
//! where q is the sum of squared contributions of n₀ photons of a [pilot](PilotLight). Random photons have
//! that variance; Sobol' points have less. Beams have their work w from a [forecast](super::forecast). So
//! signatures go to photons in the order of w / q, the fewest that come near to the least work of both. What
//! beams would have left out goes along with them: all light is measured then.
//!
//! The price is noise: bounds of that light are those of photons, with their confidence. So beams keep all
//! light unless photons save most of the work.

use std::collections::{BTreeMap, BTreeSet};

use super::forecast::WorkBySignature;
use super::schedule;
use super::settings::BeamSettings;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::reference::photons::bounds::CONFIDENCE;
use crate::reference::photons::pilot::{PILOT_PHOTONS, Received};
use crate::reference::photons::{self, PhotonSettings};
use crate::reference::target::LitTexels;
use crate::run::{Budget, Error, Estimate, Progress};
use crate::scene::{Scene, Sensor};
use crate::transport::chain::ChainSettings;
use crate::transport::followed::Followed;
use crate::transport::signature::Signature;

/// Part of the error asked for that is left to beams, if photons measure some of the light.
pub const OF_BEAMS: f64 = 0.6;

/// The part that photons are forecast with: the squares of both add to 1.
const OF_PHOTONS: f64 = 0.8;

/// Part of the variance that is left if photons start where the light in question does, about: a fifth in
/// `turntable-bumpy`, the one scene where it was measured.
const AIMED: f64 = 0.25;

/// Largest part of beams' work that beams and photons together may take.
const WORTH: f64 = 0.25;

/// The work of beams \[rays\] from which on photons are asked: some times what their pilot takes.
pub const LEAST_WORK: f64 = (1 << 22) as f64;

/// Factor of their forecast after which beams give up. That of flat facets may be a tenth of their work, and
/// light that beams know would cost photons far more.
const OVERRUN: f64 = 32.0;

/// Most work \[rays\] of beams that are chosen without being asked for: some minutes' work.
pub const MOST_RAYS: f64 = 1e9;

/// Work of beams \[rays\] after which they give up although photons are to measure nothing, by their
/// forecast. It is no less than a forecast may tell if beams are to be chosen.
pub fn most_alone(forecast: f64) -> u64 {
    (OVERRUN * forecast).max(MOST_RAYS) as u64
}

/// Photons that measure a part of the light.
pub struct ByPhotons<'a> {
    sensor: &'a Sensor,
    setup: photons::run::Setup<'a>,
}

/// A division of the light between beams and photons.
#[derive(Clone, Debug, PartialEq)]
pub struct Division {
    /// The signatures that photons measure.
    pub to_photons: BTreeSet<Signature>,
    /// Likely work of both \[rays\].
    pub work: f64,
    /// Work of beams \[rays\] after which their forecast was wrong: photons measure what they did not end.
    pub most_of_beams: u64,
}

/// Photons, and their part of the light.
pub struct PhotonPart<'a> {
    /// The photons.
    pub photons: ByPhotons<'a>,
    /// The division.
    pub division: Division,
}

impl<'a> ByPhotons<'a> {
    /// Photons for the same light as beams; `None` if they cannot be connected to the sensor.
    pub fn new(
        scene: &'a Scene,
        sensor: &'a Sensor,
        settings: BeamSettings,
        progress: &'a Progress,
    ) -> Option<Self> {
        let settings = PhotonSettings {
            seed: settings.seed,
            chains: ChainSettings {
                max_depth: settings.max_depth,
                shading_normals: settings.shading_normals,
                followed: Followed::Smooth,
                ..ChainSettings::default()
            },
            max_layers: 0,
            ..PhotonSettings::default()
        };
        let setup = photons::run::Setup::new(scene, sensor, settings, progress).ok()?;
        Some(Self { sensor, setup })
    }

    /// The division that takes the least work to a relative `error` on so many `lit` texels, given beams'
    /// work on each signature; those that `must_stay` stay with beams. `None` if beams had better keep all
    /// light.
    pub fn division(
        &self,
        by_beams: &WorkBySignature,
        must_stay: impl Fn(&Signature) -> bool,
        lit: f64,
        error: f64,
    ) -> Option<Division> {
        let work = by_beams
            .iter()
            .map(|(signature, work)| (*signature, work.work()));
        let (stays, work): (BTreeMap<_, _>, BTreeMap<_, _>) =
            work.partition(|(one, _)| must_stay(one));
        let pilot = self.setup.pilot();
        let each = pilot.rays as f64 / PILOT_PHOTONS as f64;
        division((&stays, &work), &pilot.received, each, (lit, error))
    }

    /// Measures the light of all signatures but those that are `followed` by beams. Of the others so many get
    /// a layer of their own. Returns the estimate with bounds, and with its error relative to the light that
    /// is `lit`, and the flux \[W\] that photons may have missed; `None` if nothing became known in time.
    ///
    /// # Errors
    ///
    /// If contributions are not representable.
    pub fn measure(
        mut self,
        followed: BTreeSet<Signature>,
        layers: usize,
        lit: Option<LitTexels>,
        budget: &Budget,
    ) -> Result<Option<(Estimate, Rgb)>, Error> {
        self.setup.leave_out(followed, layers, lit);
        let (estimate, missed) = self.setup.run_aimed(budget)?;
        if estimate.total.is_unknown() {
            return Ok(None);
        }
        let (replicates, _) = self.setup.division(estimate.paths);
        let least = self.sensor.film.filter.least_light();
        let estimate = estimate.with_bounds(CONFIDENCE, replicates, least);
        Ok(Some((estimate, missed)))
    }
}

/// The best division to a relative error on so many lit texels: by beams' work \[rays\] on each signature
/// that stays with them, and on each that need not; by what a pilot received of all of them, and by the rays
/// that a photon takes.
fn division(
    (stays, work): (&BTreeMap<Signature, f64>, &BTreeMap<Signature, f64>),
    received: &BTreeMap<Signature, Received>,
    rays_each: f64,
    (lit, error): (f64, f64),
) -> Option<Division> {
    let alone: f64 = work.values().chain(stays.values()).sum();
    let flux: f64 = received.values().map(|one| one.flux).sum();
    if flux <= 0.0 {
        return None;
    }
    // The sum over lit texels of squared errors, in flux.
    let allowed = math::powi(OF_PHOTONS * error * flux, 2) / lit;
    let squares = |signature: &Signature| received.get(signature).map_or(0.0, |one| one.squares);
    let by_photons = |squares: f64| {
        let photons = PILOT_PHOTONS as f64 * AIMED * squares / allowed;
        rays_each * photons.max(PILOT_PHOTONS as f64)
    };
    let mut order: Vec<(Signature, f64, f64)> = work
        .iter()
        .map(|(signature, work)| (*signature, *work, squares(signature)))
        .collect();
    // The dearest for their variance first; ties by signature.
    order.sort_by(|(a, v, p), (b, w, q)| (w * p).total_cmp(&(v * q)).then(a.cmp(b)));
    let growth = schedule::growth(OF_BEAMS);
    let mut variance: f64 = received
        .keys()
        .filter(|signature| !work.contains_key(signature) && !stays.contains_key(signature))
        .map(squares)
        .sum();
    let mut left = alone;
    // Work of both, and of beams.
    let mut works: Vec<(f64, f64)> = Vec::new();
    for (_, work, squares) in &order {
        left -= work;
        variance += squares;
        let of_beams = growth * left.max(0.0);
        works.push((of_beams + by_photons(variance), of_beams));
    }
    let least = works
        .iter()
        .fold(f64::INFINITY, |least, (all, _)| least.min(*all));
    // No noise in more light than is worth it.
    let (index, (all, of_beams)) = works
        .into_iter()
        .enumerate()
        .find(|(_, (all, _))| *all <= least + LEAST_WORK)
        .filter(|(_, (all, _))| *all <= WORTH * alone)?;
    Some(Division {
        to_photons: order[..=index]
            .iter()
            .map(|(signature, ..)| *signature)
            .collect(),
        work: all,
        most_of_beams: (OVERRUN * of_beams).max(LEAST_WORK) as u64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Beams' work on each signature, and what a pilot received of it: flux, and its squares.
    fn divided(light: &[(&str, f64, f64, f64)], error: f64) -> Option<Division> {
        divided_but("LD", light, error)
    }

    /// The same if the light of one signature stays with beams.
    fn divided_but(stays: &str, light: &[(&str, f64, f64, f64)], error: f64) -> Option<Division> {
        let name = |name: &str| name.parse::<Signature>().unwrap();
        let work = light.iter().map(|(one, work, ..)| (name(one), *work));
        let received = light.iter().map(|(one, _, flux, squares)| {
            let received = Received {
                flux: *flux,
                squares: *squares,
                ..Received::default()
            };
            (name(one), received)
        });
        let (stays, work) = work.partition(|(one, _)| *one == name(stays));
        division((&stays, &work), &received.collect(), 8.0, (4096.0, error))
    }

    /// One photon in two is in the bright light, and one in fifty in the chaotic.
    const BRIGHT: (&str, f64, f64, f64) = ("LTTD", 1e6, 1.0, 3e-5);
    const CHAOTIC: (&str, f64, f64, f64) = ("LTRRRRTD", 1e9, 0.02, 6e-7);

    fn names(division: &Division) -> Vec<String> {
        division
            .to_photons
            .iter()
            .map(ToString::to_string)
            .collect()
    }

    #[test]
    fn little_light_that_beams_take_long_for_goes_to_photons() {
        let division = divided(&[BRIGHT, CHAOTIC], 1e-2).unwrap();
        assert_eq!(names(&division), ["LTRRRRTD"]);
        // Variance that may be left: (0.8 x 1.02 %)² / 4096 = 1.63e-8. So photons are 2¹⁶ x 6e-7 / 4 /
        // 1.63e-8 = 6.0e5, of eight rays. Beams take 0.6^-0.79 = 1.49 times as long for their part of the
        // error.
        let photons = 65_536.0 * 0.25 * 6e-7 / (math::powi(0.8 * 1.02e-2, 2) / 4096.0);
        let work = 8.0 * photons + 1e6 * math::powf(0.6, -0.55 / 0.7);
        assert!((division.work / work - 1.0).abs() < 1e-12, "{division:?}");
        assert_eq!(
            division.most_of_beams,
            (32.0 * 1e6 * math::powf(0.6, -0.55 / 0.7)) as u64
        );
    }

    #[test]
    fn beams_keep_light_that_photons_would_take_as_long_for() {
        // To a hundredth of the error photons take 10⁴ times as long: 5e10 rays.
        assert_eq!(divided(&[BRIGHT, CHAOTIC], 1e-4), None);
        // No light is dear.
        let cheap = (CHAOTIC.0, 3e5, CHAOTIC.2, CHAOTIC.3);
        assert_eq!(divided(&[BRIGHT, cheap], 1e-2), None);
    }

    #[test]
    fn beams_alone_give_up_after_many_times_their_forecast_but_not_early() {
        assert_eq!(most_alone(1.0), 1_000_000_000);
        assert_eq!(most_alone(1e9), 32_000_000_000);
    }

    #[test]
    fn light_that_no_photon_of_the_pilot_brought_goes_first() {
        let unseen = ("LTRRRTD", 1e8, 0.0, 0.0);
        let division = divided(&[BRIGHT, CHAOTIC, unseen], 1e-2).unwrap();
        assert_eq!(names(&division), ["LTRRRTD", "LTRRRRTD"]);
    }

    #[test]
    fn light_that_must_stay_with_beams_is_part_of_their_work() {
        let dear = ("LTRRRTD", 2e7, 0.02, 6e-7);
        let light = [BRIGHT, CHAOTIC, dear];
        let both = divided(&light, 1e-2).unwrap();
        let stays = divided_but("LTRRRTD", &light, 1e-2).unwrap();
        assert_eq!(
            (names(&both).len(), names(&stays)),
            (2, vec!["LTRRRRTD".to_owned()])
        );
        assert!(stays.most_of_beams as f64 > 32.0 * 2e7);
    }

    #[test]
    fn a_light_of_which_nothing_arrives_is_left_to_beams() {
        let dark = ("LTTD", 1e9, 0.0, 0.0);
        assert_eq!(divided(&[dark], 1e-2), None);
    }
}
