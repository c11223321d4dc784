//! The cells that a table has: how many, and where.

use glam::DVec3;

use super::cells::Cells;
use super::grid::Grid;
use super::settings::Settings;
use super::shells::Shells;
use super::variants::{Region, Space, Tree};
use crate::geometry::Geodesic;
use crate::numeric::math;
use crate::numeric::{SphericalHarmonics, harmonic_fit, spread_bits};

/// The cells of an object's tables, and the region that they fill.
#[derive(Clone, Debug)]
pub struct Layout {
    /// The finest cells; none if space is exact.
    pub cells: Option<Cells>,
    /// The radius \[m\] of the region that cells fill: B.
    pub radius: f64,
    /// The ways from roots to the triangles of a shell, if a tree merges these.
    paths: Vec<(u32, u32)>,
    /// The triangles at the ends of these ways, root by root.
    triangles: Vec<u32>,
    /// The fit of harmonics to the middles of a shell's triangles, coefficient by coefficient, if tables have
    /// those.
    pub fit: Vec<Vec<f64>>,
    /// These harmonics.
    pub harmonics: Option<SphericalHarmonics>,
}

impl Layout {
    /// The cells that settings ask for around an object of some radius \[m\], with the inner borders of its
    /// shells (`radii`, from 0 to the region's radius). An exact region reaches as far as `farthest` \[m\].
    pub fn new(settings: &Settings, object: f64, radii: &[f64], farthest: f64) -> Self {
        let plain = settings.reach * object;
        let radius = region(settings, object, farthest);
        let cells = match kind(settings) {
            None => None,
            Some(Tree::Grid) => {
                let edge = 2.0 * plain / f64::from(settings.cells);
                let side = side(settings, radius / plain);
                Some(Cells::Grid(Grid::new(side as u32, 0.5 * edge * side)))
            }
            Some(Tree::Shells) => {
                let mut radii = radii.to_vec();
                let thickness = radii[radii.len() - 1] - radii[radii.len() - 2];
                while radii[radii.len() - 1] < radius {
                    radii.push(radii[radii.len() - 1] + thickness);
                }
                Some(Cells::Shells(Box::new(Shells::new(
                    settings.shell_level,
                    radii,
                ))))
            }
        };
        let paths = match &cells {
            Some(Cells::Shells(_)) if settings.space == Space::MultiResolution => {
                paths(settings.shell_level)
            }
            _ => Vec::new(),
        };
        let mut triangles = vec![0; paths.len()];
        let ways = paths.len() / 20;
        for (triangle, (root, way)) in (0..).zip(&paths) {
            triangles[*root as usize * ways + *way as usize] = triangle;
        }
        let (mut fit, mut harmonics) = (Vec::new(), None);
        if let (Some(Cells::Shells(shells)), Space::ShellHarmonics) = (&cells, settings.space) {
            let order = settings.order as usize;
            fit = harmonic_fit(shells.middles(), order).unwrap_or_default();
            harmonics = Some(SphericalHarmonics::new(order));
        }
        Self {
            cells,
            radius,
            paths,
            triangles,
            fit,
            harmonics,
        }
    }

    /// The number of cells.
    pub fn count(&self) -> usize {
        self.cells.as_ref().map_or(0, Cells::count)
    }

    /// The form of trees over the cells: children of a node and levels, and the number of roots.
    pub fn trees(&self) -> Option<([u32; 2], usize)> {
        match self.cells.as_ref()? {
            Cells::Grid(grid) => Some(([8, grid.side().next_power_of_two().trailing_zeros()], 1)),
            Cells::Shells(shells) => {
                let level = shells.geodesic().frequency().trailing_zeros();
                Some(([4, level], 20 * shells.layers()))
            }
        }
    }

    /// The root of a cell's tree, and the way from there.
    #[inline]
    pub fn path(&self, cell: u32) -> (usize, u64) {
        match &self.cells {
            Some(Cells::Grid(grid)) => (0, interleaved(grid.places(cell))),
            Some(Cells::Shells(shells)) => {
                let (layer, triangle) = shells.parts(cell);
                let (root, path) = self.paths[triangle as usize];
                (20 * layer + root as usize, u64::from(path))
            }
            None => (0, 0),
        }
    }

    /// The cell at the end of a way, if there is one: the reverse of [`path`](Self::path).
    pub fn cell_at(&self, root: usize, path: u64) -> Option<u32> {
        match self.cells.as_ref()? {
            Cells::Grid(grid) => {
                let n = grid.side();
                let [x, y, z] = apart(path);
                (x < n && y < n && z < n).then(|| grid.index([x, y, z]))
            }
            Cells::Shells(shells) => {
                let (layer, face) = (root / 20, root % 20);
                let ways = shells.triangles() / 20;
                let triangle = self.triangles[face * ways + path as usize];
                Some((layer * shells.triangles()) as u32 + triangle)
            }
        }
    }
}

