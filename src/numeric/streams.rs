//! Sample streams: random numbers keyed by the sample that they belong to, never by thread or time.
//!
//! A [`Stream`] is a function, not a generator: it has no state that moves. Sample `index` of a seed is the
//! same number on any machine, with any number of threads, in any order of calls.

use super::sobol;

/// Layout of the points of a [`Stream`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StreamKind {
    /// Independent uniform points: an estimate's variance falls as 1/n.
    Random,
    /// Sobol' points under Owen scrambling: each point is uniform, and 2^m of them fill every dyadic box
    /// evenly. In the plane the variance falls as n⁻³ log n for smooth integrands and as n^-1.5 across an
    /// edge. For no integrand is it above e = 2.72 times that of random points (Owen, *Monte Carlo Variance
    /// of Scrambled Net Quadrature*, 1997).
    Sobol,
}

/// A function from (index, dimension) to uniform numbers in [0, 1).
///
/// ```
/// # use nephroid::internals::numeric::{Stream, StreamKind};
/// let stream = Stream::new(StreamKind::Sobol, 7);
/// let replicate = stream.split(3); // the fourth replicate's own stream
/// assert_eq!(replicate.point2(1000), replicate.point2(1000));
/// assert_ne!(replicate.point2(1000), stream.point2(1000));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stream {
    kind: StreamKind,
    key: u64,
    /// Keys for each use, computed once: they depend on `key` alone.
    points: u64,
    low_digits: u64,
    extra: u64,
}

/// The use of a hash: domains keep the numbers of different uses apart.
#[derive(Clone, Copy)]
#[repr(u64)]
enum Domain {
    Seed = 1,
    Split,
    Points,
    LowDigits,
    Extra,
}

