//! Morton order: points of space in a row, near ones mostly near each other.

use glam::DVec3;

/// The index of a point of the unit cube along the Morton curve through 2¹⁶ cells an axis, 0 to 2⁴⁸ − 1
/// (Morton 1966). Points outside count as on the cube's border, NaN as 0.
pub fn morton_code(point: DVec3) -> u64 {
    code_of_bits(point, 16)
}

/// The same through 2²¹ cells an axis, 0 to 2⁶³ − 1.
pub fn fine_morton_code(point: DVec3) -> u64 {
    code_of_bits(point, 21)
}

fn code_of_bits(point: DVec3, bits: u32) -> u64 {
    let cells = f64::from(1_u32 << bits);
    let [x, y, z] = (point * cells)
        .to_array()
        .map(|along| spread_bits(along.clamp(0.0, cells - 1.0) as u64));
    x << 2 | y << 1 | z
}

/// The lowest 21 bits, each followed by two zeros.
#[inline]
pub fn spread_bits(bits: u64) -> u64 {
    [
        (32, 0x001f_0000_0000_ffff),
        (16, 0x001f_0000_ff00_00ff),
        (8, 0x100f_00f0_0f00_f00f),
        (4, 0x10c3_0c30_c30c_30c3),
        (2, 0x1249_2492_4924_9249),
    ]
    .iter()
    .fold(bits, |bits, &(shift, mask)| (bits | bits << shift) & mask)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bits_take_turns() {
        for bits in [16, 21] {
            let code = |at| {
                if bits == 16 {
                    morton_code(at)
                } else {
                    fine_morton_code(at)
                }
            };
            let cells = 1_u32 << bits;
            let cell = |x: u32, y: u32, z: u32| {
                let at = DVec3::new(f64::from(x), f64::from(y), f64::from(z)) + 0.5;
                code(at / f64::from(cells))
            };
            assert_eq!(cell(0, 0, 0), 0);
            assert_eq!([cell(1, 0, 0), cell(0, 1, 0), cell(0, 0, 1)], [4, 2, 1]);
            let last = cells - 1;
            assert_eq!(cell(last, last, last), (1 << (3 * bits)) - 1);
            for bit in 0..bits {
                assert_eq!(cell(1 << bit, 0, 0), 4 << (3 * bit));
            }
        }
    }

    #[test]
    fn what_is_outside_or_no_number_is_on_the_border() {
        assert_eq!(morton_code(DVec3::splat(-3.0)), 0);
        assert_eq!(morton_code(DVec3::splat(f64::NAN)), 0);
        assert_eq!(morton_code(DVec3::INFINITY), (1 << 48) - 1);
    }
}
