//! Trees of cells that are merged where a caustic is even (section 4.3).

/// Trees over cells, each with the same number of children and of levels.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trees {
    branches: u32,
    levels: u32,
    roots: Vec<u32>,
    nodes: Vec<Node>,
}

/// A node whose cells are not merged.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Node {
    /// A bit for each child: true if it has children itself.
    is_inner: u8,
    /// The first of those that have children, in the list of nodes.
    first_inner: u32,
    /// The first of the others, in the list of leaves.
    first_leaf: u32,
}

/// Bit of a root that is a leaf itself.
const LEAF: u32 = 1 << 31;

/// The largest, the least and the sum of some cells' numbers.
#[derive(Clone, Copy, Debug)]
struct Range {
    least: [f64; 3],
    most: [f64; 3],
    sum: [f64; 3],
    cells: u64,
}

impl Range {
    const NONE: Self = Self {
        least: [f64::INFINITY; 3],
        most: [f64::NEG_INFINITY; 3],
        sum: [0.0; 3],
        cells: 0,
    };

    fn union(self, other: Self) -> Self {
        Self {
            least: std::array::from_fn(|c| self.least[c].min(other.least[c])),
            most: std::array::from_fn(|c| self.most[c].max(other.most[c])),
            sum: std::array::from_fn(|c| self.sum[c] + other.sum[c]),
            cells: self.cells + other.cells,
        }
    }

    fn mean(&self) -> [f64; 3] {
        self.sum.map(|sum| sum / self.cells.max(1) as f64)
    }

    fn is_even(&self, tolerance: f64) -> bool {
        let mean = self.mean();
        self.cells == 0
            || (0..3).all(|c| (self.most[c] - mean[c]).max(mean[c] - self.least[c]) <= tolerance)
    }
}

/// A subtree while it is built.
enum Part {
    Leaf,
    Inner(Vec<(Range, Part)>),
}

impl Trees {
    /// The trees over `roots` times `branches`^`levels` cells, and the means of their leaves.
    ///
    /// `value(root, path)` is a cell's numbers, or `None` for a cell that is not there. The first child of a
    /// path is in its highest digit.
    pub fn new(
        [branches, levels]: [u32; 2],
        roots: usize,
        tolerance: f64,
        value: impl Fn(usize, u64) -> Option<[f64; 3]>,
    ) -> (Self, Vec<[f64; 3]>) {
        let mut trees = Self {
            branches,
            levels,
            ..Self::default()
        };
        let mut leaves = Vec::new();
        for root in 0..roots {
            let (range, part) = trees.part(root, 0, 0, tolerance, &value);
            let entry = match part {
                Part::Leaf => {
                    leaves.push(range.mean());
                    (leaves.len() - 1) as u32 | LEAF
                }
                Part::Inner(children) => {
                    let node = trees.nodes.len();
                    trees.nodes.push(Node::default());
                    trees.add(node, children, &mut leaves);
                    node as u32
                }
            };
            trees.roots.push(entry);
        }
        (trees, leaves)
    }

    fn part(
        &self,
        root: usize,
        level: u32,
        path: u64,
        tolerance: f64,
        value: &impl Fn(usize, u64) -> Option<[f64; 3]>,
    ) -> (Range, Part) {
        if level == self.levels {
            let range = value(root, path).map_or(Range::NONE, |value| Range {
                least: value,
                most: value,
                sum: value,
                cells: 1,
            });
            return (range, Part::Leaf);
        }
        let children: Vec<(Range, Part)> = (0..u64::from(self.branches))
            .map(|child| {
                let path = path * u64::from(self.branches) + child;
                self.part(root, level + 1, path, tolerance, value)
            })
            .collect();
        let range = children
            .iter()
            .fold(Range::NONE, |all, (range, _)| all.union(*range));
        let are_leaves = children.iter().all(|(_, part)| matches!(part, Part::Leaf));
        if are_leaves && range.is_even(tolerance) {
            (range, Part::Leaf)
        } else {
            (range, Part::Inner(children))
        }
    }

    /// Adds the children of a node: those with children lie together, and so do leaves.
    fn add(&mut self, node: usize, children: Vec<(Range, Part)>, leaves: &mut Vec<[f64; 3]>) {
        let (first_inner, first_leaf) = (self.nodes.len() as u32, leaves.len() as u32);
        let mut is_inner = 0;
        let mut inner = Vec::new();
        for (child, (range, part)) in children.into_iter().enumerate() {
            match part {
                Part::Leaf => leaves.push(range.mean()),
                Part::Inner(children) => {
                    is_inner |= 1 << child;
                    inner.push(children);
                }
            }
        }
        self.nodes[node] = Node {
            is_inner,
            first_inner,
            first_leaf,
        };
        let end = self.nodes.len() + inner.len();
        self.nodes.resize(end, Node::default());
        for (place, children) in inner.into_iter().enumerate() {
            self.add(first_inner as usize + place, children, leaves);
        }
    }

    /// The leaf that a cell is in, and the number of nodes on the way.
    #[inline]
    pub fn leaf(&self, root: usize, path: u64) -> (usize, u64) {
        let entry = self.roots[root];
        if entry & LEAF != 0 {
            return ((entry & !LEAF) as usize, 1);
        }
        let bits = self.branches.trailing_zeros();
        let mut node = self.nodes[entry as usize];
        let mut level = 1;
        loop {
            let child = (path >> (bits * (self.levels - level))) as u32 & (self.branches - 1);
            let before = u32::from(node.is_inner) & ((1 << child) - 1);
            if u32::from(node.is_inner) >> child & 1 == 0 {
                let leaf = node.first_leaf + child - before.count_ones();
                return (leaf as usize, u64::from(level) + 1);
            }
            node = self.nodes[(node.first_inner + before.count_ones()) as usize];
            level += 1;
        }
    }

