//! All emitters of a scene together.

use glam::DVec3;

use super::area::AreaLight;
use super::delta::{DeltaLight, NormalLights};
use super::environment::Environment;
use super::sample::LightSample;
use crate::geometry::{Hit, Ray, SurfacePoint};
use crate::radiometry::Rgb;
use crate::scene::{Emitter, Scene};
use crate::transport::domain::chart::Falloff;

/// All emitters of a scene, ready to be sampled.
#[derive(Clone, Debug)]
pub struct Lights<'a> {
    scene: &'a Scene,
    /// The emitters in the scene's order.
    list: Vec<SceneLight<'a>>,
    /// For each shape, the index of its light.
    of_shape: Vec<Option<u32>>,
    /// The index of the environment.
    environment: Option<usize>,
}

/// One emitter.
// A scene holds a handful of lights: boxing the large variant would only cost clarity.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug)]
enum SceneLight<'a> {
    Delta(DeltaLight<'a>),
    Normal(NormalLights),
    Area(AreaLight<'a>),
    Environment(Environment<'a>),
}

impl<'a> Lights<'a> {
    /// The emitters of `scene`, all of which can be sampled.
    pub fn new(scene: &'a Scene) -> Self {
        let mut of_shape = vec![None; scene.world().shapes().len()];
        let environment = scene.emitters().iter().position(Emitter::is_environment);
        let emitters = scene.emitters().iter().enumerate();
        let list = emitters
            .map(|(index, emitter)| match emitter {
                Emitter::Area {
                    shape,
                    radiance,
                    texture,
                } => {
                    // A scene has at most one emitter a shape, and fewer than 2³² of them.
                    of_shape[shape.0 as usize] = Some(index as u32);
                    SceneLight::Area(AreaLight::new(scene, *shape, *radiance, *texture))
                }
                Emitter::Point {
                    position,
                    intensity,
                } => SceneLight::Delta(DeltaLight::at(*position, *intensity, Falloff::None)),
                Emitter::Spot {
                    to_world,
                    intensity,
                    ..
                } => {
                    let position = to_world.point(DVec3::ZERO);
                    let light = DeltaLight::at(position, *intensity, Falloff::of(emitter));
                    SceneLight::Delta(light.through(emitter))
                }
                Emitter::Projector { slide, irradiance } => {
                    let light = DeltaLight::at(slide.origin(), *irradiance, Falloff::None);
                    SceneLight::Delta(light.through(emitter))
                }
                Emitter::Directional {
                    direction,
                    irradiance,
                } => SceneLight::Delta(DeltaLight::far_away(*direction, *irradiance)),
                Emitter::DirectionalArea { .. } => {
                    SceneLight::Normal(NormalLights::new(scene, emitter))
                }
                Emitter::Constant { radiance } => {
                    SceneLight::Environment(Environment::Constant(*radiance))
                }
                Emitter::Envmap(map) => SceneLight::Environment(Environment::image(map)),
                Emitter::Sunsky(daylight) => {
                    SceneLight::Environment(Environment::daylight(daylight))
                }
            })
            .collect();
        Self {
            scene,
            list,
            of_shape,
            environment,
        }
    }

    /// True if there are no emitters.
    pub fn is_empty(&self) -> bool {
        self.list.is_empty()
    }

    /// A direction from which light may come to `point`; `None` if the emitter chosen sends nothing there.
    ///
    /// `u` are uniform in [0, 1): the first chooses the emitter. No direction of `point`'s own surface is
    /// left out: the bsdf decides if light from there is scattered.
    pub fn sample(&self, point: &SurfacePoint, u: [f64; 3]) -> Option<LightSample> {
        let count = self.list.len();
        let emitter = ((u[0] * count as f64) as usize).min(count.checked_sub(1)?);
        let sample = match &self.list[emitter] {
            SceneLight::Delta(light) => light.sample(point),
            SceneLight::Normal(light) => light.sample(point, u[1]),
            SceneLight::Area(light) => light.sample(point, [u[1], u[2]]),
            SceneLight::Environment(light) => light.sample([u[1], u[2]]),
        }?;
        Some(LightSample {
            radiance_over_pdf: sample.radiance_over_pdf * count as f64,
            pdf_solid_angle: sample.pdf_solid_angle / count as f64,
            emitter,
            ..sample
        })
    }

    /// Radiance [W/m²/sr] that comes back along a ray, from the front of an area light or the environment.
    ///
    /// `hit` is the first thing that the ray met, `None` if it left the scene. Rays never meet delta lights.
    pub fn emitted(&self, ray: &Ray, hit: Option<&Hit>) -> Rgb {
        match self.met(hit) {
            Some(LightHit::Surface(light, hit)) => light.emitted(ray, hit),
            Some(LightHit::Environment(light)) => light.radiance(ray.direction),
            None => Rgb::BLACK,
        }
    }

    /// [`Self::emitted`], and the density [1/sr] with which [`sample`](Self::sample) at `from` chooses the
    /// ray's direction for the light that the ray met. It is zero if that light sends nothing along the ray.
    ///
    /// The ray may start elsewhere on the line, as it does behind null surfaces.
    pub fn emitted_and_pdf(&self, from: DVec3, ray: &Ray, hit: Option<&Hit>) -> (Rgb, f64) {
        let (emitted, pdf) = match self.met(hit) {
            Some(LightHit::Surface(light, hit)) => {
                let emitted = light.emitted(ray, hit);
                if emitted.is_black() {
                    return (emitted, 0.0);
                }
                let point = self.scene.world().bounce_point(ray, hit);
                let pdf = light.pdf_solid_angle(from, hit.face, &point, ray.direction);
                (emitted, pdf)
            }
            Some(LightHit::Environment(light)) => light.radiance_and_pdf(ray.direction),
            None => (Rgb::BLACK, 0.0),
        };
        (emitted, pdf / self.list.len().max(1) as f64)
    }

    /// The light that a ray met, if there is one.
    fn met<'b>(&'b self, hit: Option<&'b Hit>) -> Option<LightHit<'b, 'a>> {
        let index = match hit {
            Some(hit) => self.of_shape[hit.shape as usize]? as usize,
            None => self.environment?,
        };
        match (&self.list[index], hit) {
            (SceneLight::Area(light), Some(hit)) => Some(LightHit::Surface(light, hit)),
            (SceneLight::Environment(light), None) => Some(LightHit::Environment(light)),
            _ => None,
        }
    }
}

/// A light that a ray met.
enum LightHit<'b, 'a> {
    Surface(&'b AreaLight<'a>, &'b Hit),
    Environment(&'b Environment<'a>),
}
