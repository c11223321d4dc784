//! One photon from the light view to the canvas: the stages before `splat`, one after the other.

use glam::{DVec2, DVec3};

use super::buffers::{Backs, Front, front};
use super::hit::{
    Canvas, Landing, Place, fixed_point, marched, marched_on_sensor, traced, traced_on_sensor,
};
use super::loss::Loss;
use super::refraction::{Arrival, Exit, Wanted};
use super::settings::Settings;
use super::spread::texels_by_pixel;
use super::variants::{Flux, Hit, Mode, Refraction};
use super::work::Work;
use crate::approximation::{DepthMap, LightView, Receivers};
use crate::geometry::TraversalCounters;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::run::Progress;
use crate::scene::Scene;
use crate::transport::first_surface::Source;
use crate::transport::scatter::Way;

/// All that a photon's way depends on.
pub struct Tracer<'a> {
    /// The wish to stop: photons that have not set out then are left out.
    pub progress: &'a Progress,
    /// The scene.
    pub scene: &'a Scene,
    /// What photons may land on.
    pub receivers: &'a Receivers,
    /// The part of the view that specular objects are in: two opposite corners.
    pub window: [DVec2; 2],
    /// The light.
    pub source: &'a Source,
    /// The photon buffer's view.
    pub view: &'a LightView,
    /// The mean over its pixels of what each measures of light space: solid angle \[sr\], of parallel light
    /// area \[m²\].
    pub pixel_measure: f64,
    /// Which light.
    pub mode: Mode,
    /// The variants.
    pub settings: &'a Settings,
    /// The picture of back faces; empty where it is not used.
    pub backs: &'a Backs,
    /// The views of this light's caustic maps.
    pub maps: &'a [LightView],
    /// The receivers' depths, in all pictures of this light; empty where they are not used.
    pub depths: &'a [DepthMap],
}

