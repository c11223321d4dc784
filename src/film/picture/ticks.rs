//! Round numbers along the bar.

use super::range::{BarRange, Scale};
use crate::numeric::math;

/// A mark on the bar.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Tick {
    /// The position, from 0 at the bar's lower end to 1 at the upper.
    pub(super) position: f64,
    /// The number beside it; minor marks have none.
    pub(super) label: Option<String>,
}

/// At most about `wanted` labelled ticks inside the range.
pub(super) fn ticks(range: &BarRange, scale: Scale, wanted: usize) -> Vec<Tick> {
    match scale {
        Scale::Linear => linear_ticks(range, wanted),
        Scale::Logarithmic => logarithmic_ticks(range, wanted),
    }
}

/// Multiples of 1, 2 or 5 times a power of ten.
fn linear_ticks(range: &BarRange, wanted: usize) -> Vec<Tick> {
    let rough = (range.high - range.low) / wanted.max(1) as f64;
    let power = math::log10(rough).floor();
    let magnitude = math::powf(10f64, power);
    let step = [1.0, 2.0, 5.0, 10.0]
        .map(|factor| factor * magnitude)
        .into_iter()
        // A step slightly below `rough` is enough: 0.5 in ten steps is 0.05 up to rounding.
        .find(|step| *step >= rough * (1.0 - 1e-9))
        .unwrap_or(rough);
    // Steps are counted from zero, so that zero itself is exact. Ends count with a small tolerance.
    let hair = 1e-9;
    let first = (range.low / step - hair).ceil();
    let last = (range.high / step + hair).floor();
    let largest = range.low.abs().max(range.high.abs());
    let count = (last - first).max(-1.0) as usize + 1;
    // If the ends are far from zero compared to their distance, no round numbers tell them apart.
    (0..count.min(100))
        .map(|i| {
            let value = (first + i as f64) * step;
            Tick {
                position: range.position(value, Scale::Linear),
                label: Some(number(value, step, largest)),
            }
        })
        .collect()
}

/// Powers of ten, every nth if they crowd. Between them 2 and 5 are labelled if there is room, and the other
/// digits are minor marks.
fn logarithmic_ticks(range: &BarRange, wanted: usize) -> Vec<Tick> {
    let decades = math::log10(range.high / range.low);
    let every = (decades / wanted.max(1) as f64).ceil().max(1.0);
    let labelled: &[u32] = match wanted as f64 / decades {
        room if room >= 9.0 => &[1, 2, 3, 4, 5, 6, 7, 8, 9],
        room if room >= 3.0 => &[1, 2, 5],
        _ => &[1],
    };
    let inside = range.low * (1.0 - 1e-9)..=range.high * (1.0 + 1e-9);
    let first = math::log10(range.low).floor() as i32;
    let last = math::log10(range.high).ceil() as i32;
    let mut ticks = Vec::new();
    for power in first..=last {
        for digit in 1..=9 {
            let value: f64 = format!("{digit}e{power}").parse().unwrap_or(f64::NAN);
            if !inside.contains(&value) {
                continue;
            }
            let on_turn = f64::from(power).rem_euclid(every) == 0.0;
            let label = (labelled.contains(&digit) && on_turn).then(|| number(value, value, value));
            // Digits between powers that are not even all labelled would blur.
            if label.is_some() || every == 1.0 {
                ticks.push(Tick {
                    position: range.position(value, Scale::Logarithmic),
                    label,
                });
            }
        }
    }
    ticks
}

/// A multiple of `step` (1, 2 or 5 times a power of ten) as text, with the decimals of `step`; with an
/// exponent if `largest`, the largest number on the bar, needs too many digits.
fn number(value: f64, step: f64, largest: f64) -> String {
    let power = math::log10(step * (1.0 + 1e-9)).floor();
    if value == 0.0 {
        return "0".to_owned();
    }
    if (1e-3..1e5).contains(&largest) && power >= -6.0 {
        return format!("{value:.*}", (-power).max(0.0) as usize);
    }
    // Digits run from the value's own leading one down to the step's.
    let leading = math::log10(value.abs() * (1.0 + 1e-9)).floor();
    format!("{value:.*e}", (leading - power).max(0.0) as usize)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(low: f64, high: f64, scale: Scale, wanted: usize) -> Vec<String> {
        let ticks = ticks(&BarRange { low, high }, scale, wanted);
        ticks.into_iter().filter_map(|tick| tick.label).collect()
    }

    #[test]
    fn linear_ticks_are_round_numbers() {
        let linear = |low, high, wanted| labels(low, high, Scale::Linear, wanted);
        assert_eq!(
            linear(0.0, 1.0, 5),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"].map(|s| if s == "0.0" { "0" } else { s })
        );
        assert_eq!(linear(0.0, 8.3, 5), ["0", "2", "4", "6", "8"]);
        assert_eq!(linear(-3.0, 3.0, 6), ["-3", "-2", "-1", "0", "1", "2", "3"]);
        assert_eq!(linear(0.0, 2.5e-5, 3), ["0", "1e-5", "2e-5"]);
        assert_eq!(linear(0.0, 3e6, 4), ["0", "1e6", "2e6", "3e6"]);
        assert_eq!(
            linear(0.0, 2.5e6, 5),
            ["0", "5e5", "1.0e6", "1.5e6", "2.0e6", "2.5e6"]
        );
    }

    #[test]
    fn logarithmic_ticks_are_powers_of_ten_and_more_where_there_is_room() {
        let logarithmic = |low, high, wanted| labels(low, high, Scale::Logarithmic, wanted);
        assert_eq!(logarithmic(0.01, 10.0, 6), ["0.01", "0.1", "1", "10"]);
        assert_eq!(
            logarithmic(0.01, 1.0, 6),
            ["0.01", "0.02", "0.05", "0.1", "0.2", "0.5", "1"]
        );
        assert_eq!(
            logarithmic(1e-6, 1e6, 6),
            ["1e-6", "1e-4", "0.01", "1", "100", "10000", "1e6"]
        );
    }

    #[test]
    fn absurd_ranges_give_few_ticks_and_no_panic() {
        for (low, high) in [
            (1e15, 1e15 + 2.0),
            (0.0, 5e-324),
            (-1e307, 1e307),
            (0.0, f64::MAX),
        ] {
            assert!(linear_ticks(&BarRange { low, high }, 8).len() <= 100);
        }
        assert!(
            logarithmic_ticks(
                &BarRange {
                    low: 5e-324,
                    high: f64::MAX
                },
                8
            )
            .len()
                <= 12
        );
    }
}
