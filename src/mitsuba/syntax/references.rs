//! References: `<ref>` finds its object, and no object may hold itself.

use super::{MAX_DEPTH, ObjectIndex, Tree, Value, numbers};
use crate::mitsuba::error::LoadError;
use crate::setting::did_you_mean;

/// Replaces every [`Value::Reference`] by the object meant.
///
/// # Errors
///
/// If an id is unknown, or objects hold each other in a ring or too deep.
pub fn resolve(tree: &mut Tree) -> Result<(), LoadError> {
    for object in 0..tree.objects.len() {
        for property in 0..tree.objects[object].properties.len() {
            let Value::Reference(id) = &tree.objects[object].properties[property].value else {
                continue;
            };
            let Some(target) = tree.ids.get(id) else {
                let at = tree.source(tree.objects[object].properties[property].at);
                return Err(LoadError::new(at, unknown_id(tree, id)));
            };
            tree.objects[object].properties[property].value = Value::Object(*target);
        }
    }
    let mut heights = vec![Height::Unknown; tree.objects.len()];
    for object in 0..tree.objects.len() {
        measure(tree, object, 0, &mut heights)?;
    }
    Ok(())
}

fn unknown_id(tree: &Tree, id: &str) -> String {
    let hint = did_you_mean(id, tree.ids.keys().map(String::as_str));
    format!("no object has the id \"{}\"{hint}", numbers::shortened(id))
}

/// The number of levels of objects below an object, as far as it is known.
#[derive(Clone, Copy)]
enum Height {
    Unknown,
    BeingMeasured,
    Known(usize),
}

fn measure(
    tree: &Tree,
    object: ObjectIndex,
    depth: usize,
    heights: &mut [Height],
) -> Result<usize, LoadError> {
    let fail = |message: String| Err(LoadError::new(tree.source(tree.object(object).at), message));
    match heights[object] {
        Height::Known(height) => return Ok(height),
        Height::BeingMeasured => {
            return fail(format!(
                "{} holds itself through references",
                name(tree, object)
            ));
        }
        Height::Unknown => {}
    }
    heights[object] = Height::BeingMeasured;
    let mut height = 0;
    for property in &tree.object(object).properties {
        if let Value::Object(child) = property.value {
            // The depth is checked before the call, to bound the recursion on a long chain.
            let below = if depth < MAX_DEPTH {
                measure(tree, child, depth + 1, heights)?
            } else {
                MAX_DEPTH
            };
            height = height.max(below + 1);
        }
    }
    if height > MAX_DEPTH {
        return fail(format!(
            "objects hold each other more than {MAX_DEPTH} levels deep"
        ));
    }
    heights[object] = Height::Known(height);
    Ok(height)
}

fn name(tree: &Tree, object: ObjectIndex) -> String {
    let object = tree.object(object);
    match &object.id {
        Some(id) => format!("{} \"{}\"", object.kind.tag(), numbers::shortened(id)),
        None => format!(
            "{} of type \"{}\"",
            object.kind.tag(),
            numbers::shortened(&object.plugin)
        ),
    }
}
