//! The references as methods: one file each, with its table of settings.

mod beams;
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
