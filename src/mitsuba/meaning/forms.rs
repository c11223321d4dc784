//! The forms of shapes: the part of `<shape>` that is geometry.

use std::path::PathBuf;
use std::sync::Arc;

use glam::{DMat4, DVec3};

use super::plugin::Plugin;
use crate::geometry::{Cylinder, Disk, Mesh, MeshParts, Rectangle, Shape, Sphere, Transform};
use crate::mitsuba::error::LoadError;
use crate::mitsuba::files::Files;
use crate::mitsuba::mesh_files::{self, Format};
use crate::mitsuba::syntax::some_perpendicular;

/// Every plugin with a form of its own.
pub const MODELLED: [&str; 8] = [
    "cube",
    "cylinder",
    "disk",
    "obj",
    "ply",
    "rectangle",
    "serialized",
    "sphere",
];

/// A form before it is made into a [`Shape`].
#[derive(Clone, Debug)]
pub enum ShapeForm {
    /// Unit sphere, mapped.
    Sphere(Placement),
    /// [-1, 1]² in the xy plane, mapped.
    Rectangle(Placement),
    /// Unit disc in the xy plane, mapped.
    Disk(Placement),
    /// Radius 1 about the z axis from z = 0 to z = 1, mapped.
    Cylinder(Placement),
    /// Triangles.
    Mesh(MeshForm),
}

/// The place and orientation of a form.
#[derive(Clone, Copy, Debug)]
pub struct Placement {
    /// Object space to world.
    pub to_world: Transform,
    /// True to turn the normals round.
    pub flip_normals: bool,
}

/// Triangles before they are read.
#[derive(Clone, Debug)]
pub struct MeshForm {
    /// The origin of the triangles.
    pub source: MeshSource,
    /// Their place.
    pub placed: Placement,
    /// True to ignore the file's normals and make none.
    pub face_normals: bool,
}

/// The origin of triangles.
#[derive(Clone, Debug)]
pub enum MeshSource {
    /// Mitsuba's cube.
    Cube,
    /// A file.
    File {
        /// As it was opened, for messages.
        path: PathBuf,
        /// Its contents.
        bytes: Arc<[u8]>,
        /// Its format.
        format: Format,
    },
}

impl ShapeForm {
    /// Object space to world.
    pub fn to_world(&self) -> Transform {
        match self {
            Self::Sphere(placed)
            | Self::Rectangle(placed)
            | Self::Disk(placed)
            | Self::Cylinder(placed)
            | Self::Mesh(MeshForm { placed, .. }) => placed.to_world,
        }
    }

    /// Makes the shape; mesh files are parsed here.
    ///
    /// # Errors
    ///
    /// The problem with the file or the form, without the place in the XML file.
    pub fn build(self) -> Result<Shape, String> {
        let not_round = |error: crate::geometry::ShapeError| error.to_string();
        match self {
            Self::Sphere(p) => Sphere::new(&p.to_world, p.flip_normals)
                .map(Shape::Sphere)
                .map_err(not_round),
            Self::Rectangle(p) => Rectangle::new(&p.to_world, p.flip_normals)
                .map(Shape::Rectangle)
                .map_err(not_round),
            Self::Disk(p) => Disk::new(&p.to_world, p.flip_normals)
                .map(Shape::Disk)
                .map_err(not_round),
            Self::Cylinder(p) => Cylinder::new(&p.to_world, p.flip_normals)
                .map(Shape::Cylinder)
                .map_err(not_round),
            Self::Mesh(mesh) => {
                let parts = mesh.parts()?;
                Mesh::new(parts)
                    .map(Shape::Mesh)
                    .map_err(|error| mesh.blame(&error.to_string()))
            }
        }
    }
}

impl MeshForm {
    /// Vertices and triangles in world space.
    ///
    /// # Errors
    ///
    /// The file's name, the place in it, and the problem there.
    pub fn parts(&self) -> Result<MeshParts, String> {
        let mut parts = match &self.source {
            MeshSource::Cube => mesh_files::cube(),
            MeshSource::File { bytes, format, .. } => {
                mesh_files::parse(bytes, *format).map_err(|error| self.blame(&error.to_string()))?
            }
        };
        parts.face_normals |= self.face_normals;
        parts.flip_normals = self.placed.flip_normals;
        let to_world = &self.placed.to_world;
        if *to_world != Transform::IDENTITY {
            for position in &mut parts.positions {
                *position = to_world.point(*position);
            }
            for normal in parts.normals.iter_mut().flatten() {
                *normal = to_world.normal(*normal);
            }
        }
        Ok(parts)
    }

