//! Batches of signatures that are followed together.
//!
//! Signatures that begin with the same events share the polygons of flat facets that had these. The films of
//! all of them are in memory at once, and nothing is known of any of them before all are done. So batches are
//! small. If a limit may end them, the first ones, of the brightest light, are smaller still.

use std::ops::Range;

/// Most signatures of a batch.
const MOST: usize = 16;

/// Most memory \[bytes\] that the films of a batch take, if they are more than one.
const MOST_BYTES: usize = 128 << 20;

/// Most signatures of a batch on films of so many bytes.
pub fn most(film: usize) -> usize {
    (MOST_BYTES / film.max(1)).clamp(1, MOST)
}

/// So many signatures in batches of `most` or fewer.
pub fn batches(count: usize, most: usize, may_end: bool) -> Vec<Range<usize>> {
    let mut size = if may_end { 1 } else { most };
    let (mut batches, mut begin) = (Vec::new(), 0);
    while begin < count {
        let end = (begin + size).min(count);
        batches.push(begin..end);
        begin = end;
        size = (2 * size).min(most);
    }
    batches
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn batches_leave_nothing_out() {
        assert_eq!(batches(12, 5, false), [0..5, 5..10, 10..12]);
        assert_eq!(batches(3, 1, false), [0..1, 1..2, 2..3]);
        assert!(batches(0, 8, false).is_empty());
    }

    #[test]
    fn batches_that_a_limit_may_end_begin_with_the_brightest_alone() {
        assert_eq!(batches(12, 4, true), [0..1, 1..3, 3..7, 7..11, 11..12]);
    }

    #[test]
    fn large_films_are_filled_one_by_one() {
        assert_eq!([most(1 << 20), most(1 << 25), most(1 << 30)], [16, 4, 1]);
    }
}