/// The number of cells that [`Layout::new`] would make, which may be beyond all that fit.
pub fn cells_needed(settings: &Settings, object: f64, radii: &[f64], farthest: f64) -> f64 {
    let plain = settings.reach * object;
    let radius = region(settings, object, farthest);
    match (kind(settings), radii) {
        (Some(Tree::Grid), _) => math::powi(side(settings, radius / plain), 3),
        (Some(Tree::Shells), [.., inner, outer]) => {
            let added = ((radius - outer) / (outer - inner)).ceil().max(0.0);
            (radii.len() as f64 - 1.0 + added) * f64::from(20u32 << (2 * settings.shell_level))
        }
        _ => 0.0,
    }
}

/// The radius \[m\] of the region that has cells.
fn region(settings: &Settings, object: f64, farthest: f64) -> f64 {
    let plain = settings.reach * object;
    match settings.region {
        // A margin for rounding.
        Region::Exact => plain.max(farthest * (1.0 + 1e-9)),
        Region::Clamp | Region::Fade => plain,
    }
}

/// Cubes along each side of a grid whose region has grown by a factor.
fn side(settings: &Settings, growth: f64) -> f64 {
    let plain = f64::from(settings.cells);
    if growth > 1.0 {
        2.0 * (0.5 * plain * growth).ceil()
    } else {
        plain
    }
}

/// The kind of cells that settings ask for; none if space is exact.
pub fn kind(settings: &Settings) -> Option<Tree> {
    match settings.space {
        Space::Grid => Some(Tree::Grid),
        Space::Shells | Space::ShellHarmonics => Some(Tree::Shells),
        Space::MultiResolution => Some(settings.tree),
        Space::Exact => None,
    }
}

/// The digits of three numbers of sixteen bits in turn, the last number's first.
fn interleaved(at: [u32; 3]) -> u64 {
    let [x, y, z] = at.map(|place| spread_bits(u64::from(place)));
    x | y << 1 | z << 2
}

/// Three numbers from the digits that they have in turn.
fn apart(path: u64) -> [u32; 3] {
    std::array::from_fn(|axis| {
        (0..21)
            .map(|bit| ((path >> (3 * bit + axis as u32) & 1) as u32) << bit)
            .sum()
    })
}

/// The face of the icosahedron that each triangle of a geodesic is in, and the way to it by quarters.
///
/// A geodesic of twice the frequency has each triangle cut in four: a triangle's number among them is the
/// place of its middle by the larger one's weights, 3 if it is the middle one.
fn paths(level: u32) -> Vec<(u32, u32)> {
    let coarser: Vec<Geodesic> = (0..level).map(|level| Geodesic::new(1 << level)).collect();
    let finest = Geodesic::new(1 << level);
    (0..finest.triangles().len() as u32)
        .map(|triangle| {
            let middle: DVec3 = finest.middle(triangle);
            let Some(first) = coarser.first() else {
                return (triangle, 0);
            };
            let root = first.place(middle).triangle;
            let way = coarser.iter().fold(0, |way, geodesic| {
                let weights = geodesic.place(middle).weights;
                let corner = weights.iter().position(|weight| *weight > 0.5);
                way << 2 | corner.unwrap_or(3) as u32
            });
            (root, way)
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn each_triangle_has_a_way_of_its_own_and_quarters_are_together() {
        for level in 0..5 {
            let paths = paths(level);
            let distinct: HashSet<(u32, u32)> = paths.iter().copied().collect();
            assert_eq!(distinct.len(), 20 << (2 * level));
            assert!(
                paths
                    .iter()
                    .all(|(root, way)| *root < 20 && *way < 1 << (2 * level))
            );
            if level > 0 {
                let finest = Geodesic::new(1 << level);
                let coarse = Geodesic::new(1 << (level - 1));
                let mut seen = HashSet::new();
                for (triangle, (root, way)) in paths.iter().enumerate() {
                    let middle = finest.middle(triangle as u32);
                    seen.insert((coarse.place(middle).triangle, *root, way >> 2));
                }
                assert_eq!(seen.len(), coarse.triangles().len());
            }
        }
    }

    #[test]
    fn digits_are_interleaved() {
        assert_eq!(interleaved([1, 0, 0]), 1);
        assert_eq!(interleaved([0, 1, 0]), 2);
        assert_eq!(interleaved([0, 0, 1]), 4);
        assert_eq!(interleaved([2, 3, 0]), 8 + 16 + 2);
        assert_eq!(apart(interleaved([5, 77, 1023])), [5, 77, 1023]);
    }
}
