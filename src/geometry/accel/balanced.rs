//! A plain tree, for boxes that obvhs' builder takes too long over.
//!
//! PLOC (Meister and Bittner, *Parallel locally-ordered clustering*, TVCG 24(3), 2018) merges boxes that are
//! each other's nearest among the next [`REACH`] along the Morton curve, first among the next one. Mostly a
//! third of them find a partner each time. But boxes in one place, in an even row, or each around the last
//! all prefer the neighbour on the same side. Then one pair is merged each time, and the work grows with the
//! square of their number (10⁵ take minutes).

use glam::Vec3A;
use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node},
};
use rayon::prelude::*;

use crate::numeric::morton_code;

/// Number of neighbours, each way, among which obvhs' `medium` preset looks for a partner.
const REACH: usize = 14;

/// The first times, when there are most boxes, it looks at the next ones alone.
const NEAR_LOOKS: usize = 3;

/// Up to this number the square does not matter: 2¹¹ · 2¹⁰ · 28 boxes are compared in a tenth of a second.
const FEW: usize = 1 << 11;

/// The number of times that each box may be looked at, on average. A third merged each time makes 3; ribbons
/// take up to 6. With fourteen neighbours from the first time on, a fan of 2·10⁴ faces around one vertex
/// takes 31, and obvhs' reinsertion takes much longer still to improve the tree made of it.
const MOST_LOOKS: usize = 12;

/// The boxes' numbers along the Morton curve through their middles; of those in one place the smaller first.
fn along_the_curve(boxes: &[Aabb]) -> Vec<u32> {
    let all = boxes.iter().fold(Aabb::empty(), |all, one| all.union(one));
    // A side without length would divide 0 by 0.
    let size = all.diagonal().max(Vec3A::splat(f32::MIN_POSITIVE));
    let key = |&number: &u32| {
        let one = &boxes[number as usize];
        let place = (one.center() - all.min) / size;
        // Areas are not negative, so their bits are in order.
        (
            morton_code(place.as_dvec3()),
            one.half_area().to_bits(),
            number,
        )
    };
    let mut order: Vec<u32> = (0..boxes.len() as u32).collect();
    order.par_sort_by_cached_key(key);
    order
}

/// True if merging boxes that are each other's nearest would look at each of them too often.
pub(super) fn is_needed(boxes: &[Aabb]) -> bool {
    if boxes.len() <= FEW {
        return false;
    }
    let order = along_the_curve(boxes);
    let mut clusters: Vec<Aabb> = order.iter().map(|&number| boxes[number as usize]).collect();
    let mut looks = 0;
    let mut reaches = [1; NEAR_LOOKS].into_iter();
    while clusters.len() > FEW {
        looks += clusters.len();
        if looks > MOST_LOOKS * boxes.len() {
            return true;
        }
        let reach = reaches.next().unwrap_or(REACH);
        let nearest: Vec<usize> = (0..clusters.len())
            .into_par_iter()
            .map(|index| nearest(&clusters, index, reach))
            .collect();
        clusters = (0..clusters.len())
            .filter_map(|index| {
                let partner = nearest[index];
                if nearest[partner] == index {
                    (index < partner).then(|| clusters[index].union(&clusters[partner]))
                } else {
                    Some(clusters[index])
                }
            })
            .collect();
    }
    false
}

/// The box whose union with this one is the smallest; the last of several, as in obvhs.
fn nearest(boxes: &[Aabb], index: usize, reach: usize) -> usize {
    let mut best = (index, f32::INFINITY);
    for other in index.saturating_sub(reach)..(index + reach + 1).min(boxes.len()) {
        let cost = boxes[index].union(&boxes[other]).half_area();
        if other != index && cost <= best.1 {
            best = (other, cost);
        }
    }
    best.0
}

/// A tree that halves the Morton curve until a leaf may hold the rest.
pub(super) fn build(boxes: &[Aabb], most_in_leaf: usize) -> Bvh2 {
    let order = along_the_curve(boxes);
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

    /// A box with its least corner at (x, 0, 0).
    fn cube(x: f32, side: f32) -> Aabb {
        let least = Vec3A::new(x, 0.0, 0.0);
        Aabb::new(least, least + side)
    }

    #[test]
    fn rows_towers_and_shells_of_boxes_need_it_and_scattered_ones_do_not() {
        let count = 10_000;
        let row: Vec<Aabb> = (0..count).map(|n| cube(n as f32, 1.0)).collect();
        let heap: Vec<Aabb> = (0..count).map(|_| cube(0.0, 1.0)).collect();
        let shells: Vec<Aabb> = (0..count).map(|n| cube(0.0, 1.0 + n as f32)).collect();
        let scattered: Vec<Aabb> = (0..count)
            .map(|n| cube((n as f32 * 0.618).fract(), 1e-3))
            .collect();
        assert!(is_needed(&row) && is_needed(&heap) && is_needed(&shells));
        assert!(!is_needed(&scattered) && !is_needed(&row[..FEW]));
    }

    #[test]
    fn every_box_is_in_one_leaf_and_inside_of_all_above_it() {
        let boxes: Vec<Aabb> = (0..1000).map(|n| cube(n as f32, 1.0)).collect();
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
