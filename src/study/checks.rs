//! Checks of a candidate: is it in the right unit, the right way up, and in the right place?
//!
//! Its texels are held against the truth's, channels averaged. If it looks like a mistake rather than an
//! approximation, the report tells so; no figure changes.

use serde::Serialize;

use crate::film::Image;
use crate::metric::LayerComparison;

/// The part of the squared difference that a mistake must explain to be named. An approximation's own error
/// is rarely halved by moving, turning or scaling its image. One that is moved, turned or scaled loses more.
const EXPLAINED: f64 = 0.5;

/// The relative error of the energy above which it is told; approximations within it are common.
const ENERGY: f64 = 0.25;

/// The relative distance of the energy from a slip's factor within which they are alike: the method's own
/// error of energy, which is seldom more.
const NEAR: f64 = 0.05;

/// Correlations that differ from 1 by less are 1. Values rounded to `f32` take 2⁻⁴⁹ off, and sums over 2²⁰
/// texels may be off by 2²⁰ · 2⁻⁵³ of themselves. An image of symmetric light correlates alike in several
/// orientations.
const ROUNDING: f64 = 1e-9;

/// Largest shift that is tried, in texels, each way.
const REACH: isize = 2;

/// A sign that a candidate is a mistake rather than an approximation.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Check {
    /// `units`, `orientation` or `shift`.
    pub kind: &'static str,
    /// The mistake that it looks like, and why.
    pub message: String,
}

/// All signs of mistakes in a candidate.
pub fn checks(truth: &Image, candidate: &Image, layer: &LayerComparison) -> Vec<Check> {
    let size = [truth.width, truth.height];
    let (Some(truth), Some(other)) = (plane(truth, layer), plane(candidate, layer)) else {
        return Vec::new();
    };
    let pair = CandidatePair {
        truth: &truth,
        other: &other,
        size,
    };
    [units(layer), orientation(&pair), shift(&pair)]
        .into_iter()
        .flatten()
        .collect()
}

/// The mean of a layer's channels; for all light, under any of its names.
pub(super) fn plane(image: &Image, layer: &LayerComparison) -> Option<Vec<f64>> {
    let names: &[&str] = if layer.is_total {
        &["E", "L", ""]
    } else {
        &[&layer.layer]
    };
    names.iter().find_map(|name| {
        let channel = |component: &str| {
            let dot = if name.is_empty() { "" } else { "." };
            image.channel(&format!("{name}{dot}{component}"))
        };
        let colour: Option<Vec<_>> = ["R", "G", "B"].iter().map(|it| channel(it)).collect();
        let channels = colour.or_else(|| Some(vec![channel("Y")?]))?;
        let share = 1.0 / channels.len() as f64;
        let texels = 0..image.width * image.height;
        let mean = |i: usize| {
            channels
                .iter()
                .map(|one| share * f64::from(one.samples[i]))
                .sum()
        };
        Some(texels.map(mean).collect())
    })
}

struct CandidatePair<'a> {
    truth: &'a [f64],
    other: &'a [f64],
    size: [usize; 2],
}

/// Factors between units, or between conventions that are mistaken for each other.
const SLIPS: [(f64, &str); 12] = [
    (
        std::f64::consts::FRAC_1_PI,
        "1/π: radiance of a white surface instead of irradiance",
    ),
    (
        0.8 * std::f64::consts::FRAC_1_PI,
        "0.8/π: radiance of a surface of reflectance 0.8 instead of irradiance",
    ),
    (
        0.5 * std::f64::consts::FRAC_1_PI,
        "0.5/π: radiance of a surface of reflectance 0.5 instead of irradiance",
    ),
    (
        std::f64::consts::PI,
        "π: a factor 1/π left out, as of a diffuse surface or of a lamp's exitance taken for its radiance",
    ),
    (
        4.0 * std::f64::consts::PI,
        "4π: a point light's power taken for its intensity",
    ),
    (
        0.25 * std::f64::consts::FRAC_1_PI,
        "1/4π: a point light's intensity taken for its power",
    ),
    (
        0.5,
        "1/2: half of the light missing, or a weight of one half counted twice",
    ),
    (2.0, "2: light counted twice"),
    (683.0, "683 lm/W: photometric instead of radiometric units"),
    (
        179.0,
        "179 lm/W: photometric units by Radiance's white efficacy",
    ),
    (255.0, "255: values of 0 to 255 instead of 0 to 1"),
    (1.0 / 255.0, "1/255: values divided by 255"),
];

