//! Upgrade of files older than version 2.0.
//!
//! Mitsuba 2 renamed all parameters from camelCase to `snake_case`, and `diffuseReflectance` of `diffuse` to
//! `reflectance`. It replaced `uscale`, `vscale`, `uoffset`, `voffset` of textures by a transform `to_uv`.
//! Mitsuba 3's parser (`src/core/parser.cpp`, version 3.9) upgrades old files by these rules, and so does
//! this one. All other changes between the versions are left to the plugins
//! ([`Tree::is_old`](super::Tree::is_old)).

use glam::{DMat4, DVec3};

use super::{Property, Tree, TreeObject, Value};

/// Upgrades the objects of all old files.
pub fn upgrade(tree: &mut Tree) {
    for index in 0..tree.objects.len() {
        if tree.is_old(tree.objects[index].at) {
            upgrade_object(&mut tree.objects[index]);
        }
    }
}

fn upgrade_object(object: &mut TreeObject) {
    for property in &mut object.properties {
        property.name = snake_case(&property.name);
        if object.plugin == "diffuse" && property.name == "diffuse_reflectance" {
            "reflectance".clone_into(&mut property.name);
        }
    }
    gather_uv_transform(object);
}

/// The new spelling of a name: `toWorld` becomes `to_world`, `intIOR` becomes `int_ior`, `B` stays.
///
/// An underscore goes in before a capital that follows a small letter, and the whole run of capitals becomes
/// small.
fn snake_case(name: &str) -> String {
    let mut result = String::with_capacity(name.len() + 4);
    let mut lowering = false;
    let mut previous_is_lower = false;
    for letter in name.chars() {
        if letter.is_ascii_uppercase() {
            if previous_is_lower {
                result.push('_');
                lowering = true;
            }
            result.push(if lowering {
                letter.to_ascii_lowercase()
            } else {
                letter
            });
        } else {
            lowering = false;
            result.push(letter);
        }
        previous_is_lower = letter.is_ascii_lowercase();
    }
    result
}

/// Joins offset and scale to one transform `to_uv`: first the offset, then the scale.
fn gather_uv_transform(object: &mut TreeObject) {
    let (mut scale, mut offset) = (DVec3::ONE, DVec3::ZERO);
    let mut at = None;
    object.properties.retain(|property| {
        let target = match property.name.as_str() {
            "uscale" => &mut scale.x,
            "vscale" => &mut scale.y,
            "uoffset" => &mut offset.x,
            "voffset" => &mut offset.y,
            _ => return true,
        };
        match property.value {
            Value::Float(number) => *target = number,
            Value::Integer(number) => *target = number as f64,
            // The plugin will report it.
            _ => return true,
        }
        at = Some(property.at);
        false
    });
    if let Some(at) = at {
        object.properties.push(Property {
            name: "to_uv".to_owned(),
            at,
            value: Value::Transform(DMat4::from_scale(scale) * DMat4::from_translation(offset)),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn camel_case_becomes_snake_case_as_in_mitsuba() {
        for (old, new) in [
            ("toWorld", "to_world"),
            ("intIOR", "int_ior"),
            ("specularTransmittance", "specular_transmittance"),
            ("maxDepth", "max_depth"),
            ("fov", "fov"),
            ("B", "B"),
            ("kNN", "k_nn"),
            ("shutterOpenTime", "shutter_open_time"),
            ("already_new", "already_new"),
            ("", ""),
        ] {
            assert_eq!(snake_case(old), new);
        }
    }
}
