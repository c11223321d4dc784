//! Area lights as many sources, each of one place on the light.
//!
//! Let x be uniform over the light's surface of area A. A caustic is the mean of those of sources at x that
//! shine with radiant intensity L A cos θ. The mean of one replicate is over n places that follow a scrambled
//! Sobol' sequence. Replicates are scrambled independently; their scatter is the error of their mean (Owen
//! 1997, *Scrambled net variance for integrals of smooth functions*).

use super::pass::BeamLight;
use super::support::refuse_area_light;
use crate::numeric::{Stream, StreamKind};
use crate::radiometry::Rgb;
use crate::run::Refusal;
use crate::scene::{Emitter, Scene};
use crate::transport::domain::surface::LightSurface;
use crate::transport::first_surface::Source;

/// The area lights of a scene that shine at all.
#[derive(Clone, Debug, Default)]
pub struct AreaLights {
    lights: Vec<AreaLight>,
}

#[derive(Clone, Debug)]
struct AreaLight {
    surface: LightSurface,
    radiance: Rgb,
    stream: Stream,
}

impl AreaLights {
    /// The area lights of a scene, with streams of `seed`.
    ///
    /// # Errors
    ///
    /// If the shape of an area light is one that light cannot start from.
    pub fn new(scene: &Scene, seed: u64) -> Result<Self, Refusal> {
        // "BEAM": apart from the streams of other uses of the same seed.
        let stream = Stream::new(StreamKind::Sobol, seed).split(0x4245_414d);
        let mut lights = Vec::new();
        for (index, emitter) in scene.emitters().iter().enumerate() {
            let Emitter::Area {
                shape, radiance, ..
            } = emitter
            else {
                continue;
            };
            if radiance.is_black() {
                continue;
            }
            let surface = LightSurface::new(&scene.world().shapes()[shape.0 as usize])
                .ok_or_else(|| refuse_area_light(scene, index, shape.0 as usize))?;
            lights.push(AreaLight {
                surface,
                radiance: *radiance,
                stream: stream.split(index as u64),
            });
        }
        Ok(Self { lights })
    }

    /// True if there are none.
    pub fn is_empty(&self) -> bool {
        self.lights.is_empty()
    }

    /// The sources of a replicate: `points` for each area light, each with its part of the light.
    ///
    /// The sources for twice as many points begin with the same places.
    pub fn lights(&self, replicate: u32, points: u64) -> Vec<BeamLight> {
        let mut lights = Vec::new();
        for area_light in &self.lights {
            let stream = area_light.stream.split(u64::from(replicate));
            let intensity = area_light.radiance * (area_light.surface.area() / points as f64);
            lights.extend((0..points).filter_map(|point| {
                let place = area_light.surface.sample(stream.point2(point).into())?;
                let source = Source::Surface { place, intensity };
                Some(BeamLight {
                    source,
                    patches: None,
                })
            }));
        }
        lights
    }
}
