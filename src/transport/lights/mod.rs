//! Emitters as a point of the scene sees them: what a path that starts at a camera asks of light.
//!
//! Three questions, which multiple importance sampling (Veach 1997, chapter 9) puts together:
//!
//! | question | answered by |
//! |---|---|
//! | in which direction may light come from? | [`sample`](Lights::sample) |
//! | what does the light shine that this ray met? | [`emitted`](Lights::emitted) |
//! | how likely would `sample` have chosen this ray? | [`pdf_solid_angle`](Lights::pdf_solid_angle) |
//!
//! `sample` first chooses an emitter, all with the same probability as Mitsuba's `path` does, then a
//! direction towards it. Nobody has looked yet whether anything is in the way: see
//! [`visibility`](super::visibility) and [`LightSample::reach`]. So with any other sampling of directions
//! that has a density q, and w the weights of that sampling and this one (w + w' = 1),
//!
//! ```text
//! ∫ L f cos θ dω = E[ w'  radiance_over_pdf · visible · f cos θ ]  +  E_q[ w · emitted · f cos θ / q ]
//! ```
//!
//! A surface shines on its front only, which is where its *true* normal points (Mitsuba asks the shading normal of a
//! mesh; photons ask the true one, and so must every method that they are compared with).

mod area;
mod delta;
mod environment;
mod sphere;

use glam::DVec3;

use crate::geometry::{Hit, Ray, SurfacePoint};
use crate::radiometry::Rgb;
use crate::scene::{Emitter, Scene};
use crate::transport::domain::chart::Falloff;
use area::AreaLight;
use delta::DeltaLight;
use environment::{Environment, ImageLight};

/// All emitters of a scene, ready to be sampled.
#[derive(Clone, Debug)]
pub struct Lights<'a> {
    scene: &'a Scene,
    /// In the scene's order.
    list: Vec<Light<'a>>,
    /// For each shape, the index of the light that it is.
    of_shape: Vec<Option<u32>>,
    /// The index of the light all round.
    environment: Option<usize>,
}

/// One emitter.
// A scene holds a handful of them: boxing the large variant would only cost clarity.
#[allow(clippy::large_enum_variant)]
#[derive(Clone, Debug)]
enum Light<'a> {
    Delta(DeltaLight),
    Area(AreaLight<'a>),
    Environment(Environment<'a>),
}

/// A direction from which light may come to a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// From the point to the light, a unit vector.
    pub direction: DVec3,
    /// How far away the light is; infinite for parallel light and environments.
    pub distance: f64,
    /// How far a shadow ray goes: up to the light but not onto it, whatever was rounded.
    pub reach: f64,
    /// What the light brings if nothing is in the way: radiance [W/m²/sr] by `pdf_solid_angle`, that is
    /// irradiance across the direction [W/m²] for a delta light, by the probability of its choice.
    pub radiance_over_pdf: Rgb,
    /// The density of `direction` [1/sr], the choice of the emitter included; for a delta light the probability
    /// of that choice.
    pub pdf_solid_angle: f64,
    /// Whether no other sampling can find this light: a delta light, of weight 1.
    pub is_delta: bool,
    /// Index into [`Scene::emitters`].
    pub emitter: usize,
}

impl<'a> Lights<'a> {
    /// The emitters of `scene`; all of them can be sampled.
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
                    Light::Area(AreaLight::new(scene, *shape, *radiance, *texture))
                }
                Emitter::Point {
                    position,
                    intensity,
                } => Light::Delta(DeltaLight::at(*position, *intensity, Falloff::None)),
                Emitter::Spot {
                    to_world,
                    intensity,
                    ..
                } => {
                    let position = to_world.point(DVec3::ZERO);
                    Light::Delta(DeltaLight::at(position, *intensity, Falloff::of(emitter)))
                }
                Emitter::Directional {
                    direction,
                    irradiance,
                } => Light::Delta(DeltaLight::far_away(*direction, *irradiance)),
                Emitter::Constant { radiance } => {
                    Light::Environment(Environment::Constant(*radiance))
                }
                Emitter::Envmap(map) => {
                    Light::Environment(Environment::Image(ImageLight::new(map)))
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

    /// A direction from which light may come to `point`; `None` where the emitter chosen sends nothing there.
    ///
    /// `u` are uniform in [0, 1): the first chooses the emitter. No direction of `point`'s own surface is left out:
    /// whether it scatters light from there is the bsdf's business.
    pub fn sample(&self, point: &SurfacePoint, u: [f64; 3]) -> Option<LightSample> {
        let count = self.list.len();
        let emitter = ((u[0] * count as f64) as usize).min(count.checked_sub(1)?);
        let sample = match &self.list[emitter] {
            Light::Delta(light) => light.sample(point),
            Light::Area(light) => light.sample(point, [u[1], u[2]]),
            Light::Environment(light) => light.sample([u[1], u[2]]),
        }?;
        Some(LightSample {
            radiance_over_pdf: sample.radiance_over_pdf * count as f64,
            pdf_solid_angle: sample.pdf_solid_angle / count as f64,
            emitter,
            ..sample
        })
    }

    /// Radiance [W/m²/sr] that comes back along a ray from what it met: the front side of an area
    /// light, or the environment.
    ///
    /// `hit` is what the ray met first, `None` where it left the scene. Delta lights are never met.
    pub fn emitted(&self, ray: &Ray, hit: Option<&Hit>) -> Rgb {
        match self.met(hit) {
            Some(Met::Surface(light, hit)) => light.emitted(ray, hit),
            Some(Met::Environment(light)) => light.radiance(ray.direction),
            None => Rgb::BLACK,
        }
    }

    /// The density [1/sr] with which [`sample`](Self::sample) at `from` chooses the ray's direction for the light
    /// that the ray met: zero where that sends nothing along the ray.
    ///
    /// The ray may start elsewhere on the line, as it does behind null surfaces.
    pub fn pdf_solid_angle(&self, from: DVec3, ray: &Ray, hit: Option<&Hit>) -> f64 {
        let pdf = match self.met(hit) {
            Some(Met::Surface(light, hit)) => {
                let point = self.scene.world().bounce_point(ray, hit);
                light.pdf_solid_angle(from, &point, ray.direction)
            }
            Some(Met::Environment(light)) => light.pdf_solid_angle(ray.direction),
            None => 0.0,
        };
        pdf / self.list.len().max(1) as f64
    }

    /// The light that a ray met, if what it met can shine.
    fn met<'b>(&'b self, hit: Option<&'b Hit>) -> Option<Met<'b, 'a>> {
        let index = match hit {
            Some(hit) => self.of_shape[hit.shape as usize]? as usize,
            None => self.environment?,
        };
        match (&self.list[index], hit) {
            (Light::Area(light), Some(hit)) => Some(Met::Surface(light, hit)),
            (Light::Environment(light), None) => Some(Met::Environment(light)),
            _ => None,
        }
    }
}

/// What a ray met that can shine.
enum Met<'b, 'a> {
    Surface(&'b AreaLight<'a>, &'b Hit),
    Environment(&'b Environment<'a>),
}
