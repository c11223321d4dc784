//! Reader of elements, which become objects and properties.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use glam::DMat4;
use roxmltree::{Document, Node, ParsingOptions};

use super::lines::LineIndex;
use super::parameters::Parameters;
use super::transforms::{self, required};
use super::values::{XmlElement, value, version};
use super::{
    MAX_DEPTH, ObjectIndex, ObjectKind, Position, Property, Tree, TreeObject, Value, Version,
};
use super::{guard, numbers, references, upgrade};
use crate::mitsuba::error::LoadError;
use crate::mitsuba::files::{Files, line_ends};
use crate::scene::{SourcePosition, Warning};

/// Largest depth of nested includes; Mitsuba's limit.
const MAX_INCLUDE_DEPTH: usize = 15;

/// Largest number of files, and of their bytes, that may be included in all, each as often as it is.
///
/// Fifteen files that each include the next ten times make 10¹⁵. Scenes include some tens.
const MOST_INCLUDES: usize = 1 << 14;
const MOST_INCLUDED_BYTES: usize = 1 << 24;

/// Reads a main file and all it includes, upgrades old files and resolves references.
///
/// # Errors
///
/// If a file cannot be read, is not well-formed, or holds something that no plugin could mean.
pub fn read(path: &Path, given: &[(String, String)], files: &mut Files) -> Result<Tree, LoadError> {
    let mut reader = Reader {
        tree: Tree::default(),
        parameters: Parameters::new(given),
        files,
        open: Vec::new(),
        named: HashMap::new(),
        included_bytes: 0,
    };
    reader.file(path, None)?;
    if let Some(name) = reader.parameters.unused() {
        let message = format!("the parameter \"{name}\" was given, but the file uses no ${name}");
        return Err(LoadError::of_file(path, message));
    }
    let mut tree = reader.tree;
    upgrade::upgrade(&mut tree);
    references::resolve(&mut tree)?;
    Ok(tree)
}

struct Reader<'a> {
    tree: Tree,
    parameters: Parameters,
    files: &'a mut Files,
    /// The file being read, and those that include it.
    open: Vec<PathBuf>,
    /// The line of every named property so far, in a map: a scene may hold any number of them.
    named: HashMap<(ObjectIndex, String), u32>,
    /// The length of all includes so far.
    included_bytes: usize,
}

/// The file that elements are read from.
struct SourceFile {
    file: u32,
    version: Version,
    lines: LineIndex,
}

