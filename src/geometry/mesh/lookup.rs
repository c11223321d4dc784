//! Attributes at points of a mesh.

use glam::DVec2;

use super::attributes::{AttributeOf, MeshAttribute};
use super::triangles::Mesh;

impl Mesh {
    fn find_attribute(&self, name: &str) -> Option<&MeshAttribute> {
        self.attributes.iter().find(|one| one.name == name)
    }

    /// The names of its attributes, in the file's order.
    pub fn attribute_names(&self) -> impl Iterator<Item = &str> {
        self.attributes.iter().map(|one| one.name.as_str())
    }

    /// The value of an attribute at barycentric weights (of the second and third vertex) of a face; `None` if
    /// the mesh has no attribute of this name.
    pub fn attribute(&self, name: &str, face: u32, weights: DVec2) -> Option<[f64; 3]> {
        let MeshAttribute { of, values, .. } = self.find_attribute(name)?;
        Some(match of {
            AttributeOf::Vertices => {
                let [a, b, c] = self.triangles[face as usize].map(|vertex| values.at(vertex));
                let first = 1.0 - weights.x - weights.y;
                std::array::from_fn(|channel| {
                    a[channel] * first + b[channel] * weights.x + c[channel] * weights.y
                })
            }
            AttributeOf::Faces => values.at(face),
        })
    }

    /// The smallest and largest number of an attribute over the mesh, both NaN if any number is; `None` if
    /// the mesh has no attribute of this name.
    pub fn attribute_range(&self, name: &str) -> Option<[f64; 2]> {
        let numbers = self.find_attribute(name)?.values.numbers();
        let range = [f64::INFINITY, f64::NEG_INFINITY];
        Some(numbers.iter().fold(range, |[low, high], x| {
            if x.is_nan() || low.is_nan() {
                [f64::NAN; 2]
            } else {
                [low.min(*x), high.max(*x)]
            }
        }))
    }
}
