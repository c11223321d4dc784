//! Maps of the differences of two images, to look at.

use rayon::prelude::*;

use super::pair::LayerPair;
use crate::film::Grid;

/// Maps of a layer, channels averaged, row 0 first.
#[derive(Clone, Debug, PartialEq)]
pub struct Maps {
    /// The other image less the reference, in the image's unit.
    pub difference: Grid<f32>,
    /// The difference over the reference; NaN if the reference is not above zero.
    pub relative: Grid<f32>,
    /// The difference in standard errors, for the channel with the largest; NaN for a texel without error
    /// bar. `None` if neither image has any.
    pub z: Option<Grid<f32>>,
}

impl Maps {
    /// The maps of a layer.
    pub fn of(pair: &LayerPair) -> Self {
        let share = 1.0 / pair.channels.len() as f64;
        let means = |texel: usize| {
            pair.channels.iter().fold([0.0; 2], |[r, o], one| {
                [
                    r + share * f64::from(one.reference[texel]),
                    o + share * f64::from(one.other[texel]),
                ]
            })
        };
        Self {
            difference: grid(pair, |texel| {
                let [reference, other] = means(texel);
                other - reference
            }),
            relative: grid(pair, |texel| {
                let [reference, other] = means(texel);
                if reference > 0.0 {
                    (other - reference) / reference
                } else {
                    f64::NAN
                }
            }),
            z: (!pair.tests.is_empty()).then(|| {
                grid(pair, |texel| {
                    pair.tests
                        .iter()
                        .filter_map(|test| test.score(texel))
                        .map(|score| score.z())
                        .fold(
                            f64::NAN,
                            |largest: f64, z| {
                                if largest.abs() >= z.abs() { largest } else { z }
                            },
                        )
                })
            }),
        }
    }
}

fn grid(pair: &LayerPair, value: impl Fn(usize) -> f64 + Sync) -> Grid<f32> {
    let mut values = vec![0.0; pair.texels()];
    values
        .par_iter_mut()
        .enumerate()
        .for_each(|(texel, place)| *place = value(texel) as f32);
    let mut values = values.into_iter();
    Grid::from_fn(pair.width, pair.height, |_, _| values.next().unwrap_or(0.0))
}

/// Half the range of a map's numbers about zero: the value that 99 of 100 do not exceed. `None` if there is
/// no contrast.
pub fn reach(map: &Grid<f32>) -> Option<f64> {
    let mut sizes: Vec<f32> = map
        .iter()
        .map(|v| v.abs())
        .filter(|v| v.is_finite())
        .collect();
    if sizes.is_empty() {
        return None;
    }
    let rank = (sizes.len() * 99 / 100).min(sizes.len() - 1);
    let reach = *sizes.select_nth_unstable_by(rank, f32::total_cmp).1;
    // If only a few texels differ, the 99th percentile is zero.
    let reach = if reach > 0.0 {
        reach
    } else {
        sizes.iter().copied().fold(0.0, f32::max)
    };
    (reach > 0.0).then_some(f64::from(reach))
}