impl Tracer<'_> {
    /// Stage `view`: the specular object in an image point; `Ok(None)` where there is none.
    ///
    /// # Errors
    ///
    /// As of [`front`](super::buffers::front).
    pub fn front(&self, at: DVec2, work: &mut Work) -> Result<Option<Front>, Loss> {
        work.photons += 1;
        let [low, high] = self.window;
        if at.cmplt(low).any() || at.cmpgt(high).any() || self.progress.is_stopped() {
            work.dropped += 1;
            return Ok(None);
        }
        let mut counters = TraversalCounters::default();
        let ray = self.view.ray(at);
        let found = front(
            self.scene,
            ray,
            self.mode,
            self.settings.view,
            &mut counters,
        );
        work.add_rays(counters);
        work.dropped += u64::from(!matches!(found, Ok(Some(_))));
        found
    }

    /// Stage `refraction`, and what interfaces take.
    ///
    /// # Errors
    ///
    /// Where the photon does not leave the object.
    pub fn exit(&self, at: DVec2, front: &Front, work: &mut Work) -> Result<Exit, Loss> {
        let mut counters = TraversalCounters::default();
        let arrival = Arrival {
            scene: self.scene,
            view: self.view,
            at,
            front,
            fresnel: self.settings.fresnel,
            wanted: Wanted::by(self.settings.splat),
        };
        let exit = match (self.mode, self.settings.refraction) {
            (Mode::Reflection, _) => arrival.at_once(Way::Reflected),
            (Mode::SingleRefraction, _) => arrival.at_once(Way::Transmitted),
            (Mode::Refraction, Refraction::Exact) => arrival.through(&mut counters),
            (Mode::Refraction, Refraction::ImageSpace) => {
                work.fetches += 2;
                arrival.image_space(self.backs, self.settings, &mut counters)
            }
        };
        work.add_rays(counters);
        work.photons += 1;
        work.dropped += u64::from(exit.is_err());
        exit
    }

    /// Stage `hit` of a photon.
    ///
    /// # Errors
    ///
    /// Where it meets no receiver.
    pub fn place(&self, exit: &Exit, work: &mut Work) -> Result<Place, Loss> {
        let mut counters = TraversalCounters::default();
        let place = match self.settings.hit {
            Hit::DepthMap => {
                let finely = [self.settings.steps, self.settings.bisections];
                marched(exit, self.depths, finely, work)
            }
            Hit::FixedPoint => fixed_point(exit, self.depths, work),
            Hit::Exact => traced(self.scene, self.receivers, exit, &mut counters),
        };
        work.add_rays(counters);
        work.photons += 1;
        work.dropped += u64::from(place.is_err());
        place
    }

    /// Stage `hit` of a beam's corner.
    ///
    /// # Errors
    ///
    /// Where it lands on no texel's surface.
    pub fn landing(&self, exit: &Exit, canvas: &Canvas, work: &mut Work) -> Result<Landing, Loss> {
        let (scene, receivers) = (self.scene, self.receivers);
        let mut counters = TraversalCounters::default();
        let landing = match (canvas, self.settings.hit) {
            (Canvas::Map(map), _) => self.place(exit, work).and_then(|place| {
                let seen = map.project(place.position).ok_or(Loss::OutsideMap)?;
                Ok(Landing {
                    at: seen.at,
                    position: place.position,
                    weight: Rgb::WHITE,
                    surface: place.surface,
                })
            }),
            (Canvas::Sensor(screen), Hit::Exact) => {
                work.photons += 1;
                let landing = traced_on_sensor(scene, receivers, screen, exit, &mut counters);
                work.dropped += u64::from(landing.is_err());
                landing
            }
            (Canvas::Sensor(screen), Hit::DepthMap | Hit::FixedPoint) => {
                self.place(exit, work).and_then(|place| {
                    let depths = self.depths;
                    marched_on_sensor(scene, receivers, screen, depths, &place, &mut counters)
                })
            }
        };
        work.add_rays(counters);
        landing
    }

    /// The light's strength towards an image point: flux by light-space measure.
    pub fn strength(&self, at: DVec2) -> Rgb {
        let falloff = match self.source {
            Source::Point { falloff, .. } => falloff.factor(self.view.ray(at).direction),
            Source::Parallel { .. } => 1.0,
        };
        self.source.strength() * falloff
    }

    /// Light-space measure that sets out in a rectangle of the image: solid angle \[sr\], of parallel light
    /// area \[m²\].
    pub fn sent(&self, low: DVec2, high: DVec2) -> f64 {
        self.view.measure_of(low, high)
    }

    /// Stage `flux`: the light-space measure by which a photon counts that stands for the rectangle of the
    /// image between `low` and `high`, and lands at `place`.
    ///
    /// `density-ratio` is that of the authors' programs of 2006 and 2008. They add up (M/N)² of each photon
    /// in the map's texels, and light a surface by that sum times its direct light. A texel of solid angle ω
    /// has the direct light I ω, so that a photon carries I ω (M/N)², with ω of the texel where it *lands*.
    /// Light that nothing bends is then direct light; light that is bent outward counts for less than it is.
    pub fn carried(&self, low: DVec2, high: DVec2, place: DVec3) -> Option<f64> {
        let pixels = (high - low).element_product();
        self.carried_anywhere(low, high)
            .or_else(|| Some(self.landing_measure(place)? * pixels))
    }

    /// The same, where it does not depend on where the photon lands.
    pub fn carried_anywhere(&self, low: DVec2, high: DVec2) -> Option<f64> {
        match self.settings.flux {
            Flux::Exact => Some(self.sent(low, high)),
            Flux::Uniform => Some(self.pixel_measure * (high - low).element_product()),
            Flux::DensityRatio => None,
        }
    }

    /// The light-space measure of a pixel of the photon buffer as large as it is where light lands; `None`
    /// where no map has the place.
    fn landing_measure(&self, place: DVec3) -> Option<f64> {
        let map = self.home(place)?;
        let at = map.project(place)?.at;
        Some(map.pixel_measure_at(at) * math::powi(texels_by_pixel(self.view, map), 2))
    }

    /// The map that a place is in; if none, the first that sees it beyond its border.
    fn home(&self, place: DVec3) -> Option<&LightView> {
        let holds = |map: &&LightView| map.project(place).is_some_and(|seen| map.holds(seen.at));
        let sees = |map: &&LightView| map.project(place).is_some();
        let mut maps = self.maps.iter();
        maps.clone().find(holds).or_else(|| maps.find(sees))
    }

    /// Whether a map has a texel for a place.
    pub fn is_on_a_map(&self, place: DVec3) -> bool {
        let holds = |map: &LightView| map.project(place).is_some_and(|seen| map.holds(seen.at));
        self.maps.iter().any(holds)
    }
}
