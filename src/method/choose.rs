//! The method that suits a scene and a sensor.

use std::collections::{BTreeMap, BTreeSet};

use super::Method;
use super::entry::Entry;
use super::references::beams;
use super::table;
use crate::reference::beams::{DEFAULT_ERROR, MOST_RAYS};
use crate::run::format::{percent, time};
use crate::scene::{Scene, Sensor};
use crate::setting::{Given, SettingError, Values};
use crate::transport::camera::Camera;
use crate::transport::chain_limits::{first_coat, first_rough};
use crate::transport::domain::LightSpace;

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
    /// The setting that the method which would suit without it does not have.
    pub by_setting: Option<String>,
    /// True if beams can follow all light, but would take too long.
    pub by_forecast: bool,
}

/// The method that suits, but for settings that it does not have.
struct Best {
    entry: Entry,
    reason: String,
    by_forecast: bool,
}

impl Best {
    /// A method that suits whatever beams would take.
    fn new(entry: Entry, reason: String) -> Self {
        Self {
            entry,
            reason,
            by_forecast: false,
        }
    }
}

impl Method {
    /// The method that suits a scene and a sensor, and why: beams if they can follow all light, and end, else
    /// photons.
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

    /// The method that suits a scene, a sensor and settings: the one that the scene suggests if it has them
    /// all, else the first that has.
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
        let Best {
            entry: best,
            reason,
            by_forecast,
        } = best(scene, sensor, settings)?;
        let lacks = |entry: Entry| settings.keys().find(|key| !has(entry, key));
        let Some(key) = lacks(best) else {
            return Ok(Choice {
                method: Self::new(best.name(), settings)?,
                reason,
                by_setting: None,
                by_forecast,
            });
        };
        let others = || Entry::references().map(Entry::Reference);
        let fits = |entry: &Entry| lacks(*entry).is_none();
        let unknown = settings.keys().find(|key| table::owners(key).is_empty());
        if let Some(unknown) = unknown {
            let all = || Entry::all().flat_map(Entry::table).map(|row| row.key);
            let names: BTreeSet<&str> = all().collect();
            return Err(SettingError::unknown("setting", unknown, names));
        }
        let found = others().find(fits).or_else(|| {
            // Settings of several methods: the one of the first that has this key says what is wrong.
            others().find(|entry| has(*entry, key))
        });
        let (name, best_name) = (found.unwrap_or(best).name(), best.name());
        Ok(Choice {
            method: Self::new(name, settings)?,
            reason: format!(
                "{key} is a setting of {name}, not of {best_name}; without it, {best_name} would suit: {reason}"
            ),
            by_setting: Some(key.clone()),
            by_forecast: false,
        })
    }
}

fn has(entry: Entry, key: &str) -> bool {
    entry.table().iter().any(|row| row.key == key)
}

/// Most texels of a film on which beams are forecast here: a choice is to take little time and memory. The
/// run on a larger one says itself how long it will take.
const MOST_TEXELS: u64 = 1 << 20;

/// The method that a scene suggests, and why. Settings tell how much is asked of beams.
fn best(scene: &Scene, sensor: &Sensor, given: &Given) -> Result<Best, SettingError> {
    let measured = if sensor.is_camera() {
        "the light that mirrors and glass bring to what the camera sees"
    } else {
        "the light on the sensor"
    };
    let (best, photons) = (Entry::of("beams")?, Entry::of("photons")?);
    // Settings that only one of them has choose a method by themselves: the reason is that of the choice
    // without them.
    let is_of_both = given.keys().all(|key| has(best, key) && has(photons, key));
    let given = if is_of_both { given } else { &Given::new() };
    let values = Values::new(best.name(), best.table(), given)?;
    if let Err(refusal) = best.supports(scene, sensor, &values) {
        let other = Entry::of(instead_of_beams(scene, sensor))?;
        let reason = format!("beams cannot follow all light: {refusal}");
        return Ok(Best::new(other, reason));
    }
    if let Some(best) = of_camera(scene, sensor)? {
        return Ok(best);
    }
    if let Some(rough) = first_rough(scene) {
        let reason = format!(
            "beams cannot follow all light: {rough} is rough, and scatters it in many directions"
        );
        return Ok(Best::new(photons, reason));
    }
    if let Some(coat) = first_coat(scene) {
        let reason =
            format!("beams cannot follow all light: the coat of {coat} mirrors some percent of it");
        return Ok(Best::new(photons, reason));
    }
    let crop = &sensor.film.crop;
    let texels = u64::from(crop.width) * u64::from(crop.height);
    // To less than the default error photons take far longer than beams, however long these take.
    let error = values.fraction("error").unwrap_or(DEFAULT_ERROR);
    let error = error.max(DEFAULT_ERROR);
    // If the sensor cannot receive, beams say why.
    let forecast = (texels <= MOST_TEXELS)
        .then(|| beams::forecast(scene, sensor, &values, error).ok())
        .flatten()
        .unwrap_or_default();
    if forecast.rays > MOST_RAYS {
        let reason = format!(
            "beams would take about {} to an error of {}, as some light goes by chaotic chains of mirrors and glass",
            time(forecast.time),
            percent(error),
        );
        return Ok(Best {
            entry: photons,
            reason,
            by_forecast: true,
        });
    }
    let noise = if forecast.by_photons {
        "with bounds, and leave to photons what goes by chaotic chains of mirrors and glass"
    } else {
        "without noise, with bounds"
    };
    let reason = format!("no light has a size: beams know {measured} {noise}");
    Ok(Best::new(best, reason))
}

