//! Numbers for people.

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
