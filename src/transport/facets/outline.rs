//! Coplanar neighbours of a mesh, taken together if they make a convex polygon.

use glam::DVec3;

use crate::geometry::Mesh;

/// Faces of one plane.
pub(super) struct Group {
    /// The largest of them.
    pub(super) face: u32,
    /// The corners of their union, in the winding's order.
    pub(super) corners: Vec<DVec3>,
    /// The other groups that a side of it is shared with.
    pub(super) beside: Vec<u32>,
}

/// A mesh's faces in groups.
pub(super) struct Outlines {
    pub(super) groups: Vec<Group>,
    /// The group of each face; beyond the last group for a face without area.
    pub(super) of_face: Vec<u32>,
    /// Number of times that a face was taken into a group, for good or not.
    #[cfg_attr(not(test), expect(dead_code, reason = "the work done, for tests"))]
    pub(super) visits: usize,
}

/// A side of a face, by the vertices at its ends.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct FaceSide {
    from: u32,
    to: u32,
    face: u32,
}

/// Mark of a face without a group.
const UNGROUPED: u32 = u32::MAX;

/// Groups a mesh's faces.
pub(super) fn outlines(mesh: &Mesh) -> Outlines {
    let welded = mesh.welded_vertices();
    let sides = |face: u32| {
        let [a, b, c] = mesh.triangles()[face as usize].map(|vertex| welded[vertex as usize]);
        [(a, b), (b, c), (c, a)].map(|(from, to)| FaceSide { from, to, face })
    };
    let faces = mesh.triangle_count() as u32;
    let mut all: Vec<FaceSide> = (0..faces).flat_map(sides).collect();
    all.sort_unstable();
    // The face on the other side of a side, if there is exactly one.
    let across = |side: &FaceSide| {
        let start = all.partition_point(|other| (other.from, other.to) < (side.to, side.from));
        let is_twin = |other: &&FaceSide| (other.from, other.to) == (side.to, side.from);
        match (all.get(start), all.get(start + 1)) {
            (Some(twin), next) if is_twin(&twin) && !next.as_ref().is_some_and(is_twin) => {
                Some(twin.face)
            }
            _ => None,
        }
    };
    let area = |face: u32| {
        let [a, b, c] = mesh.corners(face);
        (b - a).cross(c - a).length_squared()
    };
    let mut order: Vec<(f64, u32)> = (0..faces).map(|face| (area(face), face)).collect();
    // The largest first: it knows its plane best.
    order.sort_unstable_by(|a, b| b.0.total_cmp(&a.0).then(a.1.cmp(&b.1)));
    let reach = mesh
        .positions()
        .iter()
        .fold(0.0_f64, |reach, p| reach.max(p.abs().max_element()));
    let mut of_face = vec![UNGROUPED; faces as usize];
    let mut groups: Vec<Group> = Vec::new();
    let mut visits = 0;
    for (area, seed) in order {
        if area == 0.0 || of_face[seed as usize] != UNGROUPED {
            continue;
        }
        let plane = FacePlane::of(mesh, seed, reach);
        let number = groups.len() as u32;
        let mut members = vec![seed];
        of_face[seed as usize] = number;
        let mut next = 0;
        while let Some(&face) = members.get(next) {
            next += 1;
            for side in sides(face) {
                if let Some(other) = across(&side)
                    && of_face[other as usize] == UNGROUPED
                    && plane.holds(mesh, other)
                {
                    of_face[other as usize] = number;
                    members.push(other);
                }
            }
        }
        visits += members.len();
        let inner = |side: &FaceSide| across(side).is_some_and(|o| of_face[o as usize] == number);
        let border = members
            .iter()
            .flat_map(|&face| sides(face))
            .filter(|side| !inner(side))
            .collect();
        // A lone triangle is convex, however thin.
        let outline = (members.len() > 1)
            .then(|| convex_loop(mesh, border, &plane))
            .flatten();
        if let Some(corners) = outline {
            groups.push(Group {
                face: seed,
                corners,
                beside: Vec::new(),
            });
            continue;
        }
        // Each face is a facet of its own, once and for all. A flood from another face of the same plane
        // would find the same outline; all floods together would cost the square of their number.
        for face in members {
            of_face[face as usize] = groups.len() as u32;
            groups.push(Group {
                face,
                corners: mesh.corners(face).to_vec(),
                beside: Vec::new(),
            });
        }
    }
    for side in &all {
        let group = of_face[side.face as usize];
        let other = across(side).map(|face| of_face[face as usize]);
        if let (Some(one), Some(other)) = (groups.get_mut(group as usize), other)
            && other != group
            && other != UNGROUPED
            && !one.beside.contains(&other)
        {
            one.beside.push(other);
        }
    }
    Outlines {
        groups,
        of_face,
        visits,
    }
}

/// A face's plane, and the distance from it that a point of the plane may have.
struct FacePlane {
    origin: DVec3,
    normal: DVec3,
    flatness: f64,
}

impl FacePlane {
    /// The plane of a face.
    ///
    /// Coordinates up to `reach` of one plane are rounded twice, when made and when transformed, by a few u =
    /// 2⁻⁵³ each. The height over the plane sums up three products. 32 u of the largest coordinate covers all
    /// that. Vertices of a file in single precision are off by more. Their faces have planes of their own,
    /// and stay apart.
    fn of(mesh: &Mesh, face: u32, reach: f64) -> Self {
        Self {
            origin: mesh.corners(face)[0],
            normal: mesh.face_normal(face),
            flatness: 32.0 * 0.5 * f64::EPSILON * reach,
        }
    }

