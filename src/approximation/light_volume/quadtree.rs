//! The hierarchy of the water's triangles: full quadtrees over a grid of buckets (section 3.3).

use std::ops::Range;

use glam::{DVec2, DVec3};

use crate::geometry::Frame;

/// Full quadtrees over `buckets` x `buckets` rectangles of the water's surface.
///
/// A triangle belongs to the leaf in which its lower left vertex is. Leaves are numbered so that those of a
/// node follow one another.
#[derive(Clone, Debug)]
pub struct Quadtree {
    buckets: u32,
    splits: u32,
    /// Coordinates across the water's mean normal, and along it.
    frame: Frame,
    /// The mean height of the water along it.
    height: f64,
    /// The rectangle of the water, across it.
    range: [DVec2; 2],
    /// Triangles leaf by leaf.
    order: Vec<u32>,
    /// Where each leaf's triangles begin, and where the last one's end.
    starts: Vec<u32>,
}

/// A node: its level, 0 for roots, and its number there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Node {
    /// 0 for roots.
    pub level: u32,
    /// Its number on its level: those of its children are four times as large, and 1, 2 and 3 more.
    pub index: u32,
}

impl Quadtree {
    /// The quadtrees of triangles whose lower left vertices are at `corners`, on a surface that fills
    /// `range`, across a frame's normal at a height.
    pub fn new(
        corners: &[DVec2],
        range: [DVec2; 2],
        (frame, height): (Frame, f64),
        [buckets, splits]: [u32; 2],
    ) -> Self {
        let side = buckets << splits;
        let [low, high] = range;
        let leaves: Vec<u32> = corners
            .iter()
            .map(|corner| {
                let at = (*corner - low) / (high - low) * f64::from(side);
                // NaN of a surface without extent is 0.
                let [column, row] = at.to_array().map(|x| (x.max(0.0) as u32).min(side - 1));
                leaf([column, row], buckets, splits)
            })
            .collect();
        let mut starts = vec![0; (side * side + 1) as usize];
        for leaf in &leaves {
            starts[*leaf as usize + 1] += 1;
        }
        for index in 1..starts.len() {
            starts[index] += starts[index - 1];
        }
        let mut order: Vec<u32> = (0..leaves.len() as u32).collect();
        order.sort_by_key(|&triangle| leaves[triangle as usize]);
        Self {
            buckets,
            splits,
            frame,
            height,
            range,
            order,
            starts,
        }
    }

    /// The triangles in the order of leaves.
    pub fn order(&self) -> &[u32] {
        &self.order
    }

    /// The roots.
    pub fn roots(&self) -> impl Iterator<Item = Node> + use<> {
        (0..self.buckets * self.buckets).map(|index| Node { level: 0, index })
    }

    /// All leaves.
    pub fn all_leaves(&self) -> impl Iterator<Item = Node> + use<> {
        let level = self.splits;
        (0..self.nodes(level)).map(move |index| Node { level, index })
    }

    /// The four children of a node; `None` of a leaf.
    pub fn children(&self, node: Node) -> Option<[Node; 4]> {
        (node.level < self.splits).then(|| {
            std::array::from_fn(|child| Node {
                level: node.level + 1,
                index: 4 * node.index + child as u32,
            })
        })
    }

    /// Levels of nodes, leaves included.
    pub fn levels(&self) -> u32 {
        self.splits + 1
    }

    /// Nodes on a level.
    pub fn nodes(&self, level: u32) -> u32 {
        (self.buckets << level) * (self.buckets << level)
    }

    /// Nodes on all levels.
    pub fn all_nodes(&self) -> u32 {
        (0..self.levels()).map(|level| self.nodes(level)).sum()
    }

    /// Number of leaves below a node.
    pub fn leaves(&self, node: Node) -> u32 {
        1 << (2 * (self.splits - node.level))
    }

    /// A node's triangles, by their places in [`order`](Self::order).
    pub fn triangles(&self, node: Node) -> Range<usize> {
        let below = 2 * (self.splits - node.level);
        let (first, last) = (node.index << below, (node.index + 1) << below);
        self.starts[first as usize] as usize..self.starts[last as usize] as usize
    }

