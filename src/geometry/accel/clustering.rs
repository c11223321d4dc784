//! Binary trees from the leaves up, by parallel locally-ordered clustering.
//!
//! Meister and Bittner, *Parallel locally-ordered clustering for bounding volume hierarchy construction*,
//! TVCG 24(3), 2018: clusters lie along the Morton curve. In each pass, those merge that are each other's
//! nearest among the next [`REACH`]. Mostly two of three find a partner, so that a third vanishes. But boxes
//! in one place, in an even row, or each around the last all prefer the neighbour on the same side. Then one
//! pair merges in each pass, and the work grows with the square of their number (10⁵ take minutes). So looks
//! are counted.

use obvhs::{
    aabb::Aabb,
    bvh2::{Bvh2, node::Bvh2Node},
};
use rayon::prelude::*;

use super::curve::along_the_curve;

/// Number of neighbours, each way, among which a cluster looks for a partner: as in obvhs' `medium` preset.
const REACH: usize = 14;

/// In the first passes, when there are most clusters, each looks at the next ones alone.
const NEAR_PASSES: usize = 3;

/// Up to this number the square does not matter: 2¹¹ · 2¹⁰ · 14 pairs are compared in a tenth of a second.
const FEW: usize = 1 << 11;

/// The number of times that each box may be looked at, on average. If a third vanishes in each pass, it is 3.
///
/// Boxes that take more make bad trees, too, over which obvhs' reinsertion takes longest: it has no bound.
const MOST_LOOKS: usize = 12;

/// Clusters that a thread takes at a time: far fewer are not worth the handing over.
const AT_A_TIME: usize = 1 << 11;

/// A tree with at most so many boxes in a leaf; `None` if boxes would be looked at too often.
///
/// Two leaves that merge become one if it may hold the boxes of both.
pub(super) fn build(boxes: &[Aabb], most_in_leaf: usize) -> Option<Bvh2> {
    let mut clusters: Vec<Bvh2Node> = along_the_curve(boxes, |_| 0.0)
        .par_iter()
        .with_min_len(AT_A_TIME)
        .map(|&number| Bvh2Node::new(boxes[number as usize], 1, number))
        .collect();
    let mut rings = Rings::of_one_each(boxes.len());
    // Children before their parents, and the later of two children first: the tree from its end on.
    let mut nodes = Vec::with_capacity(4 * boxes.len() / (most_in_leaf + 1));
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
                let other = clusters[partner];
                let around = cluster.aabb().union(other.aabb());
                let count = cluster.prim_count + other.prim_count;
                let are_leaves = cluster.is_leaf() && other.is_leaf();
                if are_leaves && count as usize <= most_in_leaf {
                    rings.join(cluster.first_index, other.first_index);
                    merged.push(Bvh2Node::new(around, count, cluster.first_index));
                } else {
                    merged.push(Bvh2Node::new(around, 0, nodes.len() as u32));
                    nodes.extend([other, cluster]);
                }
            }
        }
        std::mem::swap(&mut clusters, &mut merged);
        merged.clear();
    }
    nodes.extend(clusters);
    debug_assert!(nodes.len() % 2 == 1 || boxes.is_empty(), "pairs and a root");
    Some(root_first(nodes, &rings))
}

/// The boxes of each leaf, in a ring: two rings become one in one step, however long they are.
struct Rings {
    /// Of each box the next in its ring.
    next: Vec<u32>,
}

impl Rings {
    fn of_one_each(count: usize) -> Self {
        Self {
            next: (0..count as u32).collect(),
        }
    }

    /// Makes one ring of the two different ones that these boxes are in.
    fn join(&mut self, one: u32, other: u32) {
        self.next.swap(one as usize, other as usize);
    }

    /// The boxes of a ring, from `first` on, over and over.
    fn members(&self, first: u32) -> impl Iterator<Item = u32> {
        std::iter::successors(Some(first), |&at| Some(self.next[at as usize]))
    }
}

/// The tree of these nodes in reverse. `first_index` of a leaf is any box of its ring, that of an inner node
/// the place of its later child.
fn root_first(mut nodes: Vec<Bvh2Node>, rings: &Rings) -> Bvh2 {
    nodes.reverse();
    let before_last = nodes.len().saturating_sub(2) as u32;
    let mut primitive_indices = Vec::with_capacity(rings.next.len());
    for node in &mut nodes {
        if node.is_leaf() {
            let members = rings.members(node.first_index);
            node.first_index = primitive_indices.len() as u32;
            primitive_indices.extend(members.take(node.prim_count as usize));
        } else {
            node.first_index = before_last - node.first_index;
        }
    }
    // `max_depth` stays as it is, however deep the tree. With it, obvhs' searches for better places would
    // panic once the tree is deeper still. Without it they forget some places.
    Bvh2 {
        nodes,
        primitive_indices,
        children_are_ordered_after_parents: true,
        ..Bvh2::default()
    }
}

