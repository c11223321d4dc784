//! The film of beams: exact sums, whatever the order of threads.

use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicI64, Ordering};

use crate::numeric::FixedPoint;
use crate::transport::flux::Flux;

/// The flux \[W\] that a cell adds to a texel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TexelSums<const N: usize> {
    /// The extrapolated flux (4B − A)/3.
    pub flux: Flux<N>,
    /// The change of the extrapolated flux when the cells were halved the last time.
    pub change: Flux<N>,
    /// Flux that cells of many texels are likely to misplace.
    pub misplaced: Flux<N>,
}

impl<const N: usize> std::ops::AddAssign for TexelSums<N> {
    #[inline]
    fn add_assign(&mut self, other: Self) {
        self.flux += other.flux;
        self.change += other.change;
        self.misplaced += other.misplaced;
    }
}

/// The flux \[W\] that all cells of one path signature left on a texel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FilmTexel<const N: usize> {
    /// The sum over the cells of [`TexelSums::flux`].
    pub flux: Flux<N>,
    /// The sum over the cells of [`TexelSums::change`].
    pub change: Flux<N>,
    /// What cells of many texels are likely to misplace, here or from beside: for each level, the most of
    /// 3 x 3 of its texels. Light on a coarser texel may be anywhere near it.
    pub misplaced: Flux<N>,
    /// Uncertain flux, of cells with more than one topology: it may be here, or not.
    pub uncertain: Flux<N>,
    /// The same flux seen together with all other texels that it may be on, worst channel. Flux that may be
    /// on any one of n texels counts as its part 1/√n on each. The sum of squares over texels is then that of
    /// one. Independent parts come with a [`Sign`] each: only its mean square over texels tells something.
    pub spread: f64,
    /// The likely square \[W²\] of what light on coarser texels is off because it counts as spread evenly
    /// within them, worst channel.
    pub uneven: f64,
}

/// The sign of uncertain flux in its [spread](FilmTexel::spread).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Sign {
    /// Always the same: cells along a border err alike.
    Same,
    /// Drawn by the first of some bits: of n independent errors, √n are left on a texel.
    Drawn {
        /// The bits.
        bits: u64,
        /// The part of the flux that errs so.
        part: f64,
    },
}

/// Least number of texels of a film on which signs are drawn: one drawn sum tells nothing, the mean square of
/// a thousand tells theirs to some percent.
const LEAST_DRAWN: usize = 1 << 10;

/// Number of kinds of sums in [`TexelSums`].
const KINDS: usize = 3;

/// The numbers of these kinds: [`TexelSums::flux`], [`TexelSums::change`] and [`TexelSums::misplaced`].
const FLUX: usize = 0;
const CHANGE: usize = 1;
const MISPLACED: usize = 2;

/// The sums of all texels.
///
/// A faint cell may have an image of many texels. So that its work does not grow with them, there are levels:
/// a texel of the next level holds four of this one. Light on a coarse texel counts as spread evenly over the
/// film's texels within.
///
/// Each addition is rounded once, to a multiple of a fixed quantum, and is exact then. Integers commute, so
/// the same cells give the same bits on any threads.
#[derive(Debug)]
pub struct BeamFilm<const N: usize> {
    size: [usize; 2],
    /// Sums by level. The texels of a level are as wide and high as two of the level before.
    levels: Vec<Level>,
    /// Uncertain flux and its spread, as differences to the texels before along both axes: a box of any size
    /// is four additions.
    uncertain_steps: ExactSums,
}

/// The sums of one level.
#[derive(Debug)]
struct Level {
    size: [usize; 2],
    sums: ExactSums,
}

/// Most texels a side of the coarsest level.
const COARSEST: usize = 16;

/// Columns and rows of all levels of a film of this size.
fn levels(size: [usize; 2]) -> impl Iterator<Item = [usize; 2]> {
    std::iter::successors(Some(size), |size| {
        let is_coarsest = size[0].max(size[1]) <= COARSEST;
        (!is_coarsest).then(|| size.map(|texels| texels.div_ceil(2)))
    })
}

/// A texel of a level.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct LevelTexel {
    /// The level; texels of level 0 are the film's.
    pub level: usize,
    /// Column and row.
    pub at: [usize; 2],
}

