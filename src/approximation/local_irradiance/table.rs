//! The table of one light sample, and how it is read.

use std::collections::HashMap;
use std::sync::Arc;

use glam::DVec3;

use super::cells::Cells;
use super::layout::Layout;
use super::leg::Stencil;
use super::reads::{Reads, bits};
use super::settings::Settings;
use super::shoot::Tally;
use super::storage::Stored;
use super::tree::Trees;
use super::variants::{Interpolation, Normal, Space};
use super::work::Work;
use crate::radiometry::Rgb;

/// Irradiance around an object in light from one direction, by the light's own irradiance.
#[derive(Clone, Debug, PartialEq)]
pub struct Table {
    /// What became of its photons.
    pub tally: Tally,
    /// Numbers that its storage cut off.
    pub saturated: u64,
    /// Its numbers.
    pub form: Form,
}

/// The numbers of a table.
#[derive(Clone, Debug, PartialEq)]
pub enum Form {
    /// One a cell.
    Cells(Stored),
    /// Three a cell: the parts of its light's vector irradiance along x, y and z.
    Vectors(Stored),
    /// One a leaf of trees.
    Trees {
        /// The trees.
        trees: Trees,
        /// Their leaves.
        leaves: Stored,
    },
    /// Coefficients of harmonics, shell by shell.
    Shells(Stored),
    /// One for each cell and normal that the sensor reads.
    Reads(Arc<Reads>, Stored),
    /// Coefficients of harmonics, shell by shell, for each normal of the sensor.
    ReadShells(HashMap<[u64; 3], Stored>),
    /// Coefficients of harmonics of the light's direction, cell by cell.
    Harmonics(Stored),
}

impl Table {
    /// Bytes that it takes.
    pub fn bytes(&self) -> u64 {
        match &self.form {
            Form::Cells(stored)
            | Form::Vectors(stored)
            | Form::Shells(stored)
            | Form::Harmonics(stored)
            | Form::Reads(_, stored) => stored.bytes(),
            Form::Trees { trees, leaves } => trees.bytes() + leaves.bytes(),
            Form::ReadShells(all) => all.values().map(Stored::bytes).sum(),
        }
    }
}

impl Layout {
    /// The table of some values, one a cell or three: stages `space` and `storage`.
    pub fn table(&self, settings: &Settings, values: Vec<[f64; 3]>, tally: Tally) -> Table {
        let store = |values| Stored::new(values, settings.storage, settings.range);
        let (form, saturated) = match (settings.space, &self.cells) {
            (Space::MultiResolution, Some(_)) => {
                let (trees, leaves) = self.merged(settings, &values);
                let (leaves, saturated) = store(leaves);
                (Form::Trees { trees, leaves }, saturated)
            }
            (Space::ShellHarmonics, Some(Cells::Shells(_))) => {
                let (stored, saturated) = store(self.coefficients(&values));
                (Form::Shells(stored), saturated)
            }
            _ => {
                let (stored, saturated) = store(values);
                let form = match settings.normal {
                    Normal::Vector => Form::Vectors(stored),
                    Normal::Fixed | Normal::Exact => Form::Cells(stored),
                };
                (form, saturated)
            }
        };
        Table {
            tally,
            saturated,
            form,
        }
    }

    /// Trees over values by cell, and the values of their leaves.
    pub fn merged(&self, settings: &Settings, values: &[[f64; 3]]) -> (Trees, Vec<[f64; 3]>) {
        let Some((form, roots)) = self.trees() else {
            return Default::default();
        };
        Trees::new(form, roots, settings.tolerance, |root, path| {
            self.cell_at(root, path).map(|cell| values[cell as usize])
        })
    }

    /// The coefficients of harmonics on each shell that fit values by cell best.
    pub fn coefficients(&self, values: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let Some(Cells::Shells(shells)) = &self.cells else {
            return Vec::new();
        };
        values
            .chunks_exact(shells.triangles())
            .flat_map(|shell| {
                self.fit.iter().map(move |row| {
                    let mut sum = [0.0; 3];
                    for (weight, value) in row.iter().zip(shell) {
                        for c in 0..3 {
                            sum[c] += weight * value[c];
                        }
                    }
                    sum
                })
            })
            .collect()
    }

    /// The cells around a place.
    #[inline]
    pub fn stencil(&self, settings: &Settings, place: DVec3) -> Stencil {
        match (&self.cells, settings.interpolation) {
            (Some(cells), Interpolation::Linear) => cells.linear(place),
            (Some(cells), Interpolation::Nearest) => cells.nearest(place),
            (None, _) => Stencil::default(),
        }
    }

    /// The irradiance that a table has at a place for a surface that faces the centre, or for the sensor's
    /// own normal if the table has those or is for any. `row` has the harmonics of the light's direction.
    #[inline]
    pub fn read(
        &self,
        settings: &Settings,
        table: &Table,
        [place, normal]: [DVec3; 2],
        row: &[f64],
        work: &mut Work,
    ) -> Rgb {
        let stencil = || self.stencil(settings, place);
        self.read_at(settings, table, [place, normal], &stencil, row, work)
    }

