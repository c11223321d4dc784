//! A plain tree, for boxes that [clustering](super::clustering) would take too long over.

use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node},
};

use super::curve::along_the_curve;

/// A tree that halves the Morton curve until a leaf may hold the rest. Of boxes in one place, the smaller are
/// together.
pub(super) fn build(boxes: &[Aabb], most_in_leaf: usize) -> Bvh2 {
    let order = along_the_curve(boxes, Aabb::half_area);
    let around = |first: usize, count: usize| {
        order[first..first + count]
            .iter()
            .fold(Aabb::empty(), |all, &number| {
                all.union(&boxes[number as usize])
            })
    };
    let node = |first: usize, count: usize| {
        Bvh2Node::new(around(first, count), count as u32, first as u32)
    };
    let mut nodes = vec![node(0, boxes.len())];
    let mut pending = vec![0];
    while let Some(index) = pending.pop() {
        let (first, count) = (
            nodes[index].first_index as usize,
            nodes[index].prim_count as usize,
        );
        if count <= most_in_leaf {
            continue;
        }
        let half = count / 2;
        let children = nodes.len();
        nodes.extend([node(first, half), node(first + half, count - half)]);
        // Inner nodes have no primitives, and the index of their children.
        nodes[index] = Bvh2Node::new(*nodes[index].aabb(), 0, children as u32);
        pending.extend([children, children + 1]);
    }
    Bvh2 {
        nodes,
        primitive_indices: order,
        ..Bvh2::default()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::accel::lanes::WIDTH;
    use glam::Vec3A;

    #[test]
    fn every_box_is_in_one_leaf_and_inside_of_all_above_it() {
        let cube = |n| Aabb::new(Vec3A::X * n as f32, Vec3A::X * n as f32 + 1.0);
        let boxes: Vec<Aabb> = (0..1000).map(cube).collect();
        // 1000 / 8 = 125 leaves: seven halvings; 1000 leaves: ten.
        for (most_in_leaf, halvings) in [(WIDTH, 7), (1, 10)] {
            let tree = build(&boxes, most_in_leaf);
            let mut seen = vec![0; boxes.len()];
            let mut pending = vec![(0, tree.nodes[0])];
            while let Some((depth, node)) = pending.pop() {
                assert!(depth <= halvings);
                let first = node.first_index as usize;
                if node.is_leaf() {
                    assert!((1..=most_in_leaf as u32).contains(&node.prim_count));
                    for &number in &tree.primitive_indices[first..first + node.prim_count as usize]
                    {
                        seen[number as usize] += 1;
                        assert_eq!(node.aabb().union(&boxes[number as usize]), *node.aabb());
                    }
                } else {
                    for child in [tree.nodes[first], tree.nodes[first + 1]] {
                        assert_eq!(node.aabb().union(child.aabb()), *node.aabb());
                        pending.push((depth + 1, child));
                    }
                }
            }
            assert!(seen.iter().all(|&count| count == 1));
        }
    }
}