impl<const N: usize> BeamFilm<N> {
    /// A dark film of `size` columns and rows, for a flux of `scale` in all.
    pub fn new(size: [usize; 2], scale: FixedPoint) -> Self {
        let level = |size: [usize; 2]| Level {
            size,
            sums: ExactSums::new(size[0] * size[1] * KINDS * N, scale),
        };
        Self {
            size,
            levels: levels(size).map(level).collect(),
            uncertain_steps: ExactSums::new((size[0] + 1) * (size[1] + 1) * (N + 1), scale),
        }
    }

    /// Memory \[bytes\] of a film of `size` columns and rows, about.
    pub const fn bytes(size: [usize; 2]) -> usize {
        // Coarser levels together have a third as many texels; uncertain flux and its spread.
        size[0] * size[1] * (KINDS * N * 4 / 3 + N + 1) * size_of::<AtomicI64>()
    }

    /// Number of sums of a film of `size` columns and rows.
    pub fn numbers(size: [usize; 2]) -> usize {
        let levels: usize = levels(size).map(|[width, height]| width * height).sum();
        levels * KINDS * N + (size[0] + 1) * (size[1] + 1) * (N + 1)
    }

    /// Columns and rows.
    pub fn size(&self) -> [usize; 2] {
        self.size
    }

    /// Columns and rows of a level.
    pub fn level_size(&self, level: usize) -> [usize; 2] {
        self.levels[level].size
    }

    /// The coarsest level.
    pub fn coarsest(&self) -> usize {
        self.levels.len() - 1
    }

    /// Number of the film's texels within a texel of a level.
    #[inline]
    pub fn texels_within(&self, texel: LevelTexel) -> usize {
        let along = |axis: usize| {
            let first = texel.at[axis] << texel.level;
            (1 << texel.level).min(self.size[axis] - first)
        };
        along(0) * along(1)
    }

    /// Adds to a texel's sums.
    #[inline]
    pub fn add(&self, texel: LevelTexel, addend: &TexelSums<N>) {
        let [column, row] = texel.at;
        let level = &self.levels[texel.level];
        let first = (row * level.size[0] + column) * KINDS * N;
        let kinds = [addend.flux, addend.change, addend.misplaced];
        for (kind, values) in kinds.iter().enumerate() {
            level.sums.add(first + kind * N, &values.0);
        }
    }

    /// Adds uncertain flux to each texel of a box, first and last column and row included.
    pub fn add_uncertain(
        &self,
        first: [usize; 2],
        last: [usize; 2],
        uncertain: Flux<N>,
        sign: Sign,
    ) {
        let texels = (last[0] + 1 - first[0]) * (last[1] + 1 - first[1]);
        let sign = match sign {
            Sign::Drawn { bits, part } if self.size[0] * self.size[1] >= LEAST_DRAWN => {
                part * (1.0 - 2.0 * (bits >> 63) as f64)
            }
            Sign::Drawn { .. } | Sign::Same => 1.0,
        };
        let spread = sign * uncertain.max_magnitude() / (texels as f64).sqrt();
        for (row, column, step) in [
            (first[1], first[0], 1.0),
            (first[1], last[0] + 1, -1.0),
            (last[1] + 1, first[0], -1.0),
            (last[1] + 1, last[0] + 1, 1.0),
        ] {
            let at = (row * (self.size[0] + 1) + column) * (N + 1);
            self.uncertain_steps.add(at, &(uncertain * step).0);
            self.uncertain_steps.add(at + N, &[spread * step]);
        }
    }

