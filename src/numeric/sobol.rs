//! The first four dimensions of Sobol's sequence, and nested uniform scrambling.
//!
//! Everything here works on *bit-reversed* 32-bit fractions: bit 0 is the digit of weight 1/2, bit 31 that of
//! weight 2⁻³². In this order the van der Corput sequence is the index itself. A digit then depends on higher
//! digits only through the *lower* bits, so that the multiplication's carries, which run upward, respect the
//! nesting of dyadic intervals.

/// Direction numbers mₖ of dimensions 2 and 3 (counted from 0) for the bits k = 0.. of the index.
///
/// From Joe and Kuo, *Constructing Sobol' sequences with better two-dimensional projections*
/// (SIAM J. Sci. Comput. 30, 2008), file `new-joe-kuo-6.21201`, rows d = 3 (s = 2, a = 1,
/// m = 1 3) and d = 4 (s = 3, a = 1, m = 1 3 1). The recurrence is their equation (2):
///
/// ```text
/// m_k = 2 a_1 m_{k-1} ⊕ 2² a_2 m_{k-2} ⊕ ... ⊕ 2^s m_{k-s} ⊕ m_{k-s}
/// ```
const fn direction_numbers(degree: usize, a: u64, initial: [u64; 3]) -> [u32; 32] {
    let mut m = [0u64; 32];
    let mut reversed = [0u32; 32];
    let mut k = 0;
    while k < 32 {
        m[k] = if k < degree {
            initial[k]
        } else {
            let mut value = m[k - degree] ^ (m[k - degree] << degree);
            let mut i = 1;
            while i < degree {
                // a holds a_1 .. a_{s-1}, a_1 in the highest place.
                if (a >> (degree - 1 - i)) & 1 == 1 {
                    value ^= m[k - i] << i;
                }
                i += 1;
            }
            value
        };
        // v_k = m_k / 2^{k+1} as a 32-bit fraction, then bit-reversed.
        reversed[k] = ((m[k] << (31 - k)) as u32).reverse_bits();
        k += 1;
    }
    reversed
}

/// One row for each byte of the index: the XOR of the direction numbers of the byte's bits.
const fn byte_tables(directions: [u32; 32]) -> [[u32; 256]; 4] {
    let mut tables = [[0u32; 256]; 4];
    let mut byte = 0;
    while byte < 4 {
        let mut value = 1;
        while value < 256 {
            let lowest = (value as u32).trailing_zeros() as usize;
            tables[byte][value] = tables[byte][value & (value - 1)] ^ directions[8 * byte + lowest];
            value += 1;
        }
        byte += 1;
    }
    tables
}

static DIMENSION_2: [[u32; 256]; 4] = byte_tables(direction_numbers(2, 1, [1, 3, 0]));
static DIMENSION_3: [[u32; 256]; 4] = byte_tables(direction_numbers(3, 1, [1, 3, 1]));

#[inline]
fn look_up(tables: &[[u32; 256]; 4], index: u32) -> u32 {
    let [a, b, c, d] = index.to_le_bytes();
    tables[0][a as usize] ^ tables[1][b as usize] ^ tables[2][c as usize] ^ tables[3][d as usize]
}

/// Dimension 1, bit-reversed, without a branch.
///
/// Its direction numbers are the rows of Pascal's triangle modulo 2. By Lucas' theorem the binomial C(k, j)
/// is odd if the bits of j are among those of k: digit j is the sum of the index' bits k over all supersets k
/// of j. Five steps, one a bit of k, build these sums. (Ahmed, *An Implementation Algorithm of 2D Sobol
/// Sequence Fast, Elegant, and Compact*, EGSR 2024, in the other bit order.)
#[inline]
fn dimension_1(index: u32) -> u32 {
    let mut sums = index;
    sums ^= (sums >> 1) & 0x5555_5555;
    sums ^= (sums >> 2) & 0x3333_3333;
    sums ^= (sums >> 4) & 0x0f0f_0f0f;
    sums ^= (sums >> 8) & 0x00ff_00ff;
    sums ^ (sums >> 16)
}

/// Point `index` of the plane's Sobol' sequence, a (0,2)-sequence in base 2, bit-reversed.
#[inline]
pub(super) fn reversed_2(index: u32) -> [u32; 2] {
    [index, dimension_1(index)]
}

/// Point `index` of the four-dimensional Sobol' sequence, bit-reversed.
#[inline]
pub(super) fn reversed_4(index: u32) -> [u32; 4] {
    [
        index,
        dimension_1(index),
        look_up(&DIMENSION_2, index),
        look_up(&DIMENSION_3, index),
    ]
}

