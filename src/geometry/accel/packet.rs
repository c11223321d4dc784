//! Searches of rays that go about the same way: they go down a tree together.

use arrayvec::ArrayVec;

use super::{
    lanes::{Lanes, WIDTH},
    ray::LocalRay,
    stream::Searches,
    tree::{AxisRange, BoxTree, Child, TreeNode},
    walk::Stack,
};

/// Up to eight rays whose directions have the same signs.
///
/// A node's children are tried for all of them at once, by the ranges of their numbers. Roundings are
/// monotone: if a ray enters a box by its own test, so does its packet. Then each ray is asked, by the very
/// test that it would make alone. So it looks at every leaf whose box it enters up to its nearest hit. It may
/// look at some beyond, as the order is the packet's.
struct Packet {
    /// With their numbers.
    rays: ArrayVec<(LocalRay, usize), WIDTH>,
    /// By axis and ray.
    near_origins: [[f32; WIDTH]; 3],
    far_origins: [[f32; WIDTH]; 3],
    reciprocals: [[f32; WIDTH]; 3],
    /// The distance in the tree's frame up to which each ray goes on; −∞ where there is none.
    limits: [f32; WIDTH],
    axes: [AxisRange; 3],
}

/// A child that waits, and a bit for each ray that enters it.
#[derive(Clone, Copy)]
struct Waiting {
    child: Child,
    rays: u32,
}

impl Packet {
    const NONE: Self = Self {
        rays: ArrayVec::new_const(),
        near_origins: [[0.0; WIDTH]; 3],
        far_origins: [[0.0; WIDTH]; 3],
        reciprocals: [[0.0; WIDTH]; 3],
        limits: [f32::NEG_INFINITY; WIDTH],
        axes: [AxisRange::NONE; 3],
    };

    /// Takes the next rays, up to one that has no place here; returns that one.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn fill(
        &mut self,
        waiting: Option<(LocalRay, usize, f64)>,
        searches: &mut impl Searches,
    ) -> Option<(LocalRay, usize, f64)> {
        self.rays.clear();
        self.limits = [f32::NEG_INFINITY; WIDTH];
        let mut next = waiting.or_else(|| searches.next());
        while let Some((ray, number, limit)) = next {
            let goes_along = (self.rays.first()).is_none_or(|(first, _)| first.signs == ray.signs);
            if !goes_along || self.rays.is_full() {
                return Some((ray, number, limit));
            }
            let lane = self.rays.len();
            for axis in 0..3 {
                self.near_origins[axis][lane] = ray.near_origin[axis];
                self.far_origins[axis][lane] = ray.far_origin[axis];
                self.reciprocals[axis][lane] = ray.reciprocal[axis];
            }
            self.limits[lane] = ray.local_limit(limit);
            self.rays.push((ray, number));
            next = searches.next();
        }
        None
    }

    /// Finds the ranges of its rays' numbers.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn find_ranges(&mut self) {
        let Some((first, _)) = self.rays.first() else {
            return;
        };
        let count = self.rays.len();
        for (axis, range) in self.axes.iter_mut().enumerate() {
            let [near, far, reciprocals] = [
                &self.near_origins[axis],
                &self.far_origins[axis],
                &self.reciprocals[axis],
            ]
            .map(|of| least_and_greatest(&of[..count]));
            let side = (first.signs[axis] & 1) as usize;
            *range = AxisRange {
                sign: first.signs[axis],
                near_origin: near[1 - side],
                far_origin: far[side],
                entering_reciprocal: reciprocals[side],
                leaving_reciprocal: reciprocals[1 - side],
            };
        }
    }

    /// The distance up to which any ray goes on.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn limit(&self) -> f32 {
        least_and_greatest(&self.limits)[1]
    }

    /// A bit for each ray that enters this child's box before its limit.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn entering(&self, lanes: impl Lanes, node: &TreeNode, child: usize) -> u32 {
        let mut near = lanes.splat(0.0);
        let mut far = lanes.load(&self.limits);
        for axis in 0..3 {
            let side = (self.axes[axis].sign & 1) as usize;
            let reciprocals = lanes.load(&self.reciprocals[axis]);
            let first = lanes.splat(node.planes[2 * axis + side][child]);
            let last = lanes.splat(node.planes[2 * axis + 1 - side][child]);
            let enter = lanes.sub(first, lanes.load(&self.near_origins[axis]));
            let leave = lanes.sub(last, lanes.load(&self.far_origins[axis]));
            near = lanes.max(lanes.mul(enter, reciprocals), near);
            far = lanes.min(lanes.mul(leave, reciprocals), far);
        }
        lanes.at_most(near, far)
    }
}

