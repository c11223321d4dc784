//! Light with nothing in its way.

use glam::{DVec2, DVec3};

use super::known_layer::{KnownLayer, KnownLight};
use super::parts::{LightOrigin, OneLight};
use super::plane::{FilmGrid, ReceiverPlane, is_along_normal};
use super::ring_flux::radial_maps;
use crate::radiometry::Rgb;
use crate::reference::closed_form::{
    AxialSpot, KnownPath, TexelRect, lambert_irradiance, parallel_irradiance, point_irradiance,
};
use crate::run::Refusal;

/// Error of a solid angle \[sr\]: four angles of up to π/2, each rounded by some four units in the last
/// place.
const OF_SOLID_ANGLE: f64 = 8e-15;

/// Error of a value that is a few products, relative.
const OF_PRODUCT: f64 = 1e-13;

/// Error of Lambert's sum, as a part of the radiance: four terms below π, each rounded by some eight units in
/// the last place.
const OF_RADIANCE: f64 = 1e-14;

/// Part of an area light's irradiance to which a texel and its quarters must agree, or the texel is cut.
const OF_HALVES: f64 = 1e-11;

/// Largest number of times that a texel is cut.
const MOST_CUTS: u32 = 6;

/// Nodes in −1..=1 and weights of Gauss's rule of four (Abramowitz and Stegun, table 25.4).
const GAUSS: [(f64, f64); 4] = [
    (-0.861_136_311_594_052_6, 0.347_854_845_137_453_8),
    (-0.339_981_043_584_856_3, 0.652_145_154_862_546_2),
    (0.339_981_043_584_856_3, 0.652_145_154_862_546_2),
    (0.861_136_311_594_052_6, 0.347_854_845_137_453_8),
];

/// A light alone with the receiver.
pub(super) struct OpenLight {
    form: OpenForm,
    strength: Rgb,
}

enum OpenForm {
    Point(DVec3),
    Parallel(DVec3),
    Spot(AxialSpot),
    Rectangle([DVec3; 4]),
}

impl OpenLight {
    /// The light of a scene without anything else.
    ///
    /// # Errors
    ///
    /// If it is not in front of the receiver, or a spot that does not look straight at the receiver's middle.
    pub(super) fn new(plane: &ReceiverPlane, light: &OneLight) -> Result<Self, Refusal> {
        let above = |z: f64| {
            if z > 0.0 {
                Ok(())
            } else {
                Err(Refusal::new(format!(
                    "{} has the height {z} over the receiver: closed forms know lights in front of it",
                    light.name
                )))
            }
        };
        let form = match &light.origin {
            LightOrigin::Point(position) => {
                above(position.z)?;
                OpenForm::Point(*position)
            }
            LightOrigin::Parallel(direction) => {
                above(-direction.z)?;
                OpenForm::Parallel(*direction)
            }
            LightOrigin::Spot {
                position,
                axis,
                cutoff_angle,
                beam_width,
            } => {
                above(position.z)?;
                if !plane.is_on_axis(*position) || !is_along_normal(*axis) || axis.z > 0.0 {
                    return Err(Refusal::new(format!(
                        "{} looks along ({}, {}, {}) from ({}, {}, {}) in the receiver's coordinates: closed forms know \
                         spots that look straight down at the receiver's middle",
                        light.name, axis.x, axis.y, axis.z, position.x, position.y, position.z
                    )));
                }
                OpenForm::Spot(AxialSpot {
                    height: position.z,
                    intensity: 1.0,
                    cutoff_angle: *cutoff_angle,
                    beam_width: *beam_width,
                    blocked_angle: 0.0,
                })
            }
            LightOrigin::Rectangle(corners) => {
                for corner in corners {
                    above(corner.z)?;
                }
                let normal = (corners[1] - corners[0]).cross(corners[2] - corners[1]);
                let heights = plane
                    .corners()
                    .map(|corner| (corner.extend(0.0) - corners[0]).dot(normal));
                if heights.iter().any(|height| *height > 0.0)
                    && heights.iter().any(|height| *height <= 0.0)
                {
                    return Err(Refusal::new(format!(
                        "{} shines on a part of the receiver only, from its edge: closed forms know lights whose plane \
                         does not cut the receiver",
                        light.name
                    )));
                }
                OpenForm::Rectangle(*corners)
            }
        };
        Ok(Self {
            form,
            strength: light.strength,
        })
    }

