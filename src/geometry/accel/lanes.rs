//! Operations on eight numbers at a time, on whatever processor.

/// How many numbers are handled at a time: children a node, triangles a leaf.
pub(in crate::geometry) const WIDTH: usize = 8;

/// Operations on [`WIDTH`] numbers at a time.
pub(in crate::geometry) trait Lanes: Copy {
    /// [`WIDTH`] numbers.
    type Vector: Copy;

    fn load(self, from: &[f32; WIDTH]) -> Self::Vector;
    fn store(self, from: Self::Vector, to: &mut [f32; WIDTH]);
    fn splat(self, value: f32) -> Self::Vector;
    fn add(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn sub(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    fn mul(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a` where it is less than `b`; else, also if one is NaN, `b`.
    fn min(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// `a` where it is greater than `b`; else, also if one is NaN, `b`.
    fn max(self, a: Self::Vector, b: Self::Vector) -> Self::Vector;
    /// Bit i is set where a ≤ b in lane i.
    fn at_most(self, a: Self::Vector, b: Self::Vector) -> u32;
    /// Hints that the value will be read soon.
    fn prefetch<T>(self, value: &T);
}
