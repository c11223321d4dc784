//! The index that a user names for a dielectric.

use std::fmt;

use super::glasses::{self, GLASSES};
use super::index::IndexFormula;
use crate::setting::did_you_mean;

/// The index of air that published indices are relative to: Mitsuba's `air`, which an interface has outside
/// unless the scene says otherwise. Its own dispersion, 7e-6 over the visible wavelengths, is ignored.
pub const AIR_IOR: f64 = 1.000277;

/// The most coefficients of a formula that is typed, of each kind.
const MOST_TERMS: usize = 4;

/// The index of refraction of a medium at each wavelength.
///
/// It is absolute, as `int_ior` of a scene is. Indices of [published glasses](glasses) that are relative to
/// air are multiplied by [`AIR_IOR`]; so glass in Mitsuba's `air` has the very ratio that was published. A
/// formula that is typed is taken as it stands.
#[derive(Clone, Debug, PartialEq)]
pub struct Glass {
    /// The first of its names, or the text of its formula.
    name: String,
    formula: IndexFormula,
    /// The factor from the formula's index to the absolute one.
    around: f64,
}

/// Reason why a text names no glass.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("{0}")]
pub struct GlassError(pub String);

impl Glass {
    /// The glass of a text: a name, `sellmeier:B1,...,C1,...` (C in µm²) or `cauchy:A,B,...` (µm², µm⁴, ...).
    ///
    /// # Errors
    ///
    /// For a name that is not known, numbers that are too many, too few or no numbers, and indices out of
    /// range at visible wavelengths.
    pub fn parse(text: &str) -> Result<Self, GlassError> {
        let name = text.trim();
        let (name, formula, around) = if let Some((kind, numbers)) = name.split_once(':') {
            (name, typed(name, kind.trim(), numbers)?, 1.0)
        } else {
            let glass = glasses::published(name).ok_or_else(|| unknown(name))?;
            let around = if glass.is_in_air { AIR_IOR } else { 1.0 };
            let formula = IndexFormula::Sellmeier(glass.terms.to_vec());
            (glass.names[0], formula, around)
        };
        match formula.problem() {
            Some(problem) => Err(GlassError(format!("{name}: {problem}"))),
            None => Ok(Self {
                name: name.to_owned(),
                formula,
                around,
            }),
        }
    }

    /// The first of its names, or the text of its formula.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The absolute index at a wavelength \[nm\].
    #[inline]
    pub fn ior(&self, wavelength_nm: f64) -> f64 {
        self.around * self.formula.ior(wavelength_nm)
    }

    /// The absolute index at line d, 587.6 nm.
    pub fn ior_d(&self) -> f64 {
        self.around * self.formula.n_d()
    }
}

impl fmt::Display for Glass {
    /// The name, its index at line d and Abbe's number.
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (n_d, abbe) = (self.formula.n_d(), self.formula.abbe());
        write!(out, "{} (n_d {n_d:.5}, ", self.name)?;
        if abbe.is_finite() {
            write!(out, "Abbe number {abbe:.2})")
        } else {
            write!(out, "the same at all wavelengths)")
        }
    }
}

/// The formula of typed coefficients.
fn typed(text: &str, kind: &str, numbers: &str) -> Result<IndexFormula, GlassError> {
    let fail = |problem: &str| Err(GlassError(format!("{text}: {problem}")));
    let parsed: Result<Vec<f64>, _> = numbers
        .split(',')
        .map(|number| number.trim().parse::<f64>())
        .collect();
    let numbers = match parsed {
        Ok(numbers) if numbers.iter().all(|number| number.is_finite()) => numbers,
        _ => return fail("coefficients are numbers, with commas between them"),
    };
    let count = numbers.len();
    match kind {
        "cauchy" if count <= MOST_TERMS => Ok(IndexFormula::Cauchy(numbers)),
        "cauchy" => fail("cauchy takes one to four coefficients: A, B in µm², C in µm⁴, D in µm⁶"),
        "sellmeier" if count.is_multiple_of(2) && count <= 2 * MOST_TERMS => {
            let (b, c) = numbers.split_at(count / 2);
            let terms = b.iter().zip(c).map(|(b, c)| [*b, *c]);
            Ok(IndexFormula::Sellmeier(terms.collect()))
        }
        "sellmeier" => {
            fail("sellmeier takes one to four B, then as many C in µm²: B1,B2,B3,C1,C2,C3")
        }
        _ => fail("formulas are cauchy:A,B,... and sellmeier:B1,...,C1,..."),
    }
}

fn unknown(name: &str) -> GlassError {
    let known: Vec<&str> = GLASSES.iter().map(|glass| glass.names[0]).collect();
    let all = GLASSES.iter().flat_map(|glass| glass.names.iter().copied());
    let hint = did_you_mean(name, all);
    GlassError(format!(
        "no glass is called \"{name}\"{hint}; known are {}, and formulas cauchy:A,B,... (µm², ...) and \
         sellmeier:B1,...,C1,... (µm²)",
        known.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typed_coefficients_of_a_glass_are_that_glass_in_vacuum() {
        let named = Glass::parse("bk7").unwrap();
        let typed =
            "sellmeier:1.03961212, 0.231792344,1.01046945,0.00600069867,0.0200179144,103.560653";
        let typed = Glass::parse(typed).unwrap();
        for nm in [380.0, 587.5618, 780.0] {
            assert_eq!(named.ior(nm), AIR_IOR * typed.ior(nm));
        }
        assert!(
            typed
                .to_string()
                .ends_with("(n_d 1.51680, Abbe number 64.17)")
        );
    }

    #[test]
    fn cauchys_formula_is_a_series_in_the_inverse_square_of_micrometres() {
        let glass = Glass::parse("cauchy:1.5,0.004,0.0001").unwrap();
        // At 0.5 µm: 1.5 + 0.004 · 4 + 0.0001 · 16, to a few roundings.
        assert!((glass.ior(500.0) - 1.5176).abs() < 1e-15);
        let constant = Glass::parse("cauchy:1.5").unwrap();
        assert_eq!([380.0, 780.0].map(|nm| constant.ior(nm)), [1.5; 2]);
        assert!(constant.to_string().contains("the same at all wavelengths"));
    }

    #[test]
    fn what_is_no_glass_is_refused_with_what_there_is() {
        for (text, expected) in [
            ("bk8", "did you mean \"bk7\"?"),
            ("", "known are bk7, f2, sf10"),
            ("cauchy:", "are numbers"),
            ("cauchy:1.5,nan", "are numbers"),
            ("cauchy:1,2,3,4,5", "one to four"),
            (
                "cauchy:0",
                "the index at 380 nm is 0; 0.1 to 10 are allowed",
            ),
            ("cauchy:1.5,1e300", "the index at 380 nm is"),
            ("cauchy:3,-1", "the index at 380 nm is"),
            ("sellmeier:1,2,3", "as many C"),
            ("sellmeier:1,0.25", "a resonance at 500.0 nm"),
            ("sellmeier:-2,0.01", "is NaN"),
            ("abbe:1.5,64", "formulas are"),
        ] {
            let error = Glass::parse(text).unwrap_err().to_string();
            assert!(error.contains(expected), "{text}: {error}");
        }
    }
}