    fn maps(&self, film: &FilmGrid) -> (Vec<f64>, Vec<f64>) {
        let both = |value: &(dyn Fn(&TexelRect) -> f64 + Sync),
                    accuracy: &(dyn Fn(&TexelRect) -> f64 + Sync)| {
            (
                film.in_film_order(&film.grid.map(value)),
                film.in_film_order(&film.grid.map(accuracy)),
            )
        };
        match &self.form {
            OpenForm::Point(position) => {
                let value = |texel: &TexelRect| point_irradiance(*position, 1.0, texel);
                both(&value, &|texel| {
                    OF_SOLID_ANGLE / texel.area() + OF_PRODUCT * value(texel)
                })
            }
            OpenForm::Parallel(direction) => {
                let value = parallel_irradiance(*direction, 1.0, DVec3::Z);
                both(&|_| value, &|_| OF_PRODUCT * value)
            }
            OpenForm::Spot(spot) => radial_maps(&spot.sheets(), film),
            OpenForm::Rectangle(corners) => {
                let at = |texel: &TexelRect| mean_of_lamp(corners, texel, MOST_CUTS);
                both(&|texel| at(texel).0, &|texel| at(texel).1)
            }
        }
    }
}

impl KnownLight for OpenLight {
    fn layers(
        &self,
        plane: &ReceiverPlane,
        _: u32,
        take: &mut dyn FnMut(KnownLayer) -> bool,
    ) -> Result<(), Refusal> {
        let (values, accuracy) = self.maps(&plane.grid());
        take(KnownLayer {
            path: KnownPath::Direct,
            values,
            accuracy,
            factor: self.strength,
        });
        Ok(())
    }
}

/// The mean irradiance of a texel from a rectangle of radiance 1, and its error.
///
/// The rule on the four quarters is 2⁸ times as good as that on the whole, so the difference of both is more
/// than its error. Texels are cut until that is small.
fn mean_of_lamp(corners: &[DVec3; 4], texel: &TexelRect, cuts: u32) -> (f64, f64) {
    let quarters = quarters(texel);
    let whole = mean_by_rule(corners, texel);
    let parts: f64 = 0.25
        * quarters
            .iter()
            .map(|part| mean_by_rule(corners, part))
            .sum::<f64>();
    let difference = (parts - whole).abs();
    if cuts == 0 || difference <= OF_HALVES * parts + OF_RADIANCE {
        return (parts, difference + OF_PRODUCT * parts + OF_RADIANCE);
    }
    let sums = quarters
        .iter()
        .map(|part| mean_of_lamp(corners, part, cuts - 1))
        .fold(DVec2::ZERO, |sums, (value, error)| {
            sums + 0.25 * DVec2::new(value, error)
        });
    (sums.x, sums.y)
}

fn mean_by_rule(corners: &[DVec3; 4], texel: &TexelRect) -> f64 {
    let (middle, half) = (0.5 * (texel.min + texel.max), 0.5 * (texel.max - texel.min));
    GAUSS
        .iter()
        .flat_map(|along| GAUSS.iter().map(move |across| (along, across)))
        .map(|((x, weight_x), (y, weight_y))| {
            let point = middle + half * DVec2::new(*x, *y);
            0.25 * weight_x
                * weight_y
                * lambert_irradiance(point.extend(0.0), DVec3::Z, corners, 1.0)
        })
        .sum()
}

fn quarters(texel: &TexelRect) -> [TexelRect; 4] {
    let TexelRect { min, max } = *texel;
    let middle = 0.5 * (min + max);
    [
        TexelRect::new(min.x, min.y, middle.x, middle.y),
        TexelRect::new(middle.x, min.y, max.x, middle.y),
        TexelRect::new(min.x, middle.y, middle.x, max.y),
        TexelRect::new(middle.x, middle.y, max.x, max.y),
    ]
}
