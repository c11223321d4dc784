//! Radiometric parameters: conversion of floats, colours and spectra to linear sRGB.

use crate::mitsuba::error::LoadError;
use crate::mitsuba::syntax::{ObjectIndex, ObjectKind, Position, Spectrum, Tree, Value};
use crate::numeric::math;
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
    /// The real or imaginary part of a complex refractive index, whose sign makes no difference: spectra of
    /// measured metals may have channels below 0 in sRGB. Their magnitudes are taken.
    ComplexIndex,
}

impl Role {
    /// The role of the colour of a nested spectrum, which is never light.
    fn of_color(self) -> Self {
        match self {
            Self::ComplexIndex => self,
            _ => Self::Index,
        }
    }
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
/// | `<spectrum type="blackbody">` | Planck's law \[W/m²/sr/nm\], integrated as light | not modelled |
/// | `<spectrum type="uniform">` | (value, value, value) | (value, value, value) |
/// | `<spectrum type="srgb">` | its color | its color |
/// | `<texture type="rawconstant">` | not modelled | its value, a float or a vector |
///
/// (Checked against Mitsuba 3.9.1, `scalar_rgb`; that has no `blackbody`, whose spectrum is that of
/// `scalar_spectral`.)
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
        Role::ComplexIndex => None,
        Role::Fraction => {
            (rgb.min_channel() < 0.0 || rgb.max_channel() > 1.0).then_some("must lie in 0..=1")
        }
    };
    let rgb = if role == Role::ComplexIndex {
        rgb.map(f64::abs)
    } else {
        rgb
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
        Role::Index | Role::ComplexIndex => cie::to_srgb(samples, Weight::UnderD65),
        // Saturated colours may leave sRGB's cube; Mitsuba clamps them, too.
        Role::Fraction => cie::to_srgb(samples, Weight::UnderD65).map(|channel| channel.min(1.0)),
    }
}

/// Planck's law for the radiance of a black body \[W/m²/sr/nm\], in linear sRGB:
///
/// ```text
/// L(λ) = 2 h c² / λ⁵ / (exp(h c / (λ k T)) − 1)
/// ```
///
/// with the constants of the SI of 2019, `kelvin` the temperature T, and none of it below the wavelength
/// `low` and above `high` \[nm\]. It is linear between wavelengths a nanometre apart.
fn blackbody(kelvin: f64, low: f64, high: f64) -> Rgb {
    let within = (350..=840)
        .map(f64::from)
        .filter(|wavelength| (low..high).contains(wavelength));
    let ends = [low, high].map(|end| end.clamp(350.0, 840.0));
    let [first, last] = ends.map(std::iter::once);
    let mut wavelengths: Vec<f64> = first.chain(within).chain(last).collect();
    wavelengths.dedup();
    let samples: Vec<(f64, f64)> = wavelengths
        .into_iter()
        .map(|wavelength| (wavelength, planck(wavelength, kelvin)))
        .collect();
    cie::to_srgb(&samples, Weight::Emission)
}

fn planck(nanometres: f64, kelvin: f64) -> f64 {
    const PLANCK: f64 = 6.626_070_15e-34;
    const LIGHT: f64 = 299_792_458.0;
    const BOLTZMANN: f64 = 1.380_649e-23;
    let metres = nanometres * 1e-9;
    let per_metre = 2.0 * PLANCK * LIGHT * LIGHT
        / math::powi(metres, 5)
        / math::exp_m1(PLANCK * LIGHT / (metres * BOLTZMANN * kelvin));
    per_metre * 1e-9
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
        // A number, or a vector whose coordinates are red, green and blue.
        ("rawconstant", Role::Fraction | Role::Index | Role::ComplexIndex) => {
            match plugin.find("value").map(|found| found.value) {
                Some(Value::Vector(vector)) => Rgb(vector.to_array()),
                _ => plugin
                    .float_at("value")?
                    .map(|(number, _)| Rgb::grey(number))
                    .ok_or_else(|| plugin.error("needs the parameter \"value\""))?,
            }
        }
        ("uniform", _) => Rgb::grey(plugin.float_or("value", 1.0)?),
        ("srgb", _) => {
            // The parameter that it stands for limits it.
            read(tree, &plugin, "color", role.of_color())?
                .ok_or_else(|| plugin.error("needs the parameter \"color\""))?
                .0
        }
        ("d65", Role::Emission) => Rgb::grey(plugin.float_or("scale", 1.0)?),
        ("blackbody", Role::Emission) => {
            if plugin.find("temperature").is_none() {
                return Err(plugin.error("needs the parameter \"temperature\""));
            }
            let kelvin = plugin.positive_or("temperature", 1.0)?;
            let range = [("wavelength_min", 360.0), ("wavelength_max", 830.0)];
            let [low, high] = range.map(|(name, default)| plugin.positive_or(name, default));
            blackbody(kelvin, low?, high?)
        }
        _ => {
            let message = format!(
                "as \"{name}\" of {} is not modelled; allowed are float, rgb, and spectra of type uniform, srgb{}",
                holder.what(),
                if role == Role::Emission {
                    ", d65, blackbody"
                } else {
                    ""
                }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_black_body_has_mitsubas_radiance() {
        // `mi.load_dict({'type': 'blackbody', 'temperature': T}).eval(si)` of Mitsuba 3.9.1
        // (`scalar_spectral`) at 400, 550, 700 and 800 nm. It computes in f32, and an exponent of 18 has 18
        // times its rounding.
        let mitsuba = [
            (2000.0, [0.179_872_38, 4.938_931_9, 24.390_255, 45.206_413]),
            (5000.0, [8_743.565_4, 12_712.999, 11_811.964, 10_242.688]),
            (6504.0, [46_296.665, 43_171.727, 31_390.779, 24_424.189]),
            (1e4, [327_766.03, 186_630.95, 104_062.58, 72_112.711]),
        ];
        for (kelvin, values) in mitsuba {
            for (nanometres, value) in [400.0, 550.0, 700.0, 800.0].into_iter().zip(values) {
                let found = planck(nanometres, kelvin);
                assert!(
                    (found / value - 1.0).abs() < 1e-5,
                    "{kelvin}: {found} {value}"
                );
            }
        }
    }

    #[test]
    fn hot_bodies_are_blue_cold_ones_red_and_a_range_is_a_part() {
        let [cold, hot] = [2000.0, 2e4].map(|kelvin| blackbody(kelvin, 360.0, 830.0));
        assert!(cold.0[0] > cold.0[1] && cold.0[1] > cold.0[2]);
        assert!(hot.0[2] > hot.0[1] && hot.0[1] > hot.0[0]);
        // Green light from 500 to 600 nm and all other light, whose red and blue are positive, too.
        let parts = [(360.0, 500.0), (500.0, 600.0), (600.0, 830.0)];
        let green: f64 = parts
            .iter()
            .map(|(low, high)| blackbody(6504.0, *low, *high).0[1])
            .sum();
        assert!(green >= blackbody(6504.0, 360.0, 830.0).0[1]);
        assert_eq!(blackbody(6504.0, 900.0, 1000.0), Rgb::BLACK);
    }
}
