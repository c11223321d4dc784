//! The contents of a file that no result depends on.

use std::collections::HashSet;

use super::plugin::what;
use crate::mitsuba::syntax::{ObjectIndex, Tree, TreeObject};
use crate::scene::Ignored;

/// Entries in the order found, one for each object.
#[derive(Default)]
pub struct IgnoredList {
    pub list: Vec<Ignored>,
    objects: HashSet<ObjectIndex>,
}

impl IgnoredList {
    /// Notes an object, unless it is noted already.
    pub fn add(&mut self, tree: &Tree, index: ObjectIndex, why: &str) {
        if self.objects.insert(index) {
            let object = tree.object(index);
            self.list.push(Ignored {
                at: tree.source(object.at),
                what: with_id(object),
                why: why.to_owned(),
            });
        }
    }
}

fn with_id(object: &TreeObject) -> String {
    match &object.id {
        Some(id) => format!("{} (id \"{id}\")", what(object)),
        None => what(object),
    }
}
