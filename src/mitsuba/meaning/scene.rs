//! The meaning of the scene element: everything in it, in the file's order.

use std::collections::{HashMap, HashSet};

use rayon::prelude::*;

use super::forms::{self, ShapeForm};
use super::ignored::IgnoredList;
use super::materials::Materials;
use super::media::Media;
use super::plugin::{Plugin, what};
use super::{emitters, integrator, sensors};
use crate::geometry::{Shape, Transform};
use crate::mitsuba::error::LoadError;
use crate::mitsuba::files::Files;
use crate::mitsuba::syntax::{ObjectIndex, ObjectKind, Position, Tree, Value, shortened};
use crate::scene::{Emitter, MediumId, Object, SceneParts, Sensor, ShapeId, Warning};
use crate::setting::did_you_mean;

/// Largest number of shapes that instances may show in all. Each is a shape of its own here, so that a small
/// file of groups and instances could make more than any memory holds.
const MOST_INSTANCED: usize = 1 << 18;

/// A scene whose forms are not yet built.
#[derive(Debug)]
pub struct Meaning {
    pub forms: Vec<ShapeForm>,
    /// All but the shapes, the path and the hash.
    pub parts: SceneParts,
}

impl Meaning {
    /// Makes all shapes, mesh files in parallel.
    ///
    /// # Errors
    ///
    /// All shapes that cannot be made, in the file's order.
    pub fn build_shapes(
        forms: Vec<ShapeForm>,
        objects: &[Object],
    ) -> Result<Vec<Shape>, LoadError> {
        let shapes: Vec<Result<Shape, String>> =
            forms.into_par_iter().map(ShapeForm::build).collect();
        let (mut made, mut errors) = (Vec::with_capacity(shapes.len()), Vec::new());
        for (shape, object) in shapes.into_iter().zip(objects) {
            match shape {
                Ok(shape) => made.push(shape),
                Err(message) => {
                    let message = format!("shape \"{}\": {message}", object.plugin);
                    errors.push(LoadError::new(object.declared_at.clone(), message));
                }
            }
        }
        LoadError::of_all(errors).map_or(Ok(made), Err)
    }
}

/// Reads the meaning of a tree; mesh files are loaded, not yet parsed.
///
/// # Errors
///
/// If something is not modelled, unknown, out of range or missing; with its place.
pub fn read(tree: &Tree, files: &mut Files) -> Result<Meaning, LoadError> {
    let mut reader = SceneReader {
        tree,
        files,
        materials: Materials::default(),
        media: Media::default(),
        ignored: IgnoredList::default(),
        forms: Vec::new(),
        parts: SceneParts {
            warnings: tree.warnings().to_vec(),
            ..SceneParts::default()
        },
        attached: HashSet::new(),
        instanced: 0,
        ids: Ids::new(tree),
    };
    let mut errors = Vec::new();
    for property in &tree.root().properties {
        let read = if let Value::Object(child) = property.value {
            reader.top_level(child)
        } else {
            let message = format!("scene has no parameter \"{}\"", shortened(&property.name));
            Err(LoadError::new(tree.source(property.at), message))
        };
        errors.extend(read.err());
    }
    if errors.is_empty() {
        // Whether something is used is known only if all could be read.
        errors.extend(reader.note_unused().err());
    }
    if let Some(error) = LoadError::of_all(errors) {
        return Err(error);
    }
    let mut parts = reader.parts;
    parts.materials = reader.materials.list;
    parts.media = reader.media.list;
    parts.material_ids = reader.materials.ids;
    parts.textures = reader.materials.textures.list;
    parts
        .warnings
        .append(&mut reader.materials.textures.warnings);
    parts.warnings.extend(tree.left_out());
    let integrator = parts.integrator.as_ref().map(|it| it.plugin.as_str());
    if let (Some(plugin @ ("path" | "direct" | "ptracer")), false) =
        (integrator, parts.media.is_empty())
    {
        parts.warnings.push(Warning {
            at: None,
            message: format!(
                "media absorb light here; Mitsuba's {plugin} takes no notice of them, and volpath does"
            ),
        });
    }
    parts.ignored = reader.ignored.list;
    Ok(Meaning {
        forms: reader.forms,
        parts,
    })
}