    /// The roots that have children, and each node's bits of children that have some themselves: all else
    /// follows from the order in which trees are built.
    pub fn shape(&self) -> (Vec<bool>, Vec<u8>) {
        let roots = self.roots.iter().map(|root| root & LEAF == 0).collect();
        (roots, self.nodes.iter().map(|node| node.is_inner).collect())
    }

    /// The trees of a [`shape`](Self::shape), and the number of their leaves; `None` if it is that of none.
    pub fn of_shape(
        [branches, levels]: [u32; 2],
        roots: &[u8],
        nodes: &[u8],
    ) -> Option<(Self, u64)> {
        let mut trees = Self {
            branches,
            levels,
            ..Self::default()
        };
        let mut leaves = 0;
        for root in roots {
            match root {
                0 => {
                    trees.roots.push(leaves | LEAF);
                    leaves += 1;
                }
                1 => {
                    trees.roots.push(trees.nodes.len() as u32);
                    trees.nodes.push(Node::default());
                    let node = trees.nodes.len() - 1;
                    trees.fill(node, 1, nodes, &mut leaves)?;
                }
                _ => return None,
            }
        }
        (trees.nodes.len() == nodes.len()).then_some((trees, u64::from(leaves)))
    }

    /// Adds a node's children in the order of [`add`](Self::add).
    fn fill(&mut self, node: usize, level: u32, nodes: &[u8], leaves: &mut u32) -> Option<()> {
        let is_inner = *nodes.get(node)?;
        let is_deep = level > self.levels || level == self.levels && is_inner != 0;
        if is_deep || u32::from(is_inner) >> self.branches != 0 {
            return None;
        }
        let (first_inner, first_leaf) = (self.nodes.len() as u32, *leaves);
        self.nodes[node] = Node {
            is_inner,
            first_inner,
            first_leaf,
        };
        *leaves += self.branches - is_inner.count_ones();
        let end = self.nodes.len() + is_inner.count_ones() as usize;
        if end > nodes.len() {
            return None;
        }
        self.nodes.resize(end, Node::default());
        (first_inner as usize..end).try_for_each(|node| self.fill(node, level + 1, nodes, leaves))
    }

    /// Bytes beside the leaves', as a frame reads them: 9 a node, and 4 a root.
    pub fn bytes(&self) -> u64 {
        9 * self.nodes.len() as u64 + 4 * self.roots.len() as u64
    }

    /// The children of a node.
    pub fn branches(&self) -> u32 {
        self.branches
    }

    /// The levels below a root.
    pub fn levels(&self) -> u32 {
        self.levels
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn value(root: usize, path: u64) -> Option<[f64; 3]> {
        // Even but for one corner; some cells are not there.
        let x = if root == 1 && path < 5 {
            path as f64
        } else {
            0.25
        };
        (path != 63).then_some([x, 0.5 * x, 0.0])
    }

    #[test]
    fn a_tree_without_tolerance_gives_every_cell_back() {
        let (trees, leaves) = Trees::new([4, 3], 2, 0.0, value);
        for root in 0..2 {
            for path in 0..63 {
                let (leaf, nodes) = trees.leaf(root, path);
                assert_eq!(Some(leaves[leaf]), value(root, path), "{root} {path}");
                assert!((1..=4).contains(&nodes));
            }
        }
        // Root 0 is one leaf. Of root 1 all is merged but the first sixteenth, whose first quarter and the
        // cell after it differ.
        assert_eq!(leaves.len(), 1 + 4 + 4 + 2 + 3);
    }

    #[test]
    fn trees_come_back_from_their_shape_and_others_are_refused() {
        for (form, roots) in [([4, 3], 2), ([8, 2], 1)] {
            let (trees, leaves) = Trees::new(form, roots, 0.0, value);
            let (roots, nodes) = trees.shape();
            let roots: Vec<u8> = roots.into_iter().map(u8::from).collect();
            let back = Trees::of_shape(form, &roots, &nodes);
            assert_eq!(back, Some((trees, leaves.len() as u64)));
            if nodes.is_empty() {
                continue;
            }
            // A node too few, one too many, one below the last level.
            assert_eq!(
                Trees::of_shape(form, &roots, &nodes[..nodes.len() - 1]),
                None
            );
            let more = [&nodes[..], &[0]].concat();
            assert_eq!(Trees::of_shape(form, &roots, &more), None);
            assert_eq!(Trees::of_shape([form[0], 1], &roots, &nodes), None);
            assert_eq!(Trees::of_shape(form, &vec![2; roots.len()], &nodes), None);
        }
    }

    #[test]
    fn merged_cells_are_within_the_tolerance_of_their_mean() {
        let noisy = |root: usize, path: u64| {
            let hash = (path + 64 * root as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15) >> 40;
            Some([(hash % 1000) as f64 * 1e-3; 3])
        };
        let (trees, leaves) = Trees::new([8, 2], 3, 0.4, noisy);
        for root in 0..3 {
            for path in 0..64 {
                let (leaf, _) = trees.leaf(root, path);
                let off = leaves[leaf][0] - noisy(root, path).unwrap()[0];
                assert!(off.abs() <= 0.4 + 1e-12);
            }
        }
        assert!(leaves.len() < 3 * 64, "nothing is merged");
    }
}
