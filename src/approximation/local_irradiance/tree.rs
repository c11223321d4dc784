//! Trees of cells that are merged where a caustic is even (section 4.3).

/// Trees over cells, each with the same number of children and of levels.
///
/// Leaves are in the order of their cells, so that a bit a cell says which leaf it is in: set if a leaf
/// starts there. A leaf's number is the count of bits up to its cell.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Trees {
    branches: u32,
    levels: u32,
    roots: usize,
    /// A root has two to this cells, and bits of cells that are not there up to a whole block.
    shift: u32,
    blocks: Vec<Block>,
}

/// Cells that follow each other.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Block {
    /// A bit for each cell: true if a leaf starts there. The lowest are in the first word.
    starts: [u32; 2],
    /// Leaves that start before this block.
    before: u32,
}

/// Cells of a block, as a power of two.
const BLOCK: u32 = 6;
/// Bytes of a block.
pub const BLOCK_BYTES: u64 = size_of::<Block>() as u64;

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
        let shift = shift([branches, levels]);
        let mut trees = Self {
            branches,
            levels,
            roots,
            shift,
            blocks: vec![Block::default(); roots << (shift - BLOCK)],
        };
        let mut leaves = Vec::new();
        // The leaves of a root, by the way to their first cells.
        let mut found: Vec<(u64, Range)> = Vec::new();
        for root in 0..roots {
            trees.merge(root, 0, 0, tolerance, &value, &mut found);
            for (path, range) in found.drain(..) {
                let bit = (path & ((1 << BLOCK) - 1)) as usize;
                let block = trees.block(root, path);
                trees.blocks[block].starts[bit / 32] |= 1 << (bit % 32);
                leaves.push(range.mean());
            }
        }
        trees.count();
        (trees, leaves)
    }

    /// Adds the leaves below a node; true if it is one itself.
    fn merge(
        &self,
        root: usize,
        level: u32,
        path: u64,
        tolerance: f64,
        value: &impl Fn(usize, u64) -> Option<[f64; 3]>,
        found: &mut Vec<(u64, Range)>,
    ) -> bool {
        if level == self.levels {
            let range = value(root, path).map_or(Range::NONE, |value| Range {
                least: value,
                most: value,
                sum: value,
                cells: 1,
            });
            found.push((path, range));
            return true;
        }
        let first = found.len();
        let mut are_leaves = true;
        for child in 0..u64::from(self.branches) {
            let path = path * u64::from(self.branches) + child;
            are_leaves &= self.merge(root, level + 1, path, tolerance, value, found);
        }
        let children = found[first..].iter();
        let all = children.fold(Range::NONE, |all, (_, range)| all.union(*range));
        let is_leaf = are_leaves && all.is_even(tolerance);
        if is_leaf {
            found.truncate(first + 1);
            found[first].1 = all;
        }
        is_leaf
    }

    /// Counts the leaves before each block, and returns that of all.
    fn count(&mut self) -> u32 {
        let mut before = 0;
        for block in &mut self.blocks {
            block.before = before;
            before += block.starts.map(u32::count_ones).iter().sum::<u32>();
        }
        before
    }

    #[inline]
    fn block(&self, root: usize, path: u64) -> usize {
        (root << (self.shift - BLOCK)) + (path >> BLOCK) as usize
    }

    /// The leaf that a cell is in.
    #[inline]
    pub fn leaf(&self, root: usize, path: u64) -> usize {
        let block = &self.blocks[self.block(root, path)];
        let [low, high] = block.starts.map(u64::from);
        let up_to = u64::MAX >> (63 - (path & ((1 << BLOCK) - 1)));
        let starts = ((low | high << 32) & up_to).count_ones();
        // Each root starts with a leaf.
        (block.before + starts - 1) as usize
    }

    /// The bits of cells at which leaves start, block by block: all else follows from these.
    pub fn starts(&self) -> impl ExactSizeIterator<Item = [u32; 2]> + '_ {
        self.blocks.iter().map(|block| block.starts)
    }

    /// The trees of some [`starts`](Self::starts), and the number of their leaves; `None` if these are those
    /// of none.
    pub fn of_starts(
        form: [u32; 2],
        roots: usize,
        starts: impl ExactSizeIterator<Item = [u32; 2]>,
    ) -> Option<(Self, u64)> {
        let shift = shift(form);
        if starts.len() != blocks(form, roots) {
            return None;
        }
        let [branches, levels] = form;
        let mut trees = Self {
            branches,
            levels,
            roots,
            shift,
            blocks: starts.map(|starts| Block { starts, before: 0 }).collect(),
        };
        for root in 0..roots {
            if !trees.is_whole(root, 0, 0) {
                return None;
            }
        }
        let leaves = trees.count();
        Some((trees, u64::from(leaves)))
    }

    /// True if a node's bits are those of a tree: its first cell starts a leaf, and if any other does, each
    /// of its children is whole. Bits of cells that are not there are 0.
    fn is_whole(&self, root: usize, level: u32, first: u64) -> bool {
        let below = self.levels - level;
        let cells = u64::from(self.branches).pow(below);
        let padded = if level == 0 { 1 << self.shift } else { cells };
        let is_start = |cell: u64| {
            let block = &self.blocks[self.block(root, cell)];
            let bit = cell & ((1 << BLOCK) - 1);
            block.starts[bit as usize / 32] >> (bit % 32) & 1 == 1
        };
        if !is_start(first) || (first + cells..first + padded).any(is_start) {
            return false;
        }
        let is_leaf = !(first + 1..first + cells).any(is_start);
        let child = cells / u64::from(self.branches);
        is_leaf
            || (0..u64::from(self.branches))
                .all(|number| self.is_whole(root, level + 1, first + number * child))
    }

    /// Bytes beside the leaves', as a frame reads them.
    pub fn bytes(&self) -> u64 {
        BLOCK_BYTES * self.blocks.len() as u64
    }

    /// The children of a node, and the levels below a root.
    pub fn form(&self) -> [u32; 2] {
        [self.branches, self.levels]
    }

    /// Roots.
    pub fn roots(&self) -> usize {
        self.roots
    }
}

