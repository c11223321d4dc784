//! Hash tables for indices and coordinates.

use std::{
    collections::{HashMap, HashSet},
    hash::{BuildHasher, Hasher, RandomState},
};

/// A map with keys of mesh data, hashed four times sooner than by the standard library's hash.
///
/// Its order changes from run to run; no result may depend on it.
pub(super) type Map<K, V> = HashMap<K, V, HashSeed>;
/// The set to go with it.
pub(super) type Set<K> = HashSet<K, HashSeed>;

/// The secret at which a table's hashes start, of its own for each table. With a known start, anybody could
/// write a file whose positions all collide, and a mesh of 10⁵ of them would take minutes.
#[derive(Clone, Copy, Debug)]
pub(super) struct HashSeed(u64);

impl Default for HashSeed {
    fn default() -> Self {
        Self(RandomState::new().hash_one(0_u8))
    }
}

impl BuildHasher for HashSeed {
    type Hasher = Mixer;

    #[inline]
    fn build_hasher(&self) -> Mixer {
        Mixer(self.0)
    }
}

/// A hash that multiplies and folds, eight bytes at a time.
#[derive(Clone, Copy, Debug)]
pub(super) struct Mixer(u64);

impl Mixer {
    #[inline]
    fn mix(&mut self, word: u64) {
        // The multiplier of `SplitMix64`'s first step: odd, with no pattern in its bits. The high half of the
        // product depends on all bits, so it is folded into the low half.
        let product = u128::from(self.0 ^ word ^ 0x9e37_79b9_7f4a_7c15) * 0xbf58_476d_1ce4_e5b9;
        self.0 = (product as u64) ^ ((product >> 64) as u64);
    }
}

impl Hasher for Mixer {
    #[inline]
    fn write(&mut self, bytes: &[u8]) {
        for chunk in bytes.chunks(8) {
            let mut word = [0; 8];
            word[..chunk.len()].copy_from_slice(chunk);
            self.mix(u64::from_le_bytes(word));
        }
    }

    #[inline]
    fn write_usize(&mut self, value: usize) {
        self.mix(value as u64);
    }

    #[inline]
    fn finish(&self) -> u64 {
        self.0
    }
}
