//! Refractive indices by name.

use crate::mitsuba::error::LoadError;
use crate::mitsuba::syntax::{Value, shortened};
use crate::setting::did_you_mean;
use crate::spectrum::AIR_IOR;

use super::plugin::Plugin;

/// Mitsuba's table of indices: gases at 0 °C and 1 atm, liquids at 20 °C, solids at room temperature.
///
/// It is `include/mitsuba/render/ior.h`, read back from version 3.9.1 by
/// `mi.load_dict({"type": "dielectric", "int_ior": name})`.
const NAMED: [(&str, f64); 23] = [
    ("vacuum", 1.0),
    ("helium", 1.000036),
    ("hydrogen", 1.000132),
    ("air", AIR_IOR),
    ("carbon dioxide", 1.00045),
    ("water", 1.333),
    ("acetone", 1.36),
    ("ethanol", 1.361),
    ("carbon tetrachloride", 1.461),
    ("glycerol", 1.4729),
    ("benzene", 1.501),
    ("silicone oil", 1.52045),
    ("bromine", 1.661),
    ("water ice", 1.31),
    ("fused quartz", 1.458),
    ("pyrex", 1.47),
    ("acrylic glass", 1.49),
    ("polypropylene", 1.49),
    ("bk7", 1.5046),
    ("sodium chloride", 1.544),
    ("amber", 1.55),
    ("pet", 1.575),
    ("diamond", 2.419),
];

/// The index with this name, in any case.
pub fn named(name: &str) -> Option<f64> {
    let entry = NAMED
        .iter()
        .find(|(known, _)| known.eq_ignore_ascii_case(name));
    entry.map(|(_, ior)| *ior)
}

/// An absolute refractive index, above 0: a float or a name.
pub fn read(plugin: &Plugin, parameter: &str, default: &str) -> Result<f64, LoadError> {
    let fallback = || named(default).unwrap_or(1.0);
    let Some(found) = plugin.find(parameter) else {
        return Ok(fallback());
    };
    if !matches!(found.value, Value::String(_)) {
        return plugin.positive_or(parameter, 1.0);
    }
    let name = plugin.string(parameter)?.unwrap_or_default();
    named(name).ok_or_else(|| {
        let names = || NAMED.iter().map(|(known, _)| *known);
        let message = format!(
            "no material is called \"{}\"{}; known are {}",
            shortened(name),
            did_you_mean(name, names()),
            names().collect::<Vec<_>>().join(", ")
        );
        plugin.parameter_error(found.property.at, parameter, message)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_known_in_any_case() {
        assert_eq!(named("BK7"), Some(1.5046));
        assert_eq!(named("acrylic glass"), Some(1.49));
        assert_eq!(named("unobtainium"), None);
    }
}