/// The cells of a root as a power of two: whole blocks.
fn shift([branches, levels]: [u32; 2]) -> u32 {
    (branches.trailing_zeros() * levels).max(BLOCK)
}

/// Blocks of trees.
pub fn blocks(form: [u32; 2], roots: usize) -> usize {
    roots << (shift(form) - BLOCK)
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
                let leaf = trees.leaf(root, path);
                assert_eq!(Some(leaves[leaf]), value(root, path), "{root} {path}");
            }
        }
        // Root 0 is one leaf. Of root 1 all is merged but the first sixteenth, whose first quarter and the
        // cell after it differ.
        assert_eq!(leaves.len(), 1 + 4 + 4 + 2 + 3);
    }

    #[test]
    fn trees_come_back_from_their_bits_and_others_are_refused() {
        for (form, roots) in [([4, 3], 2), ([8, 2], 1), ([4, 2], 3), ([8, 3], 2)] {
            let (trees, leaves) = Trees::new(form, roots, 0.0, value);
            let starts: Vec<[u32; 2]> = trees.starts().collect();
            let of = |starts: &[[u32; 2]]| Trees::of_starts(form, roots, starts.iter().copied());
            assert_eq!(of(&starts), Some((trees, leaves.len() as u64)));
            // A block too few, and one too many.
            assert_eq!(of(&starts[1..]), None);
            assert_eq!(of(&[&starts[..], &[[1, 0]]].concat()), None);
            for block in 0..starts.len() {
                for bit in 0..64 {
                    let mut other = starts.clone();
                    other[block][bit / 32] ^= 1 << (bit % 32);
                    let cells = form[0].pow(form[1]) as usize;
                    let at = 64 * block + bit;
                    // No leaf at a root, and one at a cell that is not there.
                    let is_missing = bit >= cells;
                    if at % cells.max(64) == 0 || is_missing {
                        assert_eq!(of(&other), None, "{form:?} {at}");
                    }
                    // Of others each is a tree whose bits they are, or none.
                    if let Some((back, _)) = of(&other) {
                        assert!(back.starts().eq(other));
                    }
                }
            }
            // The second cell alone starts a leaf: its sisters have none.
            let mut odd = vec![[0, 0]; starts.len()];
            let of_root = starts.len() / roots;
            odd.iter_mut()
                .step_by(of_root)
                .for_each(|block| block[0] = 1);
            assert!(of(&odd).is_some(), "all is merged");
            odd[0][0] = 3;
            assert_eq!(of(&odd), None);
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
                let leaf = trees.leaf(root, path);
                let off = leaves[leaf][0] - noisy(root, path).unwrap()[0];
                assert!(off.abs() <= 0.4 + 1e-12);
            }
        }
        assert!(leaves.len() < 3 * 64, "nothing is merged");
    }
}
