//! Two parallel faces of glass between the light and the receiver.

use glam::DVec2;

use super::glass::Glass;
use super::known_layer::{KnownLayer, KnownLight};
use super::parts::{Body, LightOrigin, OneLight};
use super::plane::{ReceiverPlane, is_along_normal};
use super::ring_flux::radial_maps;
use crate::geometry::Rectangle;
use crate::radiometry::Rgb;
use crate::reference::closed_form::{FlatSlab, KnownPath};
use crate::run::Refusal;

/// Error of a texel in parallel light, as a part of its value: Fresnel's formula and a few products.
const OF_CONSTANT: f64 = 1e-13;

/// A pane in light of strength 1.
///
/// Its borders are out of play. From a point on the axis all light moves outward as it goes down, and light
/// straight down does not move at all. So light on the receiver has met both faces no farther from the axis
/// than it lands; and light by a border, or past it, lands farther out than the border. The receiver must
/// therefore reach less far than both faces do.
pub(super) struct Pane {
    slab: FlatSlab,
    glass: Glass,
    /// Height of a point light; `None` for parallel light.
    light_height: Option<f64>,
    strength: Rgb,
}

impl Pane {
    /// The pane of a scene.
    ///
    /// # Errors
    ///
    /// If the faces are not parallel to the receiver, of one glass, and wide enough, or the light is neither
    /// on the normal through the receiver's middle nor along it.
    pub(super) fn new(
        plane: &ReceiverPlane,
        light: &OneLight,
        faces: [(&Body, &Rectangle); 2],
    ) -> Result<Self, Refusal> {
        let height = |face: &Rectangle| plane.point(face.center()).z;
        let [mut top, mut bottom] = faces;
        if height(top.1) < height(bottom.1) {
            (top, bottom) = (bottom, top);
        }
        for (body, face) in [top, bottom] {
            if !is_along_normal(plane.vector(face.normal())) {
                return Err(Refusal::new(format!(
                    "{} is not parallel to the receiver: the faces of a pane must be",
                    body.name
                )));
            }
            let reach = inscribed_radius(plane, face);
            if reach <= plane.reach() {
                return Err(Refusal::new(format!(
                    "{} has a border {reach} from the normal through the receiver's middle, and the receiver reaches {}: \
                     the faces of a pane must reach farther than the receiver",
                    body.name,
                    plane.reach()
                )));
            }
        }
        let rises = |face: &Rectangle| plane.vector(face.normal()).z > 0.0;
        if rises(top.1) == rises(bottom.1) {
            return Err(Refusal::new(format!(
                "{} and {} face the same way: the normals of a pane's faces must point away from each other",
                top.0.name, bottom.0.name
            )));
        }
        let (glass, other) = (
            Glass::of(top.0, !rises(top.1))?,
            Glass::of(bottom.0, rises(bottom.1))?,
        );
        if glass != other {
            return Err(Refusal::new(format!(
                "{} and {} are of different glass: a pane is of one",
                top.0.name, bottom.0.name
            )));
        }
        if height(bottom.1) <= 0.0 || height(top.1) <= height(bottom.1) {
            return Err(Refusal::new(format!(
                "{} is {} over the receiver and {} is {}: a pane must be thick, and in front of the receiver",
                top.0.name,
                height(top.1),
                bottom.0.name,
                height(bottom.1)
            )));
        }
        let light_height = match light.origin {
            LightOrigin::Point(position) if plane.is_on_axis(position) => Some(position.z),
            LightOrigin::Parallel(direction) if is_along_normal(direction) && direction.z < 0.0 => {
                None
            }
            _ => {
                return Err(Refusal::new(format!(
                    "{} shines on a pane: closed forms know a point on the normal through the receiver's middle, and \
                     parallel light along it",
                    light.name
                )));
            }
        };
        if light_height.is_some_and(|light_height| light_height <= height(top.1)) {
            return Err(Refusal::new(format!(
                "{} is not above {}: the light of a pane must be",
                light.name, top.0.name
            )));
        }
        Ok(Self {
            slab: FlatSlab {
                thickness: height(top.1) - height(bottom.1),
                ior: glass.ior,
            },
            glass,
            light_height,
            strength: light.strength,
        })
    }
}

impl KnownLight for Pane {
    fn layers(
        &self,
        plane: &ReceiverPlane,
        max_depth: u32,
        take: &mut dyn FnMut(KnownLayer) -> bool,
    ) -> Result<(), Refusal> {
        let film = plane.grid();
        let texels = film.grid.columns * film.grid.rows;
        let layer = |path: KnownPath, (values, accuracy): (Vec<f64>, Vec<f64>)| KnownLayer {
            path,
            values,
            accuracy,
            factor: self.strength * self.glass.factor(path),
        };
        let shade = layer(KnownPath::Direct, (vec![0.0; texels], vec![0.0; texels]));
        // An odd number of reflections inside sends light back up.
        let through = (2..=max_depth).step_by(2).map(|events| {
            let path = KnownPath::Through(events - 2);
            let maps = if let Some(height) = self.light_height {
                radial_maps(&[self.slab.sheet(height, 1.0, path)], &film)
            } else {
                let value = self.slab.transmitted_fraction(1.0, path);
                (vec![value; texels], vec![OF_CONSTANT * value; texels])
            };
            layer(path, maps)
        });
        std::iter::once(shade).chain(through).all(take);
        Ok(())
    }
}

/// Distance of the nearest side of a face from the normal through the receiver's middle; negative if that
/// normal misses the face.
fn inscribed_radius(plane: &ReceiverPlane, face: &Rectangle) -> f64 {
    let corners = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)]
        .map(|(u, v)| plane.point(face.point(DVec2::new(u, v))).truncate());
    let turn = (corners[1] - corners[0])
        .perp_dot(corners[2] - corners[1])
        .signum();
    (0..4)
        .map(|side| {
            let (from, to) = (corners[side], corners[(side + 1) % 4]);
            turn * (to - from).normalize().perp_dot(-from)
        })
        .fold(f64::INFINITY, f64::min)
}
