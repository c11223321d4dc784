//! Attributes: numbers by name, at a mesh's vertices or on its faces.

/// The elements of a mesh that an attribute has values for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AttributeOf {
    /// One value a position; between vertices it is interpolated.
    Vertices,
    /// One value a triangle.
    Faces,
}

/// The values of an attribute, one an element.
#[derive(Clone, Debug, PartialEq)]
pub enum AttributeValues {
    /// Single numbers: the same in all channels.
    Numbers(Vec<f64>),
    /// Red, green and blue.
    Colors(Vec<[f64; 3]>),
}

impl AttributeValues {
    pub(super) fn len(&self) -> usize {
        match self {
            Self::Numbers(values) => values.len(),
            Self::Colors(values) => values.len(),
        }
    }

    /// Memory held, bytes.
    pub(super) fn bytes(&self) -> usize {
        match self {
            Self::Numbers(values) => size_of_val(&**values),
            Self::Colors(values) => size_of_val(&**values),
        }
    }

    pub(super) fn at(&self, index: u32) -> [f64; 3] {
        match self {
            Self::Numbers(values) => [values[index as usize]; 3],
            Self::Colors(values) => values[index as usize],
        }
    }

    pub(super) fn numbers(&self) -> &[f64] {
        match self {
            Self::Numbers(values) => values,
            Self::Colors(values) => values.as_flattened(),
        }
    }
}

/// Numbers that a mesh's file gives by name, as Mitsuba's `mesh_attribute` looks them up.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshAttribute {
    /// Its name, e.g. `vertex_color`.
    pub name: String,
    /// The elements that have values.
    pub of: AttributeOf,
    /// A value for each of them. Not checked to be finite: a file may hold attributes that no scene uses.
    pub values: AttributeValues,
}
