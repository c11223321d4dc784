//! The sensor and the method that suit what is asked for: one place for the program and for Python.

use super::Method;
use super::sensors::{choose_camera, choose_sensor};
use crate::run::Error;
use crate::scene::{ReconstructionFilter, Scene, Sensor};
use crate::setting::{Given, SettingError};

/// A wish for a run; what is left open is chosen by the scene.
#[derive(Clone, Copy, Debug)]
pub struct Wanted<'a> {
    /// The sensor's id.
    pub sensor: Option<&'a str>,
    /// The method's name.
    pub method: Option<&'a str>,
    /// Settings as text.
    pub given: &'a Given,
    /// True if a part of a run is asked for.
    pub is_shard: bool,
    /// Another filter of the film than the scene's.
    pub filter: Option<ReconstructionFilter>,
}

/// The sensor and the method of a run.
#[derive(Clone, Debug)]
pub struct Chosen {
    /// The sensor, with the filter asked for.
    pub sensor: Sensor,
    /// The method.
    pub method: Method,
    /// A notice if the method is not what one would expect.
    pub notice: Option<String>,
}

impl Wanted<'_> {
    /// The sensor and the method asked for, or those that suit the scene. A scene that has cameras alone is
    /// seen by the first. `typed` tells a setting's key as it was typed, for the notice.
    ///
    /// # Errors
    ///
    /// For a sensor, a method or a setting that does not exist.
    pub fn choose(&self, scene: &Scene, typed: &dyn Fn(&str) -> String) -> Result<Chosen, Error> {
        // Settings of another method are better known before the scene is looked at.
        let is_of_cameras = match self.method {
            Some(name) => Method::new(name, &Given::new())?.is_of_cameras(),
            None => false,
        };
        let is_open = self.sensor.is_none() && self.method.is_none() && !self.is_shard;
        let sensors = scene.sensors();
        let are_cameras = !sensors.is_empty() && sensors.iter().all(Sensor::is_camera);
        // Light that dispersion takes apart is for photons, whatever they see.
        let is_seen = is_open && are_cameras && scene.dispersion().is_empty();
        let sensor = if is_of_cameras || (is_open && are_cameras) {
            choose_camera(scene, self.sensor)?
        } else {
            choose_sensor(scene, self.sensor)?
        };
        let mut sensor = sensor.clone();
        if let Some(filter) = self.filter {
            sensor.film.filter = filter;
        }
        let (method, notice) = if is_seen {
            self.choose_view(scene, &sensor)?
        } else {
            self.choose_method(scene, &sensor, typed)?
        };
        Ok(Chosen {
            sensor,
            method,
            notice,
        })
    }

    /// The method that makes a picture of all light: all methods together. Settings of one method alone
    /// choose it.
    fn choose_view(
        &self,
        scene: &Scene,
        sensor: &Sensor,
    ) -> Result<(Method, Option<String>), SettingError> {
        let of = |name: &str| Method::new(name, self.given);
        let seen = format!(
            "no sensor is an irradiancemeter: camera \"{}\" is rendered",
            sensor.id
        );
        let Ok(full) = of("full") else {
            let method = match of("path") {
                Ok(path) => path,
                Err(_) => Method::choose_with(scene, sensor, self.given)?.method,
            };
            let notice = format!("{seen} by {}, whose settings are given", method.name());
            return Ok((method, Some(notice)));
        };
        Ok((full, Some(format!("{seen} by full, with all of its light"))))
    }

    /// The method asked for, or the one that suits the scene and the settings, with a notice if it is not
    /// what one would expect.
    fn choose_method(
        &self,
        scene: &Scene,
        sensor: &Sensor,
        typed: &dyn Fn(&str) -> String,
    ) -> Result<(Method, Option<String>), SettingError> {
        let name = self.method.or(self.is_shard.then_some("photons"));
        if let Some(name) = name {
            return Ok((Method::new(name, self.given)?, None));
        }
        let choice = Method::choose_with(scene, sensor, self.given)?;
        // Whoever gives an amount of work knows the method whose work that is.
        let work_key = choice.method.work_key();
        let is_work = work_key.is_some_and(|key| self.given.contains_key(key));
        let notice = match choice.by_setting {
            // The reason begins with the setting.
            Some(key) => (!is_work).then(|| choice.reason.replacen(&key, &typed(&key), 1)),
            None => (choice.by_forecast && !is_work)
                .then(|| format!("photons measure all light: {}", choice.reason)),
        };
        Ok((choice.method, notice))
    }
}
