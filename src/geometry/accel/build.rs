//! Construction of a wide tree from boxes, by way of obvhs' binary one.

use std::time::Duration;

use glam::{DVec3, Vec3A};
use obvhs::{
    BvhBuildParams,
    aabb::Aabb,
    bvh2::{Bvh2, builder::build_bvh2, node::Bvh2Node},
};

use super::{
    balanced,
    lanes::WIDTH,
    tree::{BoxTree, Child, TreeNode},
    tree_frame::TreeFrame,
};
use crate::geometry::{Bounds, rounding::gamma};

/// Parameters of obvhs' builder: its `medium` preset, with leaves as full as the filter tests at once.
///
/// The preset is within 8 % of the slowest one in speed of search, and built several times sooner. A pack of
/// eight costs little more than a pack of four, so going one node deeper must save a lot. Costs of 6 to 15
/// measure the same, 3 (the preset's) is a tenth slower, 1 a quarter.
fn parameters() -> BvhBuildParams {
    BvhBuildParams {
        max_prims_per_leaf: WIDTH as u32,
        collapse_traversal_cost: 12.0,
        ..BvhBuildParams::medium_build()
    }
}

impl BoxTree {
    /// A tree over `boxes`, with up to eight in a leaf.
    pub(in crate::geometry) fn new(boxes: &[Bounds]) -> Self {
        if boxes.is_empty() {
            return Self {
                bounds: Bounds::EMPTY,
                frame: TreeFrame::WORLD,
                nodes: vec![EMPTY_NODE],
                leaf_starts: vec![0],
                order: Vec::new(),
            };
        }
        let exact = boxes.iter().fold(Bounds::EMPTY, |all, &one| all.union(one));
        // The box is slightly wider, so that no ray that meets a primitive runs along the border: 0 · ∞ there
        // would hide it from the slab test.
        let reach = exact.min.abs().max(exact.max.abs()).max_element();
        let bounds = exact.padded(gamma(4) * reach);
        let frame = TreeFrame::around(&bounds);
        let narrow: Vec<Aabb> = boxes
            .iter()
            .map(|bounds| {
                Aabb::new(
                    rounded(frame.to_local(bounds.min), f32::next_down),
                    rounded(frame.to_local(bounds.max), f32::next_up),
                )
            })
            .collect();
        let binary = if balanced::is_needed(&narrow) {
            balanced::build(&narrow)
        } else {
            build_bvh2(&narrow, parameters(), &mut Duration::default())
        };
        let mut tree = Self {
            bounds,
            frame,
            nodes: Vec::new(),
            leaf_starts: vec![0],
            order: Vec::with_capacity(boxes.len()),
        };
        if let Some(root) = binary.nodes.first() {
            collapse(&binary, root, &mut tree);
        }
        tree
    }
}

/// Rounding to nearest, then one step outward, is outward.
fn rounded(v: DVec3, step: fn(f32) -> f32) -> Vec3A {
    Vec3A::new(step(v.x as f32), step(v.y as f32), step(v.z as f32))
}

/// Boxes that no ray enters: the least plane is never before the greatest.
const EMPTY_NODE: TreeNode = TreeNode {
    planes: [
        [f32::INFINITY; WIDTH],
        [f32::NEG_INFINITY; WIDTH],
        [f32::INFINITY; WIDTH],
        [f32::NEG_INFINITY; WIDTH],
        [f32::INFINITY; WIDTH],
        [f32::NEG_INFINITY; WIDTH],
    ],
    children: [Child::NONE; WIDTH],
};

/// Makes wide nodes of binary ones, each parent before its children.
///
/// A wide node takes in the two children of its binary node. It then goes on replacing the child with the
/// largest surface (the likeliest to be entered) by its own children until it is full.
fn collapse(binary: &Bvh2, root: &Bvh2Node, tree: &mut BoxTree) {
    tree.nodes.push(EMPTY_NODE);
    let mut pending = vec![(0usize, *root)];
    while let Some((index, node)) = pending.pop() {
        let mut members = vec![node];
        while members.len() < WIDTH {
            let largest = (0..members.len())
                .filter(|&i| !members[i].is_leaf())
                .max_by(|&i, &j| {
                    let area = |k: usize| members[k].aabb().half_area();
                    area(i).total_cmp(&area(j))
                });
            let Some(opened) = largest else { break };
            let first = members[opened].first_index as usize;
            members[opened] = binary.nodes[first];
            members.push(binary.nodes[first + 1]);
        }
        for (slot, member) in members.iter().enumerate() {
            let child = if member.is_leaf() {
                let first = member.first_index as usize;
                let primitives = first..first + member.prim_count as usize;
                tree.order
                    .extend_from_slice(&binary.primitive_indices[primitives]);
                tree.leaf_starts.push(tree.order.len() as u32);
                Child::leaf(tree.leaf_starts.len() - 2)
            } else {
                tree.nodes.push(EMPTY_NODE);
                pending.push((tree.nodes.len() - 1, *member));
                Child::node(tree.nodes.len() - 1)
            };
            let aabb = member.aabb();
            let node = &mut tree.nodes[index];
            node.children[slot] = child;
            for axis in 0..3 {
                node.planes[2 * axis][slot] = aabb.min[axis];
                node.planes[2 * axis + 1][slot] = aabb.max[axis];
            }
        }
    }
}
