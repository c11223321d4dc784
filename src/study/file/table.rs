//! A table of a TOML file whose keys and values know their places.

use std::ops::Range;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeTable, DeValue};

use super::error::FileError;
use crate::setting::SettingError;

/// A text and its file, to name places in it.
#[derive(Clone, Copy)]
pub struct Text<'a> {
    /// The file.
    pub path: &'a Path,
    /// Its contents.
    pub contents: &'a str,
}

impl Text<'_> {
    /// An error at a place: line and column count from 1, columns in characters.
    pub fn error(&self, at: &Range<usize>, message: impl Into<String>) -> FileError {
        let before = self.contents.get(..at.start).unwrap_or(self.contents);
        let line = before.rsplit('\n').next().unwrap_or("");
        FileError::Content {
            path: self.path.to_owned(),
            line: before.matches('\n').count() + 1,
            column: line.chars().count() + 1,
            message: message.into(),
        }
    }
}

/// A table whose keys are taken one by one; keys that nobody took are unknown.
pub struct TomlTable<'a> {
    text: Text<'a>,
    /// The table's name in messages: `study`, `[truth]`.
    name: &'a str,
    at: Range<usize>,
    content: &'a DeTable<'a>,
    known: Vec<&'static str>,
}

/// A value and its place.
pub struct TomlNode<'a> {
    text: Text<'a>,
    key: &'a str,
    value: &'a Spanned<DeValue<'a>>,
}

impl<'a> TomlTable<'a> {
    /// A table that stands at a place.
    pub fn new(text: Text<'a>, name: &'a str, at: Range<usize>, content: &'a DeTable<'a>) -> Self {
        Self {
            text,
            name,
            at,
            content,
            known: Vec::new(),
        }
    }

    /// The value of a key, if it is there.
    pub fn take(&mut self, key: &'static str) -> Option<TomlNode<'a>> {
        self.known.push(key);
        self.nodes().find(|node| node.key == key)
    }

    /// The value of a key.
    ///
    /// # Errors
    ///
    /// If it is missing.
    pub fn need(&mut self, key: &'static str) -> Result<TomlNode<'a>, FileError> {
        self.take(key).ok_or_else(|| {
            let message = format!("{} needs a key \"{key}\"", self.name);
            self.text.error(&self.at, message)
        })
    }

    /// All values that nobody took: for tables whose keys are names.
    pub fn rest(&self) -> impl Iterator<Item = TomlNode<'a>> + '_ {
        self.nodes().filter(|node| !self.known.contains(&node.key))
    }

    /// Refuses keys that nobody took.
    ///
    /// # Errors
    ///
    /// The first unknown key.
    pub fn finish(self) -> Result<(), FileError> {
        let unknown = self.content.keys().find(|key| {
            let name: &str = key.get_ref();
            !self.known.contains(&name)
        });
        unknown.map_or(Ok(()), |key| {
            let what = format!("key of {}", self.name);
            let error = SettingError::unknown(what, key.get_ref(), self.known.iter().copied());
            Err(self.text.error(&key.span(), error.to_string()))
        })
    }

    fn nodes(&self) -> impl Iterator<Item = TomlNode<'a>> + use<'a> {
        let text = self.text;
        self.content.iter().map(move |(key, value)| TomlNode {
            text,
            key: key.get_ref(),
            value,
        })
    }
}

impl<'a> TomlNode<'a> {
    /// Its key.
    pub fn key(&self) -> &'a str {
        self.key
    }

    /// An error at this value.
    pub fn error(&self, message: impl Into<String>) -> FileError {
        self.text.error(&self.value.span(), message)
    }

    fn wrong(&self, allowed: &str) -> FileError {
        let found = self.value.get_ref().type_str();
        self.error(format!(
            "{} is of type {found}; {allowed} is allowed",
            self.key
        ))
    }

    /// A string, number or truth value as text.
    ///
    /// # Errors
    ///
    /// For lists, tables and dates.
    pub fn scalar(&self) -> Result<String, FileError> {
        scalar(self.value).ok_or_else(|| self.wrong("a number, a text, true or false"))
    }

    /// A text that `parse` understands.
    ///
    /// # Errors
    ///
    /// For other texts; `allowed` names the texts that are allowed.
    pub fn parsed<T>(
        &self,
        parse: impl FnOnce(&str) -> Option<T>,
        allowed: &str,
    ) -> Result<T, FileError> {
        let text = self.scalar()?;
        parse(&text)
            .ok_or_else(|| self.error(format!("{} is \"{text}\"; allowed are {allowed}", self.key)))
    }

    /// The values of a list, each as text; `None` if it is no list.
    ///
    /// # Errors
    ///
    /// For a list that is empty or holds more than scalars.
    pub fn list(&self) -> Result<Option<Vec<String>>, FileError> {
        let Some(list) = self.value.get_ref().as_array() else {
            return Ok(None);
        };
        if list.is_empty() {
            return Err(self.error(format!("{} is an empty list", self.key)));
        }
        let values = list.iter().map(|one| {
            scalar(one).ok_or_else(|| {
                let message = format!("{}: a list holds numbers or texts only", self.key);
                self.text.error(&one.span(), message)
            })
        });
        values.collect::<Result<_, _>>().map(Some)
    }

    /// True if it is a table.
    pub fn is_table(&self) -> bool {
        self.value.get_ref().as_table().is_some()
    }

    /// Its table, under this name in messages; `None` if it is no table.
    pub fn table(&self, name: &'a str) -> Option<TomlTable<'a>> {
        let content = self.value.get_ref().as_table()?;
        Some(TomlTable::new(self.text, name, self.value.span(), content))
    }

    /// Its table.
    ///
    /// # Errors
    ///
    /// If it is no table.
    pub fn need_table(&self, name: &'a str) -> Result<TomlTable<'a>, FileError> {
        self.table(name).ok_or_else(|| self.wrong("a table"))
    }

    /// Its tables, of `[[key]]`.
    ///
    /// # Errors
    ///
    /// If it holds anything else.
    pub fn tables(&self, name: &'a str) -> Result<Vec<TomlTable<'a>>, FileError> {
        let Some(list) = self.value.get_ref().as_array() else {
            return Err(self.wrong(&format!("{name}, once for each,")));
        };
        let tables = list.iter().map(|value| {
            let node = TomlNode {
                text: self.text,
                key: self.key,
                value,
            };
            node.need_table(name)
        });
        tables.collect()
    }
}

fn scalar(value: &Spanned<DeValue>) -> Option<String> {
    match value.get_ref() {
        DeValue::String(text) => Some(text.to_string()),
        DeValue::Integer(number) if number.radix() == 10 => Some(number.as_str().to_owned()),
        DeValue::Float(number) => Some(number.as_str().to_owned()),
        DeValue::Boolean(value) => Some(value.to_string()),
        _ => None,
    }
}
