//! The rows of a film that a part of a run measures.

use crate::reference::shard::Shard;

/// A tile's side \[pixels\].
pub const TILE: usize = 16;

/// The least number of bands that a part has, if the film is high enough: glass that is all in one place is
/// then in several parts.
const BANDS_EACH: usize = 4;

/// Bands of rows, dealt to parts by turns.
///
/// A band is as high as one tile or several. Samples of other bands that the film's filter spreads into it
/// are traced for it, too: of a filter as wide as a pixel there are none.
#[derive(Clone, Copy, Debug)]
pub struct Bands {
    shard: Shard,
    /// Rows of the film.
    height: usize,
    /// Rows of a band.
    rows: usize,
}

impl Bands {
    /// Those of a part of a film with so many rows.
    pub fn of(shard: Shard, height: usize) -> Self {
        let tiles = height.div_ceil(TILE);
        let tiles_each = (tiles / (BANDS_EACH * shard.count as usize)).max(1);
        Self {
            shard,
            height,
            rows: tiles_each * TILE,
        }
    }

    /// All rows.
    pub fn whole(height: usize) -> Self {
        Self::of(Shard::WHOLE, height)
    }

    /// The most parts of a film of which each has a band.
    pub fn most(height: usize) -> u32 {
        u32::try_from(height.div_ceil(TILE)).unwrap_or(u32::MAX)
    }

    /// True if this is all of the film.
    pub fn is_all(self) -> bool {
        self.shard.count == 1
    }

    /// True if a row of the film is in one of the bands.
    pub fn contains(self, row: usize) -> bool {
        self.shard.holds((row / self.rows) as u32)
    }

    /// The rows in the bands, from the top.
    pub fn rows(self) -> impl Iterator<Item = usize> {
        (0..self.height).filter(move |row| self.contains(*row))
    }

    /// How many they are.
    pub fn row_count(self) -> usize {
        let Shard { index, count } = self.shard;
        let (index, count) = (index as usize, count as usize);
        let bands = self.height.div_ceil(self.rows);
        if bands <= index {
            return 0;
        }
        let mine = (bands - 1 - index) / count + 1;
        // The last band of all may be cut off.
        let has_last = (bands - 1) % count == index;
        let missing = if has_last {
            bands * self.rows - self.height
        } else {
            0
        };
        mine * self.rows - missing
    }

    /// True if the bands have a row at most `reach` rows from this one, which may be beyond the film by
    /// `border` rows and is counted from there.
    pub fn is_near(self, row: usize, border: usize, reach: usize) -> bool {
        let first = row.saturating_sub(border + reach);
        let end = (row + reach + 1).saturating_sub(border).min(self.height);
        self.is_all() || (first..end).any(|row| self.contains(row))
    }

    /// True if work for this row is counted here: that for rows beyond the film is where its nearest row is.
    pub fn counts(self, row: usize, border: usize) -> bool {
        self.contains(self.nearest(row, border))
    }

    /// The film's row that is nearest to this one, which may be beyond the film by `border` rows and is
    /// counted from there.
    pub fn nearest(self, row: usize, border: usize) -> usize {
        let last = self.height.saturating_sub(1);
        row.saturating_sub(border).min(last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_row_is_in_one_part_and_work_for_it_is_counted_there() {
        for (height, count) in [
            (1, 1),
            (1, 3),
            (16, 2),
            (100, 3),
            (480, 4),
            (480, 30),
            (1080, 7),
        ] {
            let parts: Vec<Bands> = (0..count)
                .map(|index| Bands::of(Shard { index, count }, height))
                .collect();
            for bands in &parts {
                assert_eq!(bands.row_count(), bands.rows().count());
            }
            for row in 0..height {
                let holding = parts.iter().filter(|bands| bands.contains(row)).count();
                assert_eq!(holding, 1, "row {row} of {height}, {count} parts");
            }
            let border = 2;
            for row in 0..height + 2 * border {
                let counting: Vec<&Bands> = parts
                    .iter()
                    .filter(|bands| bands.counts(row, border))
                    .collect();
                assert_eq!(counting.len(), 1, "row {row} of {height}, {count} parts");
                // It is traced there.
                assert!(counting[0].is_near(row, border, border));
            }
        }
    }

    #[test]
    fn rows_of_other_bands_are_traced_as_far_as_the_filter_reaches_and_no_farther() {
        let bands = Bands::of(Shard { index: 1, count: 3 }, 64);
        assert!(bands.rows().eq(16..32));
        let near = |border, reach| -> Vec<usize> {
            let rows = 0..64 + 2 * border;
            rows.filter(|row| bands.is_near(*row, border, reach))
                .collect()
        };
        assert!(near(0, 0).into_iter().eq(16..32));
        assert!(near(0, 3).into_iter().eq(13..35));
        assert!(near(2, 2).into_iter().eq(16..36));
        assert!(near(0, 100).into_iter().eq(0..64));
        assert_eq!(Bands::whole(64).rows().count(), 64);
    }

    #[test]
    fn parts_have_several_bands_if_there_are_enough_rows() {
        let bands = Bands::of(Shard { index: 1, count: 4 }, 1080);
        let starts = bands
            .rows()
            .filter(|row| *row == 0 || !bands.contains(*row - 1))
            .count();
        assert_eq!(starts, 4);
        assert_eq!(Bands::most(1080), 68);
        // One more part has no row.
        let beyond = |index| Bands::of(Shard { index, count: 69 }, 1080).rows().count();
        assert_eq!((beyond(67), beyond(68)), (8, 0));
    }
}
