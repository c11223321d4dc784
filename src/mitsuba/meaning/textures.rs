//! `<texture>` as the reflectance of a diffuse surface: checked, but not modelled.

use super::plugin::Plugin;
use super::spectra::{self, Role};
use crate::mitsuba::error::LoadError;
use crate::mitsuba::files::Files;
use crate::mitsuba::syntax::{Kind, ObjectIndex, Tree};
use crate::scene::Warning;

/// Whether it varies over a surface (and is not a plain spectrum with a type).
pub fn is_texture(tree: &Tree, object: ObjectIndex) -> bool {
    let object = tree.object(object);
    object.kind == Kind::Texture && !matches!(object.plugin.as_str(), "uniform" | "srgb" | "d65")
}

/// Checks the parameters; warns of a missing image.
///
/// `scale`, `gamma`, `cache` and `maxAnisotropy` are known in old files only, as in Mitsuba 0.6.
pub fn check(
    tree: &Tree,
    texture: ObjectIndex,
    files: &Files,
) -> Result<Option<Warning>, LoadError> {
    let plugin = Plugin::new(tree, texture);
    let mut warning = None;
    match plugin.name() {
        "bitmap" => {
            let name = plugin.required_string("filename")?;
            let path = files.resolve(name);
            if !path.is_file() {
                warning = Some(Warning {
                    at: Some(plugin.source()),
                    message: format!(
                        "there is no image {}; no irradiance depends on it",
                        path.display()
                    ),
                });
            }
            plugin.choice_or(
                "filter_type",
                &["nearest", "bilinear", "trilinear", "ewa"],
                "bilinear",
            )?;
            plugin.choice_or("wrap_mode", &["repeat", "mirror", "clamp"], "repeat")?;
            plugin.boolean_or("raw", false)?;
            plugin.boolean_or("accel", true)?;
            plugin.string("format")?;
            if plugin.is_old() {
                plugin.accept(&["gamma", "cache", "max_anisotropy", "channel"]);
            }
        }
        "checkerboard" => {
            for color in ["color0", "color1"] {
                if let Some(found) = plugin.find(color)
                    && !matches!(found.value, crate::mitsuba::syntax::Value::Object(_))
                {
                    spectra::read(tree, &plugin, color, Role::Fraction)?;
                }
            }
        }
        "mesh_attribute" => {
            plugin.required_string("name")?;
            plugin.float_or("scale", 1.0)?;
        }
        "scale" if plugin.is_old() => {
            plugin.accept(&["scale"]);
            if let Some(child) = plugin.child(Kind::Texture)? {
                warning = check(tree, child, files)?;
            }
        }
        _ => {
            return Err(plugin
                .error("is not known; known textures are: bitmap, checkerboard, mesh_attribute"));
        }
    }
    plugin.find("to_uv");
    plugin.finish()?;
    Ok(warning)
}
