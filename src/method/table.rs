//! The table of all methods with their settings, for flags, help and documents.

use std::fmt::Write as _;

use super::entry::Entry;
pub use super::rows::MAX_COUNT;
use crate::setting::{Preset, Setting};

/// One setting as a flag: the rows of all references that have its key.
pub struct Flag {
    /// The key, which is the flag without its dashes.
    pub key: &'static str,
    /// Each method that has it, with its row.
    pub rows: Vec<(&'static str, &'static Setting)>,
    /// True if it limits a run.
    pub is_limit: bool,
}

/// The settings of all references, each key once: limits first. Techniques have theirs by `--set` alone.
pub fn flags() -> Vec<Flag> {
    let mut flags: Vec<Flag> = Vec::new();
    let references: Vec<_> = Entry::references().collect();
    let limits = references.iter().map(|one| (one, one.about().limits, true));
    let settings = references
        .iter()
        .map(|one| (one, one.about().settings, false));
    for (method, rows, is_limit) in limits.chain(settings) {
        for row in rows {
            match flags.iter_mut().find(|flag| flag.key == row.key) {
                Some(flag) => flag.rows.push((method.about().name, row)),
                None => flags.push(Flag {
                    key: row.key,
                    rows: vec![(method.about().name, row)],
                    is_limit,
                }),
            }
        }
    }
    flags
}

impl Flag {
    /// The help of a flag: its meanings, the methods that have it, its words and its defaults.
    pub fn help(&self) -> String {
        let mut parts = Vec::new();
        for (meaning, methods) in self.grouped(|row| row.meaning) {
            parts.push(format!("{meaning} ({})", methods.join(", ")));
        }
        let mut words = Vec::new();
        for word in self.rows.iter().flat_map(|(_, row)| row.kind.words()) {
            if !words.contains(&word.0) {
                words.push(word.0);
            }
        }
        let mut text = parts.join("; ");
        if !words.is_empty() {
            let _ = write!(text, " [{}]", words.join(", "));
        }
        // The default of most methods first, without their names.
        let mut defaults = self.grouped(|row| row.default.text());
        defaults.sort_by_key(|(_, methods)| std::cmp::Reverse(methods.len()));
        let defaults = defaults.iter().enumerate();
        let defaults = defaults.map(|(i, (default, methods))| match i {
            0 => (*default).to_owned(),
            _ => format!("{}: {default}", methods.join(", ")),
        });
        let defaults: Vec<String> = defaults.collect();
        let _ = write!(text, " [default: {}]", defaults.join("; "));
        text
    }

    /// The methods with the same text of their rows, in the order of the table.
    fn grouped(&self, text: impl Fn(&Setting) -> &'static str) -> Vec<(&'static str, Vec<&str>)> {
        let mut groups: Vec<(&'static str, Vec<&str>)> = Vec::new();
        for (method, row) in &self.rows {
            match groups.iter_mut().find(|group| group.0 == text(row)) {
                Some((_, methods)) => methods.push(method),
                None => groups.push((text(row), vec![method])),
            }
        }
        groups
    }
}

/// The settings of a method as Markdown: a table with a row a setting, then a list of the words of choices.
pub fn markdown(name: &str) -> String {
    let rows = rows(name);
    let mut text = "| setting | values | default | meaning |\n|---|---|---|---|\n".to_owned();
    for row in &rows {
        let unit = match row.unit {
            "" => String::new(),
            unit => format!(" \\[{unit}\\]"),
        };
        let default = match row.default {
            Preset::Value(value) => format!("`{value}`"),
            Preset::Rule(rule) => rule.to_owned(),
        };
        let _ = writeln!(
            text,
            "| `{}` | {} | {default} | {}{unit} |",
            row.key,
            row.kind.column(),
            row.meaning
        );
    }
    for row in rows.iter().filter(|row| !row.kind.words().is_empty()) {
        let _ = writeln!(text, "\nWords of `{}`:\n", row.key);
        for (word, meaning) in row.kind.words() {
            let _ = writeln!(text, "- `{word}`: {meaning}");
        }
    }
    text
}

/// The settings of a method as plain text: its meaning, values and default, and the words of choices.
pub fn listing(name: &str) -> String {
    let rows = rows(name);
    let width = rows.iter().map(|row| row.key.len()).max().unwrap_or(0);
    let mut text = String::new();
    for row in &rows {
        let _ = writeln!(text, "  {:width$}  {}", row.key, row.meaning);
        let words = row.kind.words();
        let values = match (words.is_empty(), row.unit) {
            (false, _) => String::new(),
            (true, "") => format!("{}; ", row.kind.column()),
            (true, unit) => format!("{} [{unit}]; ", row.kind.column()),
        };
        let default = row.default.text();
        let _ = writeln!(text, "  {:width$}    {values}default: {default}", "");
        let longest = words.iter().map(|(word, _)| word.len()).max().unwrap_or(0);
        for (word, meaning) in words {
            let _ = writeln!(text, "  {:width$}    {word:longest$}  {meaning}", "");
        }
    }
    text
}

/// The methods that have a setting.
pub(super) fn owners(key: &str) -> Vec<&'static str> {
    let has = |entry: &Entry| entry.table().iter().any(|row| row.key == key);
    let entries = Entry::all().filter(has);
    entries.map(Entry::name).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_help_of_a_flag_is_short_and_names_its_methods() {
        let flags = flags();
        for flag in &flags {
            let help = flag.help();
            // Four lines of a terminal with 100 columns.
            assert!(help.len() <= 4 * 65, "{}: {help}", flag.key);
            for (method, _) in &flag.rows {
                assert!(help.contains(method), "{}: {help}", flag.key);
            }
        }
        assert!(flags.is_sorted_by_key(|flag| !flag.is_limit));
    }

    #[test]
    fn defaults_that_differ_are_told_by_method() {
        let flags = flags();
        let help = |key: &str| flags.iter().find(|flag| flag.key == key).unwrap().help();
        assert!(help("replicates").contains("[default: 32; path: 8; photon-map: 16; full: "));
        assert!(
            help("error").ends_with("[default: no limit; beams: 0.1% if nothing else is limited]")
        );
    }

    #[test]
    fn words_are_listed_with_their_meanings() {
        for text in [markdown("photons"), listing("photons")] {
            assert!(text.contains("Owen-scrambled"), "{text}");
        }
        assert_eq!(owners("spp"), ["path", "full"]);
    }
}