    /// The corners of a node's rectangle of the water at its mean height, in turn.
    pub fn corners(&self, node: Node) -> [DVec3; 4] {
        let [low, high] = self.rectangle(node);
        [
            low,
            DVec2::new(high.x, low.y),
            high,
            DVec2::new(low.x, high.y),
        ]
        .map(|at| self.frame.to_world(at.extend(self.height)))
    }

    /// A point and the normal of the plane in which all rectangles are.
    pub fn plane(&self) -> [DVec3; 2] {
        [self.frame.n * self.height, self.frame.n]
    }

    /// A node's rectangle of the water: two corners across the mean normal.
    pub fn rectangle(&self, node: Node) -> [DVec2; 2] {
        let in_root = node.index & ((1 << (2 * node.level)) - 1);
        let root = node.index >> (2 * node.level);
        let mut place = [root % self.buckets, root / self.buckets];
        for level in (0..node.level).rev() {
            let quarter = in_root >> (2 * level);
            place = [
                2 * place[0] + (quarter & 1),
                2 * place[1] + (quarter >> 1 & 1),
            ];
        }
        let [low, high] = self.range;
        let side = f64::from(self.buckets << node.level);
        let at =
            |x: u32, y: u32| low + (high - low) * (DVec2::new(f64::from(x), f64::from(y)) / side);
        [at(place[0], place[1]), at(place[0] + 1, place[1] + 1)]
    }
}

/// The number of the leaf in a column and a row.
fn leaf([column, row]: [u32; 2], buckets: u32, splits: u32) -> u32 {
    let root = (row >> splits) * buckets + (column >> splits);
    let mut number = root;
    for level in (0..splits).rev() {
        number = 4 * number + 2 * (row >> level & 1) + (column >> level & 1);
    }
    number
}

/// The lower left of a triangle's vertices: the lowest; of equally low ones the leftmost.
pub fn lower_left(corners: [DVec2; 3]) -> DVec2 {
    let is_before = |a: DVec2, b: DVec2| a.y < b.y || a.y == b.y && a.x < b.x;
    let [a, b, c] = corners;
    let ab = if is_before(b, a) { b } else { a };
    if is_before(c, ab) { c } else { ab }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_triangle_is_in_the_leaf_whose_rectangle_has_its_lower_left_vertex() {
        let corners: Vec<DVec2> = (0..40)
            .map(|i| DVec2::new(f64::from(i % 8) * 0.37, f64::from(i / 8) * 0.71))
            .collect();
        let range = [DVec2::ZERO, DVec2::new(3.0, 3.2)];
        let tree = Quadtree::new(&corners, range, (Frame::around(DVec3::Z), 0.0), [3, 2]);
        let mut seen = 0;
        for level in 0..tree.levels() {
            let mut on_level = 0;
            for index in 0..tree.nodes(level) {
                let node = Node { level, index };
                let [low, high] = tree.rectangle(node);
                for &triangle in &tree.order()[tree.triangles(node)] {
                    let corner = corners[triangle as usize];
                    assert!(corner.cmpge(low - 1e-12).all() && corner.cmplt(high + 1e-12).all());
                    on_level += 1;
                }
                if let Some(children) = tree.children(node) {
                    let parts = children.map(|child| tree.triangles(child));
                    assert_eq!(parts[0].start, tree.triangles(node).start);
                    assert_eq!(parts[3].end, tree.triangles(node).end);
                    assert!(parts.windows(2).all(|pair| pair[0].end == pair[1].start));
                }
            }
            assert_eq!(on_level, corners.len());
            seen += on_level;
        }
        assert_eq!(seen, 3 * corners.len());
    }

    #[test]
    fn the_lower_left_vertex_of_both_halves_of_a_cell_is_its_corner() {
        let [a, b, c, d] = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]].map(DVec2::from);
        assert_eq!(lower_left([a, b, c]), a);
        assert_eq!(lower_left([c, d, a]), a);
    }
}
