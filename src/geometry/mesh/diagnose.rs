//! Finds the defects of a mesh.

use std::collections::hash_map::Entry;

use glam::DVec3;

use super::{diagnostics::MeshDiagnostics, hash::Map, triangles::Mesh, weld};

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
    /// The mesh's defects: open and non-manifold edges, orientation, degenerate faces. They are found when
    /// they are first asked for, and kept.
    pub fn diagnose(&self) -> &MeshDiagnostics {
        self.diagnostics.0.get_or_init(|| diagnose(self))
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
