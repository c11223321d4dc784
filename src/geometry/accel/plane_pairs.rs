//! Pairs of planes in a tree's own frame, and the test of eight boxes against them.

use glam::DVec3;

use super::{
    lanes::{Lanes, WIDTH},
    ray::NARROW_ROUNDOFF,
    tree::{BoxTree, Root, TreeNode},
    tree_frame::TreeFrame,
    walk::Stack,
};
use crate::geometry::{PlanePair, rounding::UNIT_ROUNDOFF};

/// A pair of planes in `f32`, in the frame of a tree, a little further apart than they are.
///
/// # The error bound
///
/// In the frame, boxes have coordinates of at most 1, or 1 + 2u by rounding. Let u = 2⁻²⁴. A corner's product
/// with the unit vector a is a sum of three terms: aₖ is rounded, the product is, and two sums are. That is
/// 4u Σ|aₖ| ≤ 7u at most. Places of planes are rounded once, by 2u: those further out than 2 decide nothing,
/// as products are no more than √3. A margin of 16u covers all, and one of their `f64` computation is added.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalPlanePair {
    along: [f32; 3],
    /// For each axis 1 if the direction is negative, else 0.
    signs: [usize; 3],
    low: f32,
    high: f32,
}

impl LocalPlanePair {
    const EVERYWHERE: Self = Self {
        along: [0.0; 3],
        signs: [0; 3],
        low: -FURTHEST as f32,
        high: FURTHEST as f32,
    };

    fn new(frame: &TreeFrame, pair: &PlanePair) -> Self {
        let center = pair.along.dot(frame.center);
        let size = frame.center.abs().element_sum();
        let margin =
            |end: f64| 16.0 * (NARROW_ROUNDOFF + UNIT_ROUNDOFF * (end.abs() + size) * frame.scale);
        let low = (pair.low - center) * frame.scale - margin(pair.low);
        let high = (pair.high - center) * frame.scale + margin(pair.high);
        Self {
            along: pair.along.to_array().map(|one| one as f32),
            signs: pair
                .along
                .to_array()
                .map(|one| usize::from(one.is_sign_negative())),
            low: within(low, -FURTHEST),
            high: within(high, FURTHEST),
        }
    }
}

/// A product that no corner of a box reaches: √3 is the largest.
const FURTHEST: f64 = 4.0;

/// A plane's place as far out as it matters; `unknown` if it is not a number.
fn within(place: f64, unknown: f64) -> f32 {
    let place = if place.is_nan() { unknown } else { place };
    place.clamp(-FURTHEST, FURTHEST) as f32
}

/// Pairs of planes in the frame of a tree. What is between all of them is between the first ones, too.
#[derive(Clone, Copy, Debug)]
pub(in crate::geometry) struct LocalPlanePairs {
    all: [LocalPlanePair; Self::MOST],
    count: usize,
}

impl LocalPlanePairs {
    /// More are not looked at.
    const MOST: usize = 16;

    pub(super) fn new(frame: &TreeFrame, pairs: impl Iterator<Item = PlanePair>) -> Self {
        let mut local = Self {
            all: [LocalPlanePair::EVERYWHERE; Self::MOST],
            count: 0,
        };
        let telling = pairs.filter(|pair| pair.along.is_finite() && pair.along != DVec3::ZERO);
        for (place, pair) in local.all.iter_mut().zip(telling) {
            *place = LocalPlanePair::new(frame, &pair);
            local.count += 1;
        }
        local
    }
}

impl BoxTree {
    /// True if `leaf(position in the order)` holds for any primitive of a leaf below `root` whose box may be
    /// between all pairs of planes.
    pub(in crate::geometry) fn any_between_planes(
        &self,
        root: Root,
        pairs: impl Iterator<Item = PlanePair>,
        mut leaf: impl FnMut(usize) -> bool,
    ) -> bool {
        let pairs = LocalPlanePairs::new(&self.frame, pairs);
        let mut stack = Stack::new();
        stack.push(root.node);
        while let Some((_, next)) = stack.pop() {
            if let Some(index) = next.as_leaf() {
                if self.leaf_range(index).any(&mut leaf) {
                    return true;
                }
                continue;
            }
            let node = &self.nodes[next.0 as usize];
            let mut inside = node.children_in(&pairs);
            while inside != 0 {
                stack.push(node.children[inside.trailing_zeros() as usize]);
                inside &= inside - 1;
            }
        }
        false
    }
}

impl TreeNode {
    /// A bit for each child, which is set if its box may be between all pairs of planes; to be compiled for
    /// each set of registers.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(super) fn children_in_local(&self, lanes: impl Lanes, pairs: &LocalPlanePairs) -> u32 {
        let planes = self.planes.each_ref().map(|plane| lanes.load(plane));
        // Missing children have empty boxes.
        let mut inside = lanes.at_most(planes[0], planes[1]);
        for pair in &pairs.all[..pairs.count] {
            let mut least = lanes.splat(0.0);
            let mut most = least;
            for axis in 0..3 {
                let along = lanes.splat(pair.along[axis]);
                let side = pair.signs[axis] & 1;
                least = lanes.add(least, lanes.mul(planes[2 * axis + side], along));
                most = lanes.add(most, lanes.mul(planes[2 * axis + 1 - side], along));
            }
            inside &= lanes.at_most(least, lanes.splat(pair.high))
                & lanes.at_most(lanes.splat(pair.low), most);
            if inside == 0 {
                break;
            }
        }
        inside
    }
}

