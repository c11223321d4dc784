//! The figures of two images, all together.

use serde::Serialize;

use super::bars::Bars;
use super::difference::Difference;
use super::equivalence::{Equivalence, Verdict};
use super::fidelity::Fidelity;
use super::flip::{self, Exposures, Images};
use super::pair::{LayerPair, Pairing};
use super::settings::{CompareSettings, ImageSide};
use super::significance::Significance;
use super::similarity::Similarity;
use super::{CompareError, CompareImage};

/// The figures of one layer.
///
/// # Example: the length of the difference
///
/// ```
/// # use nephroid::{CompareImage, CompareSettings, Image, compare};
/// # let grey = |value: f64| {
/// #     let mut image = Image::new(16, 16);
/// #     image.add_rgb("E", &[[value; 3]; 256]);
/// #     image.add_rgb("E.stderr", &[[0.001; 3]; 256]);
/// #     CompareImage::new(format!("{value}.exr"), image)
/// # };
/// # let (truth, mine) = (grey(1.0), grey(1.02));
/// # let comparison = compare(&truth, &mine, &CompareSettings::default())?;
/// let all = &comparison.layers[0];
/// assert!(all.is_total && all.layer == "E");
/// assert!((all.difference.relative_rmse.unwrap() - 0.02).abs() < 1e-6);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct LayerComparison {
    /// The layer's name.
    pub layer: String,
    /// True if it is all light.
    pub is_total: bool,
    /// Texels a row and rows.
    pub size: [usize; 2],
    /// Figures that need no error bars.
    pub difference: Difference,
    /// How much light there is, how far from its place, and right at which scale.
    pub fidelity: Fidelity,
    /// SSIM; `None` if the image is smaller than its window or the reference dark.
    pub similarity: Option<Similarity>,
    /// HDR-FLIP; `None` if it is left out or the reference dark.
    pub flip: Option<Flip>,
    /// The tests against the error bars; `None` if neither image has any.
    pub significance: Option<Significance>,
    /// The verdicts at the margin.
    pub equivalence: Equivalence,
}

/// HDR-FLIP of a layer, and the settings that it depends on.
///
/// # Example: the difference that an eye sees
///
/// ```
/// # use nephroid::{CompareImage, CompareSettings, Image, compare};
/// # let grey = |value: f64| {
/// #     let mut image = Image::new(16, 16);
/// #     image.add_rgb("E", &[[value; 3]; 256]);
/// #     image.add_rgb("E.stderr", &[[0.001; 3]; 256]);
/// #     CompareImage::new(format!("{value}.exr"), image)
/// # };
/// # let (truth, mine) = (grey(1.0), grey(1.02));
/// # let comparison = compare(&truth, &mine, &CompareSettings::default())?;
/// let flip = comparison.layers[0].flip.unwrap();
/// assert!(flip.mean < 0.1 && flip.mean <= flip.max);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Flip {
    /// The mean over texels: from 0 (no difference) to 1.
    pub mean: f64,
    /// The largest of a texel.
    pub max: f64,
    /// Pixels a degree of vision.
    #[doc(hidden)]
    pub pixels_per_degree: f32,
    /// The exposures.
    #[doc(hidden)]
    pub exposures: Exposures,
}

/// The figures of two images.
///
/// # Example: all verdicts
///
/// ```
/// # use nephroid::{CompareImage, CompareSettings, Image, compare};
/// # let grey = |value: f64| {
/// #     let mut image = Image::new(16, 16);
/// #     image.add_rgb("E", &[[value; 3]; 256]);
/// #     image.add_rgb("E.stderr", &[[0.001; 3]; 256]);
/// #     CompareImage::new(format!("{value}.exr"), image)
/// # };
/// # let (truth, mine) = (grey(1.0), grey(1.02));
/// # let comparison = compare(&truth, &mine, &CompareSettings::default())?;
/// for layer in &comparison.layers {
///     println!("{}: {}", layer.layer, layer.equivalence.verdict.name());
/// }
/// assert_eq!(comparison.verdict, nephroid::Verdict::Different);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Comparison {
    /// The first image.
    pub a: String,
    /// The second.
    pub b: String,
    /// The settings of the comparison.
    pub settings: CompareSettings,
    /// All light first, then layer by layer.
    pub layers: Vec<LayerComparison>,
    /// The worst verdict of any layer.
    pub verdict: Verdict,
    /// Oddities of the images.
    pub notes: Vec<String>,
}

