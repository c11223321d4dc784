//! The operations on eight numbers at a time that the search needs of a processor.

/// Number of numbers handled at a time: children a node, triangles a leaf.
pub(in crate::geometry) const WIDTH: usize = 8;

/// Operations on [`WIDTH`] numbers at a time, each as IEEE 754 has it (no fused ones).
pub(in crate::geometry) trait Lanes: Copy {
    /// [`WIDTH`] numbers.
    type Vector: Copy;

    fn load(self, from: &[f32; WIDTH]) -> Self::Vector;
    fn store(self, from: Self::Vector, to: &mut [f32; WIDTH]);
    fn splat(self, value: f32) -> Self::Vector;
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// For each lane `a` if it is less than `b`; else, also if one is NaN, `b`.
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// For each lane `a` if it is greater than `b`; else, also if one is NaN, `b`.
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Bits for the lanes: bit i is set if a ≤ b in lane i.
    fn at_most(self, a: Self::Vector, b: Self::Vector) -> u32;
    /// Hints that the value will be read soon.
    fn prefetch<T>(self, value: &T);
}
