//! The colour spaces that FLIP measures in. All conversions assume the illuminant D65.

use crate::numeric::math::single;
/// Three numbers of one texel.
pub(super) type Colour = [f32; 3];

/// White in XYZ: D65, the sums of the rows of [`RGB_TO_XYZ`].
const ILLUMINANT: Colour = [0.950_428_55, 1.0, 1.088_900_4];

/// Linear sRGB to XYZ, as fractions by which the published implementations agree to the last digit.
const RGB_TO_XYZ: [Colour; 3] = [
    [
        10135552.0 / 24577794.0,
        8788810.0 / 24577794.0,
        4435075.0 / 24577794.0,
    ],
    [
        2613072.0 / 12288897.0,
        8788810.0 / 12288897.0,
        887015.0 / 12288897.0,
    ],
    [
        1425312.0 / 73733382.0,
        8788810.0 / 73733382.0,
        70074185.0 / 73733382.0,
    ],
];

/// XYZ to linear sRGB: the inverse of [`RGB_TO_XYZ`].
const XYZ_TO_RGB: [Colour; 3] = [
    [3.241_003_3, -1.537_398_9, -0.498_615_86],
    [-0.969_224_33, 1.875_930_1, 0.041554224],
    [0.055639423, -0.204_011_2, 1.057_148_9],
];

#[inline]
fn transformed(matrix: &[Colour; 3], [x, y, z]: Colour) -> Colour {
    let row = |[a, b, c]: Colour| a * x + b * y + c * z;
    [row(matrix[0]), row(matrix[1]), row(matrix[2])]
}

/// Relative luminance of linear sRGB, with the weights FLIP rounds to four digits.
#[inline]
pub(super) fn luminance([r, g, b]: Colour) -> f32 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

/// Linear sRGB to the opponent space `YCxCz`: CIELAB without its cube root, so that it is linear and can be
/// filtered (Andersson et al. 2020, section 4.1).
#[inline]
pub(super) fn to_opponent(rgb: Colour) -> Colour {
    let [x, y, z] = transformed(&RGB_TO_XYZ, rgb);
    let (x, z) = (x / ILLUMINANT[0], z / ILLUMINANT[2]);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The inverse of [`to_opponent`].
#[inline]
pub(super) fn from_opponent([luma, cx, cz]: Colour) -> Colour {
    let y = (luma + 16.0) / 116.0;
    let x = (y + cx / 500.0) * ILLUMINANT[0];
    let z = (y - cz / 200.0) * ILLUMINANT[2];
    transformed(&XYZ_TO_RGB, [x, y, z])
}

/// Linear sRGB to CIELAB with Hunt's adjustment: chroma is less visible in the dark, a' = 0.01 L a and b' =
/// 0.01 L b (Andersson et al. 2020, section 4.1.2).
#[inline]
pub(super) fn to_hunt_lab(rgb: Colour) -> Colour {
    const DELTA: f32 = 6.0 / 29.0;
    let [x, y, z] = transformed(&RGB_TO_XYZ, rgb);
    let [x, y, z] = [x / ILLUMINANT[0], y, z / ILLUMINANT[2]].map(|value| {
        if value > DELTA * DELTA * DELTA {
            single::cbrt(value)
        } else {
            value / (3.0 * DELTA * DELTA) + 4.0 / 29.0
        }
    });
    let lightness = 116.0 * y - 16.0;
    let adjust = 0.01 * lightness;
    [
        lightness,
        adjust * 500.0 * (x - y),
        adjust * 200.0 * (y - z),
    ]
}

/// The distance `HyAB`: city-block in lightness, Euclidean in chroma.
#[inline]
pub(super) fn hyab(one: Colour, other: Colour) -> f32 {
    let [l, a, b] = std::array::from_fn(|c| one[c] - other[c]);
    l.abs() + (a * a + b * b).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_opponent_space_is_left_as_it_was_entered() {
        for rgb in [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0], [0.2, 0.7, 0.05]] {
            let back = from_opponent(to_opponent(rgb));
            for c in 0..3 {
                // f32 has seven digits; some ten operations on values up to 500 / 500 = 1.
                assert!((back[c] - rgb[c]).abs() < 20.0 * f32::EPSILON, "{back:?}");
            }
        }
    }

    #[test]
    fn white_has_lightness_100_and_no_chroma() {
        let [l, a, b] = to_hunt_lab([1.0; 3]);
        assert!((l - 100.0).abs() < 1e-4, "{l}");
        // 500 (x - y) with x and y known to a few times 2^-24.
        assert!(a.abs() < 5e-4 && b.abs() < 5e-4, "{a} {b}");
        assert_eq!(hyab([1.0, 0.0, 3.0], [3.0, 3.0, -1.0]), 7.0);
    }
}
