//! The search for beams around points: beams in their order, in groups of groups.

use glam::DVec2;

use super::beam::Beam;
use super::slicing::{LocalBox, Slicing};

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
            let other = self.beam.reach(to);
            reach = [reach[0].min(other[0]), reach[1].max(other[1])];
        }
        overlaps(reach, target.across)
    }
}

#[inline]
fn overlaps(a: [DVec2; 2], b: [DVec2; 2]) -> bool {
    a[0].cmple(b[1]).all() && b[0].cmple(a[1]).all()
}

/// Beams of a group.
const GROUP: usize = 8;

/// A group of beams, or of groups.
#[derive(Clone, Copy)]
struct Group {
    /// What its rays reach in the top plane, and in the lowest one.
    reach: [[DVec2; 2]; 2],
    depths: [f64; 2],
}

impl Group {
    fn union(self, other: Self) -> Self {
        let join = |a: [DVec2; 2], b: [DVec2; 2]| [a[0].min(b[0]), a[1].max(b[1])];
        Self {
            reach: [
                join(self.reach[0], other.reach[0]),
                join(self.reach[1], other.reach[1]),
            ],
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
    bottom: f64,
}

impl<'a> BeamSearch<'a> {
    /// The search among beams that end at the depth `bottom`.
    pub fn new(drawn: &'a [Drawn<'a>], bottom: f64) -> Self {
        let single = |drawn: &Drawn| Group {
            reach: [drawn.beam.reach(0.0), drawn.beam.reach(bottom)],
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
        Self {
            drawn,
            levels,
            bottom,
        }
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
        let at = |depth: f64| {
            let t = depth / self.bottom;
            [0, 1].map(|i| group.reach[0][i] + (group.reach[1][i] - group.reach[0][i]) * t)
        };
        let (from, to) = (at(target.depths[0]), at(target.depths[1]));
        if !overlaps([from[0].min(to[0]), from[1].max(to[1])], target.across) {
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
