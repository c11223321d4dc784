//! Which meshes share a tree.

use glam::DVec3;

use crate::geometry::{Bounds, Mesh};

/// The largest extent of a tree, in mean extents of a face of any of its meshes.
///
/// A search is unsure of places by about 2⁻²² of the tree's extent (see `LocalRay`): here by 2⁻⁸ of a mean
/// face, so hardly more faces are tested than there are hits.
const LARGEST_EXTENT: f64 = (1u64 << 14) as f64;

/// A mesh, as far as it matters to sharing.
#[derive(Clone, Copy)]
struct Member {
    /// Its place among all.
    index: usize,
    bounds: Bounds,
    /// The mean extent of a face.
    of_face: f64,
}

/// The meshes, by their places among these, that share a tree, tree by tree.
///
/// All meshes that are not too fine for a tree around all share the first. The others share among themselves
/// if they are in a much smaller box; otherwise the left and the right half of them do, and so on.
pub(in crate::geometry) fn sharing(meshes: &[&Mesh]) -> Vec<Vec<usize>> {
    let all = meshes.iter().enumerate().map(|(index, mesh)| {
        let bounds = mesh.bounds();
        let faces = mesh.triangle_count().max(1) as f64;
        Member {
            index,
            bounds,
            of_face: extent(&bounds) / faces.sqrt(),
        }
    });
    let indices = |members: &[Member]| members.iter().map(|member| member.index).collect();
    let (mut shared, mut pending) = (Vec::new(), vec![all.collect::<Vec<_>>()]);
    while let Some(members) = pending.pop() {
        let largest = extent_of_all(&members);
        let (together, rest): (Vec<Member>, Vec<Member>) = members
            .into_iter()
            .partition(|member| member.of_face * LARGEST_EXTENT >= largest);
        if !together.is_empty() {
            shared.push(indices(&together));
        }
        if !together.is_empty() && extent_of_all(&rest) <= 0.5 * largest {
            if !rest.is_empty() {
                pending.push(rest);
            }
            continue;
        }
        let halves = halves(rest);
        if halves.iter().any(Vec::is_empty) {
            let alone = halves.iter().flatten();
            shared.extend(alone.map(|member| vec![member.index]));
        } else {
            pending.extend(halves);
        }
    }
    shared
}

/// The members on both sides of the middle of their centers' box, across its longest side.
fn halves(members: Vec<Member>) -> [Vec<Member>; 2] {
    let centers = Bounds::from_points(members.iter().map(|member| member.bounds.center()));
    let (size, middle) = (centers.extent(), centers.center());
    let across = DVec3::AXES
        .into_iter()
        .max_by(|a, b| size.dot(*a).total_cmp(&size.dot(*b)))
        .unwrap_or(DVec3::X);
    let (left, right) = members
        .into_iter()
        .partition(|member| member.bounds.center().dot(across) < middle.dot(across));
    [left, right]
}

fn extent_of_all(members: &[Member]) -> f64 {
    let bounds = members.iter().map(|member| member.bounds);
    extent(&bounds.fold(Bounds::EMPTY, Bounds::union))
}

/// The longest side of a box; 0 if it is empty.
fn extent(bounds: &Bounds) -> f64 {
    bounds.extent().max_element().max(0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::MeshParts;
    use glam::DVec3;

    /// A triangle with legs of this length, at a place.
    fn triangle(leg: f64, at: DVec3) -> Mesh {
        Mesh::new(MeshParts {
            positions: vec![at, at + DVec3::X * leg, at + DVec3::Y * leg],
            triangles: vec![[0, 1, 2]],
            ..MeshParts::default()
        })
        .expect("valid")
    }

    fn sharing_of(meshes: &[Mesh]) -> Vec<Vec<usize>> {
        sharing(&meshes.iter().collect::<Vec<_>>())
    }

    #[test]
    fn meshes_share_a_tree_if_none_of_them_is_tiny_in_it() {
        let (least, most) = (1.01 / LARGEST_EXTENT, 0.99 / LARGEST_EXTENT);
        let floor = triangle(1.0, DVec3::ZERO);
        assert_eq!(sharing_of(&[]), Vec::<Vec<usize>>::new());
        assert_eq!(sharing_of(std::slice::from_ref(&floor)), [vec![0]]);
        let chair = triangle(least, DVec3::splat(0.2));
        assert_eq!(sharing_of(&[floor.clone(), chair]), [vec![0, 1]]);
        let pins = [0.2, 0.2001].map(|at| triangle(most, DVec3::splat(at)));
        let [one, other] = pins;
        assert_eq!(sharing_of(&[one, floor, other]), [vec![1], vec![0, 2]]);
    }

    #[test]
    fn tiny_meshes_that_are_far_apart_have_trees_of_their_own() {
        let far = |n: u32| triangle(1.0, DVec3::X * 1e6 * f64::from(n));
        let many: Vec<Mesh> = (0..5).map(far).collect();
        let mut found = sharing_of(&many);
        found.sort();
        assert_eq!(found, [[0], [1], [2], [3], [4]].map(Vec::from));
        // In one place, too: none of them is tiny there.
        let heap = [triangle(1.0, DVec3::ZERO), triangle(1.0, DVec3::ZERO)];
        assert_eq!(sharing_of(&heap), [vec![0, 1]]);
    }

    #[test]
    fn one_mesh_that_is_far_away_keeps_none_from_sharing() {
        let mut meshes: Vec<Mesh> = (0..6)
            .map(|n| triangle(1.0, DVec3::Y * f64::from(n)))
            .collect();
        meshes.insert(2, triangle(1e-3, DVec3::splat(1e9)));
        let mut found = sharing_of(&meshes);
        found.sort();
        assert_eq!(found, [vec![0, 1, 3, 4, 5, 6], vec![2]]);
    }

    #[test]
    fn fine_meshes_on_a_large_floor_share_with_their_neighbours() {
        // Two groups of plants: each too fine for a tree around both.
        let plant = |n: u32| {
            let group = f64::from(n % 2) * 0.6;
            triangle(1e-5, DVec3::new(group + 1e-4 * f64::from(n), 0.1, 0.0))
        };
        let mut meshes = vec![triangle(1.0, DVec3::ZERO)];
        meshes.extend((0..6).map(plant));
        let mut found = sharing_of(&meshes);
        found.sort();
        assert_eq!(found, [vec![0], vec![1, 3, 5], vec![2, 4, 6]]);
    }
}
