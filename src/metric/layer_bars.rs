//! A layer's values with their error bars, in channels that two images can share.

use std::borrow::Cow;

use super::bars::{Bars, CONFIDENCE};
use super::compare_image::{ChannelKind, Contents, TOTALS, component};
use super::{CompareError, CompareImage};
use crate::film::Channel;

/// Linear sRGB to CIE XYZ under D65 (IEC 61966-2-1), as Mitsuba's `moment` integrator converts.
const RGB_TO_XYZ: [[f32; 3]; 3] = [
    [0.412453, 0.357580, 0.180423],
    [0.212671, 0.715160, 0.072169],
    [0.019334, 0.119193, 0.950227],
];

/// Half a unit in the last place of an `f32`, relative.
const ROUNDING: f64 = 1.0 / (1 << 24) as f64;

/// Values and bars of one layer of one image.
pub(super) struct LayerBars<'a> {
    /// `R`, `G`, `B`; `X`, `Y`, `Z`; or `Y`.
    pub(super) names: Vec<&'a str>,
    /// Values and bars, channel by channel.
    pub(super) bars: Vec<Bars<'a>>,
}

impl<'a> LayerBars<'a> {
    /// A layer as its file has it, with its errors.
    ///
    /// The errors are the moments, if the layer is all light and has them; else those of a separate image, if
    /// one is given; else the file's own.
    pub(super) fn of(
        contents: &Contents<'a>,
        source: &'a CompareImage,
        layer: &str,
        is_total: bool,
    ) -> Result<Self, CompareError> {
        if is_total
            && source.errors.is_none()
            && let Some([means, squares]) = contents.moments()
        {
            return Self::from_moments(contents, source, &means, &squares);
        }
        let values = contents.colour(layer, ChannelKind::Value);
        let (errors, bounds) = match &source.errors {
            None => (contents.standard_errors(layer)?, contents.bounds(layer)?),
            Some((name, image)) => {
                let errors = Contents::new(name, image, source.corner);
                (separate_errors(&errors, layer, is_total, &values)?, None)
            }
        };
        // Both of one draw: to take both would count its scatter twice.
        let are_sampling = errors.is_some() && source.image.metadata(CONFIDENCE).is_some();
        let bounds = |c: usize, sampling: bool| {
            let bounds = bounds.as_ref().filter(|_| sampling == are_sampling)?;
            Some(bounds[c].map(Cow::Borrowed))
        };
        let bars = values.iter().enumerate().map(|(c, channel)| Bars {
            values: Cow::Borrowed(channel.samples.as_slice()),
            standard_errors: errors.as_ref().map(|errors| errors[c].clone()),
            bounds: bounds(c, false),
            sampling: bounds(c, true),
            freedom: source.freedom(),
        });
        Ok(Self {
            bars: bars.collect(),
            names: values
                .iter()
                .map(|channel| component(&channel.name))
                .collect(),
        })
    }

