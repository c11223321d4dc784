//! Limits on figures: the largest that a curve or a candidate may have.

use std::fmt;

use serde::Serialize;

use crate::metric::{Bounded, Figure, LayerComparison};
use crate::run::format::three_digits;
use crate::setting::{Words as _, parse_fraction};

/// The largest that a figure may be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Limit {
    /// The figure.
    pub figure: Figure,
    /// The largest value.
    pub most: f64,
    /// Its unit.
    pub unit: LimitUnit,
}

/// The unit of a limit.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum LimitUnit {
    /// None.
    Fraction,
    /// Texels.
    Texels,
    /// Metres.
    Metres,
}

/// A limit on a curve: of every sensor that has it, or of one.
#[derive(Clone, Debug, PartialEq)]
pub struct StudyLimit {
    /// The curve's or candidate's name.
    pub curve: String,
    /// The only sensor that is meant.
    pub sensor: Option<String>,
    /// The limit.
    pub limit: Limit,
}

/// What is allowed, for messages.
pub const ALLOWED: &str = "NAME[@SENSOR][:FIGURE] with 5% or 0.05, a length in texels (2texels) or in metres (0.02m) for \
                           displaced and resolution, as in mine=5% or mine:displaced=2texels; FIGURE is energy, l1 (the \
                           default), misplaced, displaced, l2, resolution, rmse or flip";

impl StudyLimit {
    /// A limit from a name, `NAME[@SENSOR][:FIGURE]`, and a value; `None` if it is none.
    pub fn parse(name: &str, value: &str) -> Option<Self> {
        let (place, figure) = match name.rsplit_once(':') {
            Some((place, word)) => (place, Figure::of_word(word)?),
            None => (name, Figure::L1),
        };
        let (curve, sensor) = match place.rsplit_once('@') {
            Some((curve, sensor)) if !sensor.is_empty() => (curve, Some(sensor.to_owned())),
            Some(_) => return None,
            None => (place, None),
        };
        let (most, unit) =
            length(value).or_else(|| Some((parse_fraction(value)?, LimitUnit::Fraction)))?;
        let is_of_unit = figure.is_length() == (unit != LimitUnit::Fraction);
        (!curve.is_empty() && is_of_unit).then(|| Self {
            curve: curve.to_owned(),
            sensor,
            limit: Limit { figure, most, unit },
        })
    }

    /// `NAME` or `NAME@SENSOR`.
    pub fn place(&self) -> String {
        match &self.sensor {
            Some(sensor) => format!("{}@{sensor}", self.curve),
            None => self.curve.clone(),
        }
    }
}

/// A length above 0 with its unit.
fn length(text: &str) -> Option<(f64, LimitUnit)> {
    let (number, factor, unit) = if let Some(number) = text.strip_suffix("texels") {
        (number, 1.0, LimitUnit::Texels)
    } else if let Some(number) = text.strip_suffix("texel") {
        (number, 1.0, LimitUnit::Texels)
    } else if let Some(number) = text.strip_suffix("mm") {
        (number, 1e-3, LimitUnit::Metres)
    } else if let Some(number) = text.strip_suffix("cm") {
        (number, 1e-2, LimitUnit::Metres)
    } else {
        (text.strip_suffix('m')?, 1.0, LimitUnit::Metres)
    };
    let value: f64 = number.trim().parse().ok()?;
    (value > 0.0 && value.is_finite()).then_some((value * factor, unit))
}

impl Limit {
    /// The figure of a layer in the limit's unit; `None` if it is not defined.
    pub fn figure_of(&self, layer: &LayerComparison) -> Option<Bounded> {
        if self.unit != LimitUnit::Metres {
            return self.figure.error(layer);
        }
        if self.figure == Figure::Displaced {
            return layer.fidelity.displaced.as_ref()?.metres;
        }
        let found = layer.fidelity.resolution?;
        let metre = found.metres? / found.texels.value;
        Some(found.texels.times(metre))
    }

    /// A value of the figure for readers.
    pub fn show(&self, value: f64) -> String {
        match self.unit {
            LimitUnit::Fraction => format!("{} %", three_digits(100.0 * value)),
            LimitUnit::Texels => format!("{} texels", three_digits(value)),
            LimitUnit::Metres => format!("{} m", three_digits(value)),
        }
    }
}

impl fmt::Display for Limit {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        write!(out, "{} {}", self.figure.word(), self.show(self.most))
    }
}

#[cfg(test)]
mod tests {
    use super::LimitUnit::{Fraction, Metres, Texels};
    use super::*;

    #[test]
    fn limits_have_a_name_and_may_have_a_sensor_and_a_figure() {
        let limit = |name: &str, value: &str| {
            let found = StudyLimit::parse(name, value)?;
            let Limit { figure, most, unit } = found.limit;
            Some((found.place(), figure, most, unit))
        };
        let is = |place: &str, figure, most, unit| Some((place.to_owned(), figure, most, unit));
        assert_eq!(limit("mine", "5%"), is("mine", Figure::L1, 0.05, Fraction));
        assert_eq!(
            limit("mine@floor:energy", "0.1"),
            is("mine@floor", Figure::Energy, 0.1, Fraction)
        );
        let lengths = [
            ("2texels", 2.0, Texels),
            ("1 texel", 1.0, Texels),
            ("2cm", 0.02, Metres),
            ("5mm", 0.005, Metres),
            ("0.5m", 0.5, Metres),
        ];
        for (text, most, unit) in lengths {
            let expected = is("mine", Figure::Displaced, most, unit);
            assert_eq!(limit("mine:displaced", text), expected, "{text}");
        }
        for (name, value) in [
            ("", "5%"),
            ("mine", "0"),
            ("mine", "2texels"),
            ("mine:displaced", "5%"),
            ("mine:nothing", "5%"),
            ("mine@", "5%"),
            ("@floor", "5%"),
            ("mine:displaced", "-1texels"),
        ] {
            assert_eq!(limit(name, value), None, "{name} {value}");
        }
    }
}
