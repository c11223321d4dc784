//! Batches of signatures that are followed together.
//!
//! Signatures that begin with the same events share the polygons of flat facets that had these. The films of
//! all of them are in memory at once, and nothing is known of any of them before all are done. So batches are
//! small, and the first ones, of the brightest light, are smaller still.

use std::ops::Range;

use super::sums::Sums;

/// Most signatures of a batch.
const MOST: usize = 8;

/// Most memory \[bytes\] that the films and sums of a batch of more than one signature take.
const MOST_BYTES: usize = 64 << 20;

/// Most signatures of a batch on a film of so many texels, by channels of light.
pub fn most(texels: usize, channels: usize) -> usize {
    // Three kinds of sums, and a third as much on coarser levels; uncertain flux and its spread: see
    // `BeamFilm`.
    let film = 8 * (4 * channels) + 8 * (channels + 1);
    (MOST_BYTES / (texels * (film + Sums::BYTES)).max(1)).clamp(1, MOST)
}

/// So many signatures in batches of `most` or fewer.
pub fn batches(count: usize, most: usize) -> Vec<Range<usize>> {
    let (mut batches, mut size, mut begin) = (Vec::new(), 1, 0);
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
    fn batches_grow_to_the_most_and_leave_nothing_out() {
        assert_eq!(batches(12, 4), [0..1, 1..3, 3..7, 7..11, 11..12]);
        assert_eq!(batches(3, 1), [0..1, 1..2, 2..3]);
        assert!(batches(0, 8).is_empty());
    }

    #[test]
    fn large_films_are_filled_one_by_one() {
        assert_eq!(most(128 * 128, 1), MOST);
        assert_eq!(most(4096 * 4096, 3), 1);
    }
}
