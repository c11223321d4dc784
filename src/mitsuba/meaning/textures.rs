//! The meaning of `<texture>`, which becomes a [`Texture`].

use std::collections::HashMap;
use std::sync::Arc;

use glam::{DMat3, DVec3};

use super::plugin::Plugin;
use super::spectra::{self, Role};
use crate::film::bitmap::{Bitmap, BitmapEncoding};
use crate::mitsuba::error::LoadError;
use crate::mitsuba::files::Files;
use crate::mitsuba::syntax::{ObjectIndex, ObjectKind, Spectrum, Tree, Value};
use crate::scene::{
    BitmapTexture, Color, Scalar, Texture, TextureFilter, TextureId, TextureWrap, Warning,
};

/// The textures so far; each texture of the file is read once.
#[derive(Default)]
pub struct Textures {
    pub list: Vec<Texture>,
    /// `None` if the image is missing.
    known: HashMap<ObjectIndex, Result<Option<TextureId>, LoadError>>,
    pub warnings: Vec<Warning>,
}

/// True if it varies over a surface (and is not a plain spectrum with a type).
fn is_texture(tree: &Tree, object: ObjectIndex) -> bool {
    let object = tree.object(object);
    object.kind == ObjectKind::Texture
        && !matches!(
            object.plugin.as_str(),
            "uniform" | "srgb" | "d65" | "rawconstant"
        )
}

/// The texture that a parameter refers to, if any.
fn of_parameter(tree: &Tree, plugin: &Plugin, name: &str) -> Option<ObjectIndex> {
    match plugin.find(name)?.value {
        Value::Object(texture) if is_texture(tree, *texture) => Some(*texture),
        _ => None,
    }
}

impl Textures {
    /// True if a material uses the texture.
    pub fn is_used(&self, texture: ObjectIndex) -> bool {
        self.known.contains_key(&texture)
    }

    /// A fraction of light, or `default` if the file gives none.
    ///
    /// It is [`Color::Unknown`] for a missing image and a spectrum from a file. A surface that ends specular
    /// chains may have any colour: only a sensor that sees it needs to know.
    pub fn color(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        name: &str,
        default: f64,
        files: &mut Files,
    ) -> Result<Color, LoadError> {
        if let Some(texture) = of_parameter(tree, plugin, name)
            && self.read(tree, texture, files)?.is_none()
        {
            return Ok(Color::Unknown);
        }
        if let Some(found) = plugin.find(name)
            && matches!(found.value, Value::Spectrum(Spectrum::File(_)))
        {
            return Ok(Color::Unknown);
        }
        self.fraction(tree, plugin, name, default, files)
    }

    /// A factor on the light that a smooth interface reflects or lets through; 1 if the file gives none.
    ///
    /// Unlike for [`Self::color`], the image must be there: chains go on by it.
    pub fn filter(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        name: &str,
        files: &mut Files,
    ) -> Result<Color, LoadError> {
        self.fraction(tree, plugin, name, 1.0, files)
    }

    /// A fraction of light whose image must be there, or `default` if the file gives none.
    fn fraction(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        name: &str,
        default: f64,
        files: &mut Files,
    ) -> Result<Color, LoadError> {
        let Some(texture) = of_parameter(tree, plugin, name) else {
            let color = spectra::read_or(tree, plugin, name, Role::Fraction, default);
            return color.map(Color::Constant);
        };
        let id = self.required(tree, texture, files)?;
        self.check_fraction(&Plugin::new(tree, texture), id)?;
        Ok(Color::Texture(id))
    }

    /// A vector in the frame of the surface, its coordinates brought to 0..=1.
    pub fn vector(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        name: &str,
        files: &mut Files,
    ) -> Result<Color, LoadError> {
        if let Some(texture) = of_parameter(tree, plugin, name) {
            return self.required(tree, texture, files).map(Color::Texture);
        }
        match spectra::read(tree, plugin, name, Role::Fraction)? {
            Some((rgb, _)) => Ok(Color::Constant(rgb)),
            None => Err(plugin.error(format!("needs the parameter \"{name}\""))),
        }
    }

    /// A number not below 0, or `default` if the file gives none.
    pub fn scalar(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        name: &str,
        default: f64,
        files: &mut Files,
    ) -> Result<Scalar, LoadError> {
        if let Some(texture) = of_parameter(tree, plugin, name) {
            return self.required(tree, texture, files).map(Scalar::Texture);
        }
        if matches!(
            plugin.find(name).map(|found| found.value),
            Some(Value::Object(_))
        ) {
            return channel(tree, plugin, name, Role::Index, default);
        }
        match plugin.float_at(name)? {
            Some((number, at)) if number < 0.0 => {
                let message = format!("must not be negative, but is {number}");
                Err(plugin.parameter_error(at, name, message))
            }
            found => Ok(Scalar::Constant(
                found.map_or(default, |(number, _)| number),
            )),
        }
    }

