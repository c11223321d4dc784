//! The first step: the contents of the files, with the place of every element.
//!
//! Tags, parameters (`$name`), includes, aliases and numbers are understood here; the meaning of a plugin's
//! properties is not. The result is a flat list of objects, each with its properties in the file's order.

mod guard;
mod lines;
mod numbers;
mod parameters;
mod reader;
mod references;
mod transforms;
mod upgrade;
mod values;

use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};
use std::path::PathBuf;

use glam::{DMat4, DVec3};

use crate::mitsuba::error::LoadError;
use crate::scene::{SourcePosition, Warning};

pub use numbers::shortened;
pub use reader::read;
pub use transforms::some_perpendicular;

/// Largest depth of nested elements, includes and references.
///
/// Mitsuba's own scenes stay below 10; the limit keeps hostile files from exhausting the stack.
pub const MAX_DEPTH: usize = 64;

/// A place in one of the tree's files.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Position {
    file: u32,
    line: u32,
    column: u32,
}

/// Mitsuba's version number, major first.
pub type Version = [u32; 3];

/// The index of an object in its [`Tree`].
pub type ObjectIndex = usize;

/// The contents of a main file and its includes.
#[derive(Debug, Default)]
pub struct Tree {
    files: Vec<(PathBuf, Version)>,
    objects: Vec<TreeObject>,
    ids: HashMap<String, ObjectIndex>,
    warnings: Vec<Warning>,
    /// Parameters that no plugin knows, if the file is read leniently.
    left_out: Option<RefCell<BTreeMap<String, Warning>>>,
}

/// The kind of object that an element declares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ObjectKind {
    Scene,
    Bsdf,
    Emitter,
    Field,
    Film,
    Integrator,
    Medium,
    Phase,
    ReconstructionFilter,
    Sampler,
    Sensor,
    Shape,
    Texture,
    Volume,
}

impl ObjectKind {
    const TAGS: [(&'static str, Self); 14] = [
        ("scene", Self::Scene),
        ("bsdf", Self::Bsdf),
        ("emitter", Self::Emitter),
        ("field", Self::Field),
        ("film", Self::Film),
        ("integrator", Self::Integrator),
        ("medium", Self::Medium),
        ("phase", Self::Phase),
        ("rfilter", Self::ReconstructionFilter),
        ("sampler", Self::Sampler),
        ("sensor", Self::Sensor),
        ("shape", Self::Shape),
        ("texture", Self::Texture),
        ("volume", Self::Volume),
    ];

    /// The kind that a tag declares.
    fn of_tag(tag: &str) -> Option<Self> {
        Self::TAGS
            .iter()
            .find(|(name, _)| *name == tag)
            .map(|(_, kind)| *kind)
    }

    /// The tag that declares it.
    pub fn tag(self) -> &'static str {
        Self::TAGS
            .iter()
            .find(|(_, kind)| *kind == self)
            .map_or("object", |(name, _)| *name)
    }
}

/// A plugin with its properties.
#[derive(Clone, Debug)]
pub struct TreeObject {
    pub kind: ObjectKind,
    /// The `type` attribute; `scene` for the root.
    pub plugin: String,
    pub id: Option<String>,
    pub at: Position,
    pub properties: Vec<Property>,
}

/// A value that an object holds.
#[derive(Clone, Debug)]
pub struct Property {
    /// Empty if the element has no `name`.
    pub name: String,
    pub at: Position,
    pub value: Value,
}

/// The value of a property.
#[derive(Clone, Debug, PartialEq)]
pub enum Value {
    Boolean(bool),
    Integer(i64),
    Float(f64),
    String(String),
    /// `<point>` and `<vector>`.
    Vector(DVec3),
    Rgb([f64; 3]),
    Spectrum(Spectrum),
    Transform(DMat4),
    Object(ObjectIndex),
    /// The `id` of a `<ref>`; replaced by [`Value::Object`] once all files are read.
    Reference(String),
}

impl Value {
    /// The tag that makes it, with its article.
    pub fn what(&self) -> &'static str {
        match self {
            Self::Boolean(_) => "a boolean",
            Self::Integer(_) => "an integer",
            Self::Float(_) => "a float",
            Self::String(_) => "a string",
            Self::Vector(_) => "a point or vector",
            Self::Rgb(_) => "an rgb",
            Self::Spectrum(_) => "a spectrum",
            Self::Transform(_) => "a transform",
            Self::Object(_) => "an object",
            Self::Reference(_) => "a ref",
        }
    }
}

/// The value of a `<spectrum>` without a type.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same at all wavelengths.
    Uniform(f64),
    /// Linear between (wavelength in nm, value), wavelengths rising; zero outside.
    Samples(Vec<(f64, f64)>),
    /// A file named by the `filename` attribute.
    File(String),
}

impl Tree {
    /// The scene element.
    pub fn root(&self) -> &TreeObject {
        &self.objects[0]
    }

    /// Oddities that still have a meaning.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }

    /// Makes parameters that a plugin does not know warnings from now on.
    pub fn be_lenient(&mut self) {
        self.left_out = Some(RefCell::default());
    }

    /// Turns the error of an unknown parameter into a warning; false, with nothing done, if it must fail.
    pub fn leaves_out(&self, error: &LoadError) -> bool {
        let Some(left_out) = &self.left_out else {
            return false;
        };
        let warning = Warning {
            at: Some(error.at.clone()),
            message: format!("{}: it is left out", error.message),
        };
        // A plugin that several objects use is read several times.
        let place = format!("{:?}", (&error.at, &error.message));
        left_out.borrow_mut().insert(place, warning);
        true
    }

    /// Warnings of the parameters that were left out.
    pub fn left_out(&self) -> Vec<Warning> {
        let all = self.left_out.iter();
        let mut all: Vec<Warning> = all
            .flat_map(|it| it.borrow().values().cloned().collect::<Vec<_>>())
            .collect();
        all.sort_by_key(|warning| {
            warning
                .at
                .as_ref()
                .map(|at| (at.file.clone(), at.line, at.column))
        });
        all
    }

    /// All objects; the root first.
    pub fn objects(&self) -> &[TreeObject] {
        &self.objects
    }

    /// The object with this index.
    pub fn object(&self, index: ObjectIndex) -> &TreeObject {
        &self.objects[index]
    }

    /// True if the file of an object predates Mitsuba 2 (`version` below 2.0.0).
    pub fn is_old(&self, at: Position) -> bool {
        self.version(at) < [2, 0, 0]
    }

    fn version(&self, at: Position) -> Version {
        self.files[at.file as usize].1
    }

    /// The place with its file's path, for messages.
    pub fn source(&self, at: Position) -> SourcePosition {
        SourcePosition {
            file: self.files[at.file as usize].0.clone(),
            line: at.line,
            column: at.column,
        }
    }
}
