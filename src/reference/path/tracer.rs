//! Paths: from the camera, by way of surfaces, to every emitter that it finds.

use glam::DVec3;

use super::settings::PathSettings;
use crate::geometry::{Hit, Ray, Segment, SurfacePoint, TraversalCounters};
use crate::numeric::PaddedStream;
use crate::radiometry::Rgb;
use crate::scene::{MediumId, Scene};
use crate::transport::bsdf::{Bsdf, BsdfSample, Scattering, Transport};
use crate::transport::camera::PixelRay;
use crate::transport::lights::Lights;
use crate::transport::media;
use crate::transport::path_class::{PathClass, PathEvent, PathEvents};
use crate::transport::visibility::transmittance;

/// Radiance [W/m²/sr] by class of path, in the order of [`PathClass::ALL`].
pub type RadianceByClass = [Rgb; PathClass::ALL.len()];

/// Largest number of surfaces that a path may meet, those that it passes included. If neither `max_depth` nor
/// roulette ends it, light could go round between mirrors for ever.
const MAX_SURFACES: u32 = 1 << 16;

/// Largest probability with which roulette keeps a path, as in Mitsuba. So light that no surface absorbs
/// ends, too.
const MAX_SURVIVAL: f64 = 0.95;

/// Rays between two looks at `stop`: some milliseconds of work. A path of [`MAX_SURFACES`] has more.
const RAYS_BETWEEN_STOPS: u64 = 4096;

/// Surfaces between two looks at `stop` of paths that are followed together.
const SURFACES_BETWEEN_STOPS: u32 = 8;

/// A tracer of paths through a scene.
pub struct Tracer<'a> {
    scene: &'a Scene,
    lights: &'a Lights<'a>,
    settings: &'a PathSettings,
    /// For each shape, true if it shines.
    shines: &'a [bool],
    /// Work done.
    pub counters: TraversalCounters,
    /// Number of paths ended at [`MAX_SURFACES`].
    pub cut_off: u64,
}

/// The numbers of one path: a sample of a pixel's stream.
#[derive(Clone, Copy)]
pub struct PathNumbers<'a> {
    /// The pixel's own stream.
    pub stream: &'a PaddedStream,
    /// The number of the sample.
    pub index: u64,
}

impl PathNumbers<'_> {
    /// The film point within the pixel, and the point of the lens.
    #[inline]
    pub fn camera(self) -> [f64; 4] {
        self.stream.padded4(self.index, 0)
    }

    /// The numbers for an emitter, as seen from a path's surface: its choice, and a direction to it.
    ///
    /// A group's first two dimensions are the most even ones, so the direction gets them.
    #[inline]
    fn emitter(self, surface: u32) -> [f64; 3] {
        let [x, y, choice, _] = self.stream.padded4(self.index, 2 * surface + 1);
        [choice, x, y]
    }

    /// The numbers for a surface: the choice of a lobe, a direction, and roulette.
    #[inline]
    fn surface(self, surface: u32) -> ([f64; 3], f64) {
        let [x, y, choice, roulette] = self.stream.padded4(self.index, 2 * surface + 2);
        ([choice, x, y], roulette)
    }
}

/// For each shape, true if it shines.
pub fn shining_shapes(scene: &Scene) -> Vec<bool> {
    let mut shines = vec![false; scene.objects().len()];
    for emitter in scene.emitters() {
        if let Some(shape) = emitter.shape() {
            shines[shape.0 as usize] = true;
        }
    }
    shines
}

/// A path on its way.
struct Path {
    ray: Ray,
    /// Length of `ray` that is searched for surfaces.
    reach: f64,
    /// The medium that `ray` is in.
    medium: MediumId,
    /// Radiance at the camera per radiance that comes along `ray`.
    throughput: Rgb,
    /// The product of all `eta` so far.
    eta: f64,
    /// Events so far.
    events: PathEvents,
    /// Number of legs so far, that along `ray` included. Surfaces that the path passes do not divide legs.
    legs: u32,
    /// The place of the last scattering, and the density of the direction from it.
    ///
    /// `None` if nothing else than the path itself could have found its light: from the camera, and after
    /// delta events.
    last: Option<(DVec3, f64)>,
    /// True if nothing has turned it aside.
    is_straight: bool,
    radiance: RadianceByClass,
}

