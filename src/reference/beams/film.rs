//! What beams leave on the film: exact sums, whatever the order of threads.

use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};

use crate::numeric::FixedPoint;
use crate::transport::flux::Flux;

/// Sums of one path signature, texel by texel \[W\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct TexelSums<const N: usize> {
    /// The extrapolated flux (4B − A)/3.
    pub flux: Flux<N>,
    /// B − A: what halving the cells once changed.
    pub difference: Flux<N>,
    /// Flux near a texel line, that the bend of its cell may have put on the wrong side.
    pub astray: Flux<N>,
    /// Flux of cells that are no single smooth family: it may be here, or not.
    pub slack: Flux<N>,
}

impl<const N: usize> Default for TexelSums<N> {
    fn default() -> Self {
        Self {
            flux: Flux::BLACK,
            difference: Flux::BLACK,
            astray: Flux::BLACK,
            slack: Flux::BLACK,
        }
    }
}

impl<const N: usize> std::ops::AddAssign for TexelSums<N> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.flux += other.flux;
        self.difference += other.difference;
        self.astray += other.astray;
        self.slack += other.slack;
    }
}

/// Kinds of sums a texel has.
const KINDS: usize = 4;

/// The sums of all texels. Each addition is rounded once, to a multiple of a fixed quantum, and
/// is exact then: integers commute, so the same cells give the same bits on any threads.
pub struct BeamFilm<const N: usize> {
    size: [usize; 2],
    scale: FixedPoint,
    sums: Vec<AtomicI64>,
    overflowed: AtomicBool,
}

impl<const N: usize> BeamFilm<N> {
    /// A dark film of `size` columns and rows, for a flux of `scale` in all.
    pub fn new(size: [usize; 2], scale: FixedPoint) -> Self {
        let length = size[0] * size[1] * KINDS * N;
        Self {
            size,
            scale,
            sums: std::iter::repeat_with(|| AtomicI64::new(0))
                .take(length)
                .collect(),
            overflowed: AtomicBool::new(false),
        }
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Adds to a texel's sums.
    #[inline]
    pub fn add(&self, [column, row]: [usize; 2], addend: &TexelSums<N>) {
        let first = (row * self.size[0] + column) * KINDS * N;
        let kinds = [addend.flux, addend.difference, addend.astray, addend.slack];
        for (kind, values) in kinds.iter().enumerate() {
            for (channel, value) in values.0.iter().enumerate() {
                if *value != 0.0 {
                    self.add_one(first + kind * N + channel, *value);
                }
            }
        }
    }

    #[inline]
    fn add_one(&self, index: usize, value: f64) {
        match self.scale.quantise(value) {
            Some(quanta) => {
                let before = self.sums[index].fetch_add(quanta, Ordering::Relaxed);
                if before.checked_add(quanta).is_none() {
                    self.overflowed.store(true, Ordering::Relaxed);
                }
            }
            None => self.overflowed.store(true, Ordering::Relaxed),
        }
    }

    /// Whether any deposit or sum was not representable: then nothing here is worth anything.
    pub fn overflowed(&self) -> bool {
        self.overflowed.load(Ordering::Relaxed)
    }

    /// The sums of a texel, counted row by row.
    pub fn texel(&self, texel: usize) -> TexelSums<N> {
        let kind = |kind: usize| {
            Flux(std::array::from_fn(|channel| {
                let index = (texel * KINDS + kind) * N + channel;
                self.scale
                    .value_i64(self.sums[index].load(Ordering::Relaxed))
            }))
        };
        TexelSums {
            flux: kind(0),
            difference: kind(1),
            astray: kind(2),
            slack: kind(3),
        }
    }
}
