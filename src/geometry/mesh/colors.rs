//! Colours from a mesh's file.

use glam::DVec2;

use super::triangles::Mesh;

impl Mesh {
    /// The value of one of Mitsuba's mesh attributes at barycentric weights (of the second and third vertex)
    /// of a face: `vertex_color`, interpolated, or `face_color`; `None` if the mesh has none.
    pub fn attribute(&self, name: &str, face: u32, weights: DVec2) -> Option<[f64; 3]> {
        match name {
            "vertex_color" if !self.vertex_colors.is_empty() => {
                let corners = self.triangles[face as usize];
                let [a, b, c] = corners.map(|vertex| self.vertex_colors[vertex as usize]);
                let first = 1.0 - weights.x - weights.y;
                Some(std::array::from_fn(|channel| {
                    a[channel] * first + b[channel] * weights.x + c[channel] * weights.y
                }))
            }
            "face_color" => self.face_colors.get(face as usize).copied(),
            _ => None,
        }
    }

    /// The smallest and largest number of an attribute over the mesh; `None` if it has none.
    pub fn attribute_range(&self, name: &str) -> Option<[f64; 2]> {
        let colors = match name {
            "vertex_color" => &self.vertex_colors,
            "face_color" => &self.face_colors,
            _ => return None,
        };
        let mut numbers = colors.iter().flatten().copied();
        let first = numbers.next()?;
        Some(numbers.fold([first; 2], |[low, high], x| [low.min(x), high.max(x)]))
    }
}
