//! Radiometric parameters: conversion of floats, colours and spectra to linear sRGB.

use crate::mitsuba::error::LoadError;
use crate::mitsuba::syntax::{ObjectIndex, ObjectKind, Position, Spectrum, Tree, Value};
use crate::radiometry::Rgb;

use super::cie::{self, Weight};
use super::plugin::{Plugin, what};

/// The role of a parameter, which decides its limits and the weight of spectra.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Light: not negative.
    Emission,
    /// A fraction of light: in 0..=1.
    Fraction,
    /// A refractive index or its like: not negative.
    Index,
}

/// The parameter `name` of a plugin in linear sRGB, and its place; `None` if the file has none.
///
/// | element | emission | fraction or index |
/// |---|---|---|
/// | `<float value="v"/>`, `<rgb value="v"/>` | (v, v, v) | (v, v, v) |
/// | `<rgb value="r, g, b"/>` | (r, g, b) | (r, g, b) |
/// | `<spectrum value="v"/>` | v times [`cie::EQUAL_ENERGY`] | (v, v, v) |
/// | `<spectrum value="w:v, ..."/>` | integrated as light | integrated under D65 |
/// | `<spectrum type="d65">` | (scale, scale, scale) | not modelled |
/// | `<spectrum type="uniform">` | (value, value, value) | (value, value, value) |
/// | `<spectrum type="srgb">` | its color | its color |
///
/// (Checked against Mitsuba 3.9.1, `scalar_rgb`.)
///
/// # Errors
///
/// If it is a texture or a spectrum from a file, which are not modelled, or a number out of range.
pub fn read(
    tree: &Tree,
    plugin: &Plugin,
    name: &str,
    role: Role,
) -> Result<Option<(Rgb, Position)>, LoadError> {
    let Some(found) = plugin.find(name) else {
        return Ok(None);
    };
    let at = found.property.at;
    let rgb = match *found.value {
        // Equal energy is not white in emission, and just a factor elsewhere.
        Value::Spectrum(Spectrum::Uniform(number)) if role == Role::Emission => {
            cie::EQUAL_ENERGY * number
        }
        Value::Float(number) | Value::Spectrum(Spectrum::Uniform(number)) => Rgb::grey(number),
        Value::Integer(number) => Rgb::grey(number as f64),
        Value::Rgb(rgb) => Rgb(rgb),
        Value::Spectrum(Spectrum::Samples(ref samples)) => integrated(samples, role),
        Value::Spectrum(Spectrum::File(_)) => {
            let message =
                "spectra from files are not modelled; give numbers or wavelength:value pairs";
            return Err(plugin.parameter_error(at, name, message));
        }
        Value::Object(child) if tree.object(child).kind == ObjectKind::Texture => {
            nested(tree, plugin, name, child, role)?
        }
        ref other => {
            let message = format!("must be a float, rgb or spectrum, not {}", other.what());
            return Err(plugin.parameter_error(at, name, message));
        }
    };
    let out_of_range = match role {
        Role::Emission | Role::Index => (rgb.min_channel() < 0.0).then_some("must not be negative"),
        Role::Fraction => {
            (rgb.min_channel() < 0.0 || rgb.max_channel() > 1.0).then_some("must lie in 0..=1")
        }
    };
    match out_of_range {
        None if rgb.is_finite() => Ok(Some((rgb, at))),
        None => Err(plugin.parameter_error(at, name, "overflows")),
        Some(message) => {
            let [red, green, blue] = rgb.0;
            Err(plugin.parameter_error(
                at,
                name,
                format!("{message}, but is ({red}, {green}, {blue})"),
            ))
        }
    }
}

/// As [`read`], or `default` if the file gives nothing.
pub fn read_or(
    tree: &Tree,
    plugin: &Plugin,
    name: &str,
    role: Role,
    default: f64,
) -> Result<Rgb, LoadError> {
    Ok(read(tree, plugin, name, role)?.map_or(Rgb::grey(default), |(rgb, _)| rgb))
}

fn integrated(samples: &[(f64, f64)], role: Role) -> Rgb {
    match role {
        Role::Emission => cie::to_srgb(samples, Weight::Emission),
        Role::Index => cie::to_srgb(samples, Weight::UnderD65),
        // Saturated colours may leave sRGB's cube; Mitsuba clamps them, too.
        Role::Fraction => cie::to_srgb(samples, Weight::UnderD65).map(|channel| channel.min(1.0)),
    }
}

/// A `<spectrum>` or `<texture>` with a type.
fn nested(
    tree: &Tree,
    holder: &Plugin,
    name: &str,
    child: ObjectIndex,
    role: Role,
) -> Result<Rgb, LoadError> {
    let plugin = Plugin::new(tree, child);
    let rgb = match (plugin.name(), role) {
        ("uniform", _) => Rgb::grey(plugin.float_or("value", 1.0)?),
        ("srgb", _) => {
            read(tree, &plugin, "color", Role::Index)?
                .ok_or_else(|| plugin.error("needs the parameter \"color\""))?
                .0
        }
        ("d65", Role::Emission) => Rgb::grey(plugin.float_or("scale", 1.0)?),
        _ => {
            let message = format!(
                "as \"{name}\" of {} is not modelled; allowed are float, rgb, and spectra of type uniform, srgb{}",
                holder.what(),
                if role == Role::Emission { ", d65" } else { "" }
            );
            return Err(LoadError::new(
                plugin.source(),
                format!("{} {message}", what(tree.object(child))),
            ));
        }
    };
    plugin.finish()?;
    Ok(rgb)
}
