//! Numbers in attributes.

use glam::DVec3;

use super::Spectrum;
use crate::numeric::math;

/// The parts of a list whose entries are separated by commas and white space.
pub fn tokens(text: &str) -> impl Iterator<Item = &str> {
    text.split(|c: char| c == ',' || c.is_ascii_whitespace())
        .filter(|token| !token.is_empty())
}

/// A finite number.
pub fn float(text: &str) -> Result<f64, String> {
    match text.trim().parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => Err(format!("\"{}\" is not a finite number", shortened(text))),
        Err(_) => Err(format!("\"{}\" is not a number", shortened(text))),
    }
}

/// A whole number.
pub fn integer(text: &str) -> Result<i64, String> {
    text.trim()
        .parse()
        .map_err(|_| format!("\"{}\" is not a whole number", shortened(text)))
}

/// `true` or `false`, in any case.
pub fn boolean(text: &str) -> Result<bool, String> {
    if text.eq_ignore_ascii_case("true") {
        Ok(true)
    } else if text.eq_ignore_ascii_case("false") {
        Ok(false)
    } else {
        Err(format!("\"{}\" is neither true nor false", shortened(text)))
    }
}

/// All numbers of a list.
pub fn floats(text: &str) -> Result<Vec<f64>, String> {
    tokens(text).map(float).collect()
}

/// Three numbers.
pub fn vector(text: &str) -> Result<DVec3, String> {
    match floats(text)?[..] {
        [x, y, z] => Ok(DVec3::new(x, y, z)),
        ref other => Err(format!("expected 3 numbers, found {}", other.len())),
    }
}

/// Linear sRGB from three numbers, one number (grey), or `#rrggbb`.
///
/// The hexadecimal form is sRGB-encoded, as on the web, and is decoded here. (Mitsuba 3.9 does not document
/// it and rejects it; its meaning is not in doubt.)
pub fn rgb(text: &str) -> Result<[f64; 3], String> {
    if let Some(digits) = text.trim().strip_prefix('#') {
        return hexadecimal(digits).map(|encoded| encoded.map(decode_srgb));
    }
    match floats(text)?[..] {
        [grey] => Ok([grey; 3]),
        [red, green, blue] => Ok([red, green, blue]),
        ref other => Err(format!("expected 1 or 3 numbers, found {}", other.len())),
    }
}

/// Linear sRGB from the sRGB-encoded numbers or digits of Mitsuba 0.x' `<srgb>`.
pub fn encoded_srgb(text: &str) -> Result<[f64; 3], String> {
    if text.trim().starts_with('#') {
        return rgb(text);
    }
    rgb(text).map(|encoded| encoded.map(decode_srgb))
}

fn hexadecimal(digits: &str) -> Result<[f64; 3], String> {
    let number = (digits.len() == 6 && digits.bytes().all(|byte| byte.is_ascii_hexdigit()))
        .then(|| u32::from_str_radix(digits, 16).ok())
        .flatten()
        .ok_or_else(|| {
            format!(
                "\"#{}\" must be # and 6 hexadecimal digits",
                shortened(digits)
            )
        })?;
    Ok([16, 8, 0].map(|shift| f64::from(number >> shift & 0xff) / 255.0))
}

/// The linear value of an sRGB-encoded one (IEC 61966-2-1).
fn decode_srgb(encoded: f64) -> f64 {
    if encoded <= 0.04045 {
        encoded / 12.92
    } else {
        math::powf((encoded + 0.055) / 1.055, 2.4)
    }
}

/// One number, or `wavelength:value` pairs with rising wavelengths.
pub fn spectrum(text: &str) -> Result<Spectrum, String> {
    let entries: Vec<&str> = tokens(text).collect();
    if let [single] = entries[..]
        && !single.contains(':')
    {
        return float(single).map(Spectrum::Uniform);
    }
    let mut samples: Vec<(f64, f64)> = Vec::with_capacity(entries.len());
    for entry in entries {
        let (wavelength, value) = entry.split_once(':').ok_or_else(|| {
            format!(
                "\"{}\" must be one number or wavelength:value pairs",
                shortened(text)
            )
        })?;
        let sample = (float(wavelength)?, float(value)?);
        if samples.last().is_some_and(|last| last.0 >= sample.0) {
            return Err(format!(
                "wavelengths must rise, but {} follows {}",
                sample.0,
                samples[samples.len() - 1].0
            ));
        }
        samples.push(sample);
    }
    if samples.len() < 2 {
        return Err(
            "a spectrum needs one number, or two or more wavelength:value pairs".to_owned(),
        );
    }
    Ok(Spectrum::Samples(samples))
}

/// A text from a file, cut to a length that fits into a message.
pub fn shortened(text: &str) -> String {
    const LIMIT: usize = 60;
    if text.chars().count() <= LIMIT {
        text.to_owned()
    } else {
        text.chars().take(LIMIT).chain("...".chars()).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_separated_by_commas_spaces_or_both() {
        for text in ["1,2,3", "1 2 3", "1, 2, 3", " 1\t2 ,\n3 "] {
            assert_eq!(vector(text), Ok(DVec3::new(1.0, 2.0, 3.0)), "{text:?}");
        }
        assert_eq!(vector("1 2"), Err("expected 3 numbers, found 2".to_owned()));
    }

    #[test]
    fn numbers_are_finite_and_decimal() {
        assert_eq!(float(" .5 "), Ok(0.5));
        assert_eq!(float("1e-3"), Ok(0.001));
        for text in ["nan", "inf", "1e999", "", "1x", "0x10"] {
            assert!(float(text).is_err(), "{text:?}");
        }
        assert_eq!(integer(" 12 "), Ok(12));
        for text in ["1.0", "", "9223372036854775808"] {
            assert!(integer(text).is_err(), "{text:?}");
        }
        assert_eq!(boolean("True"), Ok(true));
        assert!(boolean("1").is_err());
    }

    #[test]
    fn colours_are_linear_but_for_the_hexadecimal_form() {
        assert_eq!(rgb("0.25"), Ok([0.25; 3]));
        assert_eq!(rgb("1 2 3"), Ok([1.0, 2.0, 3.0]));
        let decoded = rgb("#ff8000").unwrap();
        assert_eq!((decoded[0], decoded[2]), (1.0, 0.0));
        // ((128/255 + 0.055)/1.055)^2.4, to the digits a calculator gives.
        assert!((decoded[1] - 0.21586050).abs() < 1e-8);
        for text in ["#ff80", "#ff80zz", "#+f8000", "1 2", ""] {
            assert!(rgb(text).is_err(), "{text:?}");
        }
    }

    #[test]
    fn a_spectrum_is_one_number_or_rising_pairs() {
        assert_eq!(spectrum("0.5"), Ok(Spectrum::Uniform(0.5)));
        assert_eq!(
            spectrum("400:1, 700:2"),
            Ok(Spectrum::Samples(vec![(400.0, 1.0), (700.0, 2.0)]))
        );
        for text in [
            "",
            "1, 2, 3",
            "400:1",
            "500:1 400:2",
            "400:1 400:2",
            "400:x 500:1",
        ] {
            assert!(spectrum(text).is_err(), "{text:?}");
        }
    }
}
