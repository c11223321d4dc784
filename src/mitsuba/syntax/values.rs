//! The values that elements give to properties.

use super::transforms::{self, attribute, required};
use super::{ObjectKind, Position, Spectrum, Value, Version, numbers};
use crate::setting::did_you_mean;

/// Tags that give a property a value.
const VALUE_TAGS: [&str; 8] = [
    "boolean", "float", "integer", "point", "rgb", "spectrum", "string", "vector",
];
/// Tags with a meaning of their own.
const OTHER_TAGS: [&str; 6] = ["alias", "default", "include", "path", "ref", "transform"];

/// An element with its parameters replaced.
pub struct XmlElement<'a> {
    pub tag: &'a str,
    pub attributes: Vec<(String, String)>,
    pub at: Position,
}

impl XmlElement<'_> {
    /// The value of an attribute.
    pub fn attribute(&self, name: &str) -> Option<&str> {
        attribute(&self.attributes, name)
    }
}

/// The value that an element gives. `old`: the file's version is below 2.0.
///
/// Old files may also use `<srgb>` (sRGB-encoded, decoded here) and `<spectrum>` with three numbers (linear
/// RGB). Both are documented in Mitsuba 0.6 and unambiguous, though Mitsuba 3 rejects them.
pub fn value(element: &XmlElement, old: bool) -> Result<Value, String> {
    let known = VALUE_TAGS.contains(&element.tag) || (old && element.tag == "srgb");
    if !known {
        let tags = || {
            ObjectKind::TAGS
                .iter()
                .map(|(tag, _)| *tag)
                .chain(VALUE_TAGS)
                .chain(OTHER_TAGS)
        };
        let hint = did_you_mean(element.tag, tags());
        return Err(format!(
            "this tag is not known{hint} (known: {})",
            tags().collect::<Vec<_>>().join(", ")
        ));
    }
    let allowed: &[&str] = match element.tag {
        "point" | "vector" => &["name", "value", "x", "y", "z"],
        "spectrum" => &["name", "value", "filename"],
        _ => &["name", "value"],
    };
    transforms::allow(&element.attributes, allowed)?;
    let text = || required(&element.attributes, "value");
    match element.tag {
        "boolean" => numbers::boolean(text()?).map(Value::Boolean),
        "float" => numbers::float(text()?).map(Value::Float),
        "integer" => numbers::integer(text()?).map(Value::Integer),
        "rgb" => numbers::rgb(text()?).map(Value::Rgb),
        "srgb" => numbers::encoded_srgb(text()?).map(Value::Rgb),
        "string" => Ok(Value::String(text()?.to_owned())),
        "point" | "vector" => {
            for axis in ["x", "y", "z"] {
                if element.attribute("value").is_none() {
                    required(&element.attributes, axis)?;
                }
            }
            transforms::components(&element.attributes, 0.0).map(Value::Vector)
        }
        _ => match (element.attribute("value"), element.attribute("filename")) {
            (Some(text), None) => spectrum(text, old),
            (None, Some(name)) => Ok(Value::Spectrum(Spectrum::File(name.to_owned()))),
            _ => Err("needs either \"value\" or \"filename\"".to_owned()),
        },
    }
}

fn spectrum(text: &str, old: bool) -> Result<Value, String> {
    if old
        && !text.contains(':')
        && let [red, green, blue] = numbers::floats(text)?[..]
    {
        return Ok(Value::Rgb([red, green, blue]));
    }
    numbers::spectrum(text).map(Value::Spectrum)
}

/// A version such as `3.0.0`, `2.1` or `3`.
pub fn version(text: &str) -> Option<Version> {
    let mut version = [0; 3];
    let parts: Vec<&str> = text.trim().split('.').collect();
    if parts.len() > 3 {
        return None;
    }
    for (number, part) in version.iter_mut().zip(parts) {
        *number = part.parse().ok()?;
    }
    Some(version)
}
