//! Sample streams: numbers keyed by what they sample, never by thread or time.
//!
//! A [`Stream`] is a function, not a generator: it has no state that moves. Sample `index` of a
//! seed is the same number on any machine, with any number of threads, asked for in any order.

use super::sobol;

/// How the points of a [`Stream`] are laid out.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum StreamKind {
    /// Independent uniform points: an estimate's variance falls as 1/n.
    Random,
    /// Sobol' points under Owen scrambling: each point is uniform, and 2^m of them fill every
    /// dyadic box evenly. Variance falls as about n⁻³ for smooth integrands in the plane, as n^-1.5
    /// across a discontinuity, and is never much above the random one.
    Sobol,
}

/// A function from (index, dimension) to uniform numbers in [0, 1).
///
/// ```
/// # use nephroid::numeric::{Stream, StreamKind};
/// let stream = Stream::new(StreamKind::Sobol, 7);
/// let replicate = stream.split(3); // the fourth replicate's own stream
/// assert_eq!(replicate.point2(1000), replicate.point2(1000));
/// assert_ne!(replicate.point2(1000), stream.point2(1000));
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Stream {
    kind: StreamKind,
    key: u64,
}

/// What a hash is for: the domains keep their numbers apart.
#[derive(Clone, Copy)]
#[repr(u64)]
enum Domain {
    Seed = 1,
    Split,
    Points,
    LowBits,
    Extra,
}

/// 2^64 / φ, odd: the step of Steele, Lea and Flood's `SplitMix64` (OOPSLA 2014).
const GOLDEN_STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// A bijection of 64-bit words in which each input bit changes each output bit with
/// probability near one half.
///
/// Stafford's variant 13 of the finaliser of `MurmurHash3`, the output function of `SplitMix64`
/// (Steele, Lea, Flood, *Fast Splittable Pseudorandom Number Generators*, OOPSLA 2014).
#[inline]
const fn mix64(mut x: u64) -> u64 {
    x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

/// A word made of two: mixed in between, so that neither can undo the other.
#[inline]
const fn hash_pair(first: u64, second: u64) -> u64 {
    mix64(mix64(first.wrapping_add(GOLDEN_STEP)) ^ second)
}

/// 64 hash bits, uniform over words, from three of them: a seed, an index and a dimension.
///
/// Two rounds of `SplitMix64`'s mixing stand between the index and the result.
#[inline]
pub const fn hash64(seed: u64, index: u64, dimension: u32) -> u64 {
    let step = GOLDEN_STEP.wrapping_mul(dimension as u64 + 1);
    mix64(hash_pair(seed, index).wrapping_add(step))
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
        Self {
            kind,
            key: hash_pair(seed, Domain::Seed as u64),
        }
    }

    /// How the points are laid out.
    pub const fn kind(&self) -> StreamKind {
        self.kind
    }

    /// A stream of its own for a part of the work (a replicate, a cell): independent of this
    /// one and of those of all other keys.
    #[must_use]
    pub const fn split(&self, key: u64) -> Self {
        Self {
            kind: self.kind,
            key: hash_pair(self.domain(Domain::Split), key),
        }
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

    /// One more uniform number in [0, 1) for sample `index`, independent of its point and of all
    /// other dimensions: for roulette, where stratification brings nothing.
    #[inline]
    pub const fn extra(&self, index: u64, dimension: u32) -> f64 {
        unit_interval(hash64(self.domain(Domain::Extra), index, dimension))
    }

    /// A key for one use of this stream.
    #[inline]
    const fn domain(&self, domain: Domain) -> u64 {
        hash_pair(self.key, domain as u64)
    }

    #[inline]
    fn random<const N: usize>(&self, index: u64) -> [f64; N] {
        let key = self.domain(Domain::Points);
        std::array::from_fn(|dimension| unit_interval(hash64(key, index, dimension as u32)))
    }

    /// Scrambles each coordinate with a key of its own, and draws the bits below the 32nd.
    ///
    /// All digits of an unscrambled Sobol' point below the 32nd are zero, and each point of a
    /// block has upper digits of its own: nested scrambling would give it lower digits that are
    /// independent of every other point's. A hash of the index is just that.
    #[inline]
    fn scrambled<const N: usize>(&self, index: u64, reversed: [u32; N]) -> [f64; N] {
        let block = index >> 32;
        let scramble_key = self.domain(Domain::Points);
        let low_key = self.domain(Domain::LowBits);
        std::array::from_fn(|dimension| {
            let key = hash64(scramble_key, block, dimension as u32) as u32;
            let high = u64::from(sobol::scramble(reversed[dimension], key)) << 32;
            let low = hash64(low_key, index, dimension as u32) >> 32;
            unit_interval(high | low)
        })
    }
}
