//! What may be wrong with a mesh.

use std::{fmt, sync::OnceLock};

/// Number of occurrences of a defect, and one example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Finding<T> {
    /// Number of occurrences.
    pub count: usize,
    /// The first occurrence; `None` if there is none.
    pub example: Option<T>,
}

impl<T> Finding<T> {
    pub(super) fn add(&mut self, example: T) {
        self.count += 1;
        self.example.get_or_insert(example);
    }
}

/// The defects of a mesh: counts with an example each.
///
/// Vertices at exactly the same position count as one: a mesh whose file repeats vertices along creases
/// (normals per face, seams of texture coordinates) is closed all the same. Edges are named by vertex indices
/// of the file, faces by their index, all counted from 0.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeshDiagnostics {
    /// Number of faces in the file.
    pub faces: usize,
    /// Number of sets of faces that are connected by edges.
    pub components: usize,
    /// Edges with one face: light leaks in or out.
    pub open_edges: Finding<[u32; 2]>,
    /// Edges with more than two faces: inside and outside cannot be told apart.
    pub non_manifold_edges: Finding<[u32; 2]>,
    /// Edges whose two faces wind opposite ways.
    pub clashing_edges: Finding<[u32; 2]>,
    /// Faces without area.
    pub zero_area_faces: Finding<u32>,
    /// Faces over the same three positions as an earlier face, whichever way they wind; searches skip them.
    /// Faces that wind the other way (the back of a sheet) still count for the edges.
    pub duplicate_faces: Finding<u32>,
    /// Vertices at the position of an earlier vertex. Not a defect by itself.
    pub repeated_positions: Finding<u32>,
    /// Faces whose interpolated normals all point to the other side than their winding does.
    pub opposed_normals: Finding<u32>,
    /// Closed components that enclose a negative volume; the example is a face.
    pub inward_components: Finding<u32>,
    /// The volume that closed components enclose, cubic scene units; inward ones subtract.
    pub signed_volume: f64,
}

impl MeshDiagnostics {
    /// True if each edge has exactly two faces that wind the same way.
    pub fn is_closed(&self) -> bool {
        self.faces > 0
            && self.open_edges.count == 0
            && self.non_manifold_edges.count == 0
            && self.clashing_edges.count == 0
    }

    /// True if the surface as a whole is inside out: closed, and its volume is negative.
    ///
    /// An inward component inside an outward one is a cavity, and no defect.
    pub fn is_inward(&self) -> bool {
        self.is_closed() && self.signed_volume < 0.0
    }

    /// One sentence for each kind of defect, with count and example; empty if there is none.
    ///
    /// `refractor`: true if light enters the mesh, so that it must have an inside and an outside.
    pub fn warnings(&self, refractor: bool) -> Vec<String> {
        let mut warnings = Vec::new();
        let mut say = |count: usize, what: &str, example: Option<String>, so: &str| {
            if let Some(example) = example {
                warnings.push(format!("{count} {what} (first: {example}){so}"));
            }
        };
        let edge = |[a, b]: [u32; 2]| format!("between vertices {a} and {b}");
        let face = |face: u32| format!("face {face}");
        if refractor {
            say(
                self.open_edges.count,
                "open edges",
                self.open_edges.example.map(edge),
                "; a refractor must be closed, light passes through the gap as if there were no surface",
            );
            say(
                self.non_manifold_edges.count,
                "edges with more than two faces",
                self.non_manifold_edges.example.map(edge),
                "; inside and outside are not well defined there",
            );
            say(
                self.clashing_edges.count,
                "edges whose faces wind round opposite ways",
                self.clashing_edges.example.map(edge),
                "; one of the two faces is inside out",
            );
            if self.is_inward() {
                say(
                    self.inward_components.count,
                    "closed parts are inside out",
                    self.inward_components.example.map(face),
                    "; light will take the inside for the outside (set flip_normals, or turn the faces round)",
                );
            }
        }
        say(
            self.opposed_normals.count,
            "faces whose vertex normals point to the other side than the winding",
            self.opposed_normals.example.map(face),
            "",
        );
        say(
            self.zero_area_faces.count,
            "faces of zero area",
            self.zero_area_faces.example.map(face),
            "",
        );
        say(
            self.duplicate_faces.count,
            "faces that repeat an earlier face",
            self.duplicate_faces.example.map(face),
            "; only the first is used",
        );
        warnings
    }
}

impl fmt::Display for MeshDiagnostics {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let state = if self.is_closed() {
            "closed"
        } else {
            "not closed"
        };
        write!(
            f,
            "{} faces, {} component(s), {state}",
            self.faces, self.components
        )?;
        if self.is_closed() {
            write!(f, ", signed volume {:.6e}", self.signed_volume)?;
        }
        for warning in self.warnings(true) {
            write!(f, "; {warning}")?;
        }
        Ok(())
    }
}

/// A mesh's defects, once they were asked for.
#[derive(Clone, Debug, Default)]
pub(super) struct OnceDiagnosed(pub(super) OnceLock<MeshDiagnostics>);

impl PartialEq for OnceDiagnosed {
    /// True: they follow from the rest of the mesh, asked for or not.
    fn eq(&self, _: &Self) -> bool {
        true
    }
}