/// Finds, for at most [`AT_A_TIME`] clusters from `first` on, the one within reach whose union with each is
/// the smallest, and of several the last.
///
/// So every pass merges some pair. Of all pairs of the least cost, take the one whose later cluster is the
/// last, and of those the one whose earlier cluster is the last. Both are each other's nearest.
fn find_nearest(clusters: &[Bvh2Node], first: usize, found: &mut [u32], reach: usize) {
    let mut least = [f32::INFINITY; AT_A_TIME];
    let end = first + found.len();
    // Each pair once: of a cluster's candidates, those before it come first, and all in their order.
    for a in first.saturating_sub(reach)..end {
        let own = clusters[a].aabb();
        let others = &clusters[a + 1..(a + 1 + reach).min(clusters.len())];
        for (b, other) in (a + 1..).zip(others) {
            // What is no number costs most: it is not to be lost.
            let cost = own.union(other.aabb()).half_area().min(f32::INFINITY);
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
    use crate::geometry::accel::lanes::WIDTH;
    use glam::Vec3A;
    use proptest::prelude::*;

    /// A box with its least corner at (x, 0, 0).
    fn cube(x: f32, side: f32) -> Aabb {
        let least = Vec3A::new(x, 0.0, 0.0);
        Aabb::new(least, least + side)
    }

    /// Builds a tree and checks that each box is in one leaf, that none holds too many, that two of one node
    /// hold too many for one, that parents are around their children, and come before them. Returns the sum
    /// of the half areas of all inner nodes with one of at most 2.
    fn checked(boxes: &[Aabb], most_in_leaf: usize) -> f64 {
        let tree = build(boxes, most_in_leaf).expect("boxes that take few looks");
        let mut seen = vec![0; boxes.len()];
        let mut area = 0.0;
        let mut pending: Vec<usize> = (0..tree.nodes.len().min(1)).collect();
        while let Some(index) = pending.pop() {
            let node = tree.nodes[index];
            let first = node.first_index as usize;
            if node.is_leaf() {
                let count = node.prim_count as usize;
                assert!((1..=most_in_leaf).contains(&count));
                let members = &tree.primitive_indices[first..first + count];
                for &member in members {
                    seen[member as usize] += 1;
                }
                let inside = members.iter().map(|&it| &boxes[it as usize]);
                let around = inside.fold(Aabb::empty(), |all, one| all.union(one));
                let is_number = |&it: &u32| !boxes[it as usize].min.is_nan();
                assert!(*node.aabb() == around || !members.iter().all(is_number));
            } else {
                assert!(first > index);
                let children = [tree.nodes[first], tree.nodes[first + 1]];
                let are_leaves = children.iter().all(Bvh2Node::is_leaf);
                let count: u32 = children.iter().map(|it| it.prim_count).sum();
                assert!(!are_leaves || count as usize > most_in_leaf);
                let around = children[0].aabb().union(children[1].aabb());
                assert!(*node.aabb() == around || around.min.is_nan());
                let own = f64::from(node.aabb().half_area());
                area += if own <= 2.0 { own } else { 0.0 };
                pending.extend([first, first + 1]);
            }
        }
        assert!(seen.iter().all(|&count| count == 1));
        area
    }

    #[test]
    fn rows_heaps_and_shells_of_boxes_take_too_long_and_scattered_ones_do_not() {
        let count = 10_000;
        let row: Vec<Aabb> = (0..count).map(|n| cube(n as f32, 1.0)).collect();
        let heap: Vec<Aabb> = (0..count).map(|_| cube(0.0, 1.0)).collect();
        let shells: Vec<Aabb> = (0..count).map(|n| cube(0.0, 1.0 + n as f32)).collect();
        let scattered: Vec<Aabb> = (0..count)
            .map(|n| cube((n as f32 * 0.618).fract(), 1e-3))
            .collect();
        for boxes in [&row, &heap, &shells] {
            assert!(build(boxes, 1).is_none());
        }
        for most_in_leaf in [1, WIDTH] {
            checked(&row[..FEW], most_in_leaf);
            checked(&scattered, most_in_leaf);
        }
    }

    #[test]
    fn boxes_without_numbers_are_leaves_too() {
        let nothing = Aabb::new(Vec3A::NAN, Vec3A::NAN);
        let endless = Aabb::new(Vec3A::NEG_INFINITY, Vec3A::INFINITY);
        let kinds = [
            nothing,
            cube(0.0, 1.0),
            Aabb::empty(),
            endless,
            cube(f32::MAX, 1.0),
        ];
        for count in 0..40 {
            for turn in 0..kinds.len() {
                let all_kinds = (0..count).map(|n| kinds[(n + turn) % kinds.len()]);
                let mostly_one = (0..count).map(|n| kinds[if n == count / 2 { 1 } else { turn }]);
                for boxes in [all_kinds.collect::<Vec<_>>(), mostly_one.collect()] {
                    checked(&boxes, 1);
                    checked(&boxes, WIDTH);
                }
            }
        }
    }

    #[test]
    fn what_is_small_in_a_large_world_is_clustered_as_well_as_alone() {
        // A sheet of 100 x 100 squares, whose numbers say nothing of their places.
        let square = |n: usize| {
            let n = n * 7919 % 10_000;
            let at = Vec3A::new((n % 100) as f32, (n / 100) as f32, 0.0) / 100.0;
            Aabb::new(at, at + Vec3A::new(0.01, 0.01, 0.001))
        };
        let sheet: Vec<Aabb> = (0..10_000).map(square).collect();
        let alone = checked(&sheet, 1);
        let mut world = sheet;
        world.extend([-1e4, 1e4].map(|far| Aabb::new(Vec3A::splat(far), Vec3A::splat(far + 1.0))));
        let within = checked(&world, 1);
        // 2²¹ cells are 0.01 wide, as the squares are. With 2¹⁶ a thousand squares share a cell.
        assert!(within < 1.1 * alone, "{within}, alone {alone}");
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
        fn every_box_is_in_one_leaf_and_inside_of_all_above_it(boxes in boxes(500), most_in_leaf in 1..=WIDTH) {
            checked(&boxes, most_in_leaf);
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