    /// As [`read`](Self::read), with the cells around the place by a function.
    #[inline]
    pub fn read_at(
        &self,
        settings: &Settings,
        table: &Table,
        [place, normal]: [DVec3; 2],
        stencil: &impl Fn() -> Stencil,
        row: &[f64],
        work: &mut Work,
    ) -> Rgb {
        let mut sum = Rgb::BLACK;
        match &table.form {
            Form::Cells(stored) => {
                let stencil = stencil();
                sum = stored.sum(stencil.iter().map(|(cell, weight)| (cell as usize, weight)));
                count(work, stencil.cells().len(), stored);
            }
            Form::Vectors(stored) => {
                let stencil = stencil();
                // V, from where E = −N·V on a surface that light meets from one side.
                for (axis, towards) in [-normal.x, -normal.y, -normal.z].into_iter().enumerate() {
                    let parts = stencil.iter();
                    let parts = parts.map(|(cell, weight)| (3 * cell as usize + axis, weight));
                    sum += stored.sum(parts) * towards;
                }
                sum = sum.map(|channel| channel.max(0.0));
                count(work, 3 * stencil.cells().len(), stored);
            }
            Form::Trees { trees, leaves } => {
                let stencil = stencil();
                sum = leaves.sum(stencil.iter().map(|(cell, weight)| {
                    let (root, path) = self.path(cell);
                    (trees.leaf(root, path), weight)
                }));
                work.nodes += stencil.cells().len() as u64;
                count(work, stencil.cells().len(), leaves);
            }
            Form::Shells(stored) => sum = self.on_shells(settings, stored, place, work),
            Form::ReadShells(all) => {
                if let Some(stored) = all.get(&bits(normal)) {
                    sum = self.on_shells(settings, stored, place, work);
                }
            }
            Form::Reads(reads, stored) => {
                let stencil = stencil();
                sum = stored.sum(
                    stencil
                        .iter()
                        .filter_map(|(cell, weight)| Some((reads.number(cell, normal)?, weight))),
                );
                count(work, stencil.cells().len(), stored);
            }
            Form::Harmonics(stored) => {
                let stencil = stencil();
                sum = stored.sum(stencil.iter().flat_map(|(cell, weight)| {
                    let first = cell as usize * row.len();
                    (first..).zip(row.iter().map(move |harmonic| weight * harmonic))
                }));
                count(work, stencil.cells().len() * row.len(), stored);
            }
        }
        sum
    }

    /// As [`read`](Self::read), from three triangles' cells on a shell, each followed by that on the next
    /// shell, with their shares: `None` if the table has other numbers than
    /// one a cell or leaf. A number of cells that is known makes loops without branches.
    #[inline]
    pub fn read_six(
        &self,
        table: &Table,
        six: impl Fn() -> [(u32, f64); 6],
        work: &mut Work,
    ) -> Option<Rgb> {
        match &table.form {
            Form::Cells(stored) => {
                count(work, 6, stored);
                Some(stored.sum(six().iter().map(|(cell, weight)| (*cell as usize, *weight))))
            }
            Form::Trees { trees, leaves } => {
                count(work, 6, leaves);
                work.nodes += 6;
                let [a, b, c, d, e, f] = six();
                let two = |[inner, outer]: [(u32, f64); 2]| {
                    // The same way on the next shell, which has roots of its own.
                    let (root, path) = self.path(inner.0);
                    [
                        (trees.leaf(root, path), inner.1),
                        (trees.leaf(root + 20, path), outer.1),
                    ]
                };
                let pairs = [two([a, b]), two([c, d]), two([e, f])];
                Some(leaves.sum(pairs.as_flattened().iter().copied()))
            }
            _ => None,
        }
    }

    fn on_shells(
        &self,
        settings: &Settings,
        stored: &Stored,
        place: DVec3,
        work: &mut Work,
    ) -> Rgb {
        let number = (settings.order * settings.order) as usize;
        // Zeros for more would take longer than all else.
        if number <= 36 {
            self.on_shells_by(&mut [0.0; 36][..number], stored, place, work)
        } else {
            self.on_shells_by(&mut [0.0; MOST_HARMONICS][..number], stored, place, work)
        }
    }

    #[inline]
    fn on_shells_by(
        &self,
        harmonics: &mut [f64],
        stored: &Stored,
        place: DVec3,
        work: &mut Work,
    ) -> Rgb {
        let (Some(Cells::Shells(shells)), Some(basis)) = (&self.cells, &self.harmonics) else {
            return Rgb::BLACK;
        };
        let number = harmonics.len();
        basis.write(place.normalize_or(DVec3::Z), harmonics);
        let ([inner, outer], part) = shells.between(place.length());
        let mut sum = Rgb::BLACK;
        for (layer, weight) in [(inner, 1.0 - part), (outer, part)] {
            if weight > 0.0 {
                sum += stored.sum_from(layer * number, harmonics) * weight;
                count(work, number, stored);
            }
        }
        sum
    }
}

/// The largest order squared.
const MOST_HARMONICS: usize = 1024;

#[inline]
fn count(work: &mut Work, fetches: usize, stored: &Stored) {
    work.fetches += fetches as u64;
    work.bytes += fetches as u64 * stored.bytes_each();
}

/// The table of sums for each cell and normal that the sensor reads.
pub fn read_table(
    layout: &Layout,
    settings: &Settings,
    reads: &Arc<Reads>,
    values: Vec<[f64; 3]>,
    tally: Tally,
) -> Table {
    let store = |values| Stored::new(values, settings.storage, settings.range);
    if settings.space == Space::ShellHarmonics {
        let mut saturated = 0;
        let mut all = HashMap::new();
        // By cell first, then by normal.
        let cells = layout.count();
        let normals = reads.count() / cells.max(1);
        for number in 0..normals {
            let own: Vec<[f64; 3]> = (0..cells)
                .map(|cell| values[cell * normals + number])
                .collect();
            let (stored, cut) = store(layout.coefficients(&own));
            saturated += cut;
            all.insert(bits(reads.normal(number)), stored);
        }
        return Table {
            tally,
            saturated,
            form: Form::ReadShells(all),
        };
    }
    let (stored, saturated) = store(values);
    Table {
        tally,
        saturated,
        form: Form::Reads(Arc::clone(reads), stored),
    }
}
