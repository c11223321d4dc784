//! The operations on eight numbers at a time, portable and by AVX2.
//!
//! All [`Lanes`] round as IEEE 754 has it. So the search visits the same nodes on every processor, however
//! many lanes an instruction handles. This is the one file of the crate with `unsafe` in it: the [`Avx2`]
//! token, which exists only on processors with the instructions, stands for their safety.
#![allow(clippy::inline_always)] // or the code is not compiled for its caller's registers

use super::{
    lanes::{Lanes, WIDTH},
    plane_pairs::LocalPlanePairs,
    stream::Searches,
    tree::{BoxTree, LeafVisitor, Root, TreeNode},
};
use crate::geometry::Ray;

impl BoxTree {
    /// Visits all leaves below `root` that the ray may enter before `limit`, or before the distance that the
    /// last visit returned, the nearest first as far as their boxes tell. Returns the number of nodes
    /// visited.
    ///
    /// Uses the best instructions that this processor has.
    #[inline]
    pub(in crate::geometry) fn search(
        &self,
        root: Root,
        ray: &Ray,
        limit: f64,
        visitor: &mut impl LeafVisitor,
    ) -> u64 {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = Avx2::detect() {
            // SAFETY: the token proves that the processor has the features.
            #[allow(unsafe_code)]
            return unsafe { search_avx2(lanes, self, root, ray, limit, visitor) };
        }
        self.search_local(Portable, root, ray, limit, visitor)
    }

    /// All searches, some at a time by turns. Returns the number of nodes visited.
    #[inline]
    pub(in crate::geometry) fn search_all(&self, searches: &mut impl Searches) -> u64 {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = Avx2::detect() {
            // SAFETY: the token proves that the processor has the features.
            #[allow(unsafe_code)]
            return unsafe { search_all_avx2(lanes, self, searches) };
        }
        self.search_all_local(Portable, searches)
    }

    /// All searches, in packets of rays that follow one another. Returns the number of nodes visited.
    #[inline]
    pub(in crate::geometry) fn search_packets(&self, searches: &mut impl Searches) -> u64 {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = Avx2::detect() {
            // SAFETY: the token proves that the processor has the features.
            #[allow(unsafe_code)]
            return unsafe { search_packets_avx2(lanes, self, searches) };
        }
        self.search_packets_local(Portable, searches)
    }
}

impl TreeNode {
    /// A bit for each child, which is set if its box may be between all pairs of planes.
    #[inline]
    pub(super) fn children_in(&self, pairs: &LocalPlanePairs) -> u32 {
        #[cfg(target_arch = "x86_64")]
        if let Some(lanes) = Avx2::detect() {
            // SAFETY: the token proves that the processor has the features.
            #[allow(unsafe_code)]
            return unsafe { children_in_avx2(lanes, self, pairs) };
        }
        self.children_in_local(Portable, pairs)
    }
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,popcnt")]
fn children_in_avx2(lanes: Avx2, node: &TreeNode, pairs: &LocalPlanePairs) -> u32 {
    node.children_in_local(lanes, pairs)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,popcnt")]
fn search_avx2(
    lanes: Avx2,
    tree: &BoxTree,
    root: Root,
    ray: &Ray,
    limit: f64,
    visitor: &mut impl LeafVisitor,
) -> u64 {
    tree.search_local(lanes, root, ray, limit, visitor)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,popcnt")]
fn search_all_avx2(lanes: Avx2, tree: &BoxTree, searches: &mut impl Searches) -> u64 {
    tree.search_all_local(lanes, searches)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,bmi1,popcnt")]
fn search_packets_avx2(lanes: Avx2, tree: &BoxTree, searches: &mut impl Searches) -> u64 {
    tree.search_packets_local(lanes, searches)
}

/// Lanes for any processor.
#[derive(Clone, Copy, Debug)]
pub(in crate::geometry) struct Portable;

#[inline(always)]
fn each(f: impl FnMut(usize) -> f32) -> [f32; WIDTH] {
    std::array::from_fn(f)
}

impl Lanes for Portable {
    type Vector = [f32; WIDTH];

    #[inline(always)]
    fn load(self, from: &[f32; WIDTH]) -> Self::Vector {
        *from
    }
    #[inline(always)]
    fn store(self, from: Self::Vector, to: &mut [f32; WIDTH]) {
        *to = from;
    }
    #[inline(always)]
    fn splat(self, value: f32) -> Self::Vector {
        [value; WIDTH]
    }
    #[inline(always)]
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        each(|i| a[i] + b[i])
    }
    #[inline(always)]
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        each(|i| a[i] - b[i])
    }
    #[inline(always)]
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        each(|i| a[i] * b[i])
    }
    #[inline(always)]
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        each(|i| if a[i] < b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        each(|i| if a[i] > b[i] { a[i] } else { b[i] })
    }
    #[inline(always)]
    fn at_most(self, a: Self::Vector, b: Self::Vector) -> u32 {
        (0..WIDTH).fold(0, |bits, i| bits | u32::from(a[i] <= b[i]) << i)
    }
    #[inline(always)]
    fn prefetch<T>(self, _value: &T) {}
}

/// A proof that the processor has AVX2, and what searches do with bits: BMI1 and POPCNT.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy, Debug)]
pub(in crate::geometry) struct Avx2(());

#[cfg(target_arch = "x86_64")]
impl Avx2 {
    #[inline(always)]
    pub(super) fn detect() -> Option<Self> {
        (std::arch::is_x86_feature_detected!("avx2")
            && std::arch::is_x86_feature_detected!("bmi1")
            && std::arch::is_x86_feature_detected!("popcnt"))
        .then_some(Self(()))
    }
}

// SAFETY, for each block below: an `Avx2` exists only if the processor has the features, and loads and stores
// go through references to arrays of just the right size.
#[cfg(target_arch = "x86_64")]
#[allow(unsafe_code)]
impl Lanes for Avx2 {
    type Vector = std::arch::x86_64::__m256;