    /// Standard errors of means of n samples from their second moments, √((m₂ − m₁²) / (n − 1)).
    ///
    /// An error is zero, for "not known", if the difference may be rounding. Summed up as `f32`, n equal
    /// samples may be off by n u of themselves (Higham 2002, section 4.2). So m₂ may be off by n u and m₁² by
    /// 2 n u.
    fn from_moments(
        contents: &Contents<'a>,
        source: &CompareImage,
        means: &[&'a Channel],
        squares: &[&'a Channel],
    ) -> Result<Self, CompareError> {
        contents.check_finite(means)?;
        contents.check_finite(squares)?;
        let Some(samples) = source.samples.filter(|n| *n >= 2) else {
            return Err(CompareError::Samples {
                file: source.name.clone(),
                channel: squares[0].name.clone(),
            });
        };
        let rounding = 3.0 * samples as f64 * ROUNDING;
        let bars = means.iter().zip(squares).map(|(mean, square)| {
            let errors = mean.samples.iter().zip(&square.samples).map(|(&m, &s)| {
                let (m, s) = (f64::from(m), f64::from(s));
                let variance = s - m * m;
                if variance > rounding * s {
                    (variance / (samples - 1) as f64).sqrt() as f32
                } else {
                    0.0
                }
            });
            Bars {
                values: Cow::Borrowed(mean.samples.as_slice()),
                standard_errors: Some(Cow::Owned(errors.collect())),
                bounds: None,
                sampling: None,
                freedom: source.freedom(),
            }
        });
        Ok(Self {
            bars: bars.collect(),
            names: vec!["X", "Y", "Z"],
        })
    }

    /// Two layers in the same channels: if one is in X, Y and Z, the other is converted.
    pub(super) fn alike([a, b]: [Self; 2]) -> [Self; 2] {
        if a.names == b.names {
            return [a, b];
        }
        let is_grey = a.names == ["Y"] || b.names == ["Y"];
        [a, b].map(|one| match (one.names.as_slice(), is_grey) {
            (["X", "Y", "Z"], true) => Self {
                names: vec!["Y"],
                bars: one.bars.into_iter().skip(1).take(1).collect(),
            },
            (["R", "G", "B"], false) => one.to_xyz(),
            _ => one,
        })
    }

    /// Red, green and blue as X, Y and Z.
    ///
    /// The correlation of the channels' errors is not known. They count as fully correlated: σ(X) = Σ m σ,
    /// which is the largest it can be, and exact for light of one colour. Bounds keep their order, as no
    /// weight is negative.
    fn to_xyz(&self) -> Self {
        let [r, g, b] = [0, 1, 2].map(|c| &self.bars[c.min(self.bars.len() - 1)]);
        let errors = [r, g, b].map(|bars| bars.standard_errors.as_deref());
        let bars = RGB_TO_XYZ.map(|weights| Bars {
            values: mixed(weights, [&r.values, &g.values, &b.values]),
            standard_errors: all(errors).map(|errors| mixed(weights, errors)),
            bounds: mixed_ends(weights, [r, g, b].map(|bars| bars.bounds.as_ref())),
            sampling: mixed_ends(weights, [r, g, b].map(|bars| bars.sampling.as_ref())),
            freedom: r.freedom,
        });
        Self {
            names: vec!["X", "Y", "Z"],
            bars: bars.into(),
        }
    }
}

/// All three, or none.
fn all(planes: [Option<&[f32]>; 3]) -> Option<[&[f32]; 3]> {
    let [r, g, b] = planes;
    Some([r?, g?, b?])
}

/// Lower and upper bounds as a plane each.
type Ends<'a> = [Cow<'a, [f32]>; 2];

/// Weighted sums of lower and of upper bounds.
fn mixed_ends(weights: [f32; 3], bounds: [Option<&Ends>; 3]) -> Option<Ends<'static>> {
    let end = |end: usize| all(bounds.map(|bounds| Some(bounds?[end].as_ref())));
    Some([mixed(weights, end(0)?), mixed(weights, end(1)?)])
}

/// A weighted sum of three planes.
fn mixed(weights: [f32; 3], planes: [&[f32]; 3]) -> Cow<'static, [f32]> {
    let mix = |i: usize| (0..3).map(|c| weights[c] * planes[c][i]).sum();
    Cow::Owned((0..planes[0].len()).map(mix).collect())
}

/// Standard errors from an image of their own.
///
/// They are named as errors of the layer, or as if they were the layer. The errors of all light may have any
/// of its names, and must be there.
fn separate_errors<'a>(
    errors: &Contents<'a>,
    layer: &str,
    is_total: bool,
    values: &[&Channel],
) -> Result<Option<Vec<Cow<'a, [f32]>>>, CompareError> {
    let fitting = |found: &Vec<Cow<'a, [f32]>>| found.len() == values.len();
    let names = if is_total { &TOTALS[..] } else { &[] };
    for name in std::iter::once(layer).chain(names.iter().copied()) {
        if let Some(found) = errors.standard_errors(name)?.filter(fitting) {
            return Ok(Some(found));
        }
        let found = errors.errors_from(&errors.colour(name, ChannelKind::Value), false)?;
        if let Some(found) = found.filter(fitting) {
            return Ok(Some(found));
        }
    }
    if !is_total {
        return Ok(None);
    }
    let dot = if layer.is_empty() { "" } else { "." };
    let expected = values.iter().map(|channel| {
        let component = component(&channel.name);
        format!("{layer}{dot}stderr.{component}")
    });
    Err(CompareError::NoErrors {
        file: errors.name.to_owned(),
        layer: if layer.is_empty() { "total" } else { layer }.to_owned(),
        expected: expected.collect::<Vec<_>>().join(", "),
    })
}
