//! Binary trees from the leaves up, by parallel locally-ordered clustering.
//!
//! Meister and Bittner, *Parallel locally-ordered clustering for bounding volume hierarchy construction*,
//! TVCG 24(3), 2018: clusters lie along the Morton curve. In each pass, those merge that are each other's
//! nearest among the next [`REACH`]. Mostly a third of them find a partner each time. But boxes in one place,
//! in an even row, or each around the last all prefer the neighbour on the same side. Then one pair is merged
//! each time, and the work grows with the square of their number (10⁵ take minutes). So looks are counted.

use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node},
};
use rayon::prelude::*;

/// Number of neighbours, each way, among which a cluster looks for a partner. So many take obvhs' builds of
/// middling quality, too.
const REACH: usize = 14;

/// In the first passes, when there are most clusters, each looks at the next ones alone.
const NEAR_PASSES: usize = 3;

/// Up to this number the square does not matter: 2¹¹ · 2¹⁰ · 28 boxes are compared in a tenth of a second.
const FEW: usize = 1 << 11;

/// The number of times that each box may be looked at, on average. A third merged each time makes 3; ribbons
/// take up to 6. With fourteen neighbours from the first time on, a fan of 2·10⁴ faces around one vertex
/// takes 31, and obvhs' reinsertion takes much longer still to improve the tree made of it.
const MOST_LOOKS: usize = 12;

/// Clusters that a thread takes at a time: far fewer are not worth the handing over.
const AT_A_TIME: usize = 1 << 11;

/// A tree with one box in each leaf; `None` if boxes would be looked at too often.
///
/// `order` has the boxes' numbers along the Morton curve.
pub(super) fn build(boxes: &[Aabb], order: &[u32]) -> Option<Bvh2> {
    let mut clusters: Vec<Bvh2Node> = order
        .par_iter()
        .with_min_len(AT_A_TIME)
        .map(|&number| Bvh2Node::new(boxes[number as usize], 1, number))
        .collect();
    // From the last one on: children come after their parents.
    let mut nodes = vec![Bvh2Node::default(); (2 * clusters.len()).saturating_sub(1)];
    let mut unused = nodes.len();
    let mut merged = Vec::with_capacity(clusters.len());
    let mut nearest = Vec::new();
    let mut looks = 0;
    for pass in 0.. {
        if clusters.len() <= 1 {
            break;
        }
        if clusters.len() > FEW {
            looks += clusters.len();
            if looks > MOST_LOOKS * boxes.len() {
                return None;
            }
        }
        let reach = if pass < NEAR_PASSES { 1 } else { REACH };
        nearest.resize(clusters.len(), 0);
        let parts = nearest.par_chunks_mut(AT_A_TIME).enumerate();
        parts.for_each(|(part, found)| find_nearest(&clusters, part * AT_A_TIME, found, reach));
        for (index, &cluster) in clusters.iter().enumerate() {
            let partner = nearest[index] as usize;
            if nearest[partner] as usize != index {
                merged.push(cluster);
            } else if index < partner {
                unused -= 2;
                (nodes[unused], nodes[unused + 1]) = (cluster, clusters[partner]);
                let around = cluster.aabb().union(clusters[partner].aabb());
                merged.push(Bvh2Node::new(around, 0, unused as u32));
            }
        }
        std::mem::swap(&mut clusters, &mut merged);
        merged.clear();
    }
    if let Some(all) = clusters.pop() {
        nodes[0] = all;
    }
    Some(Bvh2 {
        nodes,
        primitive_indices: (0..boxes.len() as u32).collect(),
        children_are_ordered_after_parents: true,
        ..Bvh2::default()
    })
}

