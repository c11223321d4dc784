//! One photon from the light view to the canvas: the stages before `splat`, one after the other.

use glam::DVec2;

use super::buffers::{Back, DepthMap, Front, Receivers, front};
use super::hit::{Canvas, Landing, marched, traced};
use super::refraction::{Exit, Wanted, image_space, reflected, through};
use super::settings::{Flux, Hit, Mode, Refraction, Settings};
use super::view::LightView;
use crate::approximation::Work;
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
    /// Which light.
    pub mode: Mode,
    /// The variants.
    pub settings: &'a Settings,
    /// The picture of back faces; empty where it is not used.
    pub backs: &'a [Option<Back>],
    /// The receivers' depths, where they are used.
    pub depths: Option<&'a DepthMap>,
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
        let (scene, view, fresnel) = (self.scene, self.view, self.settings.fresnel);
        let wanted = Wanted::by(self.settings.splat);
        let exit = match (self.mode, self.settings.refraction) {
            (Mode::Reflection, _) => reflected(scene, view, at, front, fresnel),
            (Mode::Refraction, Refraction::Exact) => {
                through(scene, view, at, front, fresnel, wanted, &mut counters)
            }
            (Mode::Refraction, Refraction::ImageSpace) => {
                work.fetches += 2;
                image_space(scene, view, at, front, self.backs, fresnel, &mut counters)
            }
        };
        work.add_rays(counters);
        work.photons += 1;
        work.dropped += u64::from(exit.is_none());
        exit
    }

    /// Stage `hit`.
    pub fn landing(&self, exit: &Exit, canvas: &Canvas, work: &mut Work) -> Option<Landing> {
        work.photons += 1;
        let landing = if let (Hit::DepthMap, Some(depths)) = (self.settings.hit, self.depths) {
            let finely = [self.settings.steps, self.settings.bisections];
            marched(
                self.scene,
                self.receivers,
                canvas,
                exit,
                depths,
                finely,
                work,
            )
        } else {
            let mut counters = TraversalCounters::default();
            let landing = traced(self.scene, self.receivers, canvas, exit, &mut counters);
            work.add_rays(counters);
            landing
        };
        work.dropped += u64::from(landing.is_none());
        landing
    }

    /// Stage `flux`: flux \[W\] that sets out in a rectangle of the image about `at`.
    pub fn emitted(&self, at: DVec2, low: DVec2, high: DVec2) -> Rgb {
        let side = self.view.side() as f64;
        let measure = match self.settings.flux {
            Flux::Exact => self.view.measure_of(low, high),
            Flux::Uniform => self.view.measure() / (side * side) * (high - low).element_product(),
        };
        let falloff = match self.source {
            Source::Point { falloff, .. } => falloff.factor(self.view.ray(at).direction),
            _ => 1.0,
        };
        self.source.strength() * (falloff * measure)
    }
}