    /// All sums of a film, in quanta: level by level, then uncertain flux.
    pub fn quanta(&self) -> impl Iterator<Item = i64> + '_ {
        self.all()
            .flat_map(|sums| &sums.sums)
            .map(|sum| sum.load(Ordering::Relaxed))
    }

    /// The same, to be set.
    pub fn quanta_mut(&mut self) -> impl Iterator<Item = &mut i64> {
        let levels = self.levels.iter_mut().map(|level| &mut level.sums);
        let all = levels.chain([&mut self.uncertain_steps]);
        all.flat_map(|sums| &mut sums.sums).map(AtomicI64::get_mut)
    }

    /// Adds the sums of another film of the same size and scale; `None` if it has others, or if a sum
    /// overflows.
    #[must_use]
    pub fn merge(&mut self, other: &Self) -> Option<()> {
        if self.size != other.size || self.scale() != other.scale() {
            return None;
        }
        for (sum, other) in self.quanta_mut().zip(other.quanta()) {
            *sum = sum.checked_add(other)?;
        }
        Some(())
    }

    /// The scale of its sums.
    pub fn scale(&self) -> FixedPoint {
        self.uncertain_steps.scale
    }

    fn all(&self) -> impl Iterator<Item = &ExactSums> {
        let levels = self.levels.iter().map(|level| &level.sums);
        levels.chain([&self.uncertain_steps])
    }

    /// True if any deposit or sum was not representable: then nothing here is valid.
    pub fn overflowed(&self) -> bool {
        self.all().any(ExactSums::overflowed)
    }

    /// Gives the sums of a level's texels, row by row, each with its part of those of `coarser` levels.
    /// [Misplaced](FilmTexel::misplaced) flux is that from beside, too. Their [unevenness](FilmTexel::uneven)
    /// comes with them.
    fn sums(
        &self,
        number: usize,
        coarser: &LevelTexels<N>,
        mut take: impl FnMut([usize; 2], TexelSums<N>, f64),
    ) {
        let [width, height] = self.levels[number].size;
        let own = |kind: usize| LevelFlux {
            size: [width, height],
            flux: (0..width * height)
                .map(|index| self.own(number, index, kind))
                .collect(),
        };
        let misplaced = own(MISPLACED);
        // The film's own texels are what is asked for.
        let spread_evenly = (number > 0).then(|| own(FLUX));
        for row in 0..height {
            for column in 0..width {
                let (at, index) = ([column, row], row * width + column);
                let (mut sums, mut uneven) = coarser.holding(at);
                sums += TexelSums {
                    flux: self.own(number, index, FLUX),
                    change: self.own(number, index, CHANGE),
                    misplaced: misplaced.most_near(at),
                };
                if let Some(flux) = &spread_evenly {
                    uneven += flux.uneven(at, number);
                }
                take(at, sums, uneven);
            }
        }
    }

    /// One kind of sum of a texel of a level alone, for each of the film's texels within.
    fn own(&self, number: usize, index: usize, kind: usize) -> Flux<N> {
        let Level { size, sums } = &self.levels[number];
        let at = [index % size[0], index / size[0]];
        let within = self.texels_within(LevelTexel { level: number, at }) as f64;
        let first = (index * KINDS + kind) * N;
        let part = |channel: usize| sums.value(sums.quanta(first + channel)) / within;
        Flux(std::array::from_fn(part))
    }

    /// The sums of all levels but that of the film's texels, for each of these.
    fn coarser(&self) -> LevelTexels<N> {
        let none = LevelTexels {
            size: [1, 1],
            values: vec![(TexelSums::default(), 0.0)],
        };
        (1..self.levels.len()).rev().fold(none, |coarser, number| {
            let size = self.levels[number].size;
            let mut values = Vec::with_capacity(size[0] * size[1]);
            self.sums(number, &coarser, |_, sums, uneven| {
                values.push((sums, uneven));
            });
            LevelTexels { size, values }
        })
    }

    /// All texels, row by row.
    pub fn texels(&self) -> Vec<FilmTexel<N>> {
        let [width, height] = self.size;
        let mut texels = Vec::with_capacity(width * height);
        // Sums of the uncertain flux in the row above, N + 1 a column; the last of them is the spread.
        let mut above = vec![0_i64; width * (N + 1)];
        let mut before = vec![0_i64; N + 1];
        self.sums(0, &self.coarser(), |[column, row], sums, uneven| {
            if column == 0 {
                before.fill(0);
            }
            let above = &mut above[column * (N + 1)..][..=N];
            let at = (row * (width + 1) + column) * (N + 1);
            for kind in 0..=N {
                // Sums of integers are exact, whatever the terms between wrap round to.
                before[kind] = before[kind].wrapping_add(self.uncertain_steps.quanta(at + kind));
                above[kind] = above[kind].wrapping_add(before[kind]);
            }
            let uncertain = |kind: usize| self.uncertain_steps.value(above[kind]);
            texels.push(FilmTexel {
                flux: sums.flux,
                change: sums.change,
                misplaced: sums.misplaced,
                uncertain: Flux(std::array::from_fn(uncertain)),
                spread: uncertain(N),
                uneven,
            });
        });
        texels
    }
}

/// Three places in a row about one, at a film's border, too.
pub fn three_near(at: usize, end: usize) -> Range<usize> {
    let first = at.saturating_sub(1).min(end.saturating_sub(3));
    first..(first + 3).min(end)
}