#[inline(always)]
#[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
fn least_and_greatest(numbers: &[f32]) -> [f32; 2] {
    let mut ends = [f32::INFINITY, f32::NEG_INFINITY];
    for &number in numbers {
        // As the registers have it: `f32::min` asks for NaN, too.
        ends[0] = if number < ends[0] { number } else { ends[0] };
        ends[1] = if number > ends[1] { number } else { ends[1] };
    }
    ends
}

impl BoxTree {
    /// All searches, in packets of rays that follow one another. Returns the number of nodes visited.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    pub(super) fn search_packets_local(
        &self,
        lanes: impl Lanes,
        searches: &mut impl Searches,
    ) -> u64 {
        let mut packet = Packet::NONE;
        let mut stack = Stack::new();
        let mut visits = 0;
        let mut waiting = packet.fill(None, searches);
        while !packet.rays.is_empty() {
            packet.find_ranges();
            visits += self.search_packet(lanes, &mut packet, &mut stack, searches);
            waiting = packet.fill(waiting, searches);
        }
        visits
    }

    /// The searches of a packet. Nothing waits on `stack`.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn search_packet(
        &self,
        lanes: impl Lanes,
        packet: &mut Packet,
        stack: &mut Stack<Waiting>,
        searches: &mut impl Searches,
    ) -> u64 {
        let mut visits = 0;
        let mut limit = packet.limit();
        // A tree's root is a node, not a leaf.
        let mut next = self.whole.node;
        loop {
            visits += 1;
            let node = &self.nodes[next.0 as usize];
            let (entries, mut hits) = node.entries(lanes, &packet.axes, limit);
            let bottom = stack.len();
            while hits != 0 {
                let index = hits.trailing_zeros() as usize;
                hits &= hits - 1;
                let rays = packet.entering(lanes, node, index);
                if rays == 0 {
                    continue;
                }
                let child = node.children[index];
                match child.as_leaf() {
                    Some(leaf) => searches.announce(lanes, leaf),
                    None => lanes.prefetch(&self.nodes[child.0 as usize]),
                }
                stack.push_sorted(bottom, entries[index], Waiting { child, rays });
            }
            loop {
                let Some((entry, Waiting { child, rays })) = stack.pop() else {
                    return visits;
                };
                if entry > limit {
                    continue;
                }
                let Some(leaf) = child.as_leaf() else {
                    next = child;
                    break;
                };
                packet.visit(lanes, leaf, rays, searches);
                limit = packet.limit();
            }
        }
    }
}

impl Packet {
    /// The work at a leaf, of these rays.
    #[inline(always)]
    #[allow(clippy::inline_always)] // or it is not compiled for the caller's registers
    fn visit(
        &mut self,
        lanes: impl Lanes,
        leaf: usize,
        mut rays: u32,
        searches: &mut impl Searches,
    ) {
        // All look first: the corners that tests read come from memory meanwhile.
        let mut candidates = [0; WIDTH];
        let mut looking = rays;
        while looking != 0 {
            let lane = looking.trailing_zeros() as usize;
            looking &= looking - 1;
            candidates[lane] = searches.candidates(lanes, leaf, &self.rays[lane].0);
        }
        while rays != 0 {
            let lane = rays.trailing_zeros() as usize;
            rays &= rays - 1;
            if candidates[lane] != 0 {
                let (ray, number) = &self.rays[lane];
                let reached = searches.test(*number, leaf, candidates[lane]);
                self.limits[lane] = ray.local_limit(reached);
            }
        }
    }
}
