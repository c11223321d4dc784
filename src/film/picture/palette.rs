//! Colours of positions from 0 to 1, as 8-bit sRGB.

use crate::numeric::math;

/// The colour of values that are not numbers, which none of the palettes holds.
pub(super) const NOT_A_NUMBER: [u8; 3] = [255, 0, 255];

/// *inferno* by Smith and van der Walt (matplotlib, 2015): dark to bright in perceptually even steps.
///
/// The polynomial of degree 6 in sRGB is Zucker's least-squares fit (shadertoy `WlfXRN`, CC0); it is within
/// 0.034 of the table of matplotlib.
pub(super) fn inferno(position: f64) -> [u8; 3] {
    const COEFFICIENTS: [[f64; 3]; 7] = [
        [
            0.0002189403691192265,
            0.001651004631001012,
            -0.01948089843709184,
        ],
        [0.1065134194856116, 0.5639564367884091, 3.932712388889277],
        [11.60249308247187, -3.972853965665698, -15.9423941062914],
        [-41.70399613139459, 17.43639888205313, 44.35414519872813],
        [77.162935699427, -33.40235894210092, -81.80730925738993],
        [-71.31942824499214, 32.62606426397723, 73.20951985803202],
        [25.13112622477341, -12.24266895238567, -23.07032500287172],
    ];
    std::array::from_fn(|channel| {
        let value = COEFFICIENTS.iter().rev().fold(0.0, |sum, coefficient| {
            sum * position + coefficient[channel]
        });
        to_byte(value)
    })
}

/// Dark blue over white (at one half) to dark red: the knots of `ColorBrewer`'s *`RdBu`* of eleven classes,
/// in reverse (Brewer, 2003; Apache 2.0), joined by straight lines.
pub(super) fn diverging(position: f64) -> [u8; 3] {
    const KNOTS: [[u8; 3]; 11] = [
        [5, 48, 97],
        [33, 102, 172],
        [67, 147, 195],
        [146, 197, 222],
        [209, 229, 240],
        [247, 247, 247],
        [253, 219, 199],
        [244, 165, 130],
        [214, 96, 77],
        [178, 24, 43],
        [103, 0, 31],
    ];
    let place = position.clamp(0.0, 1.0) * (KNOTS.len() - 1) as f64;
    let knot = (place as usize).min(KNOTS.len() - 2);
    let fraction = place - knot as f64;
    std::array::from_fn(|channel| {
        let [from, to] = [KNOTS[knot], KNOTS[knot + 1]].map(|c| f64::from(c[channel]));
        to_byte((from + fraction * (to - from)) / 255.0)
    })
}

/// The display's value for a linear value in 0..=1 (IEC 61966-2-1).
pub(super) fn srgb(linear: f64) -> u8 {
    to_byte(if linear <= 0.0031308 {
        12.92 * linear
    } else {
        1.055 * math::powf(linear, 1.0 / 2.4) - 0.055
    })
}

/// The nearest byte; the cast keeps values beyond at the ends.
fn to_byte(value: f64) -> u8 {
    (value * 255.0).round() as u8
}