    /// A share of light, the same in all channels, or `default` if the file gives none.
    pub fn share(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        name: &str,
        default: f64,
        files: &mut Files,
    ) -> Result<Scalar, LoadError> {
        if let Some(texture) = of_parameter(tree, plugin, name) {
            return self.required(tree, texture, files).map(Scalar::Texture);
        }
        channel(tree, plugin, name, Role::Fraction, default)
    }

    /// The texture that gives an emitter's light, if it is one; its image must be there, and not be negative.
    /// A scene checks the values of other textures, which depend on the shape.
    pub fn emission(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        name: &str,
        files: &mut Files,
    ) -> Result<Option<TextureId>, LoadError> {
        let Some(texture) = of_parameter(tree, plugin, name) else {
            return Ok(None);
        };
        let id = self.required(tree, texture, files)?;
        match self.range(id) {
            Some([low, _]) if low < 0.0 => {
                let message = format!("holds {low}, but light must not be negative");
                Err(Plugin::new(tree, texture).error(message))
            }
            _ => Ok(Some(id)),
        }
    }

    /// Fails if an image has negative texels; warns if it has some above 1.
    fn check_fraction(&mut self, texture: &Plugin, id: TextureId) -> Result<(), LoadError> {
        let Some([low, high]) = self.range(id) else {
            return Ok(());
        };
        if low < 0.0 {
            let message = format!("holds {low}, but a fraction of light must not be negative");
            return Err(texture.error(message));
        }
        if high > 1.0 {
            self.warnings.push(Warning {
                at: Some(texture.source()),
                message: format!(
                    "the texture holds {high}: such a surface gives back more light than it gets (Mitsuba 3 \
                     takes it as it is, too)"
                ),
            });
        }
        Ok(())
    }

    /// The smallest and largest number of an image; `None` for other textures.
    fn range(&self, id: TextureId) -> Option<[f64; 2]> {
        match &self.list[id.0 as usize] {
            Texture::Bitmap(bitmap) => {
                let [low, high] = bitmap.image.range();
                Some([
                    low.into_iter().fold(f64::INFINITY, f64::min),
                    high.into_iter().fold(f64::NEG_INFINITY, f64::max),
                ])
            }
            Texture::Scaled { nested, scale } => {
                let [low, high] = self.range(*nested)?;
                Some([low * scale.max_channel(), high * scale.max_channel()])
            }
            Texture::Checkerboard { .. } | Texture::MeshAttribute { .. } => None,
        }
    }

    /// A texture whose image must be there.
    pub fn required(
        &mut self,
        tree: &Tree,
        texture: ObjectIndex,
        files: &mut Files,
    ) -> Result<TextureId, LoadError> {
        let warned = self.warnings.len();
        if let Some(id) = self.read(tree, texture, files)? {
            return Ok(id);
        }
        let why = self.warnings.get(warned).map_or("", |one| &one.message);
        let message = if why.is_empty() {
            "needs its image".to_owned()
        } else {
            format!("needs its image: {why}")
        };
        Err(Plugin::new(tree, texture).error(message))
    }

    /// A texture; `None`, with a warning, if its image is missing.
    pub fn read(
        &mut self,
        tree: &Tree,
        texture: ObjectIndex,
        files: &mut Files,
    ) -> Result<Option<TextureId>, LoadError> {
        if let Some(found) = self.known.get(&texture) {
            return found.clone();
        }
        let found = self.read_anew(tree, texture, files);
        self.known.insert(texture, found.clone());
        found
    }

    fn read_anew(
        &mut self,
        tree: &Tree,
        texture: ObjectIndex,
        files: &mut Files,
    ) -> Result<Option<TextureId>, LoadError> {
        let plugin = Plugin::new(tree, texture);
        let meant = match plugin.name() {
            "bitmap" => self.bitmap(&plugin, files)?,
            "checkerboard" => Some(self.checkerboard(tree, &plugin, files)?),
            "mesh_attribute" => Some(Texture::MeshAttribute {
                name: plugin.required_string("name")?.to_owned(),
                scale: plugin.float_or("scale", 1.0)?,
            }),
            "scale" if plugin.is_old() => self.scaled(tree, &plugin, files)?,
            _ => {
                return Err(plugin.error(
                    "is not modelled; modelled textures are: bitmap, checkerboard, mesh_attribute, \
                     rawconstant",
                ));
            }
        };
        plugin.finish()?;
        let id = meant.map(|texture| {
            self.list.push(texture);
            TextureId(self.list.len() as u32 - 1)
        });
        Ok(id)
    }