/// Nested uniform ("Owen") scrambling of a bit-reversed fraction; gives the 32-bit fraction in the usual
/// order.
///
/// Each digit is flipped, or not, by a hash of `key` and all digits above it. This random permutation of
/// dyadic intervals keeps every (t, m, s)-net one (Owen, 1995). The hash is Laine and Karras' construction
/// (2011) as used by Burley, *Practical Hash-based Owen Scrambling* (JCGT 9(4), 2020). Its operations and
/// constants are Vegdahl's (*Building a Better LK Hash*, 2021), which flip all digits nearly evenly;
/// Blender's Cycles uses the same.
#[inline]
pub(super) fn scramble(reversed: u32, key: u32) -> u32 {
    let mut x = reversed;
    x ^= x.wrapping_mul(0x3d20_adea);
    x = x.wrapping_add(key);
    x = x.wrapping_mul((key >> 16) | 1);
    x ^= x.wrapping_mul(0x0552_6c56);
    x ^= x.wrapping_mul(0x53a2_2864);
    x.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::numeric::math;
    use proptest::prelude::*;

    /// True if 2^m points have exactly one in each dyadic box of volume 2^-m.
    fn is_a_net(points: &[[u32; 2]], m: u32) -> bool {
        (0..=m).all(|bits_of_first| {
            let mut seen = vec![false; 1 << m];
            points.iter().all(|&[x, y]| {
                // A shift by all 32 bits is no shift for `u32`: go through `u64`.
                let column = u64::from(x) >> (32 - bits_of_first);
                let row = u64::from(y) >> (32 - (m - bits_of_first));
                let cell = ((column << (m - bits_of_first)) | row) as usize;
                !std::mem::replace(&mut seen[cell], true)
            })
        })
    }

    /// The point straight from the definition, one direction number a bit.
    fn by_definition(index: u32, directions: [u32; 32]) -> u32 {
        (0..32)
            .filter(|k| index >> k & 1 == 1)
            .fold(0, |sum, k| sum ^ directions[k])
    }

    #[test]
    fn the_first_points_are_those_of_joe_and_kuo() {
        // Output of their program `sobol` for `8 4 new-joe-kuo-6.21201`: point n is that of the index n ^ (n
        // >> 1), the Gray code of n.
        let expected = [
            [0.0, 0.0, 0.0, 0.0],
            [0.5, 0.5, 0.5, 0.5],
            [0.75, 0.25, 0.25, 0.25],
            [0.25, 0.75, 0.75, 0.75],
            [0.375, 0.375, 0.625, 0.875],
            [0.875, 0.875, 0.125, 0.375],
            [0.625, 0.125, 0.875, 0.625],
            [0.125, 0.625, 0.375, 0.125],
        ];
        for (n, expected) in (0u32..).zip(expected) {
            let point = reversed_4(n ^ (n >> 1))
                .map(|x| f64::from(x.reverse_bits()) / math::powi(2f64, 32));
            assert_eq!(point, expected, "point {n}");
        }
    }

    #[test]
    fn dimension_1_is_the_sequence_of_the_polynomial_x_plus_1() {
        // Joe and Kuo's row d = 2: s = 1, a = 0, m = 1.
        let directions = direction_numbers(1, 0, [1, 0, 0]);
        for index in (0..5000).chain(u32::MAX - 5000..=u32::MAX) {
            assert_eq!(
                dimension_1(index),
                by_definition(index, directions),
                "{index}"
            );
        }
    }

    #[test]
    fn the_byte_tables_agree_with_the_definition() {
        let second = direction_numbers(2, 1, [1, 3, 0]);
        let third = direction_numbers(3, 1, [1, 3, 1]);
        for index in (0..5000).chain(u32::MAX - 5000..=u32::MAX) {
            assert_eq!(look_up(&DIMENSION_2, index), by_definition(index, second));
            assert_eq!(look_up(&DIMENSION_3, index), by_definition(index, third));
        }
    }

    #[test]
    fn every_aligned_block_is_a_net_before_and_after_scrambling() {
        for m in 0..=10 {
            for block in [0u32, 1, 2, 5, 1000] {
                let plain: Vec<[u32; 2]> = (block << m..(block + 1) << m)
                    .map(|index| reversed_2(index).map(u32::reverse_bits))
                    .collect();
                assert!(is_a_net(&plain, m), "plain, m = {m}, block {block}");
                for key in [0u32, 1, 0x8000_0000, 0xdead_beef] {
                    let scrambled: Vec<[u32; 2]> = (block << m..(block + 1) << m)
                        .map(|index| {
                            let [x, y] = reversed_2(index);
                            [scramble(x, key), scramble(y, !key)]
                        })
                        .collect();
                    assert!(
                        is_a_net(&scrambled, m),
                        "key {key:x}, m = {m}, block {block}"
                    );
                }
            }
        }
    }

    #[test]
    fn the_net_test_can_fail() {
        let mut points: Vec<[u32; 2]> = (0..16)
            .map(|index| reversed_2(index).map(u32::reverse_bits))
            .collect();
        points[3][1] ^= 1 << 28;
        assert!(!is_a_net(&points, 4));
    }

    proptest! {
        /// The property that makes a scrambling "nested": equal leading digits stay equal, and the first
        /// digit that differs still differs.
        #[test]
        fn scrambling_keeps_the_first_digit_in_which_two_points_differ(
            x: u32, y: u32, key: u32
        ) {
            let scrambled = scramble(x.reverse_bits(), key) ^ scramble(y.reverse_bits(), key);
            prop_assert_eq!(scrambled.leading_zeros(), (x ^ y).leading_zeros());
        }
    }
}
