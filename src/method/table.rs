//! The table of all methods with their settings, for flags, help and documents.

use super::entry::Entry;
use crate::setting::{Kind, Setting};

/// One setting as a flag: the rows of all references that have its key.
pub struct Flag {
    /// The key, which is the flag without its dashes.
    pub key: &'static str,
    /// Each method that has it, with its row.
    pub rows: Vec<(&'static str, &'static Setting)>,
}

/// The settings of all references, each key once: limits first. Techniques have theirs by `--set` alone.
pub fn flags() -> Vec<Flag> {
    let mut flags: Vec<Flag> = Vec::new();
    for entry in Entry::all() {
        let Entry::Reference(_) = entry else { continue };
        for row in entry.table() {
            match flags.iter_mut().find(|flag| flag.key == row.key) {
                Some(flag) => flag.rows.push((entry.name(), row)),
                None => flags.push(Flag {
                    key: row.key,
                    rows: vec![(entry.name(), row)],
                }),
            }
        }
    }
    flags
}

impl Flag {
    /// The help of a flag: its meanings, methods, words and defaults.
    pub fn help(&self) -> String {
        let mut groups: Vec<(&Setting, Vec<&str>)> = Vec::new();
        for (method, row) in &self.rows {
            let same = |one: &&mut (&Setting, Vec<&str>)| {
                one.0.meaning == row.meaning && one.0.default == row.default
            };
            match groups.iter_mut().find(same) {
                Some((_, methods)) => methods.push(method),
                None => groups.push((row, vec![method])),
            }
        }
        let lines = groups.iter().map(|(row, methods)| {
            let methods = methods.join(", ");
            format!(
                "{} ({methods}) [default: {}]",
                row.meaning,
                row.default.text()
            )
        });
        let lines: Vec<String> = lines.collect();
        let Some((_, row)) = self.rows.first() else {
            return String::new();
        };
        match row.kind {
            Kind::Choice(words) => {
                let words = words().into_iter();
                let words: Vec<String> = words
                    .map(|(word, meaning)| format!("{word}: {meaning}"))
                    .collect();
                format!("{}; {}", lines.join("; "), words.join("; "))
            }
            _ => lines.join("; "),
        }
    }
}

/// The settings of a method as rows of Markdown: key, values, default, unit, meaning.
pub fn markdown(name: &str) -> String {
    let mut text = "| setting | values | default | meaning |\n|---|---|---|---|\n".to_owned();
    for row in rows(name) {
        let values = match row.kind {
            Kind::Choice(words) => {
                let words: Vec<String> = words()
                    .iter()
                    .map(|(word, _)| format!("`{word}`"))
                    .collect();
                words.join(", ")
            }
            kind => kind.allowed(),
        };
        let unit = if row.unit.is_empty() {
            String::new()
        } else {
            format!(" [{}]", row.unit)
        };
        text.push_str(&format!(
            "| `{}` | {values}{unit} | {} | {} |\n",
            row.key,
            row.default.text(),
            row.meaning
        ));
    }
    text
}

/// The settings of a method: limits first; empty for a name that is no method's.
pub fn rows(name: &str) -> Vec<&'static Setting> {
    Entry::of(name).map_or_else(|_| Vec::new(), Entry::table)
}

/// Each method's name and meaning.
pub fn summary() -> Vec<(&'static str, &'static str)> {
    Entry::all()
        .map(|entry| (entry.name(), entry.meaning()))
        .collect()
}
