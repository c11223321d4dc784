//! Fractions, times and lists from text.

use std::time::Duration;

/// A number above 0 from a fraction (`0.01`) or a percentage (`1%`).
pub fn parse_fraction(text: &str) -> Option<f64> {
    let (number, factor) = match text.strip_suffix('%') {
        Some(number) => (number, 0.01),
        None => (text, 1.0),
    };
    let value: f64 = number.trim().parse().ok()?;
    (value > 0.0 && value.is_finite()).then_some(value * factor)
}

/// Names with a fraction each, from `LRD=1%,LTTD=0.001`.
pub fn parse_named_fractions(text: &str) -> Option<Vec<(&str, f64)>> {
    text.split(',')
        .map(|pair| {
            let (name, fraction) = pair.split_once('=')?;
            let name = name.trim();
            (!name.is_empty()).then_some((name, parse_fraction(fraction.trim())?))
        })
        .collect()
}

/// A time from a number and a unit: `250ms`, `30s`, `2m` or `min`, `1h`; without a unit, seconds.
pub fn parse_duration(text: &str) -> Option<Duration> {
    let split = text.find(|c: char| c.is_ascii_alphabetic());
    let (number, unit) = text.split_at(split.unwrap_or(text.len()));
    let factor = match unit {
        "ms" => 1e-3,
        "s" | "" => 1.0,
        "m" | "min" => 60.0,
        "h" => 3600.0,
        _ => return None,
    };
    let seconds: f64 = number.trim().parse().ok()?;
    Duration::try_from_secs_f64(seconds * factor).ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn times_have_units() {
        assert_eq!(parse_duration("30s"), Some(Duration::from_secs(30)));
        assert_eq!(parse_duration("1.5m"), Some(Duration::from_secs(90)));
        assert_eq!(parse_duration("250ms"), Some(Duration::from_millis(250)));
        for text in ["", "s", "-1s", "1x", "nans", "1e300s"] {
            assert!(parse_duration(text).is_none(), "{text}");
        }
    }

    #[test]
    fn names_have_a_fraction_each() {
        assert_eq!(
            parse_named_fractions("LRD=1%, LTTD = 0.25"),
            Some(vec![("LRD", 0.01), ("LTTD", 0.25)])
        );
        for text in ["", "LRD", "LRD=", "=1%", "LRD=1%,", "LRD=0"] {
            assert!(parse_named_fractions(text).is_none(), "{text}");
        }
    }

    #[test]
    fn fractions_may_be_percentages() {
        assert_eq!(parse_fraction("1%"), Some(0.01));
        assert_eq!(parse_fraction("0.25"), Some(0.25));
        for text in ["", "%", "0", "-1%", "inf", "nan"] {
            assert!(parse_fraction(text).is_none(), "{text}");
        }
    }
}
