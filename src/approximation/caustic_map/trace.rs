//! One photon from the light view to the canvas: the stages before `splat`, one after the other.

use glam::DVec2;

use super::buffers::{Back, Front, front};
use super::hit::{Canvas, Landing, Place, marched, marched_on_sensor, traced, traced_on_sensor};
use super::refraction::{Arrival, Exit, Wanted};
use super::settings::{Flux, Hit, Mode, Refraction, Settings};
use super::work::Work;
use crate::approximation::{DepthMap, LightView, Receivers};
use crate::geometry::TraversalCounters;
use crate::radiometry::Rgb;
use crate::scene::Scene;
use crate::transport::first_surface::Source;

/// All that a photon's way depends on.
pub struct Tracer<'a> {
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
    pub backs: &'a [Option<Back>],
    /// The receivers' depths, in all pictures of this light; empty where they are not used.
    pub depths: &'a [DepthMap],
}

impl Tracer<'_> {
    /// Stage `view`.
    pub fn front(&self, at: DVec2, work: &mut Work) -> Option<Front> {
        work.photons += 1;
        let [low, high] = self.window;
        if at.cmplt(low).any() || at.cmpgt(high).any() {
            work.dropped += 1;
            return None;
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
        work.dropped += u64::from(found.is_none());
        found
    }

    /// Stage `refraction`, and what interfaces take.
    pub fn exit(&self, at: DVec2, front: &Front, work: &mut Work) -> Option<Exit> {
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
            (Mode::Reflection, _) => arrival.reflected(),
            (Mode::Refraction, Refraction::Exact) => arrival.through(&mut counters),
            (Mode::Refraction, Refraction::ImageSpace) => {
                work.fetches += 2;
                arrival.image_space(self.backs, &mut counters)
            }
        };
        work.add_rays(counters);
        work.photons += 1;
        work.dropped += u64::from(exit.is_none());
        exit
    }

    /// Stage `hit` of a photon.
    pub fn place(&self, exit: &Exit, work: &mut Work) -> Option<Place> {
        let mut counters = TraversalCounters::default();
        let place = match self.settings.hit {
            Hit::DepthMap => {
                let finely = [self.settings.steps, self.settings.bisections];
                marched(exit, self.depths, finely, work)
            }
            Hit::Exact => traced(self.scene, self.receivers, exit, &mut counters),
        };
        work.add_rays(counters);
        work.photons += 1;
        work.dropped += u64::from(place.is_none());
        place
    }

    /// Stage `hit` of a beam's corner.
    pub fn landing(&self, exit: &Exit, canvas: &Canvas, work: &mut Work) -> Option<Landing> {
        let (scene, receivers) = (self.scene, self.receivers);
        let mut counters = TraversalCounters::default();
        let landing = match (canvas, self.settings.hit) {
            (Canvas::Map(map), _) => self.place(exit, work).and_then(|place| {
                Some(Landing {
                    at: map.project(place.position)?.at,
                    weight: Rgb::WHITE,
                    surface: place.surface,
                })
            }),
            (Canvas::Sensor(screen), Hit::Exact) => {
                work.photons += 1;
                let landing = traced_on_sensor(scene, receivers, screen, exit, &mut counters);
                work.dropped += u64::from(landing.is_none());
                landing
            }
            (Canvas::Sensor(screen), Hit::DepthMap) => self.place(exit, work).and_then(|place| {
                let depths = self.depths;
                marched_on_sensor(scene, receivers, screen, depths, &place, &mut counters)
            }),
        };
        work.add_rays(counters);
        landing
    }

    /// Stage `flux`: flux \[W\] that sets out in a rectangle of the image about `at`.
    pub fn emitted(&self, at: DVec2, low: DVec2, high: DVec2) -> Rgb {
        let measure = match self.settings.flux {
            Flux::Exact => self.view.measure_of(low, high),
            Flux::Uniform => self.pixel_measure * (high - low).element_product(),
        };
        let falloff = match self.source {
            Source::Point { falloff, .. } => falloff.factor(self.view.ray(at).direction),
            Source::Parallel { .. } => 1.0,
        };
        self.source.strength() * (falloff * measure)
    }
}
