//! Splats and faces drawn into a map in bands of rows: the same bits on any number of threads.

use glam::DVec2;
use rayon::prelude::*;

use crate::numeric::math;

/// A point's diameter in standard deviations of its Gaussian.
///
/// The 7-tap filter of binomial weights, which a 7x7 Gaussian is on a device, has the variance 6/4: its
/// diameter is 5.7 deviations.
pub const DEVIATIONS: f64 = 6.0;

/// Rows of a map that are drawn as one task: photons of a band are drawn in their order, so that sums are the
/// same bits on any number of threads.
const BAND: usize = 16;

/// A number of texels, among places that may lie outside of a map.
pub fn signed(count: usize) -> i64 {
    i64::try_from(count).unwrap_or(i64::MAX)
}

/// Where along one axis a point of `diameter` about `center` has its texels' centres: first and last texel,
/// at least the one that holds its own centre.
#[inline]
pub fn reach(center: f64, diameter: f64) -> (i64, i64) {
    let home = center.floor() as i64;
    let first = (center - 0.5 * diameter - 0.5).ceil() as i64;
    let last = (center + 0.5 * diameter - 0.5).floor() as i64;
    (first.min(home), last.max(home))
}

/// Weights of a Gaussian along one axis, at the centres of texels `first` to `last`; their sum is 1.
fn weights(center: f64, (first, last): (i64, i64), deviation: f64, into: &mut Vec<f64>) {
    into.clear();
    // Where a beam is focused most points are of one texel.
    if first == last {
        into.push(1.0);
        return;
    }
    let scale = -0.5 / (deviation * deviation);
    into.extend((first..=last).map(|texel| {
        let offset = texel as f64 + 0.5 - center;
        math::exp(offset * offset * scale)
    }));
    let sum: f64 = into.iter().sum();
    // A point much narrower than a texel whose centre it misses is all in that texel.
    if sum > 0.0 {
        for weight in into.iter_mut() {
            *weight /= sum;
        }
    } else {
        let share = 1.0 / into.len() as f64;
        into.fill(share);
    }
}

/// Rows of a map that one task draws.
pub struct Band<'a, V> {
    columns: usize,
    /// The first row.
    first: i64,
    texels: &'a mut [V],
    /// Texels drawn so far, counted again for each splat.
    pub fragments: u64,
    /// The weights of a point's columns and rows, or of all texels of an ellipse; kept to save making them.
    pub across: Vec<f64>,
    down: Vec<f64>,
}

impl<V> Band<'_, V> {
    /// The first row of the map that the band has, and the first after it.
    pub fn rows(&self) -> [i64; 2] {
        [
            self.first,
            self.first + signed(self.texels.len() / self.columns),
        ]
    }

    /// The texel in a column and a row of the map; `None` outside of the band.
    #[inline]
    pub fn texel(&mut self, column: i64, row: i64) -> Option<&mut V> {
        let row = usize::try_from(row - self.first).ok()?;
        let column = usize::try_from(column)
            .ok()
            .filter(|&column| column < self.columns)?;
        self.texels.get_mut(row * self.columns + column)
    }

    /// The texels of a row of the map from one column to another, both included, which must be in the map;
    /// none outside of the band.
    #[inline]
    pub fn line(&mut self, row: i64, left: i64, right: i64) -> &mut [V] {
        let [first, end] = self.rows();
        if row < first || row >= end || left < 0 || right < left {
            return &mut [];
        }
        let start = (row - first) as usize * self.columns;
        let range = start + left as usize..=start + (right as usize).min(self.columns - 1);
        self.texels.get_mut(range).unwrap_or_default()
    }

    /// Adds to each texel of the band that a round point holds: `add(texel, weight, [column, row])`.
    #[inline]
    pub fn draw_round(
        &mut self,
        at: DVec2,
        diameter: f64,
        mut add: impl FnMut(&mut V, f64, [i64; 2]),
    ) {
        let deviation = diameter / DEVIATIONS;
        let (columns, rows) = (reach(at.x, diameter), reach(at.y, diameter));
        weights(at.x, columns, deviation, &mut self.across);
        weights(at.y, rows, deviation, &mut self.down);
        let last_row = self.first + signed(self.texels.len() / self.columns) - 1;
        let (left, right) = (columns.0.max(0), columns.1.min(signed(self.columns) - 1));
        for row in rows.0.max(self.first)..=rows.1.min(last_row) {
            let down = self.down[(row - rows.0) as usize];
            let line =
                &mut self.texels[(row - self.first) as usize * self.columns..][..self.columns];
            for column in left..=right {
                let weight = self.across[(column - columns.0) as usize] * down;
                add(&mut line[column as usize], weight, [column, row]);
                self.fragments += 1;
            }
        }
    }
}

/// Runs `draw(item, band)` for every item and every band of a map that it reaches: `rows(item)` are its first
/// and last row. Returns the map with the number of texels drawn.
pub fn in_bands<T: Sync, V: Clone + Default + Send + Sync>(
    [columns, height]: [usize; 2],
    items: &[T],
    rows: impl Fn(&T) -> (i64, i64) + Sync,
    draw: impl Fn(&T, &mut Band<V>) + Sync,
) -> (Vec<V>, u64) {
    let bands = height.div_ceil(BAND);
    let mut lists: Vec<Vec<u32>> = vec![Vec::new(); bands];
    for (index, item) in items.iter().enumerate() {
        let (first, last) = rows(item);
        let last = last.min(signed(height) - 1);
        if last >= 0 && first < signed(height) {
            let bands = first.max(0) as usize / BAND..=last as usize / BAND;
            lists[bands]
                .iter_mut()
                .for_each(|list| list.push(index as u32));
        }
    }
    let mut map = vec![V::default(); columns * height];
    let fragments = map
        .par_chunks_mut(BAND * columns)
        .zip(&lists)
        .enumerate()
        .map(|(band, (texels, list))| {
            let mut band = Band {
                columns,
                first: signed(band * BAND),
                texels,
                fragments: 0,
                across: Vec::new(),
                down: Vec::new(),
            };
            for &index in list {
                draw(&items[index as usize], &mut band);
            }
            band.fragments
        })
        .sum();
    (map, fragments)
}
