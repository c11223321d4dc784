//! The attributes of a PLY element, by the names of its properties.
//!
//! `r g b` or `red green blue` is the attribute `color`. Other properties in a row make an attribute if their
//! names differ in what follows the last `_` alone, and if that runs through `0 1 2`, `1 2 3`, `x y z` or
//! `r g b`, or is the first of these. `color_0 color_1 color_2` is `color`, `heat_0` is `heat`, and
//! `tint_r tint_g tint_b` is `tint_color`. In the scene the name follows `vertex_` or `face_`.
//!
//! Everything else is no attribute. All this was found out by loading files in Mitsuba 3.9.1, which warns of
//! what it leaves out.

use std::collections::HashSet;

use super::ply_header::PlyElement;

/// The properties, by number, that an attribute has its values from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AttributeColumns {
    /// A single number.
    Number(usize),
    /// Red, green and blue.
    Color([usize; 3]),
}

/// Properties that are no attributes: they have a meaning of their own.
const RESERVED: [&str; 9] = [
    "x",
    "y",
    "z",
    "nx",
    "ny",
    "nz",
    "texture_u",
    "texture_v",
    "a",
];

/// The endings that properties of an attribute run through.
const ENDINGS: [[char; 4]; 4] = [
    ['0', '1', '2', '3'],
    ['1', '2', '3', '4'],
    ['x', 'y', 'z', 'w'],
    ['r', 'g', 'b', 'a'],
];

/// Properties in a row whose names begin alike.
struct Run<'a> {
    stem: &'a str,
    endings: [char; 4],
    columns: Vec<usize>,
    is_valid: bool,
}

impl<'a> Run<'a> {
    /// A run that a property begins; `None` if no attribute begins with its ending.
    fn begun(stem: &'a str, ending: char, column: usize) -> Option<Self> {
        let endings = ENDINGS.into_iter().find(|[first, ..]| *first == ending)?;
        Some(Self {
            stem,
            endings,
            columns: vec![column],
            is_valid: true,
        })
    }

    fn go_on(&mut self, ending: char, column: usize) {
        self.is_valid &= self.endings.get(self.columns.len()) == Some(&ending);
        self.columns.push(column);
    }

    fn attribute(&self) -> Option<(String, AttributeColumns)> {
        let columns = match *self.columns {
            [one] => AttributeColumns::Number(one),
            [red, green, blue] => AttributeColumns::Color([red, green, blue]),
            _ => return None,
        };
        let kind = if self.endings[0] == 'r' { "_color" } else { "" };
        self.is_valid
            .then(|| (format!("{}{kind}", self.stem), columns))
    }
}

/// The attributes of an element named `vertex` or `face`, in the file's order, and their columns.
pub fn find(element: &PlyElement) -> Vec<(String, AttributeColumns)> {
    let mut found = Vec::new();
    for names in [["r", "g", "b"], ["red", "green", "blue"]] {
        if let [Some(red), Some(green), Some(blue)] = names.map(|name| element.number(name)) {
            let columns = AttributeColumns::Color([red, green, blue]);
            found.push(("color".to_owned(), columns));
            break;
        }
    }
    let mut known = HashSet::new();
    let mut run: Option<Run> = None;
    let mut end = |run: &mut Option<Run>| found.extend(run.take().and_then(|run| run.attribute()));
    for (column, property) in element.properties.iter().enumerate() {
        let parts = property.name.rsplit_once('_');
        let named = parts.filter(|_| !RESERVED.contains(&property.name.as_str()));
        let ending = named.and_then(|(stem, ending)| Some((stem, one_letter(ending)?)));
        let Some((stem, ending)) = ending.filter(|_| property.is_number()) else {
            end(&mut run);
            continue;
        };
        match &mut run {
            Some(run) if run.stem == stem => run.go_on(ending, column),
            _ => {
                end(&mut run);
                // A name that stood before is not taken up again.
                run = Run::begun(stem, ending, column).filter(|_| !known.contains(stem));
                if run.is_some() {
                    known.insert(stem);
                }
            }
        }
    }
    end(&mut run);
    let prefixed = |(name, columns)| (format!("{}_{name}", element.name), columns);
    found.into_iter().map(prefixed).collect()
}

/// The only letter of a text.
fn one_letter(text: &str) -> Option<char> {
    let mut letters = text.chars();
    letters.next().filter(|_| letters.next().is_none())
}

#[cfg(test)]
mod tests {
    use super::super::ply_header::{PlyLayout, PlyProperty, PlyScalar};
    use super::*;

    /// The attributes of vertices with such properties.
    fn of(names: &str) -> String {
        let property = |name: &str| PlyProperty {
            name: name.to_owned(),
            layout: PlyLayout::Number(PlyScalar::F32),
        };
        let element = PlyElement {
            name: "vertex".to_owned(),
            count: 1,
            properties: names.split_whitespace().map(property).collect(),
        };
        let described = find(&element)
            .into_iter()
            .map(|(name, columns)| match columns {
                AttributeColumns::Number(at) => format!("{name} {at}"),
                AttributeColumns::Color([red, green, blue]) => format!("{name} {red}{green}{blue}"),
            });
        described.collect::<Vec<_>>().join(", ")
    }

    #[test]
    fn attributes_are_those_that_mitsuba_finds() {
        // Properties beside what `mi.traverse` of Mitsuba 3.9.1 lists for a file with them.
        for (properties, attributes) in [
            ("color_0 color_1 color_2", "vertex_color 012"),
            ("weight_0", "vertex_weight 0"),
            (
                "x color_0 color_1 color_2 weight_0",
                "vertex_color 123, vertex_weight 4",
            ),
            ("color_1 color_2 color_3", "vertex_color 012"),
            ("tint_x tint_y tint_z", "vertex_tint 012"),
            ("tint_r tint_g tint_b", "vertex_tint_color 012"),
            ("tint_r", "vertex_tint_color 0"),
            ("a_b_0", "vertex_a_b 0"),
            ("g r b", "vertex_color 102"),
            ("red green blue alpha", "vertex_color 012"),
            ("a_0 b_0 a_1", "vertex_a 0, vertex_b 1"),
            ("a_0 q a_1 a_2", "vertex_a 0"),
            ("t_0 t_0x t_1", "vertex_t 0"),
            ("color_1 color_0 color_2", ""),
            ("tint_0 tint_1", ""),
            ("tint_0 tint_1 tint_2 tint_3", ""),
            ("t_0 t_1 t_2 t_3 t_4", ""),
            ("color_0 color_1 weight_0 color_2", "vertex_weight 2"),
            ("tint_0 tint_1 tint_x", ""),
            ("tint_2 tint_3 tint_4", ""),
            ("tint_y tint_z tint_w", ""),
            ("tint_00", ""),
            ("quality", ""),
            ("r g", ""),
            ("texture_u texture_v", ""),
        ] {
            assert_eq!(of(properties), attributes, "{properties}");
        }
    }
}
