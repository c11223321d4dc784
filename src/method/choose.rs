//! The method that suits a scene and a sensor.

use std::collections::BTreeMap;

use super::Method;
use super::entry::Entry;
use super::memory::is_camera;
use crate::scene::{Scene, Sensor};
use crate::setting::{Given, SettingError};

/// A method, and the reason for which it was chosen.
///
/// # Example: the reason in a log
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// let choice = nephroid::Method::choose(&scene, sensor)?;
/// println!("{}: {}", choice.method.name(), choice.reason);
/// assert_eq!(choice.by_setting, None, "the scene alone decided");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq)]
pub struct Choice {
    /// The method.
    pub method: Method,
    /// The reason, in a sentence.
    pub reason: String,
    /// The setting that led to another method than the scene alone would have.
    pub by_setting: Option<String>,
}

impl Method {
    /// The method that suits a scene and a sensor, and why: beams if they can follow all light without drawing at
    /// random, else photons.
    ///
    /// # Errors
    ///
    /// None for the defaults; see [`Method::choose_with`] for settings that fit no method.
    ///
    /// # Example
    ///
    /// ```
    /// # fn main() -> Result<(), Box<dyn std::error::Error>> {
    /// let scene = nephroid::load("scenes/cornell-glass.xml".as_ref(), &[])?;
    /// let choice = nephroid::Method::choose(&scene, &scene.sensors()[0])?;
    /// assert_eq!(choice.method.name(), "photons");
    /// assert!(choice.reason.contains("area light"));
    /// # Ok(())
    /// # }
    /// ```
    pub fn choose(scene: &Scene, sensor: &Sensor) -> Result<Choice, SettingError> {
        Self::choose_with(scene, sensor, &Given::new())
    }

    /// The method that suits a scene, a sensor and settings: the one that the scene suggests if it has them all, else
    /// the first that has.
    ///
    /// # Errors
    ///
    /// If no method has all settings, or a value cannot be.
    ///
    /// # Example: a seed asks for a method that draws at random
    ///
    /// ```
    /// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
    /// # let sensor = &scene.sensors()[0];
    /// let settings = [("seed".to_owned(), "7".to_owned())].into();
    /// let choice = nephroid::Method::choose_with(&scene, sensor, &settings)?;
    /// assert_eq!(choice.method.name(), "photons");
    /// assert_eq!(choice.by_setting.as_deref(), Some("seed"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn choose_with(
        scene: &Scene,
        sensor: &Sensor,
        settings: &BTreeMap<String, String>,
    ) -> Result<Choice, SettingError> {
        let (best, reason) = best(scene, sensor);
        let lacks = |entry: Entry| {
            let table = entry.table();
            let mut keys = settings.keys();
            keys.find(|key| {
                let is_known = table.iter().any(|row| row.key == **key);
                let is_ignored = matches!(entry, Entry::Reference(one) if one.ignores(scene, key));
                !is_known || is_ignored
            })
        };
        let Some(key) = lacks(best) else {
            return Ok(Choice {
                method: Self::new(best.name(), settings)?,
                reason,
                by_setting: None,
            });
        };
        let others = || Entry::all().filter(|entry| matches!(entry, Entry::Reference(_)));
        let fits = |entry: &Entry| lacks(*entry).is_none();
        let found = others().find(fits).or_else(|| {
            // Settings of several methods: the one of the first that has this key says what is wrong.
            others().find(|entry| entry.table().iter().any(|row| row.key == key.as_str()))
        });
        let entry = found.unwrap_or(best);
        Ok(Choice {
            method: Self::new(entry.name(), settings)?,
            reason: format!(
                "{key} is a setting of {}, not of {}",
                entry.name(),
                best.name()
            ),
            by_setting: Some(key.clone()),
        })
    }
}

/// The method that a scene alone suggests, and why.
fn best(scene: &Scene, sensor: &Sensor) -> (Entry, String) {
    let find = |name: &str| Entry::all().find(|entry| entry.name() == name);
    let all = || Entry::all().next();
    let measured = if is_camera(sensor) {
        "the light that mirrors and glass bring to what the camera sees"
    } else {
        "the light on the sensor"
    };
    // The list of methods begins with beams, and photons are in it.
    let (Some(beams), Some(photons)) = (find("beams").or_else(all), find("photons").or_else(all))
    else {
        unreachable!("there are methods");
    };
    let values = crate::setting::Values::new(beams.name(), beams.table(), &Given::new());
    let refusal = match values {
        Ok(values) => beams.supports(scene, sensor, &values).err(),
        Err(_) => None,
    };
    let draws = !matches!(beams, Entry::Reference(one) if one.ignores(scene, "seed"));
    match refusal {
        Some(refusal) => (photons, format!("beams cannot follow all light: {refusal}")),
        None if draws => (
            photons,
            "an area light shines: beams would draw places on it at random, and photons are sooner at the same error"
                .to_owned(),
        ),
        None => (
            beams,
            format!("no light has a size: beams know {measured} without noise, with bounds"),
        ),
    }
}