    fn blame(&self, message: &str) -> String {
        match &self.source {
            MeshSource::Cube => message.to_owned(),
            MeshSource::File { path, .. } => format!("{}: {message}", path.display()),
        }
    }
}

/// The form of a shape plugin and Mitsuba's name for it; `None` if the plugin is not one of [`MODELLED`].
/// `outer` is applied last.
pub fn read(
    plugin: &Plugin,
    outer: &Transform,
    files: &mut Files,
) -> Result<Option<(ShapeForm, &'static str)>, LoadError> {
    let Some(name) = MODELLED.into_iter().find(|name| *name == plugin.name()) else {
        return Ok(None);
    };
    let mut to_world = plugin.to_world()?;
    let flip_normals = plugin.boolean_or("flip_normals", false)?;
    let inner = match name {
        "sphere" => sphere(plugin)?,
        "cylinder" => cylinder(plugin)?,
        _ => DMat4::IDENTITY,
    };
    let composed = Transform::from_matrix(inner)
        .and_then(|inner| to_world.after(&inner))
        .and_then(|inner| outer.after(&inner));
    to_world =
        composed.map_err(|error| plugin.error(format!("has no usable transform: {error}")))?;
    let placed = Placement {
        to_world,
        flip_normals,
    };
    let form = match name {
        "sphere" => ShapeForm::Sphere(placed),
        "rectangle" => {
            plugin.boolean_or("face_normals", false)?;
            ShapeForm::Rectangle(placed)
        }
        "disk" => ShapeForm::Disk(placed),
        "cylinder" => ShapeForm::Cylinder(placed),
        _ => {
            let face_normals = plugin.boolean_or("face_normals", false)?;
            let source = mesh_source(plugin, name, files)?;
            ShapeForm::Mesh(MeshForm {
                source,
                placed,
                face_normals,
            })
        }
    };
    Ok(Some((form, name)))
}

fn sphere(plugin: &Plugin) -> Result<DMat4, LoadError> {
    let center = plugin
        .vector("center")?
        .map_or(DVec3::ZERO, |(center, _)| center);
    let radius = plugin.positive_or("radius", 1.0)?;
    Ok(DMat4::from_translation(center) * DMat4::from_scale(DVec3::splat(radius)))
}

/// The transform of a cylinder from `p0` to `p1`. The directions across are Mitsuba's, so that u begins at
/// the same place.
fn cylinder(plugin: &Plugin) -> Result<DMat4, LoadError> {
    let radius = plugin.positive_or("radius", 1.0)?;
    let p0 = plugin.vector("p0")?.map_or(DVec3::ZERO, |(point, _)| point);
    let end = plugin.vector("p1")?;
    let axis = end.map_or(DVec3::Z, |(point, _)| point) - p0;
    let Some(direction) = axis.try_normalize() else {
        return Err(plugin.error("needs p0 and p1 to differ"));
    };
    let across = some_perpendicular(direction);
    Ok(DMat4::from_cols(
        (across * radius).extend(0.0),
        (direction.cross(across) * radius).extend(0.0),
        axis.extend(0.0),
        p0.extend(1.0),
    ))
}

fn mesh_source(plugin: &Plugin, name: &str, files: &mut Files) -> Result<MeshSource, LoadError> {
    let format = match name {
        "obj" => Format::Obj {
            flip_v: plugin.boolean_or("flip_tex_coords", true)?,
        },
        "ply" => Format::Ply {
            flip_v: plugin.boolean_or("flip_tex_coords", false)?,
        },
        "serialized" => Format::Serialized {
            shape_index: plugin.integer_or("shape_index", 0, 0)?,
        },
        _ => return Ok(MeshSource::Cube),
    };
    let path = files.resolve(plugin.required_string("filename")?);
    let bytes = match files.read_named(&path) {
        Ok(bytes) => bytes,
        Err(message) => {
            let at = plugin.find("filename").map(|found| found.property.at);
            return Err(match at {
                Some(at) => plugin.parameter_error(at, "filename", message),
                None => plugin.error(message),
            });
        }
    };
    Ok(MeshSource::File {
        path,
        bytes,
        format,
    })
}