/// Finds, for the clusters from `first` on, the one within reach whose union with each is the smallest; the
/// last of several, as in obvhs.
fn find_nearest(clusters: &[Bvh2Node], first: usize, found: &mut [u32], reach: usize) {
    let mut least = [f32::INFINITY; AT_A_TIME];
    let end = first + found.len();
    // Each pair once: of a cluster's candidates, those before it come first, and all in their order.
    for a in first.saturating_sub(reach)..end {
        let own = clusters[a].aabb();
        let others = &clusters[a + 1..(a + 1 + reach).min(clusters.len())];
        for (b, other) in (a + 1..).zip(others) {
            let cost = own.union(other.aabb()).half_area();
            for (one, candidate) in [(a, b), (b, a)] {
                if (first..end).contains(&one) && cost <= least[one - first] {
                    least[one - first] = cost;
                    found[one - first] = candidate as u32;
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::accel::curve::along_the_curve;
    use glam::Vec3A;
    use proptest::prelude::*;

    /// A box with its least corner at (x, 0, 0).
    fn cube(x: f32, side: f32) -> Aabb {
        let least = Vec3A::new(x, 0.0, 0.0);
        Aabb::new(least, least + side)
    }

    fn tree(boxes: &[Aabb]) -> Option<Bvh2> {
        build(boxes, &along_the_curve(boxes))
    }

    #[test]
    fn rows_towers_and_shells_of_boxes_take_too_long_and_scattered_ones_do_not() {
        let count = 10_000;
        let row: Vec<Aabb> = (0..count).map(|n| cube(n as f32, 1.0)).collect();
        let heap: Vec<Aabb> = (0..count).map(|_| cube(0.0, 1.0)).collect();
        let shells: Vec<Aabb> = (0..count).map(|n| cube(0.0, 1.0 + n as f32)).collect();
        let scattered: Vec<Aabb> = (0..count)
            .map(|n| cube((n as f32 * 0.618).fract(), 1e-3))
            .collect();
        for boxes in [&row, &heap, &shells] {
            assert!(tree(boxes).is_none());
        }
        assert!(tree(&scattered).is_some() && tree(&row[..FEW]).is_some());
    }

    /// Boxes with whole-numbered corners, so that many unions are equally large.
    fn boxes(count: usize) -> impl Strategy<Value = Vec<Aabb>> {
        let corner =
            || [0_u8..16, 0_u8..16, 0_u8..16].prop_map(|it| Vec3A::from(it.map(f32::from)));
        let one = (corner(), corner()).prop_map(|(a, b)| Aabb::new(a, a + b));
        prop::collection::vec(one, 0..count)
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

        #[test]
        fn every_box_is_a_leaf_and_inside_of_all_above_it(boxes in boxes(500)) {
            let tree = tree(&boxes).expect("few boxes never take too long");
            let mut seen = vec![0; boxes.len()];
            let mut pending: Vec<usize> = (0..tree.nodes.len().min(1)).collect();
            while let Some(index) = pending.pop() {
                let node = tree.nodes[index];
                let first = node.first_index as usize;
                if node.is_leaf() {
                    prop_assert_eq!(node.prim_count, 1);
                    let number = tree.primitive_indices[first] as usize;
                    prop_assert_eq!(*node.aabb(), boxes[number]);
                    seen[number] += 1;
                } else {
                    prop_assert!(first > index);
                    let around = tree.nodes[first].aabb().union(tree.nodes[first + 1].aabb());
                    prop_assert_eq!(*node.aabb(), around);
                    pending.extend([first, first + 1]);
                }
            }
            prop_assert!(seen.iter().all(|&count| count == 1));
        }

        #[test]
        fn the_nearest_in_parts_are_those_of_trying_all(boxes in boxes(120), reach in 1_usize..16, cut in 0_usize..120) {
            let clusters: Vec<Bvh2Node> = (0..).zip(&boxes).map(|(n, &it)| Bvh2Node::new(it, 1, n)).collect();
            let mut found = vec![u32::MAX; clusters.len()];
            let cut = cut.min(clusters.len());
            let (before, after) = found.split_at_mut(cut);
            find_nearest(&clusters, 0, before, reach);
            find_nearest(&clusters, cut, after, reach);
            for (index, &found) in found.iter().enumerate() {
                let within_reach = |&other: &usize| other != index && other.abs_diff(index) <= reach;
                let cost = |other: usize| boxes[index].union(&boxes[other]).half_area();
                // The last of the least: `min_by` takes the first, so they are turned around.
                let nearest = (0..boxes.len())
                    .rev()
                    .filter(within_reach)
                    .min_by(|&a, &b| cost(a).total_cmp(&cost(b)));
                prop_assert_eq!(nearest.unwrap_or(u32::MAX as usize), found as usize);
            }
        }
    }
}
