//! Circles of files: a file that imports from another, and the other from it, directly or by way of more.
//!
//! An import counts for the file that defines what is imported, so re-exports are followed. A `mod.rs` that
//! only re-exports imports nothing by that.

use std::collections::{BTreeMap, BTreeSet};

/// Files that import from each other in a circle.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Circle {
    /// Paths, sorted.
    pub files: Vec<String>,
    /// A line for each pair of files of the circle: who imports what from whom.
    pub imports: Vec<String>,
}

/// All circles among files, each a path below `src` and its text; a file is in one circle at most.
pub fn circles(sources: &[(String, String)]) -> Vec<Circle> {
    let house = House::new(sources);
    let imports: BTreeMap<&String, Imports> = house
        .files
        .keys()
        .map(|module| (module, house.imports(module)))
        .collect();
    let reach: BTreeMap<&String, BTreeSet<&String>> = imports
        .keys()
        .map(|module| (*module, reachable(module, &imports)))
        .collect();
    let mut circles = Vec::new();
    let mut done = BTreeSet::new();
    for (module, reached) in &reach {
        let circle: BTreeSet<&String> = reached
            .iter()
            .filter(|other| reach[*other].contains(module))
            .copied()
            .collect();
        if circle.len() > 1 && done.insert(circle.clone()) {
            circles.push(house.circle(&circle, &imports));
        }
    }
    circles
}

/// Modules from which a file imports, and the names that it imports from each.
type Imports = BTreeMap<String, BTreeSet<String>>;

/// All modules that a module imports from, directly or by way of others.
fn reachable<'a>(from: &String, imports: &'a BTreeMap<&String, Imports>) -> BTreeSet<&'a String> {
    let mut reached = BTreeSet::new();
    let mut open = vec![from];
    while let Some(module) = open.pop() {
        for next in imports[module].keys() {
            if reached.insert(next) {
                open.push(next);
            }
        }
    }
    reached
}

/// A path in the code, word by word: `crate::film::exr` has three.
type Words = Vec<String>;

/// A module's file.
struct File {
    path: String,
    uses: Vec<Use>,
    /// All paths of two words or more outside `use`.
    paths: Vec<Words>,
}

/// One name that a `use` brings in.
struct Use {
    path: Words,
    name: String,
    is_public: bool,
}

/// All files, by module path (`film::exr`; the crate's root is empty).
struct House {
    files: BTreeMap<String, File>,
}

impl House {
    fn new(sources: &[(String, String)]) -> Self {
        let files = sources.iter().map(|(path, text)| {
            let stem = path.trim_end_matches(".rs");
            let module = match stem {
                "lib" => String::new(),
                _ => stem.trim_end_matches("/mod").replace('/', "::"),
            };
            (module, File::new(path, text))
        });
        Self {
            files: files.collect(),
        }
    }

    fn imports(&self, module: &str) -> Imports {
        let file = &self.files[module];
        let mut imports = Imports::new();
        let mut add = |from: Option<String>, name: String| {
            if let Some(from) = from.filter(|from| from != module) {
                imports.entry(from).or_default().insert(name);
            }
        };
        let mut modules: BTreeMap<&str, Words> = BTreeMap::new();
        for one in &file.uses {
            let Some(path) = self.absolute(module, &one.path) else {
                continue;
            };
            if self.files.contains_key(&path.join("::")) {
                modules.insert(&one.name, path);
            } else if !one.is_public {
                add(self.definer(path), one.name.clone());
            }
        }
        for path in &file.paths {
            let name = path.join("::");
            if let Some(whole) = modules.get(path[0].as_str()) {
                add(self.definer([whole, &path[1..]].concat()), name.clone());
            }
            if let Some(whole) = self.absolute(module, path) {
                add(self.definer(whole), name);
            }
        }
        imports
    }

    /// A path from the crate's root; `None` for paths of other crates, and of names in the file itself.
    fn absolute(&self, module: &str, path: &[String]) -> Option<Words> {
        let mut place: Words = module.split("::").map(str::to_owned).collect();
        place.retain(|word| !word.is_empty());
        let rest = match path[0].as_str() {
            "crate" => return Some(path[1..].to_vec()),
            "self" => &path[1..],
            "super" => {
                let levels = path.iter().take_while(|word| *word == "super").count();
                place.truncate(place.len().saturating_sub(levels));
                &path[levels..]
            }
            _ => {
                let child = [place.as_slice(), &path[..1]].concat().join("::");
                self.files.contains_key(&child).then_some(path)?
            }
        };
        Some([place.as_slice(), rest].concat())
    }

    /// The module whose file defines what a path from the root leads to.
    fn definer(&self, path: Words) -> Option<String> {
        let mut path = path;
        // No re-export passes through so many: a circle of re-exports does not compile.
        for _ in 0..10 {
            let (module, rest) = (0..=path.len()).rev().find_map(|length| {
                let module = path[..length].join("::");
                self.files
                    .contains_key(&module)
                    .then(|| (module, &path[length..]))
            })?;
            let Some(name) = rest.first().filter(|name| *name != "self") else {
                return Some(module);
            };
            let file = &self.files[&module];
            let mut exports = file.uses.iter().rev();
            let Some(export) = exports.find(|one| one.is_public && one.name == *name) else {
                return Some(module);
            };
            path = [self.absolute(&module, &export.path)?.as_slice(), &rest[1..]].concat();
        }
        None
    }

