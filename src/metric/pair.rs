//! Two images, layer beside layer.

use super::bars::Bars;
use super::compare_image::{ChannelKind, Contents, component, names};
use super::layer_bars::LayerBars;
use super::settings::ImageSide;
use super::texel_grid::TexelGrid;
use super::{CompareError, CompareImage};

/// A layer of the reference beside the same layer of the other image.
#[derive(Clone, Debug)]
pub struct LayerPair<'a> {
    /// `LTTD`, ...; for all light the name it has in both files, or `total`.
    pub name: String,
    /// True if it is all light.
    pub is_total: bool,
    /// Texels a row.
    pub width: usize,
    /// Rows.
    pub height: usize,
    /// The place of the upper left texel in the files.
    pub corner: [usize; 2],
    /// Red, green and blue, or luminance alone.
    ///
    /// If all three are the same in both images, one channel stands for them: each figure over channels is
    /// then the same.
    pub channels: Vec<ChannelPair<'a>>,
    /// The channels again, with their error bars, as they can be tested: X, Y and Z if one image has its
    /// moments in these. Empty if neither image has error bars.
    pub tests: Vec<TestPair<'a>>,
    /// Size and area of its texels.
    pub grid: TexelGrid<'a>,
}

/// A channel in both images, row by row.
#[derive(Clone, Debug)]
pub struct ChannelPair<'a> {
    /// Its name, as the reference calls it.
    pub name: String,
    /// The truth.
    pub reference: &'a [f32],
    /// The values compared with it.
    pub other: &'a [f32],
}

/// A channel with its error bars in both images.
#[derive(Clone, Debug)]
pub struct TestPair<'a> {
    /// Its name.
    pub name: String,
    /// The truth.
    pub reference: Bars<'a>,
    /// The values compared with it.
    pub other: Bars<'a>,
}

/// All layers that two images share, with notes on oddities.
#[derive(Clone, Debug)]
pub struct Pairing<'a> {
    /// All light first, then layer by layer.
    pub pairs: Vec<LayerPair<'a>>,
    /// Layers that only one image has, and the like.
    pub notes: Vec<String>,
}

impl<'a> Pairing<'a> {
    /// The layers of two images side by side; `wanted` are those to take, all if empty.
    ///
    /// # Errors
    ///
    /// If the images differ in size, channels or quantity, or a wanted layer is not in both. Also if a layer
    /// that is taken has anything but finite numbers, negative standard errors or crossed bounds.
    pub fn new(
        a: &'a CompareImage,
        b: &'a CompareImage,
        reference: ImageSide,
        wanted: &[String],
    ) -> Result<Self, CompareError> {
        check_sizes(a, b)?;
        let contents =
            [a, b].map(|source| Contents::new(&source.name, &source.image, source.corner));
        let [in_a, in_b] = &contents;
        let totals = [in_a.total()?, in_b.total()?];
        if totals[0] != totals[1] && totals.iter().all(|name| !name.is_empty()) {
            return Err(CompareError::Quantity {
                file: a.name.clone(),
                quantity: totals[0].to_owned(),
                other: b.name.clone(),
                other_quantity: totals[1].to_owned(),
            });
        }
        let total = if totals[0] == totals[1] && !totals[0].is_empty() {
            totals[0]
        } else {
            "total"
        };
        let [layers_a, layers_b] = [in_a.layers(), in_b.layers()];
        // The rest without layers of its own is the same light only if the same layers were split off.
        let is_comparable = |name: &str| name != REST || layers_a == layers_b;
        let shared: Vec<&str> = layers_a
            .iter()
            .copied()
            .filter(|name| layers_b.contains(name) && is_comparable(name))
            .collect();
        let is_wanted = |name: &str| wanted.is_empty() || wanted.iter().any(|one| one == name);
        if let Some(missing) = wanted
            .iter()
            .find(|name| *name != total && !shared.contains(&name.as_str()))
        {
            let there: Vec<&str> = std::iter::once(total).chain(shared).collect();
            return Err(CompareError::NoLayer {
                layer: missing.clone(),
                there: there.join(", "),
            });
        }
        let mut notes = Vec::new();
        for (source, own, others) in [(a, &layers_a, &layers_b), (b, &layers_b, &layers_a)] {
            let alone: Vec<&str> = own
                .iter()
                .copied()
                .filter(|name| !others.contains(name))
                .collect();
            if !alone.is_empty() && !others.is_empty() {
                notes.push(format!(
                    "only {} has layers {}: not compared",
                    source.name,
                    alone.join(", ")
                ));
            }
        }
        if layers_a.contains(&REST) && layers_b.contains(&REST) && !is_comparable(REST) {
            notes.push(format!(
                "layer {REST} is the rest of other signatures in each image: not compared"
            ));
        }
        let mut pairs = Vec::new();
        if is_wanted(total) {
            pairs.push(pair(total, true, totals, [a, b], &contents, reference)?);
        }
        for name in shared.into_iter().filter(|name| is_wanted(name)) {
            pairs.push(pair(name, false, [name; 2], [a, b], &contents, reference)?);
        }
        Ok(Self { pairs, notes })
    }
}

