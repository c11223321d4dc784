//! What images say of their texels: size, area, and whether they lie in a plane.

use super::CompareImage;
use crate::film::Image;

/// The texels of a layer, as an image's description has them.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct TexelGrid<'a> {
    /// Width and height of a texel \[m\], if all are the same.
    pub spacing: Option<[f64; 2]>,
    /// The area of each texel \[m²\], if they differ.
    pub areas: Option<&'a [f32]>,
    /// The reason why distances between texels are not those of a plane, if there is one.
    pub not_a_plane: Option<String>,
}

/// The attribute with the size of texels \[m\], `[width,height]`.
pub const SIZE: &str = "texel-size";

/// The attribute that names a surface whose texels do not lie side by side in a plane.
pub const SURFACE: &str = "texel-surface";

/// The channel with the texels' areas \[m²\].
pub const AREA: &str = "area.Y";

impl<'a> TexelGrid<'a> {
    /// The texels as the truth describes them, or, if it says nothing of them, as the other image does.
    pub(super) fn of(truth: &'a CompareImage, other: &'a CompareImage) -> Self {
        let says_any = |image: &&'a Image| {
            let mut keys = [SIZE, SURFACE].into_iter();
            keys.any(|key| image.metadata(key).is_some()) || image.channel(AREA).is_some()
        };
        let Some(image) = [&truth.image, &other.image].into_iter().find(says_any) else {
            return Self::default();
        };
        let areas = image
            .channel(AREA)
            .map(|channel| channel.samples.as_slice());
        let is_area = |area: &f32| area.is_finite() && *area >= 0.0;
        let areas = areas.filter(|areas| areas.iter().all(is_area));
        let areas = areas.filter(|areas| areas.iter().any(|area| *area > 0.0));
        let surface = image.metadata(SURFACE);
        let surface = surface.or(areas.map(|_| "a surface whose texels differ in area"));
        Self {
            spacing: spacing(image),
            areas,
            not_a_plane: surface.map(|surface| {
                format!("the receiver is {surface}: distances between its texels are not those of a plane")
            }),
        }
    }

    /// The weight of a texel in sums: its area, or one where all are the same.
    pub(super) fn weight(&self, texel: usize) -> f64 {
        self.areas.map_or(1.0, |areas| f64::from(areas[texel]))
    }
}

/// Width and height of an image's texels \[m\], if it says so.
pub fn spacing(image: &Image) -> Option<[f64; 2]> {
    image.metadata(SIZE).and_then(size)
}

fn size(text: &str) -> Option<[f64; 2]> {
    let size: [f64; 2] = serde_json::from_str(text).ok()?;
    size.iter()
        .all(|side| side.is_finite() && *side > 0.0)
        .then_some(size)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_size_that_is_none_is_no_size() {
        assert_eq!(size("[0.5,0.25]"), Some([0.5, 0.25]));
        for text in ["", "0.5", "[0.5]", "[0,1]", "[-1,1]", "[null,1]", "[1,1,1]"] {
            assert_eq!(size(text), None, "{text}");
        }
    }

    #[test]
    fn a_truth_that_says_nothing_of_its_texels_is_described_by_the_other_image() {
        let plain = CompareImage::new("truth", Image::new(1, 1));
        let mut image = Image::new(1, 1);
        image.add_metadata(SIZE, "[2.0,2.0]");
        let other = CompareImage::new("other", image);
        assert_eq!(TexelGrid::of(&plain, &other).spacing, Some([2.0, 2.0]));
        assert_eq!(TexelGrid::of(&plain, &plain), TexelGrid::default());
        // What the other image says besides is not mixed in.
        let mut image = Image::new(1, 1);
        image.add_metadata(SURFACE, "a sphere");
        image.add_scalar(AREA, [0.0]);
        let odd = CompareImage::new("odd", image);
        assert_eq!(TexelGrid::of(&other, &odd), TexelGrid::of(&other, &plain));
        let found = TexelGrid::of(&plain, &odd);
        assert!(found.areas.is_none() && found.not_a_plane.is_some());
    }
}
