//! Why a file does not become a scene.

use std::path::Path;

use crate::scene::{SceneError, SourcePosition};

/// Why a file does not become a scene: where, what, and what is allowed there.
///
/// It displays as `scene.xml:12:5: bsdf "roughplastic" is not modelled; ...`. A problem inside a
/// mesh file is reported at the XML element that asked for the file, and names the place inside it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{at}: {message}")]
pub struct LoadError {
    /// The element or file that is to blame.
    pub at: SourcePosition,
    /// What is wrong, and what is allowed.
    pub message: String,
}

impl LoadError {
    /// An error at a known place.
    pub(super) fn new(at: SourcePosition, message: impl Into<String>) -> Self {
        Self {
            at,
            message: message.into(),
        }
    }

    /// An error about a file as a whole.
    pub(super) fn of_file(file: &Path, message: impl Into<String>) -> Self {
        let at = SourcePosition {
            file: file.to_owned(),
            line: 0,
            column: 0,
        };
        Self::new(at, message)
    }
}

impl From<SceneError> for LoadError {
    fn from(error: SceneError) -> Self {
        Self::new(error.at, error.message)
    }
}

/// `; did you mean "..."?` with the name nearest to what was written, or nothing where none is near.
///
/// Near means at most two letters in five changed (Levenshtein), which catches slips of the
/// finger and a forgotten underscore but does not propose unrelated words.
pub(super) fn did_you_mean<'a>(
    written: &str,
    allowed: impl IntoIterator<Item = &'a str>,
) -> String {
    let plain = |name: &str| name.to_lowercase().replace(['_', '-', ' '], "");
    let written = plain(written);
    let nearest = allowed
        .into_iter()
        .map(|name| (edit_distance(&written, &plain(name)), name))
        .min();
    match nearest {
        Some((distance, name)) if distance * 5 <= name.chars().count() * 2 => {
            format!("; did you mean \"{name}\"?")
        }
        _ => String::new(),
    }
}

/// How many letters must be inserted, removed or replaced to get from `a` to `b`.
fn edit_distance(a: &str, b: &str) -> usize {
    // What a file wrote may be of any length; suggestions are for names.
    if a.len() > 64 {
        return usize::MAX / 4;
    }
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, other) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(letter != *other);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_of_the_finger_finds_its_word_and_a_strange_word_finds_none() {
        let allowed = ["int_ior", "ext_ior", "specular_reflectance"];
        assert_eq!(
            did_you_mean("intIOR", allowed),
            "; did you mean \"int_ior\"?"
        );
        assert_eq!(
            did_you_mean("specular_reflectence", allowed),
            "; did you mean \"specular_reflectance\"?"
        );
        assert_eq!(did_you_mean("caustic_receiver", allowed), "");
        assert_eq!(did_you_mean(&"x".repeat(1_000_000), allowed), "");
    }

    #[test]
    fn edit_distance_counts_insertions_removals_and_replacements() {
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
        assert_eq!(edit_distance("abc", "abc"), 0);
    }
}