    fn circle(&self, modules: &BTreeSet<&String>, imports: &BTreeMap<&String, Imports>) -> Circle {
        let mut lines = Vec::new();
        for module in modules {
            for (from, names) in imports[*module]
                .iter()
                .filter(|(from, _)| modules.contains(from))
            {
                let names: Vec<&str> = names.iter().map(String::as_str).collect();
                let (file, other) = (&self.files[*module].path, &self.files[from].path);
                lines.push(format!("{file} imports from {other}: {}", names.join(", ")));
            }
        }
        let mut files: Vec<String> = modules
            .iter()
            .map(|module| self.files[*module].path.clone())
            .collect();
        files.sort();
        Circle {
            files,
            imports: lines,
        }
    }
}

impl File {
    fn new(path: &str, text: &str) -> Self {
        let text = text.split("#[cfg(test)]\nmod").next().unwrap_or_default();
        let words = tokens(text);
        let mut file = Self {
            path: path.to_owned(),
            uses: Vec::new(),
            paths: Vec::new(),
        };
        let mut at = 0;
        while at < words.len() {
            if words[at] == "use" && words.get(at + 1).is_some_and(|next| next != "<") {
                let is_public = is_public(&words[..at]);
                let end = at
                    + words[at..]
                        .iter()
                        .position(|word| word == ";")
                        .unwrap_or(words.len() - at);
                let mut tree = words[at + 1..end].iter().map(String::as_str).peekable();
                read_tree(&mut tree, &[], is_public, &mut file.uses);
                at = end;
            } else if is_word(&words[at]) && (at == 0 || words[at - 1] != "::") {
                let mut path = vec![words[at].clone()];
                while let [separator, word, ..] = &words[at + 1..]
                    && separator == "::"
                    && is_word(word)
                {
                    path.push(word.clone());
                    at += 2;
                }
                if path.len() > 1 {
                    file.paths.push(path);
                }
            }
            at += 1;
        }
        file
    }
}

/// True if what ends here is `pub` or `pub(...)`.
fn is_public(before: &[String]) -> bool {
    match before {
        [.., last] if last == "pub" => true,
        [.., last] if last == ")" => {
            let open = before.iter().rposition(|word| word == "(");
            open.is_some_and(|open| open > 0 && before[open - 1] == "pub")
        }
        _ => false,
    }
}

/// Reads `a::b`, `a::b as c`, `a::*` or `a::{...}`.
fn read_tree<'a>(
    words: &mut std::iter::Peekable<impl Iterator<Item = &'a str>>,
    before: &[String],
    is_public: bool,
    into: &mut Vec<Use>,
) {
    let mut path = before.to_vec();
    while let Some(word) = words.peek().copied() {
        match word {
            "," | "}" => break,
            "{" => {
                words.next();
                while words.peek().is_some_and(|word| *word != "}") {
                    read_tree(words, &path, is_public, into);
                    words.next_if_eq(&",");
                }
                words.next();
                return;
            }
            "as" => {
                words.next();
                let name = words.next().unwrap_or_default().to_owned();
                into.push(Use {
                    path,
                    name,
                    is_public,
                });
                return;
            }
            "::" => {}
            word => path.push(word.to_owned()),
        }
        words.next();
    }
    if let Some(name) = path.last().cloned() {
        into.push(Use {
            path,
            name,
            is_public,
        });
    }
}

fn is_word(token: &str) -> bool {
    token.starts_with(|letter: char| letter.is_alphabetic() || letter == '_')
}

/// Words, `::`, and single signs; comments and the text of strings left out.
fn tokens(text: &str) -> Vec<String> {
    let mut tokens = Vec::new();
    let mut rest = text;
    while let Some(letter) = rest.chars().next() {
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if rest.starts_with("r\"") || rest.starts_with("r#\"") {
            let (open, close) = if rest.starts_with("r\"") {
                (2, "\"")
            } else {
                (3, "\"#")
            };
            rest[open..]
                .find(close)
                .map_or(rest.len(), |end| open + end + close.len())
        } else if letter == '"' {
            string_length(rest)
        } else if letter == '\'' {
            character_length(rest)
        } else if letter.is_alphanumeric() || letter == '_' {
            let end = rest.find(|letter: char| !letter.is_alphanumeric() && letter != '_');
            let end = end.unwrap_or(rest.len());
            tokens.push(rest[..end].to_owned());
            end
        } else if rest.starts_with("::") {
            tokens.push("::".to_owned());
            2
        } else {
            if !letter.is_whitespace() {
                tokens.push(letter.to_string());
            }
            letter.len_utf8()
        };
        rest = &rest[length..];
    }
    tokens
}

/// Bytes of the string literal that a text begins with.
fn string_length(text: &str) -> usize {
    let mut is_escaped = true;
    for (at, letter) in text.char_indices() {
        match letter {
            _ if is_escaped => is_escaped = false,
            '\\' => is_escaped = true,
            '"' => return at + 1,
            _ => {}
        }
    }
    text.len()
}

/// Bytes of the character literal that a text begins with; of a lifetime the quote alone.
fn character_length(text: &str) -> usize {
    let mut letters = text.char_indices().skip(1);
    match letters.next() {
        Some((_, '\\')) => {
            let end = letters.skip(1).find(|(_, letter)| *letter == '\'');
            end.map_or(text.len(), |(at, _)| at + 1)
        }
        _ => match letters.next() {
            Some((at, '\'')) => at + 1,
            _ => 1,
        },
    }
}