const _: () = assert!(WIDTH <= u32::BITS as usize);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::Bounds;
    use proptest::prelude::*;

    fn point(size: f64) -> impl Strategy<Value = DVec3> {
        [-size..size, -size..size, -size..size].prop_map(DVec3::from_array)
    }

    /// Directions of all kinds, those of coordinates among them.
    fn normal() -> impl Strategy<Value = DVec3> {
        let upright = vec![
            DVec3::X,
            DVec3::NEG_Y,
            DVec3::Z,
            DVec3::new(-0.0, 1.0, -1.0),
        ];
        prop_oneof![point(1.0), prop::sample::select(upright)]
    }

    /// The boxes of the leaves that may be between the planes, by number.
    fn found(boxes: &[Bounds], pairs: &[PlanePair]) -> Vec<usize> {
        let tree = BoxTree::new(boxes);
        let mut found = Vec::new();
        tree.any_between_planes(tree.whole(), pairs.iter().copied(), |position| {
            found.push(tree.order()[position] as usize);
            false
        });
        found.sort_unstable();
        found
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 2_000, ..ProptestConfig::default() })]

        #[test]
        fn no_box_that_touches_all_planes_is_lost(
            boxes in prop::collection::vec((point(1.0), point(0.1)), 1..60),
            normals in [normal(), normal(), normal()],
            through in prop::sample::select(vec![0_usize, 7, 31, 59]),
            corner in 0_usize..8,
            far in prop::sample::select(vec![0.0, 1e3, 1e9]),
            scale in prop::sample::select(vec![1e-9, 1.0, 1e6]),
        ) {
            let boxes: Vec<Bounds> = boxes
                .iter()
                .map(|&(at, size)| {
                    let at = (at + DVec3::splat(far)) * scale;
                    Bounds::from_points([at, at + size * scale])
                })
                .collect();
            let one = through % boxes.len();
            let touched = boxes[one].corners()[corner];
            // Planes through a corner, with all space on one side, the other, or none.
            let planes: Vec<PlanePair> = normals
                .iter()
                .enumerate()
                .map(|(i, normal)| {
                    let along = normal.normalize_or_zero();
                    let at = along.dot(touched);
                    match i {
                        0 => PlanePair::above(along, at),
                        1 => PlanePair::below(along, at),
                        _ => PlanePair { along, low: at, high: at },
                    }
                })
                .collect();
            prop_assert!(found(&boxes, &planes).contains(&one));
        }

        #[test]
        fn leaves_beside_planes_are_not_visited(
            normal in point(1.0),
            beyond in 1e-3..1.0,
            side in prop::bool::ANY,
        ) {
            let boxes: Vec<Bounds> = (0..500)
                .map(|i| {
                    let at = DVec3::new(f64::from(i % 10), f64::from(i / 10 % 10), f64::from(i / 100));
                    Bounds::from_points([at, at + 0.5])
                })
                .collect();
            let along = normal.normalize_or_zero();
            let all: Vec<f64> =
                boxes.iter().flat_map(Bounds::corners).map(|corner| along.dot(corner)).collect();
            let [low, high] = [
                all.iter().copied().fold(f64::INFINITY, f64::min),
                all.iter().copied().fold(f64::NEG_INFINITY, f64::max),
            ];
            let pair = if side {
                PlanePair::above(along, high + beyond)
            } else {
                PlanePair::below(along, low - beyond)
            };
            prop_assert!(found(&boxes, &[pair]).is_empty());
        }
    }

    #[test]
    fn of_two_heaps_far_apart_only_the_one_between_the_planes_is_visited() {
        let boxes: Vec<Bounds> = (0..200)
            .map(|i| {
                let at = DVec3::new(f64::from(i % 10), f64::from(i / 10 % 10), 0.0);
                let heap = DVec3::ONE * f64::from(i / 100) * 100.0;
                Bounds::from_points([at + heap, at + heap + 0.5])
            })
            .collect();
        let along = DVec3::ONE.normalize();
        // The first heap is 0 to 11.3 along the diagonal, the second 173 and more.
        let pair = PlanePair {
            along,
            low: -1.0,
            high: 20.0,
        };
        let found = found(&boxes, &[pair]);
        let first = found.iter().filter(|&&number| number < 100).count();
        assert_eq!(first, 100);
        // One leaf at most has boxes of both heaps, and it has eight boxes.
        assert!(found.len() <= 107, "{}", found.len());
    }

    #[test]
    fn pairs_without_direction_or_numbers_hold_all_boxes() {
        let boxes: Vec<Bounds> = (0..20)
            .map(|i| Bounds::from_points([DVec3::splat(f64::from(i))]))
            .collect();
        let unknown = PlanePair {
            along: DVec3::X,
            low: f64::NAN,
            high: f64::NAN,
        };
        let nowhere = PlanePair {
            along: DVec3::Y * f64::NAN,
            ..unknown
        };
        let endless = PlanePair::above(DVec3::Z * f64::INFINITY, 0.0);
        for pairs in [
            &[][..],
            &[PlanePair::EVERYWHERE],
            &[unknown, nowhere, endless],
            &[unknown; 40],
        ] {
            assert_eq!(found(&boxes, pairs).len(), boxes.len());
        }
        assert!(found(&[], &[PlanePair::EVERYWHERE]).is_empty());
    }
}