/// The method for light that beams cannot follow. If photons cannot follow it either, paths from the camera
/// find what they can.
fn instead_of_beams(scene: &Scene, sensor: &Sensor) -> &'static str {
    match (LightSpace::check(scene), sensor.is_camera()) {
        (_, false) => "photons",
        (Err(_), true) => "path",
        (Ok(()), true) => for_camera(scene, sensor),
    }
}

/// Photons for a camera that light can be connected to, else photon maps.
fn for_camera(scene: &Scene, sensor: &Sensor) -> &'static str {
    if Camera::connectable(scene, sensor).is_ok() {
        "photons"
    } else {
        "photon-map"
    }
}

/// The method for a camera that beams cannot fill, and why.
fn of_camera(scene: &Scene, sensor: &Sensor) -> Result<Option<Best>, SettingError> {
    if !sensor.is_camera() {
        return Ok(None);
    }
    let Err(error) = Camera::new(scene, sensor) else {
        return Ok(None);
    };
    let entry = Entry::of(for_camera(scene, sensor))?;
    let reason = format!("beams cannot fill this camera: {error}");
    Ok(Some(Best::new(entry, reason)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_in_chaotic_chains_is_for_photons_which_end() {
        // Three parts in a hundred of its light are mirrored again and again within a bumpy ball of glass.
        let chosen = choice("scenes/turntable-bumpy.xml", &[]).unwrap();
        assert_eq!(chosen.method.name(), "photons");
        assert!(chosen.reason.contains("chaotic"), "{}", chosen.reason);
        assert!(chosen.by_forecast && chosen.by_setting.is_none());
        let smooth = choice("scenes/turntable-ball.xml", &[]).unwrap();
        assert_eq!(smooth.method.name(), "beams");
    }

    #[test]
    fn a_method_is_chosen_by_the_error_and_the_depth_asked_for() {
        let bumpy =
            |settings: &[(&str, &str)]| choice("scenes/turntable-bumpy.xml", settings).unwrap();
        // To a percent, photons measure chaotic light for beams, and some seconds' work is left.
        let divided = bumpy(&[("error", "1%")]);
        assert_eq!(divided.method.name(), "beams");
        assert!(
            divided.reason.contains("leave to photons"),
            "{}",
            divided.reason
        );
        // Two events are not chaotic.
        assert_eq!(bumpy(&[("max-depth", "2")]).method.name(), "beams");
        // To a millionth, beams take long and photons for ever.
        let fine = choice("scenes/coffee-cup.xml", &[("error", "0.0001%")]).unwrap();
        assert_eq!(fine.method.name(), "beams");
        // A setting of beams alone decides, too, and the reason says what would have been without it.
        let typed = bumpy(&[("chaotic", "photons")]);
        assert_eq!(
            (typed.method.name(), typed.by_setting.as_deref()),
            ("beams", Some("chaotic"))
        );
        assert!(
            typed.reason.contains("to an error of 0.100 %"),
            "{}",
            typed.reason
        );
    }

    fn choice(scene: &str, settings: &[(&str, &str)]) -> Result<Choice, SettingError> {
        let scene = crate::mitsuba::load(scene.as_ref(), &[]).unwrap();
        let owned = |(key, value): &(&str, &str)| ((*key).to_owned(), (*value).to_owned());
        let given = settings.iter().map(owned).collect();
        Method::choose_with(&scene, &scene.sensors()[0], &given)
    }

    #[test]
    fn a_setting_that_the_method_does_not_have_is_named() {
        let of_samples = choice("scenes/glass-ball.xml", &[("samples", "random")]).unwrap();
        assert_eq!(of_samples.method.name(), "photons");
        let reason = "samples is a setting of photons, not of beams; without it, beams would suit";
        assert!(
            of_samples.reason.starts_with(reason),
            "{}",
            of_samples.reason
        );
    }

    #[test]
    fn lights_without_size_are_left_to_beams_and_others_to_photons() {
        let of_point = choice("scenes/glass-ball.xml", &[]).unwrap();
        assert_eq!(of_point.method.name(), "beams");
        let scene = crate::mitsuba::load("scenes/cornell-glass.xml".as_ref(), &[]).unwrap();
        let mut meters = scene.sensors().iter().filter(|one| !one.is_camera());
        let of_area = Method::choose(&scene, meters.next().unwrap()).unwrap();
        assert_eq!(of_area.method.name(), "photons");
        let reason = "beams cannot follow all light: emitter 0 is an area light on shape";
        assert!(of_area.reason.starts_with(reason), "{}", of_area.reason);
    }

    #[test]
    fn settings_of_one_method_alone_choose_it() {
        let name = |settings: &[(&str, &str)]| {
            let choice = choice("scenes/glass-ball.xml", settings).unwrap();
            choice.method.name()
        };
        assert_eq!(name(&[("max-depth", "3"), ("error", "1%")]), "beams");
        assert_eq!(name(&[("photons", "64"), ("seed", "1")]), "photons");
        assert_eq!(name(&[("spp", "4"), ("seed", "1")]), "path");
        // Legs, which beams do not have so many of.
        assert_eq!(name(&[("spp", "4"), ("max-depth", "200")]), "path");
        assert_eq!(name(&[("seen", "directly")]), "photon-map");
        assert_eq!(name(&[("spp", "4"), ("photons", "64")]), "full");
        assert!(choice("scenes/glass-ball.xml", &[("rays", "4"), ("spp", "4")]).is_err());
    }
}
