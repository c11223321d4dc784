//! The meaning of `<medium>`, which becomes a [`Medium`], and of the shapes that bound media.

use std::collections::HashMap;

use super::plugin::{Plugin, what};
use super::spectra::{self, Role};
use crate::mitsuba::error::LoadError;
use crate::mitsuba::syntax::{ObjectIndex, ObjectKind, Tree, Value};
use crate::radiometry::Rgb;
use crate::scene::{Boundary, Medium, MediumId};

/// Mitsuba's albedo of a medium whose file gives none.
const DEFAULT_ALBEDO: f64 = 0.75;

/// What is modelled, for errors.
const ABSORBING: &str =
    "media may absorb light, but not scatter it: give a homogeneous medium the albedo 0";

/// The media of a scene, in the order of their first use.
#[derive(Default)]
pub struct Media {
    pub list: Vec<Medium>,
    known: HashMap<ObjectIndex, MediumId>,
}

impl Media {
    /// True if a shape bounds the medium, or anything says that it is in it.
    pub fn is_used(&self, medium: ObjectIndex) -> bool {
        self.known.contains_key(&medium)
    }

    /// The media that a shape bounds, by the names `interior` and `exterior`; `None` if it has neither.
    /// `id_of` names a medium.
    ///
    /// # Errors
    ///
    /// If a medium has another name, scatters light or is not modelled.
    pub fn boundary(
        &mut self,
        tree: &Tree,
        shape: &Plugin,
        mut id_of: impl FnMut(ObjectIndex) -> String,
    ) -> Result<Option<Boundary>, LoadError> {
        let count = shape.children(ObjectKind::Medium).len();
        if count == 0 {
            return Ok(None);
        }
        let sides = ["interior", "exterior"].map(|name| named(tree, shape, name));
        if sides.iter().flatten().count() < count {
            let message = "holds a medium that is neither its \"interior\" nor its \"exterior\": \
                           give it one of these names";
            return Err(shape.error(message));
        }
        let mut read = |side| match side {
            None => Ok(MediumId::CLEAR),
            Some(medium) => self.read(tree, medium, &mut id_of),
        };
        let [interior, exterior] = sides.map(&mut read);
        Ok(Some(Boundary {
            interior: interior?,
            exterior: exterior?,
        }))
    }

    /// The medium at this place of the tree; `id_of` names it.
    ///
    /// # Errors
    ///
    /// If it scatters light or is not modelled.
    pub fn read(
        &mut self,
        tree: &Tree,
        index: ObjectIndex,
        id_of: &mut impl FnMut(ObjectIndex) -> String,
    ) -> Result<MediumId, LoadError> {
        if let Some(&known) = self.known.get(&index) {
            return Ok(known);
        }
        let absorption = absorption(tree, Plugin::new(tree, index))?;
        let id = if absorption.is_black() {
            MediumId::CLEAR
        } else {
            self.list.push(Medium {
                id: id_of(index),
                absorption,
            });
            MediumId::new(self.list.len() - 1)
        };
        self.known.insert(index, id);
        Ok(id)
    }
}

/// The medium that a shape holds under a name.
fn named(tree: &Tree, shape: &Plugin, name: &str) -> Option<ObjectIndex> {
    match *shape.find(name)?.value {
        Value::Object(medium) if tree.object(medium).kind == ObjectKind::Medium => Some(medium),
        _ => None,
    }
}

/// The absorption of a `homogeneous` medium: `sigma_t` times `scale`. Old files may also give `sigma_a` and
/// `sigma_s`.
fn absorption(tree: &Tree, plugin: Plugin) -> Result<Rgb, LoadError> {
    if plugin.name() != "homogeneous" {
        return Err(plugin.error(format!("is not modelled; {ABSORBING}")));
    }
    // What light would do if it were scattered, and how Mitsuba would sample that.
    plugin.children(ObjectKind::Phase);
    plugin.boolean_or("sample_emitters", true)?;
    plugin.boolean_or("has_spectral_extinction", true)?;
    let scale = plugin.float_within("scale", 0.0..=f64::MAX, 1.0)?;
    let is_split = plugin.is_old() && plugin.find("sigma_a").is_some();
    let [absorbing, scattering] = if is_split {
        ["sigma_a", "sigma_s"]
    } else {
        ["sigma_t", "albedo"]
    };
    let absorption = coefficient(tree, &plugin, absorbing)?.unwrap_or(Rgb::WHITE);
    let scattered = coefficient(tree, &plugin, scattering)?
        .unwrap_or_else(|| Rgb::grey(if is_split { 0.0 } else { DEFAULT_ALBEDO }));
    if !scattered.is_black() {
        let [red, green, blue] = scattered.0;
        return Err(plugin.error(format!(
            "scatters light, as its {scattering} is ({red}, {green}, {blue}); {ABSORBING}"
        )));
    }
    plugin.finish()?;
    Ok(absorption * scale)
}

/// A coefficient. A number may be any that is not negative; a colour has channels in 0..=1, as in Mitsuba.
fn coefficient(tree: &Tree, plugin: &Plugin, name: &str) -> Result<Option<Rgb>, LoadError> {
    let Some(found) = plugin.find(name) else {
        return Ok(None);
    };
    let role = match found.value {
        Value::Rgb(_) if !plugin.is_old() => Role::Fraction,
        Value::Object(volume) => {
            let volume = what(tree.object(*volume));
            let message = format!(
                "must be a float or an rgb, as media are the same everywhere, not {volume}"
            );
            return Err(plugin.parameter_error(found.property.at, name, message));
        }
        _ => Role::Index,
    };
    let read = spectra::read(tree, plugin, name, role).map_err(|error| match role {
        Role::Fraction => LoadError {
            message: error.message + "; \"scale\" multiplies it",
            ..error
        },
        _ => error,
    });
    Ok(read?.map(|(value, _)| value))
}