/// Reports if the energy is far off, and which slip that resembles.
fn units(layer: &LayerComparison) -> Option<Check> {
    let ratio = layer.difference.energy_ratio?;
    if (ratio - 1.0).abs() <= ENERGY {
        return None;
    }
    let found = format!("its energy is {ratio:.4} of the truth's");
    let is_near = |factor: f64| (ratio / factor - 1.0).abs() < NEAR;
    let texels = (layer.size[0] * layer.size[1]) as f64;
    let slips = SLIPS
        .iter()
        .map(|(factor, what)| (*factor, (*what).to_owned()));
    let counts = [
        (texels, "the number of texels: sums instead of averages"),
        (
            1.0 / texels,
            "one over the number of texels: flux divided by it",
        ),
    ];
    let counts = counts.map(|(factor, what)| (factor, what.to_owned()));
    let slip = slips.chain(counts).find(|(factor, _)| is_near(*factor));
    Some(Check {
        kind: "units",
        message: match slip {
            Some((_, what)) => format!("{found}, which resembles {what}"),
            None => format!("{found}: is it in the truth's unit?"),
        },
    })
}

/// An orientation of an image: the texel of the candidate against which the truth's (x, y) is held.
type Turn = fn([usize; 2], [usize; 2]) -> [usize; 2];

const TURNS: [(&str, bool, Turn); 7] = [
    ("flipped left to right", false, |[x, y], [w, _]| {
        [w - 1 - x, y]
    }),
    ("flipped upside down", false, |[x, y], [_, h]| {
        [x, h - 1 - y]
    }),
    ("turned by 180°", false, |[x, y], [w, h]| {
        [w - 1 - x, h - 1 - y]
    }),
    ("transposed: rows for columns", true, |[x, y], _| [y, x]),
    ("turned by 90° clockwise", true, |[x, y], [w, _]| {
        [w - 1 - y, x]
    }),
    ("turned by 90° anticlockwise", true, |[x, y], [_, h]| {
        [y, h - 1 - x]
    }),
    (
        "flipped about the other diagonal",
        true,
        |[x, y], [w, h]| [w - 1 - y, h - 1 - x],
    ),
];

/// Reports if another orientation correlates better.
fn orientation(pair: &CandidatePair) -> Option<Check> {
    let [width, height] = pair.size;
    let places = |turn: Turn| {
        move |i: usize| {
            let [x, y] = turn([i % width, i / width], [width, height]);
            y * width + x
        }
    };
    let upright = pair.correlation(|i| i)?;
    let turned = TURNS
        .iter()
        .filter(|(_, needs_square, _)| !needs_square || width == height)
        .filter_map(|(name, _, turn)| Some((*name, pair.correlation(places(*turn))?)));
    let (name, best) = turned.max_by(|a, b| a.1.total_cmp(&b.1))?;
    let is_better = 1.0 - best < EXPLAINED * (1.0 - upright) && best - upright > ROUNDING;
    is_better.then(|| Check {
        kind: "orientation",
        message: format!(
            "it looks {name}: so it correlates with the truth by {best:.4}, as it is by {upright:.4}"
        ),
    })
}

/// Reports if the image fits better some texels away.
fn shift(pair: &CandidatePair) -> Option<Check> {
    let squares = |by: [isize; 2]| pair.squares(by);
    let unmoved = squares([0, 0])?;
    let shifts = (-REACH..=REACH).flat_map(|dy| (-REACH..=REACH).map(move |dx| [dx, dy]));
    let moved = shifts
        .filter(|by| *by != [0, 0])
        .filter_map(|by| Some((by, squares(by)?)));
    let ([dx, dy], best) = moved.min_by(|a, b| a.1.total_cmp(&b.1))?;
    (best < EXPLAINED * unmoved).then(|| Check {
        kind: "shift",
        message: format!(
            "it looks shifted by ({dx:+}, {dy:+}) texels (columns, rows): moved back, {:.1} % of the squared difference is left",
            100.0 * best / unmoved
        ),
    })
}

impl CandidatePair<'_> {
    /// Pearson's correlation of the truth with the candidate's texels at other places; `None` if either has
    /// no contrast.
    fn correlation(&self, place: impl Fn(usize) -> usize) -> Option<f64> {
        let n = self.truth.len() as f64;
        let mean = |values: &[f64]| values.iter().sum::<f64>() / n;
        let (t, o) = (mean(self.truth), mean(self.other));
        let (mut tt, mut oo, mut to) = (0.0, 0.0, 0.0);
        for (i, value) in self.truth.iter().enumerate() {
            let (a, b) = (value - t, self.other[place(i)] - o);
            tt += a * a;
            oo += b * b;
            to += a * b;
        }
        (tt > 0.0 && oo > 0.0).then(|| to / (tt * oo).sqrt())
    }

    /// Σ d² with the candidate moved back by (dx, dy), over texels that all shifts have.
    fn squares(&self, [dx, dy]: [isize; 2]) -> Option<f64> {
        let [width, height] = self.size.map(|n| isize::try_from(n).unwrap_or(0));
        if width <= 2 * REACH || height <= 2 * REACH {
            return None;
        }
        let mut sum = 0.0;
        for y in REACH..height - REACH {
            for x in REACH..width - REACH {
                let at = |x: isize, y: isize| (y * width + x) as usize;
                let d = self.other[at(x + dx, y + dy)] - self.truth[at(x, y)];
                sum += d * d;
            }
        }
        Some(sum)
    }
}