impl<'a> Tracer<'a> {
    /// A tracer, with `shines` as from [`shining_shapes`].
    pub fn new(
        scene: &'a Scene,
        lights: &'a Lights<'a>,
        settings: &'a PathSettings,
        shines: &'a [bool],
    ) -> Self {
        Self {
            scene,
            lights,
            settings,
            shines,
            counters: TraversalCounters::default(),
            cut_off: 0,
        }
    }

    /// A sample of the radiance [W/m²/sr] that comes back along each view, by class of path: `found`
    /// becomes one entry a view. Each depends on its view and numbers alone.
    ///
    /// False, with fewer entries, if `stop` asked for an end.
    pub fn trace_all(
        &mut self,
        views: &[(PixelRay, PathNumbers<'_>)],
        found: &mut Vec<RadianceByClass>,
        stop: &dyn Fn() -> bool,
    ) -> bool {
        found.clear();
        if self.settings.max_depth == Some(0) {
            found.resize(views.len(), Default::default());
        } else if self.scene.world().gains_by_many() {
            return self.trace_together(views, found, stop);
        } else {
            let mut asked = self.counters.rays;
            for (view, numbers) in views {
                if self.counters.rays - asked >= RAYS_BETWEEN_STOPS {
                    asked = self.counters.rays;
                    if stop() {
                        return false;
                    }
                }
                found.push(self.trace(view, *numbers));
            }
        }
        true
    }

    fn trace(&mut self, view: &PixelRay, numbers: PathNumbers) -> RadianceByClass {
        let mut path = self.start(view);
        let world = self.scene.world();
        for surface in 0..MAX_SURFACES {
            let hit = world.closest_hit(&path.ray, path.reach, &mut self.counters);
            if !self.step(&mut path, hit, surface, numbers) {
                return path.radiance;
            }
        }
        self.cut_off += 1;
        path.radiance
    }

    /// Traces paths whose rays are searched for together: those from the camera go down trees in packets, and
    /// searches in large meshes wait for memory together.
    fn trace_together(
        &mut self,
        views: &[(PixelRay, PathNumbers<'_>)],
        found: &mut Vec<RadianceByClass>,
        stop: &dyn Fn() -> bool,
    ) -> bool {
        let mut paths: Vec<Path> = views.iter().map(|(view, _)| self.start(view)).collect();
        let mut under_way: Vec<usize> = (0..paths.len()).collect();
        let (mut segments, mut hits) = (Vec::new(), Vec::new());
        for surface in 0..MAX_SURFACES {
            if under_way.is_empty() {
                break;
            }
            if surface % SURFACES_BETWEEN_STOPS == SURFACES_BETWEEN_STOPS - 1 && stop() {
                return false;
            }
            segments.clear();
            segments.extend(under_way.iter().map(|&i| Segment {
                ray: paths[i].ray,
                length: paths[i].reach,
            }));
            let world = self.scene.world();
            world.closest_hits(&segments, &mut hits, &mut self.counters);
            let mut hits = hits.iter();
            under_way.retain(|&i| {
                let hit = hits.next().copied().flatten();
                self.step(&mut paths[i], hit, surface, views[i].1)
            });
        }
        self.cut_off += under_way.len() as u64;
        found.extend(paths.iter().map(|path| path.radiance));
        true
    }

    fn start(&mut self, view: &PixelRay) -> Path {
        let mut path = Path {
            ray: view.ray,
            reach: view.reach,
            medium: view.medium,
            throughput: Rgb::WHITE,
            eta: 1.0,
            events: PathEvents::default(),
            legs: 1,
            last: None,
            is_straight: true,
            radiance: [Rgb::BLACK; PathClass::ALL.len()],
        };
        if self.settings.hide_emitters {
            self.skip_shining(&mut path);
        }
        path
    }

    /// Arrives at a surface, if there is one, and goes away from it. True if the path goes on.
    fn step(
        &mut self,
        path: &mut Path,
        hit: Option<Hit>,
        surface: u32,
        numbers: PathNumbers,
    ) -> bool {
        let world = self.scene.world();
        let Some(hit) = hit else {
            path.travel(self.scene, f64::INFINITY);
            // An environment is hidden as long as nothing else is seen in that direction.
            if !(self.settings.hide_emitters && path.is_straight) {
                self.meet_emitter(path, None);
            }
            return false;
        };
        let point = world.surface_point(&path.ray, &hit);
        path.travel(self.scene, hit.distance);
        self.meet_emitter(path, Some(&hit));
        let bsdf = Bsdf::at(self.scene, &hit, &point);
        let wi = -path.ray.direction;
        let is_last = self
            .settings
            .max_depth
            .is_some_and(|most| path.legs >= most);
        if !is_last {
            self.sample_emitter(path, (&hit, &point), &bsdf, || numbers.emitter(surface));
        }
        let (choice, roulette) = numbers.surface(surface);
        match bsdf.sample(wi, choice, Transport::Radiance) {
            Some(sample) if sample.scattering == Scattering::Passed => {
                path.pass(&point, hit.distance);
                path.enter(self.scene, &hit, &point);
                true
            }
            Some(sample) if !is_last => {
                path.scatter(&point, &sample, event(&bsdf, wi, sample.is_delta));
                path.enter(self.scene, &hit, &point);
                self.survives(path, roulette)
            }
            _ => false,
        }
    }

    /// Passes hidden shapes, which the camera looks through. Mirrors show them, and so does a mask that is
    /// passed first.
    fn skip_shining(&mut self, path: &mut Path) {
        let world = self.scene.world();
        for _ in 0..MAX_SURFACES {
            match world.closest_hit(&path.ray, path.reach, &mut self.counters) {
                Some(hit) if self.shines[hit.shape as usize] => {
                    let point = world.bounce_point(&path.ray, &hit);
                    path.travel(self.scene, hit.distance);
                    path.pass(&point, hit.distance);
                    path.enter(self.scene, &hit, &point);
                }
                _ => return,
            }
        }
    }

    /// Counts the light that shines back along the path's ray.
    fn meet_emitter(&self, path: &mut Path, hit: Option<&Hit>) {
        let class = path.events.class_at_emitter();
        if !self.settings.classes.contains(class) {
            return;
        }
        let (emitted, weight) = match path.last {
            None => (self.lights.emitted(&path.ray, hit), 1.0),
            Some((from, of_surface)) => {
                let (emitted, of_emitter) = self.lights.emitted_and_pdf(from, &path.ray, hit);
                let way = self.settings.light_sampling;
                (emitted, way.weight_of_surface(of_surface, of_emitter))
            }
        };
        if emitted.is_black() {
            return;
        }
        path.radiance[class.index()] += path.throughput * emitted * weight;
    }

    /// Counts the light of an emitter that is chosen and tested for visibility (next-event estimation).
    fn sample_emitter(
        &mut self,
        path: &mut Path,
        (hit, point): (&Hit, &SurfacePoint),
        bsdf: &Bsdf,
        u: impl Fn() -> [f64; 3],
    ) {
        let wi = -path.ray.direction;
        let event = event(bsdf, wi, false);
        let class = path.events.then(event).class_at_emitter();
        let way = self.settings.light_sampling;
        if bsdf.is_delta() || !way.samples_emitters() || !self.settings.classes.contains(class) {
            return;
        }
        let Some(light) = self.lights.sample(point, u()) else {
            return;
        };
        let mut value = bsdf.eval(wi, light.direction, Transport::Radiance);
        if !light.is_delta {
            let of_surface = bsdf.pdf_solid_angle(wi, light.direction);
            value *= way.weight_of_emitter(light.pdf_solid_angle, of_surface);
        }
        if value.is_black() {
            return;
        }
        let passed = transmittance(
            self.scene,
            point,
            light.direction,
            light.reach,
            &mut self.counters,
        );
        let mut found = path.throughput * value * light.radiance_over_pdf * passed;
        if !self.scene.is_clear() && !found.is_black() {
            let n = point.geometric_normal;
            let scene = self.scene;
            let medium = scene.medium_beyond(hit.shape, n, light.direction, path.medium);
            let (towards, reach) = (light.direction, light.reach);
            let counters = &mut self.counters;
            found = found * media::left_on_way(scene, point, towards, reach, medium, counters);
        }
        path.radiance[class.index()] += found;
    }

    /// Russian roulette on a path that was just scattered, as in Mitsuba.
    ///
    /// It uses the throughput without the factor of refraction on radiance, which is undone when the light
    /// leaves the glass.
    fn survives(&self, path: &mut Path, roulette: f64) -> bool {
        let leg_before = path.legs - 1;
        if path.throughput.is_black() {
            return false;
        }
        if leg_before < self.settings.rr_depth {
            return true;
        }
        let survival = (path.throughput.max_channel() * path.eta * path.eta).min(MAX_SURVIVAL);
        path.throughput *= 1.0 / survival;
        roulette < survival
    }
}

/// The event of a path from `wi`.
#[inline]
fn event(bsdf: &Bsdf, wi: DVec3, is_delta: bool) -> PathEvent {
    if is_delta {
        PathEvent::Specular
    } else if bsdf.is_glossy(wi) {
        PathEvent::Glossy
    } else {
        PathEvent::Scattered
    }
}

impl Path {
    /// Goes `distance` through the medium that the ray is in.
    #[inline]
    fn travel(&mut self, scene: &Scene, distance: f64) {
        if self.medium != MediumId::CLEAR {
            self.throughput = self.throughput * scene.transmittance(self.medium, distance);
        }
    }

    /// Sets out into the medium beyond a surface, along its new ray.
    #[inline]
    fn enter(&mut self, scene: &Scene, hit: &Hit, point: &SurfacePoint) {
        if !scene.is_clear() {
            let (n, towards) = (point.geometric_normal, self.ray.direction);
            self.medium = scene.medium_beyond(hit.shape, n, towards, self.medium);
        }
    }

    /// Sends the path on, behind a surface that it passes.
    fn pass(&mut self, point: &SurfacePoint, distance: f64) {
        self.ray = point.spawn(self.ray.direction);
        self.reach -= distance;
    }

    /// Sends the path on, along a direction to which a surface scatters.
    fn scatter(&mut self, point: &SurfacePoint, sample: &BsdfSample, event: PathEvent) {
        // A pane does not turn light aside.
        let goes_straight =
            sample.is_delta && sample.scattering == Scattering::Transmitted && sample.eta == 1.0;
        self.is_straight &= goes_straight;
        self.last = (!sample.is_delta).then_some((point.position, sample.pdf_solid_angle));
        self.events = self.events.then(event);
        self.throughput = self.throughput * sample.weight;
        self.eta *= sample.eta;
        self.legs += 1;
        self.ray = point.spawn(sample.wo);
        self.reach = f64::INFINITY;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::{Stream, StreamKind};
    use crate::transport::camera::Camera;
    use glam::DVec2;

    fn load(file: &str) -> Scene {
        crate::mitsuba::load(file.as_ref(), &[]).expect("a shipped scene loads")
    }

    /// A scene's camera, and what its paths need.
    struct Viewed<'a> {
        scene: &'a Scene,
        lights: Lights<'a>,
        shines: Vec<bool>,
        camera: Camera,
    }

    impl<'s> Viewed<'s> {
        fn new(scene: &'s Scene) -> Self {
            let sensor = scene.sensors().iter().find(|it| it.id == "camera");
            let camera = Camera::new(scene, sensor.expect("a camera"));
            Self {
                scene,
                lights: Lights::new(scene),
                shines: shining_shapes(scene),
                camera: camera.expect("it can be sampled"),
            }
        }

        fn tracer<'a>(&'a self, settings: &'a PathSettings) -> Tracer<'a> {
            Tracer::new(self.scene, &self.lights, settings, &self.shines)
        }

        /// The ray through a place of the image, given in shares of its sides, and one of the lens.
        fn ray(&self, at: [f64; 2], lens: [f64; 2]) -> PixelRay {
            let size = DVec2::new(self.camera.width() as f64, self.camera.height() as f64);
            self.camera
                .ray_through(DVec2::from(at) * size, DVec2::from(lens))
        }
    }

    fn stream(count: u64) -> PaddedStream {
        PaddedStream::new(Stream::new(StreamKind::Sobol, 1), count)
    }

    #[test]
    fn paths_in_packets_bring_what_each_brings_alone() {
        let scene = load("scenes/glass-ball-mesh.xml");
        let viewed = Viewed::new(&scene);
        let (settings, stream) = (PathSettings::default(), stream(512));
        // A row of pixels through the ball.
        let row = |index: u64| {
            let share = (index as f64 + 0.5) / 512.0;
            let numbers = PathNumbers {
                stream: &stream,
                index,
            };
            (viewed.ray([share, 0.5], [0.5; 2]), numbers)
        };
        let views: Vec<_> = (0..512).map(row).collect();
        let mut tracer = viewed.tracer(&settings);
        let mut together = Vec::new();
        assert!(tracer.trace_all(&views, &mut together, &|| false));
        let counters = std::mem::take(&mut tracer.counters);
        let alone: Vec<_> = views
            .iter()
            .map(|(view, numbers)| tracer.trace(view, *numbers))
            .collect();
        assert_eq!(together, alone);
        assert_eq!(counters.rays, tracer.counters.rays);
        assert!(
            counters.node_visits < tracer.counters.node_visits,
            "none go down the tree together"
        );
    }

    #[test]
    fn paths_followed_together_bring_what_each_brings_alone() {
        let scene = load("scenes/cornell-glass.xml");
        let viewed = Viewed::new(&scene);
        for (max_depth, hide_emitters) in [(None, false), (Some(3), true)] {
            let settings = PathSettings {
                max_depth,
                hide_emitters,
                ..PathSettings::default()
            };
            let stream = stream(600);
            let anywhere = |index: u64| {
                let numbers = PathNumbers {
                    stream: &stream,
                    index,
                };
                let [u, v, s, t] = numbers.camera();
                (viewed.ray([u, v], [s, t]), numbers)
            };
            let views: Vec<_> = (0..600).map(anywhere).collect();
            let mut tracer = viewed.tracer(&settings);
            let mut together = Vec::new();
            assert!(tracer.trace_together(&views, &mut together, &|| false));
            let counters = std::mem::take(&mut tracer.counters);
            let alone: Vec<_> = views
                .iter()
                .map(|(view, numbers)| tracer.trace(view, *numbers))
                .collect();
            assert_eq!(together, alone);
            assert_eq!(counters, tracer.counters);
            let (many, mut ended) = (views.repeat(9), Vec::new());
            assert!(!tracer.trace_all(&many, &mut ended, &|| true));
            assert!(ended.len() < many.len(), "a stop is heard between rays");
            let lit = alone.iter().flatten().filter(|it| !it.is_black()).count();
            assert!(lit > 300, "only {lit} paths bring light: they test little");
        }
    }
}