/// Sums of a level's texels and their unevenness, row by row.
struct LevelTexels<const N: usize> {
    size: [usize; 2],
    values: Vec<(TexelSums<N>, f64)>,
}

impl<const N: usize> LevelTexels<N> {
    /// The sums of the texel that holds one of the next finer level.
    fn holding(&self, at: [usize; 2]) -> (TexelSums<N>, f64) {
        // All is in the one texel that stands for no coarser level.
        let [column, row] = [0, 1].map(|axis| (at[axis] / 2).min(self.size[axis] - 1));
        self.values[row * self.size[0] + column]
    }
}

/// Flux of a level's texels, row by row, for each of the film's texels within.
struct LevelFlux<const N: usize> {
    size: [usize; 2],
    flux: Vec<Flux<N>>,
}

impl<const N: usize> LevelFlux<N> {
    /// The largest of 3 x 3, channel by channel.
    fn most_near(&self, [column, row]: [usize; 2]) -> Flux<N> {
        let [width, height] = self.size;
        let mut most = Flux::BLACK;
        for y in three_near(row, height) {
            for one in &self.flux[y * width..][three_near(column, width)] {
                most = most.larger(*one);
            }
        }
        most
    }

    /// The likely mean square of what a texel's light is off on the film's texels within it, worst channel.
    ///
    /// Of light that ends at a line anywhere in a texel, that mean is (1 − 2⁻ˡ)/6 of its square, for texels
    /// 2ˡ of the film's wide. The larger change s to the two neighbours is taken, along each axis. Together
    /// that texel and those beside it then have 5/4 of the light's square in s². So their means are
    /// 2/15 (1 − 2⁻ˡ) s². For light that changes evenly that is up to 1.6 times the true mean.
    fn uneven(&self, at: [usize; 2], level: usize) -> f64 {
        let index = |[column, row]: [usize; 2]| row * self.size[0] + column;
        let own = self.flux[index(at)];
        let along = |axis: usize| {
            let ends = at[axis].saturating_sub(1)..(at[axis] + 2).min(self.size[axis]);
            let steps = ends.map(|place| {
                let mut beside = at;
                beside[axis] = place;
                (self.flux[index(beside)] - own).max_magnitude()
            });
            let most = steps.fold(0.0, f64::max);
            most * most
        };
        let within = 1.0 - 1.0 / (1_u64 << level) as f64;
        (along(0) + along(1)) * within * 2.0 / 15.0
    }
}

/// Sums that threads add to in any order.
#[derive(Debug)]
struct ExactSums {
    scale: FixedPoint,
    sums: Vec<AtomicI64>,
    overflowed: AtomicBool,
}

impl ExactSums {
    fn new(length: usize, scale: FixedPoint) -> Self {
        Self {
            scale,
            sums: std::iter::repeat_with(|| AtomicI64::new(0))
                .take(length)
                .collect(),
            overflowed: AtomicBool::new(false),
        }
    }

    /// Adds to the sums from `first` on.
    #[inline]
    fn add(&self, first: usize, addends: &[f64]) {
        for (sum, addend) in self.sums[first..].iter().zip(addends) {
            if *addend == 0.0 {
                continue;
            }
            let fits = self.scale.quantise(*addend).is_some_and(|quanta| {
                let before = sum.fetch_add(quanta, Ordering::Relaxed);
                before.checked_add(quanta).is_some()
            });
            if !fits {
                self.overflowed.store(true, Ordering::Relaxed);
            }
        }
    }

    fn overflowed(&self) -> bool {
        self.overflowed.load(Ordering::Relaxed)
    }

    #[inline]
    fn quanta(&self, index: usize) -> i64 {
        self.sums[index].load(Ordering::Relaxed)
    }