/// 2^64 / φ, odd: the step of Steele, Lea and Flood's `SplitMix64` (OOPSLA 2014).
const GOLDEN_STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// A bijection of 64-bit words in which each input bit changes each output bit with probability near one
/// half.
///
/// Stafford's variant 13 of the finaliser of `MurmurHash3`, the output function of `SplitMix64` (Steele, Lea,
/// Flood, *Fast Splittable Pseudorandom Number Generators*, OOPSLA 2014).
#[inline]
const fn mix64(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// One word from two, mixed in between, so that neither can undo the other.
#[inline]
const fn hash_pair(first: u64, second: u64) -> u64 {
    mix64(mix64(first.wrapping_add(GOLDEN_STEP)) ^ second)
}

/// 64 hash bits, uniform over words, from three of them: a seed, an index and a dimension.
///
/// Two rounds of `SplitMix64`'s mixing stand between the index and the result.
#[inline]
pub const fn hash64(seed: u64, index: u64, dimension: u32) -> u64 {
    hash_dimension(hash_pair(seed, index), dimension)
}

/// Element `dimension` of `SplitMix64`'s sequence from `key`.
#[inline]
const fn hash_dimension(key: u64, dimension: u32) -> u64 {
    let step = GOLDEN_STEP.wrapping_mul(dimension as u64 + 1);
    mix64(key.wrapping_add(step))
}

/// The upper 53 bits as a number in [0, 1): a multiple of 2⁻⁵³, at most 1 − 2⁻⁵³.
#[inline]
pub const fn unit_interval(bits: u64) -> f64 {
    const QUANTUM: f64 = 1.0 / (1u64 << 53) as f64;
    (bits >> 11) as f64 * QUANTUM
}

impl Stream {
    /// The stream of a seed; any seed is as good as any other, neighbours too.
    pub const fn new(kind: StreamKind, seed: u64) -> Self {
        Self::of_key(kind, hash_pair(seed, Domain::Seed as u64))
    }

    const fn of_key(kind: StreamKind, key: u64) -> Self {
        Self {
            kind,
            key,
            points: hash_pair(key, Domain::Points as u64),
            low_digits: hash_pair(key, Domain::LowDigits as u64),
            extra: hash_pair(key, Domain::Extra as u64),
        }
    }

    /// Layout of the points.
    pub const fn kind(&self) -> StreamKind {
        self.kind
    }

    /// An independent stream for a part of the work (a replicate, a cell): independent of this one and of
    /// those of all other keys.
    #[must_use]
    pub const fn split(&self, key: u64) -> Self {
        let domain = hash_pair(self.key, Domain::Split as u64);
        Self::of_key(self.kind, hash_pair(domain, key))
    }

    /// Point `index` in the unit square; the first two coordinates of [`Stream::point4`].
    ///
    /// Any aligned block of 2^m Sobol' points (m ≤ 32) is a (0, m, 2)-net. An index needs no
    /// more than 64 bits: each block of 2³² is scrambled anew, independently of the others.
    #[inline]
    pub fn point2(&self, index: u64) -> [f64; 2] {
        match self.kind {
            StreamKind::Random => self.random(index),
            StreamKind::Sobol => self.scrambled(index, sobol::reversed_2(index as u32)),
        }
    }

    /// Point `index` in the unit hypercube of four dimensions.
    ///
    /// Any aligned block of 2^m Sobol' points is evenly spread over the pairs of coordinates
    /// (0, 1) as a (0, m, 2)-net, over the others a little less evenly. Indices: see [`Stream::point2`].
    #[inline]
    pub fn point4(&self, index: u64) -> [f64; 4] {
        match self.kind {
            StreamKind::Random => self.random(index),
            StreamKind::Sobol => self.scrambled(index, sobol::reversed_4(index as u32)),
        }
    }

    /// Point `index` of group `group`: four dimensions more, for samples of any number of dimensions.
    ///
    /// Groups are independent of each other. Each has a scrambling of its own and assigns its points to the
    /// indices in an order of its own (Burley, *Practical Hash-based Owen Scrambling*, JCGT 9(4), 2020,
    /// section 4). Without that order, points of two groups would go together by their upper digits. With it,
    /// consider a function of two groups whose integral over either group alone is constant: its variance is
    /// at most about 1.6 times that of random points. Within a group any aligned block of 2^m indices gets an
    /// aligned block of points, which is as even as that of [`Stream::point4`].
    #[inline]
    pub fn padded4(&self, index: u64, group: u32) -> [f64; 4] {
        self.split(u64::from(group)).dealt4(index)
    }

    /// Point `index` of this stream as a group of another: see [`Stream::padded4`].
    #[inline]
    fn dealt4(&self, index: u64) -> [f64; 4] {
        match self.kind {
            StreamKind::Random => self.random(index),
            StreamKind::Sobol => {
                let block = index >> 32;
                let key = hash_of_pair(self.extra, block, 0) as u32;
                // A block of indices is a dyadic interval if the index is read as a fraction: scrambling
                // keeps those.
                let dealt = sobol::scramble((index as u32).reverse_bits(), key);
                self.scrambled(block << 32 | u64::from(dealt), sobol::reversed_4(dealt))
            }
        }
    }

    /// One more uniform number in [0, 1) for sample `index`, independent of its point and of all other
    /// dimensions: for Russian roulette, which gains nothing from stratification.
    #[inline]
    pub const fn extra(&self, index: u64, dimension: u32) -> f64 {
        self.extras(index).at(dimension)
    }

    /// The [extra](Stream::extra) numbers of sample `index`.
    #[inline]
    pub const fn extras(&self, index: u64) -> Extras {
        Extras {
            key: hash_pair(self.extra, index),
        }
    }

    #[inline]
    fn random<const N: usize>(&self, index: u64) -> [f64; N] {
        std::array::from_fn(|d| unit_interval(hash64(self.points, index, d as u32)))
    }

    /// Scrambles each coordinate with a key of its own, and draws the digits below the 32nd at random.
    ///
    /// All digits of an unscrambled Sobol' point below the 32nd are zero, and each point of a block has upper
    /// digits of its own. So nested scrambling would give it lower digits that are independent of every other
    /// point's. A hash of the index does the same.
    #[inline]
    fn scrambled<const N: usize>(&self, index: u64, reversed: [u32; N]) -> [f64; N] {
        let block = index >> 32;
        std::array::from_fn(|d| {
            // One hash of 64 bits serves two dimensions.
            let (pair, half) = (d as u64 / 2, 32 * (d as u32 % 2));
            let key = (hash_of_pair(self.points, block, pair) >> half) as u32;
            let low = (hash_of_pair(self.low_digits, index, pair) >> half) as u32;
            let high = sobol::scramble(reversed[d], key);
            unit_interval(u64::from(high) << 32 | u64::from(low))
        })
    }
}

/// A stream whose first groups are at hand: [`Stream::padded4`] of many indices, with the work that depends
/// on the group done once.
#[derive(Clone, Debug)]
pub struct PaddedStream {
    stream: Stream,
    groups: Vec<Stream>,
}

impl PaddedStream {
    /// Groups that are made beforehand: those of six surfaces of a path.
    const KEPT: u32 = 13;
    /// The least number of indices for which that pays.
    const ENOUGH: u64 = 4;

    /// A stream from which each group gives about `count` points.
    pub fn new(stream: Stream, count: u64) -> Self {
        let kept = if count < Self::ENOUGH { 0 } else { Self::KEPT };
        Self {
            stream,
            groups: (0..kept)
                .map(|group| stream.split(u64::from(group)))
                .collect(),
        }
    }

    /// [`Stream::padded4`].
    #[inline]
    pub fn padded4(&self, index: u64, group: u32) -> [f64; 4] {
        match self.groups.get(group as usize) {
            Some(own) => own.dealt4(index),
            None => self.stream.padded4(index, group),
        }
    }
}

/// One sample's numbers of all dimensions: [`Stream::extra`] with the work that depends on the index done
/// once.
#[derive(Clone, Copy, Debug)]
pub struct Extras {
    key: u64,
}

impl Extras {
    /// The number of a dimension, uniform in [0, 1).
    #[inline]
    pub const fn at(self, dimension: u32) -> f64 {
        unit_interval(hash_dimension(self.key, dimension))
    }
}

/// 64 hash bits for dimensions 2 `pair` and 2 `pair` + 1, `pair` being 0 or 1: element 2 `counter` + `pair`
/// of `SplitMix64`'s sequence from `key`.
#[inline]
const fn hash_of_pair(key: u64, counter: u64, pair: u64) -> u64 {
    let element = counter.wrapping_mul(2).wrapping_add(pair);
    mix64(key.wrapping_add(element.wrapping_mul(GOLDEN_STEP)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::SampleMoments;
    use crate::numeric::distributions::chi_squared_survival;
    use crate::numeric::math;

    const KINDS: [StreamKind; 2] = [StreamKind::Random, StreamKind::Sobol];

    /// Error probability of each χ² test below. The seeds are fixed, so that a test that passes always
    /// passes. About thirty p-values are drawn, so that a good generator fails a choice of seeds with
    /// probability 6e-5.
    const ALPHA: f64 = 1e-6;

    /// Asserts that pairs fall evenly into 16 x 16 cells: neither too unevenly nor too evenly.
    fn assert_uniform(claim: &str, pairs: impl Iterator<Item = [f64; 2]>) {
        let mut counts = [0u32; 256];
        for pair in pairs {
            assert!(
                pair.iter().all(|x| (0.0..1.0).contains(x)),
                "{claim}: {pair:?}"
            );
            let [column, row] = pair.map(|x| (x * 16.0) as usize);
            counts[16 * row + column] += 1;
        }
        let expected = f64::from(counts.iter().sum::<u32>()) / 256.0;
        let chi_squared: f64 = counts
            .iter()
            .map(|&n| math::powi(f64::from(n) - expected, 2) / expected)
            .sum();
        let p = chi_squared_survival(chi_squared, 255.0);
        assert!(
            (ALPHA..1.0 - ALPHA).contains(&p),
            "{claim}: χ² = {chi_squared}, p = {p}"
        );
    }

    /// Far more than 5 a cell, as the χ² approximation wants.
    const PAIRS: u64 = 1 << 16;

    #[test]
    fn groups_that_are_at_hand_have_the_same_points() {
        for kind in KINDS {
            let stream = Stream::new(kind, 4);
            for count in [1, 16] {
                let padded = PaddedStream::new(stream, count);
                for (index, group) in [(0, 0), (7, 1), (1 << 40, 12), (3, 13), (5, 400)] {
                    assert_eq!(padded.padded4(index, group), stream.padded4(index, group));
                }
            }
        }
    }

    #[test]
    fn one_point_is_uniform_over_seeds_splits_and_dimensions() {
        for kind in KINDS {
            for index in [0, 12345, u64::from(u32::MAX), 1 << 40] {
                let root = Stream::new(kind, 99);
                let seeds = (0..PAIRS).map(|seed| Stream::new(kind, seed).point2(index));
                assert_uniform("seeds", seeds);
                assert_uniform(
                    "splits",
                    (0..PAIRS).map(|key| root.split(key).point2(index)),
                );
                let others = (0..PAIRS).map(|key| root.split(key).point4(index));
                assert_uniform("dimensions 2 and 3", others.map(|[_, _, z, w]| [z, w]));
            }
        }
    }

    #[test]
    fn streams_of_neighbouring_seeds_and_keys_are_independent() {
        for kind in KINDS {
            let root = Stream::new(kind, 5);
            let pair = |a: Stream, b: Stream, i: u64| [a.point2(i)[0], b.point2(i)[0]];
            let seeds = (0..PAIRS)
                .map(|seed| pair(Stream::new(kind, seed), Stream::new(kind, seed + 1), 77));
            assert_uniform("seeds", seeds);
            let keys = (0..PAIRS).map(|key| pair(root.split(key), root.split(key + 1), 77));
            assert_uniform("keys", keys);
            let parent = (0..PAIRS).map(|key| Stream::new(kind, key));
            assert_uniform("parent and child", parent.map(|s| pair(s, s.split(0), 77)));
        }
    }

    #[test]
    fn random_points_are_independent_of_their_neighbours() {
        let stream = Stream::new(StreamKind::Random, 1);
        assert_uniform("points", (0..PAIRS).map(|i| stream.point2(i)));
        let neighbours = (0..PAIRS).map(|i| [stream.point2(i)[0], stream.point2(i + 1)[0]]);
        assert_uniform("indices", neighbours);
        let crossed = (0..PAIRS).map(|i| [stream.point2(i)[0], stream.point2(i + 1)[1]]);
        assert_uniform("indices and dimensions", crossed);
    }

    #[test]
    fn extra_numbers_are_independent_of_points_and_of_each_other() {
        for kind in KINDS {
            let stream = Stream::new(kind, 3);
            let pairs = (0..PAIRS).map(|i| [stream.extra(i, 0), stream.extra(i, 1)]);
            assert_uniform("two extras", pairs);
            let pairs = (0..PAIRS).map(|i| [stream.extra(i, 0), stream.extra(i + 1, 0)]);
            assert_uniform("neighbours", pairs);
            let pairs = (0..PAIRS).map(|key| {
                let stream = stream.split(key);
                [stream.point2(9)[0], stream.extra(9, 0)]
            });
            assert_uniform("point and extra", pairs);
        }
    }

    #[test]
    fn digits_below_the_32nd_are_uniform_and_independent() {
        let stream = Stream::new(StreamKind::Sobol, 11);
        // The next 4 binary digits after the 32nd are those of 2^32 x modulo 1.
        let low = |x: f64| (x * math::powi(2f64, 32)).fract();
        assert_uniform("both", (0..PAIRS).map(|i| stream.point2(i).map(low)));
        let neighbours = (0..PAIRS).map(|i| [stream.point2(i)[0], stream.point2(i + 1)[0]]);
        assert_uniform("neighbours", neighbours.map(|pair| pair.map(low)));
    }

    #[test]
    fn every_aligned_block_of_points_is_a_net_beyond_2_to_the_32_too() {
        let stream = Stream::new(StreamKind::Sobol, 8);
        for first in [0u64, 1 << 10, 5 << 10, 1 << 32, (7 << 32) + (3 << 10)] {
            let points: Vec<[f64; 2]> = (first..first + 1024).map(|i| stream.point2(i)).collect();
            for columns in (0..=10).map(|bits| 1usize << bits) {
                let rows = 1024 / columns;
                let mut seen = [false; 1024];
                for &[x, y] in &points {
                    let cell = (y * rows as f64) as usize * columns + (x * columns as f64) as usize;
                    assert!(
                        !std::mem::replace(&mut seen[cell], true),
                        "{first}, {columns}"
                    );
                }
            }
        }
        assert_ne!(stream.point2(5), stream.point2((1 << 32) + 5));
    }

    #[test]
    fn the_first_two_of_four_coordinates_are_the_point_of_the_plane() {
        for kind in KINDS {
            let stream = Stream::new(kind, 4);
            for index in 0..100 {
                let [x, y, ..] = stream.point4(index);
                assert_eq!([x, y], stream.point2(index));
            }
        }
    }

    #[test]
    fn groups_are_even_in_themselves_and_independent_of_each_other() {
        for kind in KINDS {
            let root = Stream::new(kind, 21);
            // Pairs across groups, at one index and many splits, and at many indices.
            let across =
                |stream: Stream, i: u64| [stream.padded4(i, 0)[0], stream.padded4(i, 1)[0]];
            assert_uniform("splits", (0..PAIRS).map(|key| across(root.split(key), 5)));
            assert_uniform(
                "indices of random order",
                (0..PAIRS).map(|i| across(root.split(i >> 4), i & 15)),
            );
            let inside = (0..PAIRS).map(|key| root.split(key).padded4(9, 3));
            assert_uniform("dimensions", inside.map(|[_, y, z, _]| [y, z]));
        }
        // Any aligned block is a net in its first two dimensions.
        let stream = Stream::new(StreamKind::Sobol, 4);
        for first in [0u64, 64, 5 << 32] {
            for columns in (0..=6).map(|bits| 1usize << bits) {
                let rows = 64 / columns;
                let mut seen = [false; 64];
                for [x, y, ..] in (first..first + 64).map(|i| stream.padded4(i, 7)) {
                    let cell = (y * rows as f64) as usize * columns + (x * columns as f64) as usize;
                    assert!(
                        !std::mem::replace(&mut seen[cell], true),
                        "{first}, {columns}"
                    );
                }
            }
        }
    }

    /// The variance of a mean over 256 samples, from 256 replicates, of a product of two coordinates. The
    /// product's integral over either coordinate alone is zero.
    fn variance_of_product(coordinates: fn(Stream, u64) -> [f64; 2]) -> f64 {
        let root = Stream::new(StreamKind::Sobol, 77);
        let means = (0..256).map(|replicate| {
            let value = |i| {
                let [x, y] = coordinates(root.split(replicate), i);
                (x - 0.5) * (y - 0.5)
            };
            (0..256).map(value).sum::<f64>() / 256.0
        });
        means.collect::<SampleMoments>().variance().unwrap()
    }

    #[test]
    fn two_groups_are_paired_nearly_at_random() {
        // Random points have 1/144/256. Orders are scrambled as points are. Two indices that differ from bit
        // k on (2^k of them) have opposite digits k + 1 if the k before are the same. So their coordinates'
        // covariance is −2^−k 4^−(k+2) in either group, and the variance is 1 + 144 Σ 2^k 4^−k 16^−(k+2) = 1
        // + 18/31 times as large. From 256 replicates it is known to √(2/255) = 9 %, four of which are 36 %.
        let random = 1.0 / 144.0 / 256.0;
        let expected = (1.0 + 18.0 / 31.0) * random;
        let padded =
            variance_of_product(|stream, i| [0, 1].map(|group| stream.padded4(i, group)[0]));
        assert!(
            (padded / expected - 1.0).abs() < 0.36,
            "{}",
            padded / random
        );
        // If they are scrambled apart but in one order, the first digits of both go together or against each
        // other: a mean near ±1/16.
        let in_order =
            variance_of_product(|stream, i| [0, 1].map(|key| stream.split(key).point4(i)[0]));
        assert!(in_order > 10.0 * random, "{}", in_order / random);
    }

    #[test]
    fn the_unit_interval_excludes_one() {
        assert_eq!(unit_interval(0), 0.0);
        assert_eq!(unit_interval(u64::MAX), 1.0f64.next_down());
    }

    /// The variance of a mean over `n` Sobol' points, from 256 replicates.
    fn variance(n: u64, integrand: fn([f64; 2]) -> f64) -> f64 {
        let root = Stream::new(StreamKind::Sobol, 2026);
        let means = (0..256).map(|replicate| {
            let stream = root.split(replicate);
            (0..n).map(|i| integrand(stream.point2(i))).sum::<f64>() / n as f64
        });
        means.collect::<SampleMoments>().variance().unwrap()
    }

    /// The order in variance ~ n^-order: the mean between 2^6 and 2^12 points. A variance from 256 replicates
    /// is known to √(2/255) = 9 %, 0.13 binary orders. So the order is known to 0.13 √2 / 6 = 0.03, and four
    /// of these are 0.12.
    fn order(integrand: fn([f64; 2]) -> f64) -> f64 {
        math::log2(variance(1 << 6, integrand) / variance(1 << 12, integrand)) / 6.0
    }

    #[test]
    fn variance_falls_with_the_third_power_for_a_smooth_integrand() {
        // Owen (1997): n^-3 log n in the plane; the logarithm takes log2(12 / 6) / 6 = 0.17.
        assert!(order(|[x, y]| math::exp(x + y)) > 3.0 - 0.17 - 0.12);
    }

    #[test]
    fn variance_falls_with_the_power_of_three_halves_across_an_edge() {
        // n boxes, about √n of them on the edge, each with a variance of its own: √n / n².
        let inside = |[x, y]: [f64; 2]| f64::from(u8::from(x * x + y * y < 1.0));
        let order = order(inside);
        assert!((order - 1.5).abs() < 0.12 + 0.1, "{order}"); // 0.1: the edge is curved
        // Random points: exactly p (1 - p) / n with p = π/4.
        let p = std::f64::consts::FRAC_PI_4;
        assert!(variance(1 << 12, inside) < 0.1 * p * (1.0 - p) / 4096.0);
    }
}