struct SceneReader<'t, 'f> {
    tree: &'t Tree,
    files: &'f mut Files,
    materials: Materials,
    media: Media,
    ignored: IgnoredList,
    forms: Vec<ShapeForm>,
    /// The parts so far. The integrator is the first that sets limits on paths.
    parts: SceneParts,
    /// Emitters that belong to a shape.
    attached: HashSet<ObjectIndex>,
    /// Number of shapes that instances show so far.
    instanced: usize,
    ids: Ids,
}

impl SceneReader<'_, '_> {
    fn top_level(&mut self, child: ObjectIndex) -> Result<(), LoadError> {
        let tree = self.tree;
        let object = tree.object(child);
        match object.kind {
            ObjectKind::Shape => self.top_level_shape(child),
            // It shines only if a shape refers to it.
            ObjectKind::Emitter if object.plugin == "area" => Ok(()),
            ObjectKind::Emitter => {
                let warnings = &mut self.parts.warnings;
                let emitter = emitters::read(
                    tree,
                    child,
                    &mut self.materials.textures,
                    self.files,
                    warnings,
                )?;
                if emitter.is_environment()
                    && self.parts.emitters.iter().any(Emitter::is_environment)
                {
                    return Err(Plugin::new(tree, child)
                        .error("is a second environment; a scene can have one"));
                }
                self.emitter(child, emitter)
            }
            ObjectKind::Sensor => {
                let (kind, film) = sensors::read(tree, child)?;
                let id = self.ids.of(tree, child, "");
                self.note_sampler(child);
                let medium = self.around(child)?;
                self.parts.sensors.push(Sensor {
                    id,
                    kind,
                    film,
                    medium,
                });
                Ok(())
            }
            ObjectKind::Integrator => {
                let found = integrator::read(tree, child)?;
                self.ignored
                    .add(tree, child, integrator::why_ignored(found.as_ref()));
                self.parts.integrator = self.parts.integrator.take().or(found);
                Ok(())
            }
            ObjectKind::Bsdf
            | ObjectKind::Texture
            | ObjectKind::Medium
            | ObjectKind::Volume
            | ObjectKind::Phase
            | ObjectKind::Film
            | ObjectKind::Sampler
            | ObjectKind::Field
            | ObjectKind::ReconstructionFilter
            | ObjectKind::Scene => Ok(()),
        }
    }

    fn emitter(&mut self, object: ObjectIndex, emitter: Emitter) -> Result<(), LoadError> {
        if self.around(object)?.is_some_and(|it| it != MediumId::CLEAR) {
            self.parts.immersed.push(self.parts.emitters.len());
        }
        self.parts.emitters.push(emitter);
        Ok(())
    }

    fn note_sampler(&mut self, sensor: ObjectIndex) {
        let why = "the number of samples is chosen on the command line";
        for (sampler, _) in Plugin::new(self.tree, sensor).children(ObjectKind::Sampler) {
            self.ignored.add(self.tree, sampler, why);
        }
    }

    fn top_level_shape(&mut self, shape: ObjectIndex) -> Result<(), LoadError> {
        match self.tree.object(shape).plugin.as_str() {
            // A group is nothing by itself: instances show it.
            "shapegroup" => Ok(()),
            "instance" => self.instance(shape),
            "merge" => self.merged(shape),
            _ => self.shape(shape, None),
        }
    }

