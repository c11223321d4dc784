//! A method with the settings that a study sweeps.

use crate::method::Method;
use crate::setting::{Given, SettingError};

/// A method and the settings with which it runs.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyMethod {
    /// The name of its curve.
    pub name: String,
    /// The method's name.
    pub method: String,
    /// The sensors for which it is meant; if there are none, all that it can fill.
    pub sensors: Vec<String>,
    /// One entry a run.
    pub settings: Vec<Given>,
}

impl StudyMethod {
    /// A method with one list of values for one setting.
    pub fn swept(method: &str, key: &str, values: &[&str]) -> Self {
        let settings = values
            .iter()
            .map(|value| Given::from([(key.to_owned(), (*value).to_owned())]));
        Self {
            name: method.to_owned(),
            method: method.to_owned(),
            sensors: Vec::new(),
            settings: settings.collect(),
        }
    }

    /// The same with one more setting.
    #[must_use]
    pub fn with(mut self, key: &str, value: &str) -> Self {
        for settings in &mut self.settings {
            settings.insert(key.to_owned(), value.to_owned());
        }
        self
    }

    /// Its methods, one for each entry of the settings, in order.
    ///
    /// # Errors
    ///
    /// For settings that contradict each other.
    pub fn methods(&self) -> Result<Vec<Method>, SettingError> {
        self.settings
            .iter()
            .map(|settings| Method::new(&self.method, settings))
            .collect()
    }
}
