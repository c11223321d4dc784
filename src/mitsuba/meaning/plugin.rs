//! The interface between a plugin and its properties: a property that was not asked for is an error.

use std::cell::{Cell, RefCell};
use std::ops::RangeInclusive;

use glam::DVec3;

use crate::geometry::Transform;
use crate::mitsuba::error::LoadError;
use crate::mitsuba::syntax::{
    ObjectIndex, ObjectKind, Position, Property, Tree, TreeObject, Value, shortened,
};
use crate::scene::SourcePosition;
use crate::setting::did_you_mean;

/// An object of the tree, and a record of the properties asked for.
pub struct Plugin<'t> {
    tree: &'t Tree,
    object: &'t TreeObject,
    used: Vec<Cell<bool>>,
    asked: RefCell<Vec<String>>,
}

/// A property that an object has.
#[derive(Clone, Copy)]
pub struct PropertyRef<'t> {
    pub property: &'t Property,
    pub value: &'t Value,
}

impl<'t> Plugin<'t> {
    /// The plugin of an object, with nothing asked yet.
    pub fn new(tree: &'t Tree, object: ObjectIndex) -> Self {
        let object = tree.object(object);
        Self {
            tree,
            object,
            used: vec![Cell::new(false); object.properties.len()],
            asked: RefCell::default(),
        }
    }