/// The layer of all signatures without one of their own.
const REST: &str = "other";

fn check_sizes(a: &CompareImage, b: &CompareImage) -> Result<(), CompareError> {
    let size = |image: &crate::film::Image| [image.width, image.height];
    let images = [(&b.name, &b.image)];
    let errors = [a, b]
        .into_iter()
        .filter_map(|source| source.errors.as_ref())
        .map(|(name, image)| (name, image));
    match images
        .into_iter()
        .chain(errors)
        .find(|(_, image)| size(image) != size(&a.image))
    {
        Some((other, image)) => Err(CompareError::Size {
            file: a.name.clone(),
            size: size(&a.image),
            other: other.clone(),
            other_size: size(image),
        }),
        None => Ok(()),
    }
}

/// One layer of both images; `layers` are its names in A and B.
fn pair<'a>(
    name: &str,
    is_total: bool,
    layers: [&str; 2],
    sources: [&'a CompareImage; 2],
    contents: &[Contents<'a>; 2],
    reference: ImageSide,
) -> Result<LayerPair<'a>, CompareError> {
    let [a, b] = [0, 1].map(|i| contents[i].colour(layers[i], ChannelKind::Value));
    if a.len() != b.len() {
        return Err(CompareError::Channels {
            layer: name.to_owned(),
            file: sources[0].name.clone(),
            channels: names(a.into_iter()),
            other: sources[1].name.clone(),
            other_channels: names(b.into_iter()),
        });
    }
    contents[0].check_finite(&a)?;
    contents[1].check_finite(&b)?;
    let measured = [
        LayerBars::of(&contents[0], sources[0], layers[0], is_total)?,
        LayerBars::of(&contents[1], sources[1], layers[1], is_total)?,
    ];
    let ordered = |[a, b]: [_; 2]| match reference {
        ImageSide::A => (a, b),
        ImageSide::B => (b, a),
    };
    let (truth, other) = ordered([a, b]);
    let mut channels: Vec<ChannelPair> = truth
        .into_iter()
        .zip(other)
        .map(|(truth, other)| ChannelPair {
            name: component(&truth.name).to_owned(),
            reference: &truth.samples,
            other: &other.samples,
        })
        .collect();
    if channels
        .iter()
        .all(|one| one.reference == channels[0].reference && one.other == channels[0].other)
    {
        channels.truncate(1);
    }
    let mut tests = tests(measured, reference);
    if tests
        .iter()
        .all(|one| one.reference == tests[0].reference && one.other == tests[0].other)
    {
        tests.truncate(1);
    }
    Ok(LayerPair {
        name: name.to_owned(),
        is_total,
        width: sources[0].image.width,
        height: sources[0].image.height,
        corner: sources[0].corner,
        channels,
        tests,
        grid: match reference {
            ImageSide::A => TexelGrid::of(sources[0], sources[1]),
            ImageSide::B => TexelGrid::of(sources[1], sources[0]),
        },
    })
}

/// The channels of a layer with their bars; none if neither image has any.
fn tests(measured: [LayerBars; 2], reference: ImageSide) -> Vec<TestPair> {
    let has_bars = measured
        .iter()
        .any(|one| one.bars.iter().any(Bars::has_any));
    let [a, b] = LayerBars::alike(measured);
    if !has_bars {
        return Vec::new();
    }
    let bars = a.bars.into_iter().zip(b.bars);
    a.names
        .into_iter()
        .zip(bars)
        .map(|(name, (a, b))| {
            let (reference, other) = match reference {
                ImageSide::A => (a, b),
                ImageSide::B => (b, a),
            };
            TestPair {
                name: name.to_owned(),
                reference,
                other,
            }
        })
        .collect()
}

impl LayerPair<'_> {
    /// Number of texels.
    pub fn texels(&self) -> usize {
        self.width * self.height
    }

    /// Column and row of a texel in the files.
    pub fn place(&self, texel: usize) -> [usize; 2] {
        [
            self.corner[0] + texel % self.width,
            self.corner[1] + texel / self.width,
        ]
    }
}