    #[inline]
    fn value(&self, quanta: i64) -> f64 {
        self.scale.value_i64(quanta)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_on_a_coarser_texel_may_be_misplaced_near_it() {
        let scale = FixedPoint::for_total(16.0).unwrap();
        let film = BeamFilm::<1>::new([40, 40], scale);
        let sums = TexelSums {
            misplaced: Flux([4.0]),
            ..TexelSums::default()
        };
        // The texels 6 and 7 along both axes: a fourth for each. Near are 4 to 9.
        film.add(
            LevelTexel {
                level: 1,
                at: [3, 3],
            },
            &sums,
        );
        film.add(
            LevelTexel {
                level: 0,
                at: [9, 9],
            },
            &sums,
        );
        let texels = film.texels();
        let at = |column: usize, row: usize| texels[row * 40 + column].misplaced.0[0];
        let row = [3, 4, 7, 8, 9, 10, 11].map(|column| at(column, 8));
        assert_eq!(row, [0.0, 1.0, 1.0, 5.0, 5.0, 4.0, 0.0]);
        assert_eq!((at(7, 3), at(7, 4)), (0.0, 1.0));
    }

    #[test]
    fn light_on_a_coarser_texel_is_spread_evenly_over_the_texels_within() {
        let scale = FixedPoint::for_total(1024.0).unwrap();
        let film = BeamFilm::<1>::new([37, 21], scale);
        // The levels are 37 x 21, 19 x 11 and 10 x 6. The last texel of the second has one column.
        for (level, at, flux) in [
            (0, [5, 2], 3.0),
            (1, [2, 1], 4.0),
            (2, [1, 0], 32.0),
            (1, [18, 7], 10.0),
        ] {
            let flux = Flux([flux]);
            let sums = TexelSums {
                flux,
                change: flux * 0.5,
                ..TexelSums::default()
            };
            film.add(LevelTexel { level, at }, &sums);
        }
        let texels = film.texels();
        let at = |column: usize, row: usize| {
            let texel = &texels[row * 37 + column];
            assert_eq!(texel.change.0[0], 0.5 * texel.flux.0[0]);
            texel.flux.0[0]
        };
        assert_eq!([at(5, 2), at(4, 3), at(6, 2)], [6.0, 3.0, 2.0]);
        assert_eq!([at(3, 2), at(5, 4), at(2, 5)], [0.0, 0.0, 0.0]);
        assert_eq!([at(36, 14), at(36, 15), at(35, 14)], [5.0, 5.0, 0.0]);
        let all: f64 = texels.iter().map(|texel| texel.flux.0[0]).sum();
        assert_eq!(all, 49.0);
    }

    #[test]
    fn light_with_a_border_within_a_coarser_texel_is_likely_off_by_part_of_it() {
        let scale = FixedPoint::for_total(1e9).unwrap();
        for axis in [0, 1] {
            let (mut said, mut off) = (0.0, 0.0);
            for step in 0..64 {
                let film = BeamFilm::<2>::new([64, 64], scale);
                let part = (f64::from(step) + 0.5) / 64.0;
                for place in 2..16 {
                    let flux = if place == 2 { 16.0 * part } else { 16.0 };
                    // The worst channel tells.
                    let sums = TexelSums {
                        flux: Flux([0.5 * flux, flux]),
                        ..TexelSums::default()
                    };
                    for other in 0..16 {
                        let mut at = [other; 2];
                        at[axis] = place;
                        film.add(LevelTexel { level: 2, at }, &sums);
                    }
                }
                let texels = film.texels();
                let across = (0..64).map(|place| match axis {
                    0 => texels[64 * 20 + place].uneven,
                    _ => texels[64 * place + 20].uneven,
                });
                said += across.sum::<f64>();
                // Light covers a part of the four of the film's texels, from one end.
                let covered = (0..4).map(|texel| (4.0 * part - f64::from(texel)).clamp(0.0, 1.0));
                off += covered.map(|one| (one - part) * (one - part)).sum::<f64>();
            }
            // A sum over 64 places is off from its integral by 1/4096, about, of squares.
            assert!((said / off - 1.0).abs() < 1e-3, "{}", said / off);
        }
    }

    #[test]
    fn squares_of_levels_add_up_and_the_films_own_texels_are_as_they_are() {
        let scale = FixedPoint::for_total(1e9).unwrap();
        let film = BeamFilm::<1>::new([64, 64], scale);
        for (level, flux) in [(0, 7.0), (1, 4.0), (2, 16.0 * 3.0)] {
            let at = [8 >> level, 8 >> level];
            let sums = TexelSums {
                flux: Flux([flux]),
                ..TexelSums::default()
            };
            film.add(LevelTexel { level, at }, &sums);
        }
        let uneven = film.texels()[64 * 8 + 8].uneven;
        // Changes of 1 and 3 along both axes.
        let expected = 2.0 * (1.0 / 2.0 + 9.0 * 3.0 / 4.0) * 2.0 / 15.0;
        assert!((uneven - expected).abs() < 1e-6, "{uneven} {expected}");
    }
}
