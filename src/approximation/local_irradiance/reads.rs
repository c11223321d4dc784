//! The cells and normals that a sensor reads: stage `normal`, exact.

use std::collections::HashMap;
use std::ops::Range;

use glam::DVec3;

use super::layout::Layout;
use super::settings::Settings;
use super::tree::Trees;
use super::variants::Space;
use crate::numeric::math;

/// The bits of a normal: surfaces of the same normal share numbers.
#[inline]
pub fn bits(normal: DVec3) -> [u64; 3] {
    normal.to_array().map(f64::to_bits)
}

/// The cells and normals that a sensor reads.
#[derive(Clone, Debug, Default)]
pub struct Reads {
    /// The place of the first of a cell's numbers, by cell; the end is that of the next.
    firsts: Vec<u32>,
    /// The normals, by number.
    normals: Vec<DVec3>,
    numbers: HashMap<(u32, [u64; 3]), u32>,
}

impl Reads {
    /// Of some cells with unit normals, in order and each once, of `cells` cells in all.
    pub fn new(cells: usize, all: Vec<Read>) -> Self {
        let mut firsts = vec![0u32; cells + 1];
        for (cell, _) in &all {
            firsts[*cell as usize + 1] += 1;
        }
        for cell in 0..cells {
            firsts[cell + 1] += firsts[cell];
        }
        Self {
            firsts,
            numbers: (0..)
                .zip(&all)
                .map(|(number, (cell, normal))| ((*cell, bits(*normal)), number))
                .collect(),
            normals: all.into_iter().map(|(_, normal)| normal).collect(),
        }
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.normals.len()
    }

    /// The numbers of a cell.
    #[inline]
    pub fn of(&self, cell: u32) -> Range<usize> {
        self.firsts[cell as usize] as usize..self.firsts[cell as usize + 1] as usize
    }

    /// The cells with their normals, in the order of numbers.
    pub fn iter(&self) -> impl Iterator<Item = (u32, DVec3)> + '_ {
        let cells = 0..self.firsts.len() as u32 - 1;
        cells
            .flat_map(move |cell| self.of(cell).map(move |_| cell))
            .zip(self.normals.iter().copied())
    }

    /// The normal of a number.
    pub fn normal(&self, number: usize) -> DVec3 {
        self.normals[number]
    }

    /// The number of a cell with a normal.
    pub fn number(&self, cell: u32, normal: DVec3) -> Option<usize> {
        let key = (cell, bits(normal));
        self.numbers.get(&key).map(|number| *number as usize)
    }
}

impl PartialEq for Reads {
    fn eq(&self, other: &Self) -> bool {
        self.firsts == other.firsts && self.normals == other.normals
    }
}

/// A cell, and the normal of a surface in it.
pub type Read = (u32, DVec3);

/// All that is read at some places with their normals, without duplicates.
pub fn reads_at(
    layout: &Layout,
    settings: &Settings,
    places: impl Iterator<Item = [DVec3; 2]>,
) -> Vec<Read> {
    let mut all = Vec::new();
    for [place, normal] in places {
        if settings.space == Space::ShellHarmonics {
            // Every cell of a shell counts.
            all.push((0, normal));
        } else {
            let stencil = layout.stencil(settings, place);
            all.extend(stencil.cells().iter().map(|cell| (*cell, normal)));
        }
    }
    distinct(all)
}

/// All that sums are needed of, for some cells to be read.
///
/// # Errors
///
/// If these are more than `most`: their number.
pub fn needed(
    layout: &Layout,
    settings: &Settings,
    all: Vec<Read>,
    most: f64,
) -> Result<Reads, f64> {
    let cells = layout.count();
    let all = distinct(all);
    let check = |count: f64| if count > most { Err(count) } else { Ok(()) };
    check(all.len() as f64)?;
    let all = match settings.space {
        Space::ShellHarmonics => {
            check(cells as f64 * all.len() as f64)?;
            (0..cells as u32)
                .flat_map(|cell| all.iter().map(move |(_, normal)| (cell, *normal)))
                .collect()
        }
        // A merged cell has the mean of all that it was merged with. Which these are is known only from the
        // light: all of its tree may be.
        Space::MultiResolution => {
            let roots = roots_of(layout, &all);
            let ways = layout.trees().map_or(0.0, |([branches, levels], _)| {
                math::powf(f64::from(branches), f64::from(levels))
            });
            check(ways * roots.len() as f64)?;
            with_relatives(layout, roots)
        }
        Space::Grid | Space::Shells | Space::Exact => all,
    };
    Ok(Reads::new(cells, all))
}

fn distinct(mut all: Vec<Read>) -> Vec<Read> {
    all.sort_unstable_by_key(|(cell, normal)| (*cell, bits(*normal)));
    all.dedup_by_key(|(cell, normal)| (*cell, bits(*normal)));
    all
}

/// The roots of some cells' trees, with the cells' normals; each once.
fn roots_of(layout: &Layout, all: &[Read]) -> Vec<(usize, DVec3)> {
    let mut roots: Vec<(usize, DVec3)> = all
        .iter()
        .map(|(cell, normal)| (layout.path(*cell).0, *normal))
        .collect();
    roots.sort_unstable_by_key(|(root, normal)| (*root, bits(*normal)));
    roots.dedup_by_key(|(root, normal)| (*root, bits(*normal)));
    roots
}

/// All cells of some trees with normals.
fn with_relatives(layout: &Layout, roots: Vec<(usize, DVec3)>) -> Vec<Read> {
    let Some(([branches, levels], _)) = layout.trees() else {
        return Vec::new();
    };
    let ways = u64::from(branches).pow(levels);
    roots
        .into_iter()
        .flat_map(|(root, normal)| {
            (0..ways).filter_map(move |way| layout.cell_at(root, way).map(|cell| (cell, normal)))
        })
        .collect()
}

/// Gives each number the mean over its cell's leaf.
pub fn average_leaves(layout: &Layout, trees: &Trees, reads: &Reads, values: &mut [[f64; 3]]) {
    let leaf_of = |cell: u32, normal: DVec3| {
        let (root, path) = layout.path(cell);
        (trees.leaf(root, path), bits(normal))
    };
    let mut means: HashMap<(usize, [u64; 3]), ([f64; 3], f64)> = HashMap::new();
    for (number, (cell, normal)) in reads.iter().enumerate() {
        let (sum, count) = means.entry(leaf_of(cell, normal)).or_default();
        for c in 0..3 {
            sum[c] += values[number][c];
        }
        *count += 1.0;
    }
    for (number, (cell, normal)) in reads.iter().enumerate() {
        let (sum, count) = means[&leaf_of(cell, normal)];
        values[number] = sum.map(|sum| sum / count);
    }
}