    fn holds(&self, mesh: &Mesh, face: u32) -> bool {
        mesh.face_normal(face).dot(self.normal) > 0.0
            && mesh
                .corners(face)
                .iter()
                .all(|&corner| (corner - self.origin).dot(self.normal).abs() <= self.flatness)
    }
}

/// The corners of a border that is one convex loop, without those on straight lines.
fn convex_loop(mesh: &Mesh, mut border: Vec<FaceSide>, plane: &FacePlane) -> Option<Vec<DVec3>> {
    let first = *border.first()?;
    border.sort_unstable();
    // A corner where two loops meet has two sides.
    if border.windows(2).any(|two| two[0].from == two[1].from) {
        return None;
    }
    let mut corners = Vec::with_capacity(border.len());
    let mut at = first.from;
    loop {
        corners.push(mesh.positions()[at as usize]);
        let side = border.binary_search_by_key(&at, |side| side.from).ok()?;
        at = border[side].to;
        if at == first.from {
            break;
        }
        if corners.len() > border.len() {
            return None;
        }
    }
    if corners.len() != border.len() {
        return None;
    }
    // The sign of turns: `face_normal` may point against the winding.
    let triangle = mesh.corners(first.face);
    let winding = (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0]);
    let winding = if winding.dot(plane.normal) < 0.0 {
        -plane.normal
    } else {
        plane.normal
    };
    let turns: Vec<f64> = (0..corners.len())
        .map(|index| {
            let count = corners.len();
            let (before, after) = (
                corners[(index + count - 1) % count],
                corners[(index + 1) % count],
            );
            let (arriving, leaving) = (corners[index] - before, after - corners[index]);
            let turn = arriving.cross(leaving).dot(winding);
            // A deviation of `flatness` from a straight line is none.
            let straight = plane.flatness * (arriving.length() + leaving.length());
            if turn.abs() <= straight { 0.0 } else { turn }
        })
        .collect();
    if turns.iter().any(|&turn| turn < 0.0) {
        return None;
    }
    let corners: Vec<DVec3> = corners
        .into_iter()
        .zip(turns)
        .filter_map(|(corner, turn)| (turn > 0.0).then_some(corner))
        .collect();
    (corners.len() >= 3).then_some(corners)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::outlines;
    use crate::geometry::{Mesh, MeshParts};

    /// A flat grid of `side` x `side` squares of two triangles, without those that `hole` names.
    fn grid(side: u32, hole: impl Fn(u32, u32) -> bool) -> Mesh {
        let at = |x: u32, y: u32| y * (side + 1) + x;
        let place = |index: u32| {
            let (x, y) = (index % (side + 1), index / (side + 1));
            DVec3::new(f64::from(x), f64::from(y), 0.0)
        };
        let squares = (0..side * side).map(|index| (index % side, index / side));
        let triangles = squares.filter(|&(x, y)| !hole(x, y)).flat_map(|(x, y)| {
            let [a, b, c, d] = [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)];
            [[a, b, c], [a, c, d]]
        });
        Mesh::new(MeshParts {
            positions: (0..(side + 1) * (side + 1)).map(place).collect(),
            triangles: triangles.collect(),
            face_normals: true,
            ..MeshParts::default()
        })
        .unwrap()
    }

    #[test]
    fn a_plane_whose_outline_is_not_convex_is_looked_through_once() {
        for side in [8, 32] {
            let all = side * side * 2;
            let square = outlines(&grid(side, |_, _| false));
            assert_eq!(square.groups.len(), 1);
            assert_eq!(square.groups[0].corners.len(), 4);
            assert_eq!(square.visits, all as usize);
            // The letter L; and one with a hole.
            let letter = outlines(&grid(side, |x, y| x >= side / 2 && y >= side / 2));
            let ring = outlines(&grid(side, |x, y| x == side / 2 && y == side / 2));
            for (mesh, faces) in [(letter, all * 3 / 4), (ring, all - 2)] {
                assert_eq!(mesh.groups.len(), faces as usize);
                assert_eq!(mesh.visits, faces as usize);
                for (face, &group) in mesh.of_face.iter().enumerate() {
                    assert_eq!(mesh.groups[group as usize].face, face as u32);
                }
            }
        }
    }

    #[test]
    fn groups_know_those_that_they_share_a_side_with() {
        // A triangle for each face: one inside has three beside it, and each of these has it.
        let letter = outlines(&grid(4, |x, y| x >= 2 && y >= 2));
        let mut most = 0;
        for (index, group) in letter.groups.iter().enumerate() {
            most = most.max(group.beside.len());
            for &other in &group.beside {
                assert!(
                    letter.groups[other as usize]
                        .beside
                        .contains(&(index as u32))
                );
            }
        }
        assert_eq!(most, 3);
        // 12 squares have a diagonal each, seen from both sides; of their 48 sides 16 bound the letter.
        let shared: usize = letter.groups.iter().map(|group| group.beside.len()).sum();
        assert_eq!(shared, 2 * 12 + (12 * 4 - 16));
        // The faces of a plane are one group, with nothing beside it.
        assert!(outlines(&grid(4, |_, _| false)).groups[0].beside.is_empty());
    }
}
