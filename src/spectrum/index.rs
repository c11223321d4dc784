//! An index of refraction as a function of the wavelength.

use super::wavelengths::VISIBLE_NM;

/// A dispersion formula; λ is in µm.
#[derive(Clone, Debug, PartialEq)]
pub enum IndexFormula {
    /// n² = 1 + Σᵢ Bᵢ λ² / (λ² − Cᵢ), C in µm² (Sellmeier, *Annalen der Physik* 219, 1871).
    Sellmeier(Vec<[f64; 2]>),
    /// n = A + B/λ² + C/λ⁴ + ..., B in µm², C in µm⁴ (Cauchy, 1836). A alone is a constant index.
    Cauchy(Vec<f64>),
}

/// Fraunhofer's lines by which glasses are named \[nm\]: F of hydrogen, d of helium, C of hydrogen.
pub const LINES_NM: [f64; 3] = [486.1327, 587.5618, 656.2725];

/// The largest and the smallest index that makes sense.
const INDICES: [f64; 2] = [0.1, 10.0];

impl IndexFormula {
    /// The index at a wavelength \[nm\].
    pub fn ior(&self, wavelength_nm: f64) -> f64 {
        let micrometres = wavelength_nm * 1e-3;
        let squared = micrometres * micrometres;
        match self {
            Self::Sellmeier(terms) => {
                let sum: f64 = terms.iter().map(|[b, c]| b * squared / (squared - c)).sum();
                (1.0 + sum).sqrt()
            }
            Self::Cauchy(coefficients) => {
                let terms = coefficients.iter().rev();
                terms.fold(0.0, |sum, coefficient| sum / squared + coefficient)
            }
        }
    }

    /// The index at Fraunhofer's line d, 587.6 nm.
    pub fn n_d(&self) -> f64 {
        self.ior(LINES_NM[1])
    }

    /// Abbe's number, (n(d) − 1)/(n(F) − n(C)): the smaller, the wider the rainbow. Infinite for a constant.
    pub fn abbe(&self) -> f64 {
        let [f, d, c] = LINES_NM.map(|nm| self.ior(nm));
        (d - 1.0) / (f - c)
    }

    /// What is wrong with it where light is visible; `None` if all is well.
    pub(super) fn problem(&self) -> Option<String> {
        let [first, last] = VISIBLE_NM;
        if let Self::Sellmeier(terms) = self {
            let visible = first * first * 1e-6..=last * last * 1e-6;
            if let Some([_, c]) = terms.iter().find(|[_, c]| visible.contains(c)) {
                return Some(format!(
                    "C = {c} µm² is a resonance at {:.1} nm, in the midst of visible light: {first} to {last} nm must \
                     be free of them",
                    c.sqrt() * 1e3
                ));
            }
        }
        let [least, most] = INDICES;
        let steps = 4 * (last - first) as u32;
        (0..=steps)
            .map(|step| first + f64::from(step) * (last - first) / f64::from(steps))
            .find(|nm| !(least..=most).contains(&self.ior(*nm)))
            .map(|nm| {
                format!(
                    "the index at {nm} nm is {}; {least} to {most} are allowed from {first} to {last} nm",
                    self.ior(nm)
                )
            })
    }
}
