//! The search for beams around points: beams in their order, in groups of groups.

use super::beam::Beam;
use super::hull::Hull;
use super::slicing::{LocalBox, Slicing, join, overlap};

/// A beam between two depths.
#[derive(Clone, Copy, Debug)]
pub struct Drawn<'a> {
    /// The beam.
    pub beam: &'a Beam,
    /// The planes between which it is drawn.
    pub planes: [u32; 2],
    /// Their depths.
    pub depths: [f64; 2],
}

impl<'a> Drawn<'a> {
    /// A beam between two planes.
    pub fn new(beam: &'a Beam, planes: [u32; 2], slicing: &Slicing) -> Self {
        Self {
            beam,
            planes,
            depths: planes.map(|plane| slicing.plane(plane)),
        }
    }
}

impl Drawn<'_> {
    /// The range of depths that it shares with a box; `None` if there is none.
    #[inline]
    fn shared(&self, depths: [f64; 2]) -> Option<[f64; 2]> {
        let shared = [self.depths[0].max(depths[0]), self.depths[1].min(depths[1])];
        (shared[0] <= shared[1]).then_some(shared)
    }

    /// True if it may have points in a box.
    #[inline]
    pub fn may_overlap(&self, target: &LocalBox) -> bool {
        let Some([from, to]) = self.shared(target.depths) else {
            return false;
        };
        let mut reach = self.beam.reach(from);
        if to > from {
            reach = join(reach, self.beam.reach(to));
        }
        overlap(reach, target.across)
    }
}

/// Beams of a group.
const GROUP: usize = 8;

/// Memory \[bytes\] of the search for each beam, groups of groups included, rounded up.
pub const SEARCH_BYTES: u64 = (size_of::<Group>() / (GROUP - 1) + 1) as u64;

/// A group of beams, or of groups.
#[derive(Clone, Copy)]
struct Group {
    /// What its rays reach between the top plane and the lowest one.
    hull: Hull,
    /// The depths between which one of them is drawn.
    depths: [f64; 2],
}

impl Group {
    fn union(self, other: Self) -> Self {
        Self {
            hull: self.hull.union(other.hull),
            depths: [
                self.depths[0].min(other.depths[0]),
                self.depths[1].max(other.depths[1]),
            ],
        }
    }
}

/// Beams in their order, in groups of eight, those in groups of eight again, and so on.
pub struct BeamSearch<'a> {
    drawn: &'a [Drawn<'a>],
    /// Groups of beams first, then groups of these.
    levels: Vec<Vec<Group>>,
}

impl<'a> BeamSearch<'a> {
    /// The search among beams that end at the depth `bottom`.
    pub fn new(drawn: &'a [Drawn<'a>], bottom: f64) -> Self {
        let single = |drawn: &Drawn| Group {
            hull: Hull::of_rays(drawn.beam, bottom),
            depths: drawn.depths,
        };
        let mut levels: Vec<Vec<Group>> = Vec::new();
        let first: Vec<Group> = drawn
            .chunks(GROUP)
            .filter_map(|group| group.iter().map(single).reduce(Group::union))
            .collect();
        levels.push(first);
        while let Some(last) = levels.last().filter(|last| last.len() > 1) {
            let groups = last
                .chunks(GROUP)
                .filter_map(|it| it.iter().copied().reduce(Group::union));
            let groups: Vec<Group> = groups.collect();
            levels.push(groups);
        }
        Self { drawn, levels }
    }

    /// The beams that may have points in a box, in their order.
    pub fn find(&self, target: &LocalBox, into: &mut Vec<u32>) {
        into.clear();
        let top = self.levels.len() - 1;
        for index in 0..self.levels[top].len() {
            self.descend(top, index, target, into);
        }
    }

    fn descend(&self, level: usize, index: usize, target: &LocalBox, into: &mut Vec<u32>) {
        let group = &self.levels[level][index];
        if group.depths[0] > target.depths[1] || group.depths[1] < target.depths[0] {
            return;
        }
        let [from, to] = target.depths.map(|depth| group.hull.at(depth));
        if !overlap(join(from, to), target.across) {
            return;
        }
        let places = index * GROUP..(index + 1) * GROUP;
        if level == 0 {
            for place in places.start..places.end.min(self.drawn.len()) {
                if self.drawn[place].may_overlap(target) {
                    into.push(place as u32);
                }
            }
        } else {
            for place in places.start..places.end.min(self.levels[level - 1].len()) {
                self.descend(level - 1, place, target, into);
            }
        }
    }
}