/// Compares two images, layer by layer.
///
/// # Errors
///
/// As [`Pairing::new`].
///
/// # Example: a render against the truth
///
/// ```
/// # let scene = nephroid::load("scenes/glass-ball.xml".as_ref(), &[("size", "8")])?;
/// # let sensor = &scene.sensors()[0];
/// # let method = nephroid::Method::new("closed-form", &Default::default())?.with("max-depth", "3")?;
/// # let rendering = method.run(&scene, sensor, &Default::default(), &Default::default())?;
/// # let other = nephroid::Method::new("photons", &Default::default())?;
/// # let render = other.run(&scene, sensor, &nephroid::Budget::work(4096), &Default::default())?;
/// # let (truth, mine) = (rendering.image(&scene), render.image(&scene));
/// use nephroid::{CompareImage, CompareSettings, compare};
///
/// let truth = CompareImage::new("truth.exr", truth);
/// let mine = CompareImage::new("mine.exr", mine);
/// let comparison = compare(&truth, &mine, &CompareSettings::default())?;
/// let all = &comparison.layers[0];
/// println!("relative RMSE {:?}", all.difference.relative_rmse);
/// assert!(all.significance.is_some(), "there are error bars");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn compare(
    a: &CompareImage,
    b: &CompareImage,
    settings: &CompareSettings,
) -> Result<Comparison, CompareError> {
    let pairing = Pairing::new(a, b, settings.reference, &settings.layers)?;
    Ok(Comparison::of(&pairing, a, b, settings))
}

impl Comparison {
    /// The figures of layers that are side by side already.
    #[doc(hidden)]
    pub fn of(
        pairing: &Pairing,
        a: &CompareImage,
        b: &CompareImage,
        settings: &CompareSettings,
    ) -> Self {
        let layers: Vec<LayerComparison> = pairing
            .pairs
            .iter()
            .map(|pair| LayerComparison::of(pair, settings))
            .collect();
        let worst = layers.iter().map(|layer| layer.equivalence.verdict).max();
        let mut notes = pairing.notes.clone();
        notes.extend(notes_on_bars(pairing, a, b, settings.reference));
        Self {
            a: a.name.clone(),
            b: b.name.clone(),
            settings: settings.clone(),
            layers,
            verdict: worst.unwrap_or(Verdict::Equivalent),
            notes,
        }
    }
}

/// Notes on the assumptions about error bars.
fn notes_on_bars(
    pairing: &Pairing,
    a: &CompareImage,
    b: &CompareImage,
    reference: ImageSide,
) -> Vec<String> {
    let sources = match reference {
        ImageSide::A => [a, b],
        ImageSide::B => [b, a],
    };
    let tests = || pairing.pairs.iter().flat_map(|pair| &pair.tests);
    let mut notes = Vec::new();
    for (source, is_reference) in sources.into_iter().zip([true, false]) {
        let bars = || {
            tests().map(move |test| {
                if is_reference {
                    &test.reference
                } else {
                    &test.other
                }
            })
        };
        if tests().next().is_some() && !bars().any(Bars::has_any) {
            notes.push(format!(
                "{} has no error bars: it counts as exact",
                source.name
            ));
        }
        if bars().any(|bars| bars.standard_errors.is_some()) && source.samples.is_none() {
            notes.push(format!(
                "{}: how many samples its standard errors come from is not known: they count as exact",
                source.name
            ));
        }
    }
    notes
}

impl LayerComparison {
    /// The figures of one layer.
    #[doc(hidden)]
    pub fn of(pair: &LayerPair, settings: &CompareSettings) -> Self {
        let difference = Difference::of(pair);
        let equivalence = Equivalence::of(pair, &difference, settings.margin, settings.level);
        Self {
            layer: pair.name.clone(),
            is_total: pair.is_total,
            size: [pair.width, pair.height],
            fidelity: Fidelity::of(pair),
            similarity: Similarity::of(pair),
            flip: settings
                .pixels_per_degree
                .and_then(|pixels_per_degree| Flip::of(pair, pixels_per_degree)),
            significance: Significance::of(pair, settings.level),
            difference,
            equivalence,
        }
    }
}

impl Flip {
    /// HDR-FLIP of a layer; `None` if the reference has no light to set exposures by.
    pub(crate) fn of(pair: &LayerPair, pixels_per_degree: f32) -> Option<Self> {
        let (map, exposures) = Self::mapped(pair, pixels_per_degree)?;
        let [sum] = super::sums::sums(map.len(), |i| [f64::from(map[i])]);
        Some(Self {
            mean: sum / map.len() as f64,
            max: f64::from(map.iter().copied().fold(0.0, f32::max)),
            pixels_per_degree,
            exposures,
        })
    }

    /// HDR-FLIP of a layer, texel by texel; `None` if the reference has no light to set exposures by.
    pub(crate) fn map(pair: &LayerPair, pixels_per_degree: f32) -> Option<Vec<f32>> {
        Some(Self::mapped(pair, pixels_per_degree)?.0)
    }

    fn mapped(pair: &LayerPair, pixels_per_degree: f32) -> Option<(Vec<f32>, Exposures)> {
        let channel = |c: usize| &pair.channels[c.min(pair.channels.len() - 1)];
        let images = Images {
            reference: [0, 1, 2].map(|c| channel(c).reference),
            test: [0, 1, 2].map(|c| channel(c).other),
            width: pair.width,
            height: pair.height,
        };
        let exposures = Exposures::of(images.reference)?;
        Some((flip::hdr(&images, pixels_per_degree, &exposures), exposures))
    }
}