impl Reader<'_> {
    fn file(
        &mut self,
        path: &Path,
        included_at: Option<(ObjectIndex, String)>,
    ) -> Result<(), LoadError> {
        let bytes = self
            .files
            .read(path)
            .map_err(|message| LoadError::of_file(path, message))?;
        if included_at.is_some() {
            self.included_bytes += bytes.len();
        }
        let text = std::str::from_utf8(&bytes).map_err(|error| {
            let line = 1 + line_ends(&bytes[..error.valid_up_to()]);
            LoadError::of_file(
                path,
                format!("line {line} is not UTF-8 (no other encoding is read)"),
            )
        })?;
        let lines = LineIndex::new(text);
        if let Some(tag) = guard::crowded_tag(text) {
            let at = lines.position(0, tag);
            let at = SourcePosition {
                file: path.to_owned(),
                line: at.line,
                column: at.column,
            };
            let most = guard::MOST_ATTRIBUTES;
            return Err(LoadError::new(
                at,
                format!("an element with more than {most} attributes"),
            ));
        }
        // Document type declarations are refused. Mitsuba expands none of their entities either, and without
        // them a file cannot grow while it is parsed. (`&amp;` and `&#160;` need none.)
        let options = ParsingOptions {
            allow_dtd: false,
            ..ParsingOptions::default()
        };
        let text = guard::with_plain_comments(text);
        let document = Document::parse_with_options(&text, options).map_err(|error| {
            let at = SourcePosition {
                file: path.to_owned(),
                line: error.pos().row,
                column: error.pos().col,
            };
            LoadError::new(at, format!("not well-formed XML: {error}"))
        })?;
        let root = document.root_element();
        let source = SourceFile {
            file: self.tree.files.len() as u32,
            version: root
                .attribute("version")
                .and_then(version)
                .unwrap_or_default(),
            lines,
        };
        self.tree.files.push((path.to_owned(), source.version));
        let at = source.lines.position(source.file, root.range().start);
        if root.attribute("version").and_then(version).is_none() {
            return self.fail(
                at,
                "the outermost element needs a version such as version=\"3.0.0\"".to_owned(),
            );
        }
        let folder = path.parent().unwrap_or(Path::new("")).to_owned();
        self.files.search_first(folder);
        self.open.push(path.to_owned());
        match included_at {
            None if root.tag_name().name() != "scene" => {
                return self.fail(
                    at,
                    format!(
                        "the outermost element must be <scene>, not <{}>",
                        root.tag_name().name()
                    ),
                );
            }
            None => self.object(root, ObjectKind::Scene, None, &source)?,
            Some((parent, _)) if root.tag_name().name() == "scene" => {
                for child in root.children().filter(Node::is_element) {
                    self.child(child, parent, 1, &source)?;
                }
            }
            Some((parent, name)) => {
                let kind = self.object_kind(root, &source)?;
                self.object(root, kind, Some((parent, name, 1)), &source)?;
            }
        }
        self.open.pop();
        Ok(())
    }

    fn object_kind(&self, node: Node, source: &SourceFile) -> Result<ObjectKind, LoadError> {
        let tag = node.tag_name().name();
        ObjectKind::of_tag(tag).ok_or_else(|| {
            let at = source.lines.position(source.file, node.range().start);
            LoadError::new(self.tree.source(at), format!("<{tag}> is not an object"))
        })
    }

    fn fail<T>(&self, at: Position, message: String) -> Result<T, LoadError> {
        Err(LoadError::new(self.tree.source(at), message))
    }

    /// An element with the parameters in all attributes replaced.
    fn element<'n>(
        &mut self,
        node: Node<'n, '_>,
        source: &SourceFile,
    ) -> Result<XmlElement<'n>, LoadError> {
        let at = source.lines.position(source.file, node.range().start);
        let mut attributes = Vec::with_capacity(node.attributes().len());
        for attribute in node.attributes() {
            match self.parameters.substitute(attribute.value()) {
                Ok(value) => attributes.push((attribute.name().to_owned(), value)),
                Err(message) => return self.fail(at, message),
            }
        }
        Ok(XmlElement {
            tag: node.tag_name().name(),
            attributes,
            at,
        })
    }

    /// Reads an object and all that it holds. `parent`: its holder, its name there, and the holder's depth.
    fn object(
        &mut self,
        node: Node,
        kind: ObjectKind,
        parent: Option<(ObjectIndex, String, usize)>,
        source: &SourceFile,
    ) -> Result<(), LoadError> {
        let element = self.element(node, source)?;
        let at = element.at;
        let is_outermost = node.parent_element().is_none();
        let allowed: &[&str] = if is_outermost {
            &["type", "id", "name", "version"]
        } else {
            &["type", "id", "name"]
        };
        let described = transforms::allow(&element.attributes, allowed).and_then(|()| {
            if kind == ObjectKind::Scene {
                return Ok("scene".to_owned());
            }
            required(&element.attributes, "type").map(str::to_owned)
        });
        let plugin = match described {
            Ok(plugin) => plugin,
            Err(message) => return self.fail(at, format!("<{}>: {message}", element.tag)),
        };
        let index = self.tree.objects.len();
        let id = element.attribute("id").map(str::to_owned);
        if let Some(id) = &id
            && let Some(previous) = self.tree.ids.insert(id.clone(), index)
        {
            let previous = self.tree.source(self.tree.object(previous).at);
            return self.fail(
                at,
                format!(
                    "the id \"{}\" is taken by {previous}",
                    numbers::shortened(id)
                ),
            );
        }
        self.tree.objects.push(TreeObject {
            kind,
            plugin,
            id,
            at,
            properties: Vec::new(),
        });
        let mut depth = 0;
        if let Some((holder, name, holder_depth)) = parent {
            depth = holder_depth + 1;
            let name = element.attribute("name").map_or(name, str::to_owned);
            self.give(holder, name, at, Value::Object(index))?;
        }
        if depth > MAX_DEPTH {
            return self.fail(
                at,
                format!("elements nest more than {MAX_DEPTH} levels deep"),
            );
        }
        for child in node.children().filter(Node::is_element) {
            self.child(child, index, depth, source)?;
        }
        Ok(())
    }

    /// Reads an element inside an object.
    fn child(
        &mut self,
        node: Node,
        holder: ObjectIndex,
        depth: usize,
        source: &SourceFile,
    ) -> Result<(), LoadError> {
        let tag = node.tag_name().name();
        let is_spectrum_plugin = tag == "spectrum" && node.has_attribute("type");
        let kind = if is_spectrum_plugin {
            Some(ObjectKind::Texture)
        } else {
            ObjectKind::of_tag(tag)
        };
        if let Some(kind) = kind {
            if kind == ObjectKind::Scene {
                let at = source.lines.position(source.file, node.range().start);
                return self.fail(at, "a scene cannot be inside another object".to_owned());
            }
            return self.object(node, kind, Some((holder, String::new(), depth)), source);
        }
        let element = self.element(node, source)?;
        if tag != "transform"
            && let Some(inner) = node.first_element_child()
        {
            let at = source.lines.position(source.file, inner.range().start);
            return self.fail(
                at,
                format!("<{}> cannot be inside <{tag}>", inner.tag_name().name()),
            );
        }
        match tag {
            "transform" => self.transform(node, &element, holder, source),
            "include" => self.include(&element, holder),
            _ => {
                let outcome = self.simple(&element, holder, source);
                outcome.map_err(|message| {
                    LoadError::new(self.tree.source(element.at), format!("<{tag}>: {message}"))
                })
            }
        }
    }

    /// Reads an element that needs nothing but its attributes.
    fn simple(
        &mut self,
        element: &XmlElement,
        holder: ObjectIndex,
        source: &SourceFile,
    ) -> Result<(), String> {
        let allow = |allowed: &[&str]| transforms::allow(&element.attributes, allowed);
        let get = |name: &str| required(&element.attributes, name);
        match element.tag {
            "ref" => {
                allow(&["id", "name"])?;
                let name = element.attribute("name").unwrap_or_default().to_owned();
                self.add(
                    holder,
                    name,
                    element.at,
                    Value::Reference(get("id")?.to_owned()),
                )
            }
            "alias" => {
                allow(&["id", "as"])?;
                let (id, alias) = (get("id")?, get("as")?);
                let target = *(self.tree.ids.get(id)).ok_or_else(|| {
                    format!(
                        "no object before it has the id \"{}\"",
                        numbers::shortened(id)
                    )
                })?;
                match self.tree.ids.insert(alias.to_owned(), target) {
                    None => Ok(()),
                    Some(_) => Err(format!("the id \"{}\" is taken", numbers::shortened(alias))),
                }
            }
            "default" => {
                allow(&["name", "value"])?;
                let (name, value) = (get("name")?, get("value")?);
                if name.is_empty() {
                    return Err("the name must not be empty".to_owned());
                }
                self.parameters.set_default(name, value)
            }
            "path" => {
                allow(&["value"])?;
                if holder != 0 {
                    return Err("only a scene may hold it".to_owned());
                }
                let folder = self.files.resolve(get("value")?);
                if !folder.is_dir() {
                    return Err(format!("there is no folder {}", folder.display()));
                }
                self.files.search_first(folder);
                Ok(())
            }
            _ => {
                let value = value(element, source.version < [2, 0, 0])?;
                self.add(holder, get("name")?.to_owned(), element.at, value)
            }
        }
    }

    fn transform(
        &mut self,
        node: Node,
        element: &XmlElement,
        holder: ObjectIndex,
        source: &SourceFile,
    ) -> Result<(), LoadError> {
        let name = transforms::allow(&element.attributes, &["name"])
            .and_then(|()| required(&element.attributes, "name"));
        let name = match name {
            Ok(name) => name.to_owned(),
            Err(message) => return self.fail(element.at, format!("<transform>: {message}")),
        };
        let mut matrix = DMat4::IDENTITY;
        for step in node.children().filter(Node::is_element) {
            let step = self.element(step, source)?;
            let tag = if step.tag == "lookAt" && source.version < [2, 0, 0] {
                "lookat"
            } else {
                step.tag
            };
            match transforms::step(tag, &step.attributes) {
                Ok(next) => {
                    matrix = next * matrix;
                    let odd = transforms::oddity(tag, &step.attributes);
                    let at = self.tree.source(step.at);
                    (self.tree.warnings).extend(odd.map(|message| Warning {
                        at: Some(at),
                        message,
                    }));
                }
                Err(message) => return self.fail(step.at, format!("<{}>: {message}", step.tag)),
            }
        }
        if !matrix.is_finite() {
            return self.fail(element.at, format!("the transform \"{name}\" overflows"));
        }
        self.give(holder, name, element.at, Value::Transform(matrix))
    }

    fn include(&mut self, element: &XmlElement, holder: ObjectIndex) -> Result<(), LoadError> {
        let allowed = transforms::allow(&element.attributes, &["filename", "name"]);
        let path = match allowed.and_then(|()| required(&element.attributes, "filename")) {
            Ok(name) => self.files.resolve(name),
            Err(message) => return self.fail(element.at, format!("<include>: {message}")),
        };
        if self.open.len() > MAX_INCLUDE_DEPTH {
            return self.fail(
                element.at,
                format!(
                    "<include>: files include each other more than {MAX_INCLUDE_DEPTH} levels deep"
                ),
            );
        }
        // The first of the files is the main one.
        if self.tree.files.len() > MOST_INCLUDES || self.included_bytes > MOST_INCLUDED_BYTES {
            return self.fail(
                element.at,
                format!(
                    "<include>: the includes before it are {MOST_INCLUDES} files or {MOST_INCLUDED_BYTES} bytes, which is all that is allowed"
                ),
            );
        }
        if !path.is_file() {
            return self.fail(
                element.at,
                format!("<include>: there is no file {}", path.display()),
            );
        }
        if self.open.contains(&path) {
            return self.fail(
                element.at,
                format!("<include>: {} includes itself", path.display()),
            );
        }
        let name = element.attribute("name").unwrap_or_default().to_owned();
        let folders = self.files.folder_count();
        self.file(&path, Some((holder, name)))?;
        // As in Mitsuba, folders of an included file count only inside it. Meshes are looked up from the main
        // file's.
        self.files.forget_folders(folders);
        Ok(())
    }

    /// As [`Self::add`], with the place in the error.
    fn give(
        &mut self,
        holder: ObjectIndex,
        name: String,
        at: Position,
        value: Value,
    ) -> Result<(), LoadError> {
        self.add(holder, name, at, value)
            .map_err(|message| LoadError::new(self.tree.source(at), message))
    }

    /// Gives `holder` a property.
    fn add(
        &mut self,
        holder: ObjectIndex,
        name: String,
        at: Position,
        value: Value,
    ) -> Result<(), String> {
        if !name.is_empty()
            && let Some(previous) = self.named.insert((holder, name.clone()), at.line)
        {
            let name = numbers::shortened(&name);
            return Err(format!("\"{name}\" was given in line {previous} already"));
        }
        let property = Property { name, at, value };
        self.tree.objects[holder].properties.push(property);
        Ok(())
    }
}
