//! What beams of any signature need of a scene.

use super::film::BeamFilm;
use super::light::BeamLight;
use super::limit::Limit;
use super::pass::Passes;
use super::settings::BeamSettings;
use super::support::supports;
use crate::reference::target::Target;
use crate::run::{Error, Progress};
use crate::scene::{Scene, Sensor};
use crate::setting::SettingError;
use crate::transport::camera::Camera;
use crate::transport::clearance::Clearance;
use crate::transport::facets::table::Facets;
use crate::transport::first_surface::SharedPlaces;
use crate::transport::scatter::ShadingNormals;
use crate::transport::signature::MAX_EVENTS;

/// A scene and a sensor, set up for beams.
pub struct BeamInputs<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The sensor.
    pub target: Target,
    /// The light of all emitters.
    pub lights: Vec<BeamLight>,
    clearance: Clearance<'a>,
    shared: SharedPlaces<'a>,
    pub(in crate::reference) facets: Facets,
    shading_normals: ShadingNormals,
}

impl<'a> BeamInputs<'a> {
    /// Finds the first surfaces.
    ///
    /// # Errors
    ///
    /// If the sensor cannot receive, or beams cannot follow an emitter or a material.
    pub fn new(
        scene: &'a Scene,
        sensor: &'a Sensor,
        settings: BeamSettings,
    ) -> Result<Self, Error> {
        supports(scene)?;
        if settings.max_depth as usize > MAX_EVENTS {
            let depth = settings.max_depth.to_string();
            let allowed = format!("0 to {MAX_EVENTS} specular events");
            return Err(SettingError::value("max-depth", &depth, allowed).into());
        }
        let shading_normals = settings.shading_normals;
        let target = Target::new(scene, sensor, shading_normals, Camera::new)?;
        Ok(Self {
            scene,
            target,
            lights: BeamLight::all(scene),
            clearance: Clearance::new(scene),
            shared: SharedPlaces::new(scene, shading_normals),
            facets: Facets::new(scene),
            shading_normals,
        })
    }

    /// Memory \[bytes\] of one signature's film.
    pub fn film_bytes(&self) -> usize {
        let size = self.target.size();
        match self.target.channels(self.scene) {
            1 => BeamFilm::<1>::bytes(size),
            _ => BeamFilm::<3>::bytes(size),
        }
    }

    /// The inputs of passes for films with room for `flux` \[W\], about.
    pub fn passes<'p>(
        &'p self,
        flux: f64,
        limit: &'p Limit<'p>,
        progress: &'p Progress,
    ) -> Passes<'p> {
        Passes {
            scene: self.scene,
            target: &self.target,
            clearance: &self.clearance,
            shared: &self.shared,
            facets: &self.facets,
            shading_normals: self.shading_normals,
            flux,
            limit,
            progress,
        }
    }
}
