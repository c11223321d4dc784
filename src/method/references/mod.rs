//! The references as methods: one file each, with its table of settings.

pub(super) mod beams;
mod closed_form;
mod full;
mod path;
mod photon_map;
pub(super) mod photons;

use super::reference::Reference;

/// All references.
pub(super) static REFERENCES: &[&dyn Reference] = &[
    &beams::Beams,
    &photons::Photons,
    &path::Path,
    &photon_map::PhotonMap,
    &full::Full,
    &closed_form::ClosedForm,
];

#[cfg(test)]
mod tests {
    use std::fmt::Debug;

    use super::*;
    use crate::reference::photons::PhotonSettings;
    use crate::setting::{Given, Preset, Setting, Values};

    /// Settings read from a table whose every default was typed, and from one where nothing was.
    fn read<T>(table: &'static [Setting], settings: impl Fn(&Values) -> T) -> [T; 2] {
        let typed = table.iter().filter_map(|row| match row.default {
            Preset::Value(text) => Some((row.key.to_owned(), text.to_owned())),
            Preset::Rule(_) => None,
        });
        [typed.collect(), Given::new()].map(|given| {
            let values = Values::new("a method", table.iter().collect(), &given).unwrap();
            settings(&values)
        })
    }

    #[test]
    fn defaults_in_tables_are_those_of_the_methods() {
        fn check<T: Default + Debug + PartialEq>(name: &str, read: [T; 2]) {
            for settings in read {
                assert_eq!(settings, T::default(), "{name}");
            }
        }
        check("beams", read(beams::SETTINGS, beams::settings));
        let of_photons = |values: &Values| photons::settings(values, PhotonSettings::default());
        check("photons", read(photons::SETTINGS, of_photons));
        let of_paths = |values: &Values| path::settings(values, None);
        check("path", read(path::SETTINGS, of_paths));
        check(
            "photon-map",
            read(photon_map::SETTINGS, photon_map::settings),
        );
        let of_all = |values: &Values| full::settings(values, None);
        check("full", read(full::SETTINGS, of_all));
        check(
            "closed-form",
            read(closed_form::SETTINGS, closed_form::settings),
        );
    }
}
