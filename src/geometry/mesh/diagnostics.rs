//! Defects of meshes.

use std::{collections::hash_map::Entry, fmt};

use glam::DVec3;

use super::{hash::Map, triangles::Mesh, weld};

/// Number of occurrences of a defect, and one example.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Finding<T> {
    /// Number of occurrences.
    pub count: usize,
    /// The first occurrence; `None` if there is none.
    pub example: Option<T>,
}

impl<T> Finding<T> {
    fn add(&mut self, example: T) {
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

/// The faces at an edge so far.
struct EdgeUse {
    /// Its ends, as the file's own vertices.
    example: [u32; 2],
    first_face: u32,
    faces: u32,
    /// Uses from the lower to the higher vertex, less uses the other way.
    balance: i32,
}

impl Mesh {
    /// The mesh's defects: open and non-manifold edges, orientation, degenerate faces.
    pub fn diagnose(&self) -> MeshDiagnostics {
        diagnose(self)
    }
}

fn diagnose(mesh: &Mesh) -> MeshDiagnostics {
    let mut found = MeshDiagnostics {
        faces: mesh.triangles.len(),
        ..MeshDiagnostics::default()
    };
    let representatives = weld::representatives(&mesh.positions);
    for (vertex, &first) in representatives.iter().enumerate() {
        if first != vertex as u32 {
            found.repeated_positions.add(vertex as u32);
        }
    }

    let mut seen = Map::with_capacity_and_hasher(mesh.triangles.len(), <_>::default());
    let mut edges: Map<[u32; 2], EdgeUse> =
        Map::with_capacity_and_hasher(2 * mesh.triangles.len(), <_>::default());
    let mut components = Components::new(mesh.triangles.len());
    let mut counted = vec![false; mesh.triangles.len()];
    for (face, &triangle) in mesh.triangles.iter().enumerate() {
        let face = face as u32;
        let corners = triangle.map(|vertex| representatives[vertex as usize]);
        let cross = cross_of(mesh, face);
        if cross == DVec3::ZERO {
            found.zero_area_faces.add(face);
        } else if opposes_its_normals(mesh, triangle, cross) {
            found.opposed_normals.add(face);
        }
        if !weld::has_distinct_corners(corners) {
            // Two of its edges are the same one, there and back; the third is a point.
            continue;
        }
        match seen.entry(weld::key(corners)) {
            Entry::Vacant(slot) => {
                slot.insert(weld::winding(corners));
            }
            Entry::Occupied(first) => {
                found.duplicate_faces.add(face);
                if *first.get() == weld::winding(corners) {
                    continue; // the same face twice, which changes nothing
                }
            }
        }
        counted[face as usize] = true;
        for i in 0..3 {
            let (a, b) = (corners[i], corners[(i + 1) % 3]);
            let entry = edges.entry([a.min(b), a.max(b)]).or_insert(EdgeUse {
                example: [triangle[i], triangle[(i + 1) % 3]],
                first_face: face,
                faces: 0,
                balance: 0,
            });
            entry.faces += 1;
            entry.balance += if a < b { 1 } else { -1 };
            components.join(entry.first_face, face);
        }
    }
    judge_edges(&edges, &mut components, &mut found);
    judge_components(mesh, &counted, &mut components, &mut found);
    found
}

/// Counts edges by kind; marks components with a defect as open.
fn judge_edges(
    edges: &Map<[u32; 2], EdgeUse>,
    components: &mut Components,
    found: &mut MeshDiagnostics,
) {
    let mut odd: Vec<&EdgeUse> = edges
        .values()
        .filter(|edge| edge.faces != 2 || edge.balance != 0)
        .collect();
    // The map's order changes from run to run; the examples must not.
    odd.sort_unstable_by_key(|edge| (edge.first_face, edge.example));
    for edge in odd {
        match edge.faces {
            1 => found.open_edges.add(edge.example),
            2 => found.clashing_edges.add(edge.example),
            _ => found.non_manifold_edges.add(edge.example),
        }
        components.mark_open(edge.first_face);
    }
}

/// Counts components, and sums the volumes of closed ones.
fn judge_components(
    mesh: &Mesh,
    counted: &[bool],
    components: &mut Components,
    found: &mut MeshDiagnostics,
) {
    // Volumes are sums of signed tetrahedra, which cancel least if taken from the center.
    let center = mesh.bounds.center();
    let mut volumes: Map<u32, (u32, f64)> = Map::default();
    let mut order = Vec::new();
    for face in (0..mesh.triangles.len() as u32).filter(|&face| counted[face as usize]) {
        let root = components.root(face);
        let [a, b, c] = mesh.corners(face).map(|corner| corner - center);
        let entry = volumes.entry(root).or_insert_with(|| {
            order.push(root);
            (face, 0.0)
        });
        entry.1 += a.dot(b.cross(c)) / 6.0;
    }
    found.components = order.len();
    for root in order {
        let (first_face, volume) = volumes[&root];
        if components.is_open(root) {
            continue;
        }
        let outward = if mesh.flip_normals { -volume } else { volume };
        found.signed_volume += outward;
        if outward < 0.0 {
            found.inward_components.add(first_face);
        }
    }
}

fn cross_of(mesh: &Mesh, face: u32) -> DVec3 {
    let [a, b, c] = mesh.corners(face);
    (b - a).cross(c - a)
}

fn opposes_its_normals(mesh: &Mesh, triangle: [u32; 3], cross: DVec3) -> bool {
    !mesh.normals.is_empty()
        && triangle
            .iter()
            .all(|&vertex| mesh.normals[vertex as usize].dot(cross) < 0.0)
}

/// Sets of faces, joined step by step (union-find with path halving).
struct Components {
    parent: Vec<u32>,
    open: Vec<bool>,
}

impl Components {
    fn new(faces: usize) -> Self {
        Self {
            parent: (0..faces as u32).collect(),
            open: vec![false; faces],
        }
    }

    fn root(&mut self, mut face: u32) -> u32 {
        while self.parent[face as usize] != face {
            let grandparent = self.parent[self.parent[face as usize] as usize];
            self.parent[face as usize] = grandparent;
            face = grandparent;
        }
        face
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        // The lower index wins, so that a set is named by its first face.
        self.parent[a.max(b) as usize] = a.min(b);
    }

    /// To be used once all joins are done.
    fn mark_open(&mut self, face: u32) {
        let root = self.root(face);
        self.open[root as usize] = true;
    }

    fn is_open(&self, root: u32) -> bool {
        self.open[root as usize]
    }
}