    /// The shapes that Mitsuba would make one mesh of, to trace it faster. Each stays one of its own.
    fn merged(&mut self, merge: ObjectIndex) -> Result<(), LoadError> {
        let plugin = Plugin::new(self.tree, merge);
        for (member, _) in plugin.children(ObjectKind::Shape) {
            match self.tree.object(member).plugin.as_str() {
                "merge" => {
                    return Err(Plugin::new(self.tree, member).error("cannot be inside a merge"));
                }
                _ => self.top_level_shape(member)?,
            }
        }
        plugin.finish()
    }

    /// Copies all shapes of a group into world space.
    fn instance(&mut self, instance: ObjectIndex) -> Result<(), LoadError> {
        let tree = self.tree;
        let plugin = Plugin::new(tree, instance);
        let to_world = plugin.to_world()?;
        let group = plugin
            .child(ObjectKind::Shape)?
            .ok_or_else(|| plugin.error("needs a shapegroup"))?;
        if tree.object(group).plugin != "shapegroup" {
            return Err(plugin.error(format!(
                "shows a shapegroup, not a {}",
                what(tree.object(group))
            )));
        }
        plugin.finish()?;
        let prefix = self.ids.of(tree, instance, "") + "/";
        let group = Plugin::new(tree, group);
        for (member, _) in group.children(ObjectKind::Shape) {
            self.instanced += 1;
            if self.instanced > MOST_INSTANCED {
                return Err(Plugin::new(tree, instance).error(format!(
                    "is one of instances that show more than {MOST_INSTANCED} shapes in all, which is all that is allowed"
                )));
            }
            if matches!(
                tree.object(member).plugin.as_str(),
                "shapegroup" | "instance" | "merge"
            ) {
                return Err(Plugin::new(tree, member).error("cannot be inside a shapegroup"));
            }
            self.shape(member, Some((&to_world, &prefix)))?;
        }
        group.finish()
    }

    /// Reads a shape with a form of its own. `instance`: the transform that is applied last, and the
    /// beginning of ids.
    fn shape(
        &mut self,
        shape: ObjectIndex,
        instance: Option<(&Transform, &str)>,
    ) -> Result<(), LoadError> {
        let tree = self.tree;
        let plugin = Plugin::new(tree, shape);
        let (outer, prefix) = instance.unwrap_or((&Transform::IDENTITY, ""));
        let Some((form, name)) = forms::read(&plugin, outer, self.files)? else {
            let all = || {
                forms::MODELLED
                    .into_iter()
                    .chain(["shapegroup", "instance", "merge"])
            };
            let hint = did_you_mean(plugin.name(), all());
            let modelled = all().collect::<Vec<_>>().join(", ");
            return Err(plugin.error(format!(
                "is not modelled{hint}; modelled shapes are: {modelled}"
            )));
        };
        let ids = &mut self.ids;
        let boundary = (self.media).boundary(tree, &plugin, |medium| ids.of(tree, medium, ""))?;
        plugin.float_or("silhouette_sampling_weight", 1.0)?;
        let bsdf = plugin.child(ObjectKind::Bsdf)?;
        let emitter = plugin.child(ObjectKind::Emitter)?;
        let material = match bsdf {
            Some(bsdf) => self.materials.read(tree, bsdf, self.files)?,
            None => self.materials.default_material(emitter.is_some()),
        };
        let id = ShapeId(self.parts.objects.len() as u32);
        let meters = plugin.children(ObjectKind::Sensor);
        if instance.is_some() {
            plugin.refuse(
                ObjectKind::Emitter,
                "a shape that is shown by instances cannot shine",
            )?;
            plugin.refuse(
                ObjectKind::Sensor,
                "a shape that is shown by instances cannot be measured",
            )?;
        }
        let declared_at = plugin.source();
        plugin.finish()?;
        if let Some(emitter) = emitter {
            if !self.attached.insert(emitter) {
                return Err(Plugin::new(tree, emitter)
                    .error("shines from several shapes; give each its own"));
            }
            let textures = &mut self.materials.textures;
            let area = emitters::read_area(tree, emitter, id, textures, self.files)?;
            self.emitter(emitter, area)?;
        }
        self.meters(&meters, id)?;
        let object_id = self.ids.of(tree, shape, prefix);
        self.parts.objects.push(Object {
            id: object_id,
            plugin: name,
            declared_at,
            material,
            boundary,
            to_world: form.to_world(),
        });
        self.forms.push(form);
        Ok(())
    }

