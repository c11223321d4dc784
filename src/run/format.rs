//! Numbers for people.

use std::time::Duration;

use crate::numeric::math;

/// Six digits of a value, which is enough for a table; zero is a dot, so that the eye finds the rest.
pub fn number(value: f64) -> String {
    if value.is_nan() {
        "unknown".to_owned()
    } else if value == 0.0 {
        "·".to_owned()
    } else if (1e-3..1e6).contains(&value.abs()) {
        let digits = (5 - math::log10(value.abs()).floor() as i32).clamp(0, 6) as usize;
        format!("{value:.digits$}")
    } else {
        format!("{value:.3e}")
    }
}

/// A number with three digits.
pub fn three_digits(value: f64) -> String {
    if value == 0.0 {
        return "0".to_owned();
    }
    let digits = 2 - math::log10(value.abs()).floor() as i32;
    if (0..=5).contains(&digits) {
        format!("{value:.*}", digits as usize)
    } else if digits < 0 {
        format!("{value:.0}")
    } else {
        format!("{value:.2e}")
    }
}

/// Bytes in megabytes.
pub fn megabytes(bytes: u64) -> String {
    format!("{:.1} MB", bytes as f64 / 1e6)
}

/// A time in whole seconds, minutes, hours or days, two digits and more.
pub fn time(time: Duration) -> String {
    let seconds = time.as_secs_f64();
    let units = [(1.0, "s"), (60.0, "min"), (3600.0, "h"), (86_400.0, "days")];
    let fits = |(unit, _): &&(f64, &str)| seconds >= 1.5 * unit;
    let (unit, name) = units.iter().rev().find(fits).unwrap_or(&units[0]);
    format!("{:.0} {name}", seconds / unit)
}

/// A fraction in percent.
pub fn percent(fraction: f64) -> String {
    if fraction.is_nan() {
        "unknown".to_owned()
    } else {
        format!("{:.3} %", 100.0 * fraction)
    }
}

/// A relative error: a dot if there is no light, and so no error.
pub fn relative(error: Option<f64>, is_dark: bool) -> String {
    match error {
        Some(error) => percent(error),
        None if is_dark => number(0.0),
        None => number(f64::NAN),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_the_largest_unit_that_they_hold_more_than_one_and_a_half_of() {
        let texts = [0.4, 89.0, 91.0, 5430.0, 61_240.0, 1e6]
            .map(|seconds| time(Duration::from_secs_f64(seconds)));
        assert_eq!(texts, ["0 s", "89 s", "2 min", "2 h", "17 h", "12 days"]);
    }
}
