//! Photons from the light view to the canvas: the stages before `splat`, one after the other.
//!
//! Each takes neighbours, whose rays are traced together.

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
use crate::approximation::interface::Crossing;
use crate::approximation::{DepthMap, LightView, Receivers};
use crate::geometry::TraversalCounters;
use crate::numeric::math;
use crate::radiometry::Rgb;
use crate::run::Progress;
use crate::scene::Scene;
use crate::transport::first_surface::Source;
use crate::transport::path_end::next_hits;
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
    /// Stage `view`: the specular object in each image point; `Ok(None)` where there is none.
    ///
    /// # Errors
    ///
    /// As of [`front`](super::buffers::front).
    pub fn fronts(&self, points: &[DVec2], work: &mut Work) -> Vec<Result<Option<Front>, Loss>> {
        let [low, high] = self.window;
        let is_stopped = self.progress.is_stopped();
        let is_seen = |at: &DVec2| !(is_stopped || at.cmplt(low).any() || at.cmpgt(high).any());
        let seen = points.iter().filter(|at| is_seen(at));
        let mut counters = TraversalCounters::default();
        let found = next_hits(self.scene, seen.map(|&at| self.view.ray(at)), &mut counters);
        work.add_rays(counters);
        let mut found = found.into_iter();
        let fronts = points.iter().map(|at| {
            let found = is_seen(at).then(|| found.next()).flatten().flatten();
            front(self.scene, found, self.mode, self.settings.view)
        });
        let fronts: Vec<_> = fronts.collect();
        work.photons += fronts.len() as u64;
        let dropped = fronts.iter().filter(|front| !matches!(front, Ok(Some(_))));
        work.dropped += dropped.count() as u64;
        fronts
    }

    /// Stage `refraction`, and what interfaces take, of photons at these image points.
    ///
    /// # Errors
    ///
    /// Where the photon does not leave the object.
    pub fn exits<'f>(
        &self,
        fronts: impl Iterator<Item = (DVec2, &'f Front)> + Clone,
        work: &mut Work,
    ) -> Vec<Result<Exit, Loss>> {
        let arrivals = fronts.map(|(at, front)| Arrival {
            scene: self.scene,
            view: self.view,
            at,
            front,
            fresnel: self.settings.fresnel,
            wanted: Wanted::by(self.settings.splat),
        });
        let mut counters = TraversalCounters::default();
        let exits: Vec<_> = match (self.mode, self.settings.refraction) {
            (Mode::Reflection, _) => arrivals.map(|it| it.at_once(Way::Reflected)).collect(),
            (Mode::SingleRefraction, _) => {
                arrivals.map(|it| it.at_once(Way::Transmitted)).collect()
            }
            (Mode::Refraction, Refraction::Exact) => {
                let entered: Vec<_> = arrivals.clone().map(|it| it.entered()).collect();
                let rays = entered.iter().flatten().map(|(_, ray)| *ray);
                let mut found = next_hits(self.scene, rays, &mut counters).into_iter();
                let exit = |(arrival, entered): (Arrival, Result<(Crossing, _), _>)| {
                    let (first, _) = entered?;
                    arrival.through(&first, found.next().flatten())
                };
                arrivals.zip(entered).map(exit).collect()
            }
            (Mode::Refraction, Refraction::ImageSpace) => {
                let exit = |it: Arrival| it.image_space(self.backs, self.settings, &mut counters);
                let exits: Vec<_> = arrivals.map(exit).collect();
                work.fetches += 2 * exits.len() as u64;
                exits
            }
        };
        work.add_rays(counters);
        work.count_results(&exits);
        exits
    }

    /// Stage `hit` of photons.
    ///
    /// # Errors
    ///
    /// Where they meet no receiver.
    pub fn places<'e>(
        &self,
        exits: impl Iterator<Item = &'e Exit> + Clone,
        work: &mut Work,
    ) -> Vec<Result<Place, Loss>> {
        let mut counters = TraversalCounters::default();
        let places: Vec<_> = match self.settings.hit {
            Hit::DepthMap => {
                let finely = [self.settings.steps, self.settings.bisections];
                let march = |exit| marched(exit, self.depths, finely, work);
                exits.map(march).collect()
            }
            Hit::FixedPoint => {
                let find = |exit| fixed_point(exit, self.depths, work);
                exits.map(find).collect()
            }
            Hit::Exact => traced(self.scene, self.receivers, exits, &mut counters),
        };
        work.add_rays(counters);
        work.count_results(&places);
        places
    }

    /// Stage `hit` of beams' corners.
    ///
    /// # Errors
    ///
    /// Where they land on no texel's surface.
    pub fn landings<'e>(
        &self,
        exits: impl Iterator<Item = &'e Exit> + Clone,
        canvas: &Canvas,
        work: &mut Work,
    ) -> Vec<Result<Landing, Loss>> {
        let (scene, receivers) = (self.scene, self.receivers);
        let mut counters = TraversalCounters::default();
        let landings = match (canvas, self.settings.hit) {
            (Canvas::Map(map), _) => {
                let landing = |place: Result<Place, Loss>| {
                    let place = place?;
                    let seen = map.project(place.position).ok_or(Loss::OutsideMap)?;
                    Ok(Landing {
                        at: seen.at,
                        position: place.position,
                        weight: Rgb::WHITE,
                        surface: place.surface,
                    })
                };
                let places = self.places(exits, work).into_iter();
                places.map(landing).collect()
            }
            (Canvas::Sensor(screen), Hit::Exact) => {
                let landings = traced_on_sensor(scene, receivers, screen, exits, &mut counters);
                work.count_results(&landings);
                landings
            }
            (Canvas::Sensor(screen), Hit::DepthMap | Hit::FixedPoint) => {
                let depths = self.depths;
                let landing = |place: Result<Place, Loss>| {
                    let place = place?;
                    marched_on_sensor(scene, receivers, screen, depths, &place, &mut counters)
                };
                let places = self.places(exits, work).into_iter();
                places.map(landing).collect()
            }
        };
        work.add_rays(counters);
        landings
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