    fn meters(
        &mut self,
        meters: &[(ObjectIndex, Position)],
        shape: ShapeId,
    ) -> Result<(), LoadError> {
        for (number, (meter, at)) in meters.iter().enumerate() {
            let (kind, film, warning) = sensors::read_meter(self.tree, *meter, shape)?;
            self.parts.warnings.extend(warning);
            if number == 1 {
                self.parts.warnings.push(Warning {
                    at: Some(self.tree.source(*at)),
                    message: "the shape has several sensors; Mitsuba 3 allows one".to_owned(),
                });
            }
            let id = self.ids.of(self.tree, *meter, "");
            self.note_sampler(*meter);
            let medium = None;
            self.parts.sensors.push(Sensor {
                id,
                kind,
                film,
                medium,
            });
        }
        Ok(())
    }

    /// The medium that a sensor or an emitter says is around it.
    fn around(&mut self, object: ObjectIndex) -> Result<Option<MediumId>, LoadError> {
        let (tree, ids) = (self.tree, &mut self.ids);
        match Plugin::new(tree, object).child(ObjectKind::Medium)? {
            None => Ok(None),
            Some(medium) => (self.media)
                .read(tree, medium, &mut |it| ids.of(tree, it, ""))
                .map(Some),
        }
    }

    /// Notes top-level objects that no shape or sensor refers to.
    fn note_unused(&mut self) -> Result<(), LoadError> {
        for property in &self.tree.root().properties {
            let Value::Object(child) = property.value else {
                continue;
            };
            let why = match self.tree.object(child).kind {
                ObjectKind::Emitter
                    if self.tree.object(child).plugin == "area"
                        && !self.attached.contains(&child) =>
                {
                    return Err(Plugin::new(self.tree, child).error("must belong to a shape"));
                }
                ObjectKind::Bsdf if self.materials.is_used(child) => continue,
                ObjectKind::Bsdf => "no shape uses it",
                ObjectKind::Texture if self.materials.textures.is_used(child) => continue,
                ObjectKind::Medium if self.media.is_used(child) => continue,
                ObjectKind::Sampler | ObjectKind::Film | ObjectKind::ReconstructionFilter => {
                    "it belongs to no sensor"
                }
                ObjectKind::Texture
                | ObjectKind::Medium
                | ObjectKind::Volume
                | ObjectKind::Phase
                | ObjectKind::Field => "nothing that is modelled uses it",
                _ => continue,
            };
            self.ignored.add(self.tree, child, why);
        }
        Ok(())
    }
}

/// Names for shapes and sensors, each once.
struct Ids {
    /// The ids in the file and those made so far.
    taken: HashSet<String>,
    made: HashMap<String, u32>,
}

impl Ids {
    fn new(tree: &Tree) -> Self {
        let taken = tree
            .objects()
            .iter()
            .filter_map(|object| object.id.clone())
            .collect();
        Self {
            taken,
            made: HashMap::new(),
        }
    }

    /// The file's id, or `<plugin>_<n>`; both behind `prefix`.
    fn of(&mut self, tree: &Tree, object: ObjectIndex, prefix: &str) -> String {
        let object = tree.object(object);
        if let Some(id) = &object.id {
            return format!("{prefix}{id}");
        }
        let stem = format!("{prefix}{}", object.plugin);
        loop {
            let number = self.made.entry(stem.clone()).or_insert(0);
            let id = format!("{stem}_{number}");
            *number += 1;
            if self.taken.insert(id.clone()) {
                return id;
            }
        }
    }
}