    /// An image file, which is decoded here.
    ///
    /// Unless told otherwise, Mitsuba keeps images of up to 16 bits a channel in half floats. Values are
    /// rounded to 11 bits there, but not here. `gamma`, `cache`, `maxAnisotropy` and the filters `trilinear`
    /// and `ewa` (bilinear, for want of a footprint) are known in old files only.
    fn bitmap(&mut self, plugin: &Plugin, files: &mut Files) -> Result<Option<Texture>, LoadError> {
        let filter = match plugin.choice_or(
            "filter_type",
            if plugin.is_old() {
                &["nearest", "bilinear", "trilinear", "ewa"]
            } else {
                &["nearest", "bilinear"]
            },
            "bilinear",
        )? {
            "nearest" => TextureFilter::Nearest,
            _ => TextureFilter::Bilinear,
        };
        let wrap = match plugin.choice_or("wrap_mode", &["repeat", "mirror", "clamp"], "repeat")? {
            "mirror" => TextureWrap::Mirror,
            "clamp" => TextureWrap::Clamp,
            _ => TextureWrap::Repeat,
        };
        let mut encoding = if plugin.boolean_or("raw", false)? {
            BitmapEncoding::Raw
        } else {
            BitmapEncoding::Color
        };
        plugin.boolean_or("accel", true)?;
        plugin.string("format")?;
        if plugin.is_old() {
            plugin.accept(&["cache", "max_anisotropy"]);
            encoding = match plugin.float_at("gamma")? {
                Some((gamma, _)) if gamma > 0.0 => BitmapEncoding::Gamma(gamma),
                Some((gamma, at)) if gamma != -1.0 => {
                    let message = format!("must be above 0, or -1 for sRGB, not {gamma}");
                    return Err(plugin.parameter_error(at, "gamma", message));
                }
                _ => encoding,
            };
        }
        let to_uv = to_uv(plugin)?;
        let name = plugin.required_string("filename")?;
        let path = files.resolve(name);
        if !files.is_file(&path) {
            self.warnings.push(Warning {
                at: Some(plugin.source()),
                message: format!(
                    "there is no image {}; no irradiance depends on it",
                    path.display()
                ),
            });
            return Ok(None);
        }
        let image = files.read_named(&path).and_then(|bytes| {
            Bitmap::read(&bytes, encoding).map_err(|error| format!("{}: {error}", path.display()))
        });
        let image = image.map_err(|message| plugin.error(message))?;
        Ok(Some(Texture::Bitmap(BitmapTexture {
            image: Arc::new(image),
            filter,
            wrap,
            to_uv,
        })))
    }

    /// Two colours or textures in turn. Nested textures have coordinates of their own.
    fn checkerboard(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &mut Files,
    ) -> Result<Texture, LoadError> {
        Ok(Texture::Checkerboard {
            color0: self.fraction(tree, plugin, "color0", 0.4, files)?,
            color1: self.fraction(tree, plugin, "color1", 0.2, files)?,
            to_uv: to_uv(plugin)?,
        })
    }

    /// Mitsuba 0.6's factor on a texture.
    fn scaled(
        &mut self,
        tree: &Tree,
        plugin: &Plugin,
        files: &mut Files,
    ) -> Result<Option<Texture>, LoadError> {
        let scale = spectra::read_or(tree, plugin, "scale", Role::Index, 1.0)?;
        let child = plugin
            .child(ObjectKind::Texture)?
            .ok_or_else(|| plugin.error("needs a nested texture"))?;
        let nested = self.read(tree, child, files)?;
        Ok(nested.map(|nested| Texture::Scaled { nested, scale }))
    }
}

/// A colour that is a single number, or `default` if the file gives none.
fn channel(
    tree: &Tree,
    plugin: &Plugin,
    name: &str,
    role: Role,
    default: f64,
) -> Result<Scalar, LoadError> {
    match spectra::read(tree, plugin, name, role)? {
        None => Ok(Scalar::Constant(default)),
        Some((rgb, _)) if rgb.is_grey() => Ok(Scalar::Constant(rgb.0[0])),
        Some((_, at)) => Err(plugin.parameter_error(at, name, "must be the same in all channels")),
    }
}

/// The part of `to_uv` that Mitsuba uses: its action on x and y, third row and column left out.
fn to_uv(plugin: &Plugin) -> Result<DMat3, LoadError> {
    let Some((transform, _)) = plugin.transform("to_uv")? else {
        return Ok(DMat3::IDENTITY);
    };
    let matrix = transform.matrix();
    let column = |column: glam::DVec4, last| DVec3::new(column.x, column.y, last);
    Ok(DMat3::from_cols(
        column(matrix.x_axis, 0.0),
        column(matrix.y_axis, 0.0),
        column(matrix.w_axis, 1.0),
    ))
}