    /// The `type` attribute.
    pub fn name(&self) -> &'t str {
        &self.object.plugin
    }

    /// Tag and plugin, as messages name it.
    pub fn what(&self) -> String {
        what(self.object)
    }

    /// The place where it is declared.
    pub fn source(&self) -> SourcePosition {
        self.tree.source(self.object.at)
    }

    /// The place of one of its parameters.
    pub fn place(&self, at: Position) -> SourcePosition {
        self.tree.source(at)
    }

    /// True if its file predates Mitsuba 2.
    pub fn is_old(&self) -> bool {
        self.tree.is_old(self.object.at)
    }

    /// An error about the plugin as a whole.
    pub fn error(&self, message: impl AsRef<str>) -> LoadError {
        LoadError::new(
            self.source(),
            format!("{} {}", self.what(), message.as_ref()),
        )
    }

    /// An error about one of its parameters, at the parameter's place.
    pub fn parameter_error(&self, at: Position, name: &str, message: impl AsRef<str>) -> LoadError {
        let message = format!(
            "{}, parameter \"{name}\": {}",
            self.what(),
            message.as_ref()
        );
        LoadError::new(self.tree.source(at), message)
    }

    /// The property with this name; from now on it counts as known.
    pub fn find(&self, name: &str) -> Option<PropertyRef<'t>> {
        if !self.asked.borrow().iter().any(|asked| asked == name) {
            self.asked.borrow_mut().push(name.to_owned());
        }
        let index = self
            .object
            .properties
            .iter()
            .position(|property| property.name == name)?;
        self.used[index].set(true);
        let property = &self.object.properties[index];
        Some(PropertyRef {
            property,
            value: &property.value,
        })
    }

    fn wrong_type(&self, found: PropertyRef, name: &str, expected: &str) -> LoadError {
        let message = format!("must be {expected}, not {}", found.value.what());
        self.parameter_error(found.property.at, name, message)
    }

    /// A number, with its place.
    pub fn float_at(&self, name: &str) -> Result<Option<(f64, Position)>, LoadError> {
        let Some(found) = self.find(name) else {
            return Ok(None);
        };
        match *found.value {
            Value::Float(number) => Ok(Some((number, found.property.at))),
            Value::Integer(number) => Ok(Some((number as f64, found.property.at))),
            _ => Err(self.wrong_type(found, name, "a float")),
        }
    }

    /// A number, or `default` if the file gives none.
    pub fn float_or(&self, name: &str, default: f64) -> Result<f64, LoadError> {
        Ok(self.float_at(name)?.map_or(default, |(number, _)| number))
    }

    /// A number above zero, or `default` if the file gives none.
    pub fn positive_or(&self, name: &str, default: f64) -> Result<f64, LoadError> {
        match self.float_at(name)? {
            Some((number, at)) if number <= 0.0 => {
                Err(self.parameter_error(at, name, format!("must be above 0, not {number}")))
            }
            found => Ok(found.map_or(default, |(number, _)| number)),
        }
    }

    /// A number in a range, or `default` if the file gives none. A range up to `f64::MAX` has all finite
    /// numbers.
    pub fn float_within(
        &self,
        name: &str,
        range: RangeInclusive<f64>,
        default: f64,
    ) -> Result<f64, LoadError> {
        match self.float_at(name)? {
            Some((number, at)) if !range.contains(&number) => {
                let (least, most) = range.into_inner();
                let message = if most == f64::MAX {
                    format!("must be at least {least} and finite, not {number}")
                } else {
                    format!("must be from {least} to {most}, not {number}")
                };
                Err(self.parameter_error(at, name, message))
            }
            found => Ok(found.map_or(default, |(number, _)| number)),
        }
    }

    /// A whole number from `smallest` to `u32::MAX`, or `default` if the file gives none.
    pub fn integer_or(&self, name: &str, smallest: u32, default: u32) -> Result<u32, LoadError> {
        let Some(found) = self.find(name) else {
            return Ok(default);
        };
        let Value::Integer(number) = *found.value else {
            return Err(self.wrong_type(found, name, "an integer"));
        };
        match u32::try_from(number) {
            Ok(number) if number >= smallest => Ok(number),
            _ => {
                let message = format!("must be from {smallest} to {}, not {number}", u32::MAX);
                Err(self.parameter_error(found.property.at, name, message))
            }
        }
    }

    /// True or false, or `default` if the file gives neither.
    pub fn boolean_or(&self, name: &str, default: bool) -> Result<bool, LoadError> {
        let Some(found) = self.find(name) else {
            return Ok(default);
        };
        match *found.value {
            Value::Boolean(value) => Ok(value),
            _ => Err(self.wrong_type(found, name, "a boolean")),
        }
    }

    /// A text.
    pub fn string(&self, name: &str) -> Result<Option<&'t str>, LoadError> {
        let Some(found) = self.find(name) else {
            return Ok(None);
        };
        match found.value {
            Value::String(text) => Ok(Some(text)),
            _ => Err(self.wrong_type(found, name, "a string")),
        }
    }

    /// A text that must be there.
    pub fn required_string(&self, name: &str) -> Result<&'t str, LoadError> {
        self.string(name)?
            .ok_or_else(|| self.error(format!("needs the parameter \"{name}\"")))
    }

    /// One of several words, or `default` if the file gives none.
    pub fn choice_or(
        &self,
        name: &str,
        allowed: &[&str],
        default: &'static str,
    ) -> Result<&'t str, LoadError> {
        let Some(found) = self.find(name) else {
            return Ok(default);
        };
        match self.string(name)? {
            Some(word) if allowed.contains(&word) => Ok(word),
            Some(word) => {
                let message = format!(
                    "must be one of {}, not \"{}\"",
                    allowed.join(", "),
                    shortened(word)
                );
                Err(self.parameter_error(found.property.at, name, message))
            }
            None => Ok(default),
        }
    }

    /// A point or a vector.
    pub fn vector(&self, name: &str) -> Result<Option<(DVec3, Position)>, LoadError> {
        let Some(found) = self.find(name) else {
            return Ok(None);
        };
        match *found.value {
            Value::Vector(vector) => Ok(Some((vector, found.property.at))),
            _ => Err(self.wrong_type(found, name, "a point or vector")),
        }
    }

    /// An invertible affine transform.
    pub fn transform(&self, name: &str) -> Result<Option<(Transform, Position)>, LoadError> {
        let Some(found) = self.find(name) else {
            return Ok(None);
        };
        let Value::Transform(matrix) = *found.value else {
            return Err(self.wrong_type(found, name, "a transform"));
        };
        let at = found.property.at;
        let transform = Transform::from_matrix(matrix)
            .map_err(|error| self.parameter_error(at, name, error.to_string()))?;
        Ok(Some((transform, at)))
    }

    /// `to_world`, or the map that changes nothing.
    pub fn to_world(&self) -> Result<Transform, LoadError> {
        Ok(self
            .transform("to_world")?
            .map_or(Transform::IDENTITY, |(transform, _)| transform))
    }

    /// The objects of one kind that it holds, whatever their names, in the file's order.
    pub fn children(&self, kind: ObjectKind) -> Vec<(ObjectIndex, Position)> {
        let mut children = Vec::new();
        for (property, used) in self.object.properties.iter().zip(&self.used) {
            if let Value::Object(child) = property.value
                && self.tree.object(child).kind == kind
            {
                used.set(true);
                children.push((child, property.at));
            }
        }
        children
    }

    /// The object of one kind that it holds, if any.
    ///
    /// # Errors
    ///
    /// If it holds several.
    pub fn child(&self, kind: ObjectKind) -> Result<Option<ObjectIndex>, LoadError> {
        match self.children(kind)[..] {
            [] => Ok(None),
            [(child, _)] => Ok(Some(child)),
            [_, (_, at), ..] => {
                let message = format!("{} may hold only one {}", self.what(), kind.tag());
                Err(LoadError::new(self.tree.source(at), message))
            }
        }
    }

    /// Fails if it holds an object of a kind that is not modelled there.
    pub fn refuse(&self, kind: ObjectKind, why: &str) -> Result<(), LoadError> {
        match self.children(kind).first() {
            None => Ok(()),
            Some((child, at)) => {
                let message = format!(
                    "{} inside {}: {why}",
                    what(self.tree.object(*child)),
                    self.what()
                );
                Err(LoadError::new(self.tree.source(*at), message))
            }
        }
    }

    /// Marks names as known that make no difference here.
    pub fn accept(&self, names: &[&str]) {
        for name in names {
            self.find(name);
        }
    }

    /// Fails if the file gives properties that were never asked for, as Mitsuba does.
    ///
    /// If the file is read leniently, parameters become warnings. Objects in places where there can be none
    /// fail all the same.
    pub fn finish(self) -> Result<(), LoadError> {
        let mut allowed = self.asked.take();
        allowed.sort_unstable();
        let strange = self.object.properties.iter().zip(&self.used);
        let strange = strange.filter(|(_, used)| !used.get());
        let errors = strange.filter_map(|(property, _)| {
            let error = LoadError::new(
                self.tree.source(property.at),
                self.strange(property, &allowed),
            );
            let is_parameter = !matches!(property.value, Value::Object(_));
            (!(is_parameter && self.tree.leaves_out(&error))).then_some(error)
        });
        LoadError::of_all(errors).map_or(Ok(()), Err)
    }

    /// The reason why a property that was never asked for is none of the plugin's.
    fn strange(&self, property: &Property, allowed: &[String]) -> String {
        if let Value::Object(child) = property.value
            && property.name.is_empty()
        {
            return format!(
                "{} cannot hold {}",
                self.what(),
                what(self.tree.object(child))
            );
        }
        let hint = did_you_mean(&property.name, allowed.iter().map(String::as_str));
        format!(
            "{} has no parameter \"{}\"{hint} (its parameters: {})",
            self.what(),
            shortened(&property.name),
            if allowed.is_empty() {
                "none".to_owned()
            } else {
                allowed.join(", ")
            }
        )
    }
}

/// Tag and plugin, as messages name an object.
pub fn what(object: &TreeObject) -> String {
    format!("{} \"{}\"", object.kind.tag(), shortened(&object.plugin))
}
