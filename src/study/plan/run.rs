//! One run of a plan.

use crate::method::Method;
use crate::setting::Given;

/// One run of one method.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyRun {
    /// The name of its curve.
    pub name: String,
    /// The method with all its settings.
    pub method: Method,
    /// The settings that are not the method's defaults, as text.
    pub given: Given,
    /// True if nobody named it: it is of the scene's default study.
    pub is_default: bool,
}

impl StudyRun {
    /// Its name for readers: its curve and the settings that are not defaults.
    pub fn label(&self) -> String {
        self.label_of(|_| true)
    }

    /// The same without the seed, which tells nothing about the only run of its kind.
    pub fn label_without_seed(&self) -> String {
        self.label_of(|key| key != "seed")
    }

    fn label_of(&self, is_told: impl Fn(&str) -> bool) -> String {
        let told = self.given.iter().filter(|(key, _)| is_told(key));
        // photons=4096, not photons photons=4096: the swept setting comes first if it has the method's name.
        let (named, other): (Vec<_>, Vec<_>) = told.partition(|(key, _)| **key == self.name);
        let named = named.iter().map(|(_, value)| format!("={value}"));
        let other = other.iter().map(|(key, value)| format!(" {key}={value}"));
        [self.name.clone()]
            .into_iter()
            .chain(named)
            .chain(other)
            .collect()
    }

    /// The arguments of `nephroid render` that make the same film.
    pub fn arguments(&self) -> String {
        let given = self.given.iter();
        let is_staged = !self.method.stages().is_empty();
        let settings = given.map(|(key, value)| {
            if is_staged {
                format!(" --set {key}={value}")
            } else {
                format!(" --{key} {value}")
            }
        });
        format!(
            "--method {}{}",
            self.method.name(),
            settings.collect::<String>()
        )
    }
}