    #[inline(always)]
    fn load(self, from: &[f32; WIDTH]) -> Self::Vector {
        unsafe { std::arch::x86_64::_mm256_loadu_ps(from.as_ptr()) }
    }
    #[inline(always)]
    fn store(self, from: Self::Vector, to: &mut [f32; WIDTH]) {
        unsafe { std::arch::x86_64::_mm256_storeu_ps(to.as_mut_ptr(), from) }
    }
    #[inline(always)]
    fn splat(self, value: f32) -> Self::Vector {
        unsafe { std::arch::x86_64::_mm256_set1_ps(value) }
    }
    #[inline(always)]
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        unsafe { std::arch::x86_64::_mm256_add_ps(a, b) }
    }
    #[inline(always)]
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        unsafe { std::arch::x86_64::_mm256_sub_ps(a, b) }
    }
    #[inline(always)]
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        unsafe { std::arch::x86_64::_mm256_mul_ps(a, b) }
    }
    #[inline(always)]
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        unsafe { std::arch::x86_64::_mm256_min_ps(a, b) }
    }
    #[inline(always)]
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector {
        unsafe { std::arch::x86_64::_mm256_max_ps(a, b) }
    }
    #[inline(always)]
    fn at_most(self, a: Self::Vector, b: Self::Vector) -> u32 {
        use std::arch::x86_64::{_CMP_LE_OQ, _mm256_cmp_ps, _mm256_movemask_ps};
        unsafe { _mm256_movemask_ps(_mm256_cmp_ps::<_CMP_LE_OQ>(a, b)) as u32 }
    }
    #[inline(always)]
    fn prefetch<T>(self, value: &T) {
        use std::arch::x86_64::{_MM_HINT_T0, _mm_prefetch};
        let start = std::ptr::from_ref(value).cast::<i8>();
        for line in (0..size_of::<T>()).step_by(64) {
            unsafe { _mm_prefetch::<_MM_HINT_T0>(start.add(line)) };
        }
    }
}

#[cfg(all(test, target_arch = "x86_64"))]
mod tests {
    use super::*;

    /// Numbers of all kinds, in all pairings.
    const KINDS: [f32; WIDTH] = [
        0.0,
        -0.0,
        1.5,
        -3.25e-7,
        f32::MIN_POSITIVE / 8.0,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
    ];

    fn bits(v: [f32; WIDTH]) -> [u32; WIDTH] {
        // Which NaN a result is does not matter.
        v.map(|x| {
            if x.is_nan() {
                f32::NAN.to_bits()
            } else {
                x.to_bits()
            }
        })
    }

    #[test]
    fn avx2_lanes_compute_the_same_bits_as_portable_ones() {
        let Some(wide) = Avx2::detect() else {
            println!("skipped: this processor lacks AVX2, BMI1 or POPCNT");
            return;
        };
        for shift in 0..WIDTH {
            let mut other = KINDS;
            other.rotate_left(shift);
            let (a, b) = (wide.load(&KINDS), wide.load(&other));
            let stored = |v| {
                let mut to = [0.0; WIDTH];
                wide.store(v, &mut to);
                bits(to)
            };
            assert_eq!(stored(wide.add(a, b)), bits(Portable.add(KINDS, other)));
            assert_eq!(stored(wide.sub(a, b)), bits(Portable.sub(KINDS, other)));
            assert_eq!(stored(wide.mul(a, b)), bits(Portable.mul(KINDS, other)));
            assert_eq!(stored(wide.min(a, b)), bits(Portable.min(KINDS, other)));
            assert_eq!(stored(wide.max(a, b)), bits(Portable.max(KINDS, other)));
            assert_eq!(wide.at_most(a, b), Portable.at_most(KINDS, other));
            assert_eq!(stored(wide.splat(other[0])), bits([other[0]; WIDTH]));
        }
    }
}
