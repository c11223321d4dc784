//! Rectangles of values.

/// A rectangle of `width` x `height` values in rows; row 0 comes first.
///
/// The owner defines the meaning of row 0 (v = 0 or the top of a picture).
#[derive(Clone, Debug, PartialEq)]
pub struct Grid<T> {
    width: usize,
    height: usize,
    values: Vec<T>,
}

impl<T> Grid<T> {
    /// A grid of given values, row by row; `None` unless there are `width` x `height` of them.
    pub fn from_vec(width: usize, height: usize, values: Vec<T>) -> Option<Self> {
        (width.checked_mul(height) == Some(values.len())).then_some(Self {
            width,
            height,
            values,
        })
    }

    /// A grid whose value at (x, y) is `value(x, y)`.
    pub fn from_fn(width: usize, height: usize, mut value: impl FnMut(usize, usize) -> T) -> Self {
        let values = (0..height)
            .flat_map(|y| (0..width).map(move |x| (x, y)))
            .map(|(x, y)| value(x, y))
            .collect();
        Self {
            width,
            height,
            values,
        }
    }

    /// Number of values a row.
    pub const fn width(&self) -> usize {
        self.width
    }

    /// Number of rows.
    pub const fn height(&self) -> usize {
        self.height
    }

    /// The value in column `x` of row `y`; `None` outside.
    #[inline]
    pub fn get(&self, x: usize, y: usize) -> Option<&T> {
        if x < self.width {
            self.values.get(y * self.width + x)
        } else {
            None
        }
    }

    /// The value in column `x` of row `y`, to change; `None` outside.
    #[inline]
    pub fn get_mut(&mut self, x: usize, y: usize) -> Option<&mut T> {
        if x < self.width {
            self.values.get_mut(y * self.width + x)
        } else {
            None
        }
    }

    /// Replaces the value in column `x` of row `y`; returns true if it exists.
    #[inline]
    #[must_use]
    pub fn set(&mut self, x: usize, y: usize, value: T) -> bool {
        self.get_mut(x, y).map(|place| *place = value).is_some()
    }

    /// All values, row by row.
    pub fn values(&self) -> &[T] {
        &self.values
    }

    /// All values, row by row, to change.
    pub fn values_mut(&mut self) -> &mut [T] {
        &mut self.values
    }

    /// All values, row by row.
    pub fn into_values(self) -> Vec<T> {
        self.values
    }

    /// All values, row by row.
    pub fn iter(&self) -> std::slice::Iter<'_, T> {
        self.values.iter()
    }

    /// The rows, first to last.
    pub fn rows(&self) -> impl DoubleEndedIterator<Item = &[T]> + ExactSizeIterator {
        // A grid without columns has no values, whatever the chunk's length.
        self.values.chunks_exact(self.width.max(1))
    }

    /// The grid of `change` of each value.
    pub fn map<U>(&self, change: impl FnMut(&T) -> U) -> Grid<U> {
        Grid {
            width: self.width,
            height: self.height,
            values: self.values.iter().map(change).collect(),
        }
    }
}

impl<T: Clone> Grid<T> {
    /// A grid of one value.
    pub fn filled(width: usize, height: usize, value: T) -> Self {
        Self {
            width,
            height,
            values: vec![value; width * height],
        }
    }
}

impl<'a, T> IntoIterator for &'a Grid<T> {
    type Item = &'a T;
    type IntoIter = std::slice::Iter<'a, T>;

    fn into_iter(self) -> Self::IntoIter {
        self.iter()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_come_first_and_outside_is_none() {
        let mut grid = Grid::from_fn(3, 2, |x, y| 10 * y + x);
        assert_eq!(grid.values(), [0, 1, 2, 10, 11, 12]);
        assert_eq!(grid.get(2, 1), Some(&12));
        assert_eq!(grid.get(3, 0), None);
        assert_eq!(grid.get(0, 2), None);
        assert!(grid.set(0, 1, 7));
        assert!(!grid.set(3, 0, 7));
        assert_eq!(
            grid.rows().collect::<Vec<_>>(),
            [&[0, 1, 2][..], &[7, 11, 12]]
        );
        assert_eq!(Grid::from_vec(2, 2, vec![0; 3]), None);
        assert_eq!(Grid::from_fn(0, 5, |_, _| 0).rows().count(), 0);
    }
}
