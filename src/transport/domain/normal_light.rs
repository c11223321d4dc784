//! Light that leaves each place of a surface along its normal: Mitsuba's `directionalarea`.
//!
//! A flat part is a window for parallel light of irradiance M / cos α, with M the radiant exitance and α the
//! angle of the light to the part's normal. It is 0, but where a mesh's vertex normals lean. A ball's light
//! is that of a point in its middle, of intensity M r², which starts at its surface.

use glam::{DVec2, DVec3};

use super::face::{face_frustum, face_sample, rectangle_solid_angle};
use super::patch::{ChartPatch, Emission};
use super::pattern::Pattern;
use super::polygon::{area, cut};
use super::probe::Probe;
use super::surface::{ACROSS, Area, LightPart, LightSurface, surface_point};
use crate::geometry::{Shape, SurfacePoint};
use crate::radiometry::Rgb;
use crate::scene::{Emitter, Scene};

/// The light of a part of a surface along its normals.
#[derive(Clone, Debug)]
pub struct NormalLight {
    form: NormalForm,
    /// Radiant exitance [W/m²], a factor on the pattern if there is one.
    exitance: Rgb,
    pattern: Option<Pattern>,
}

#[derive(Clone, Copy, Debug)]
enum NormalForm {
    Flat(FlatLight),
    /// A ball, or the part of it in the directions of a cube-map face with this frame.
    Ball {
        center: DVec3,
        radius: f64,
        axes: [DVec3; 3],
    },
}

/// Parallel light from a flat part.
#[derive(Clone, Copy, Debug)]
struct FlatLight {
    area: Area,
    /// The unit normal on the side of `direction`.
    normal: DVec3,
    /// The unit vector along which light travels.
    direction: DVec3,
    /// Vectors that give the coordinates of a vector in the plane.
    duals: [DVec3; 2],
    /// Area [m²] by coordinates.
    scale: f64,
}

/// Straight light from a part to a point.
#[derive(Clone, Copy, Debug)]
pub struct NormalRay {
    /// The length of a shadow ray to the part, without its own surface.
    pub reach: f64,
    /// The pattern's value at its start.
    pub value: Rgb,
}

impl NormalLight {
    /// The parts of an emitter; none for other emitters, and for surfaces without an area.
    ///
    /// Surfaces that have no [`LightSurface`] give `None`.
    pub fn parts(scene: &Scene, emitter: &Emitter) -> Option<Vec<Self>> {
        let Emitter::DirectionalArea {
            shape,
            exitance,
            texture,
        } = emitter
        else {
            return Some(Vec::new());
        };
        let surface = &scene.world().shapes()[shape.0 as usize];
        let parts = LightSurface::new(surface)?;
        let patterns = |numbers: &[u32], across: u32| -> Vec<Option<Pattern>> {
            match texture {
                None => vec![None; numbers.len()],
                Some(id) => {
                    let all = Pattern::all(scene, *id, surface, numbers.iter().copied(), across);
                    all.into_iter().map(Some).collect()
                }
            }
        };
        let light = |form, pattern: Option<Pattern>| {
            let even = pattern.as_ref().and_then(Pattern::even);
            Self {
                form,
                exitance: even.map_or(*exitance, |value| *exitance * value),
                pattern: pattern.filter(|_| even.is_none()),
            }
        };
        if let Some((area, normal)) = parts.rectangle() {
            let form = FlatLight::new(area, normal).map(NormalForm::Flat);
            let pattern = patterns(&[0], 1).pop().flatten();
            return Some(form.map(|form| light(form, pattern)).into_iter().collect());
        }
        let numbers: Vec<u32> = parts.numbered().map(|(number, _)| number).collect();
        let patterns = patterns(&numbers, ACROSS);
        let of_part = |((number, part), pattern): ((u32, &LightPart), Option<Pattern>)| {
            let form = match part {
                LightPart::Flat(area, normal) => {
                    let direction = match surface {
                        Shape::Mesh(mesh) => mesh.even_shading_normal(number)?,
                        _ => *normal,
                    };
                    NormalForm::Flat(FlatLight::new(*area, direction)?)
                }
                LightPart::Ball { center, radius } => NormalForm::Ball {
                    center: *center,
                    radius: *radius,
                    axes: [DVec3::X, DVec3::Y, DVec3::Z],
                },
            };
            Some(light(form, pattern))
        };
        Some(parts.numbered().zip(patterns).filter_map(of_part).collect())
    }

    /// The charts over it: itself, or the ball's part before each of some cube-map faces.
    pub(super) fn charts(self, faces: &[[DVec3; 3]]) -> Vec<Self> {
        let NormalForm::Ball { center, radius, .. } = self.form else {
            return vec![self];
        };
        let of_face = |axes: &[DVec3; 3]| Self {
            form: NormalForm::Ball {
                center,
                radius,
                axes: *axes,
            },
            ..self.clone()
        };
        faces.iter().map(of_face).collect()
    }

    /// Radiant exitance [W/m²], a factor on the texture if it has one.
    pub fn strength(&self) -> Rgb {
        self.exitance
    }

    /// True if it shines unevenly.
    pub fn has_pattern(&self) -> bool {
        self.pattern.is_some()
    }

    /// The emitter without a size whose light it is, where [`meets`](Self::meets) finds a ray. With a pattern
    /// it is for the value 1.
    pub fn without_size(&self) -> Emitter {
        match self.form {
            NormalForm::Flat(flat) => Emitter::Directional {
                direction: flat.direction,
                irradiance: self.exitance / flat.normal.dot(flat.direction),
            },
            NormalForm::Ball { center, radius, .. } => Emitter::Point {
                position: center,
                intensity: self.exitance * (radius * radius),
            },
        }
    }

    /// The straight ray of light to a point, if nothing is in the way; `None` where there is none.
    pub fn meets(&self, point: &SurfacePoint) -> Option<NormalRay> {
        let (distance, cosine, start, value) = match &self.form {
            NormalForm::Flat(flat) => {
                let (origin, [x, y]) = flat.area.axes();
                let cosine = flat.normal.dot(flat.direction);
                let (place, distance) = flat.origin_of(point.position);
                if !(distance > 0.0 && flat.area.holds(place)) {
                    return None;
                }
                let value = self.pattern.as_ref().map(|it| it.value(place));
                let start = origin + x * place.x + y * place.y;
                (distance, cosine, surface_point(start, flat.normal), value)
            }
            NormalForm::Ball { center, radius, .. } => {
                let offset = point.position - *center;
                let direction = offset.try_normalize()?;
                let value = self.pattern.as_ref().map(|it| it.value_along(direction));
                let start = surface_point(*center + direction * *radius, direction);
                (offset.length() - *radius, 1.0, start, value)
            }
        };
        let margin = start.position_error.length() + point.position_error.length();
        let reach = distance * (1.0 - 8.0 * f64::EPSILON) - 2.0 * margin / cosine;
        (reach > 0.0).then_some(NormalRay {
            reach,
            value: value.unwrap_or(Rgb::WHITE),
        })
    }

    /// The surface of a flat part.
    pub fn area(&self) -> Option<Area> {
        match &self.form {
            NormalForm::Flat(flat) => Some(flat.area),
            NormalForm::Ball { .. } => None,
        }
    }

    /// The place on the plane of a flat part from which light would come to a point, and its way from there
    /// \[m\]; it is below 0 behind the part. `None` for balls.
    pub fn origin_of(&self, point: DVec3) -> Option<(DVec2, f64)> {
        match &self.form {
            NormalForm::Flat(flat) => Some(flat.origin_of(point)),
            NormalForm::Ball { .. } => None,
        }
    }

    /// A bound of the pattern's values, on a patch of places if it is known; 1 without a pattern.
    pub fn peak(&self, places: Option<&ChartPatch>) -> Rgb {
        match (&self.pattern, places) {
            (None, _) => Rgb::WHITE,
            (Some(pattern), None) => pattern.peak(),
            (Some(pattern), Some(places)) => pattern.peak_in(places),
        }
    }

    /// True if a patch is known to send no light.
    pub(super) fn is_dark(&self, patch: &ChartPatch) -> bool {
        let nearest = DVec2::ZERO.clamp(patch.from, patch.to);
        let is_off = match &self.form {
            NormalForm::Flat(flat) => match flat.area {
                Area::Parallelogram { .. } => false,
                Area::Triangle(_) => patch.from.x + patch.from.y >= 1.0,
                Area::Disk { .. } => nearest.length_squared() >= 1.0,
            },
            NormalForm::Ball { .. } => return self.flux_bound(patch).is_black(),
        };
        is_off || (self.exitance * self.peak(Some(patch))).is_black()
    }

    /// The patch of all places on the chart.
    pub(super) fn root(&self) -> ChartPatch {
        let (from, to) = match &self.form {
            NormalForm::Flat(flat) => flat.area.extent(),
            NormalForm::Ball { .. } => (DVec2::NEG_ONE, DVec2::ONE),
        };
        ChartPatch { from, to }
    }

    /// True if a patch holds more than a texel, of which some may be bright and others dark.
    pub(super) fn is_uneven(&self, patch: &ChartPatch) -> bool {
        let pattern = self.pattern.as_ref();
        pattern.is_some_and(|pattern| pattern.pieces_across(patch) > 1.0)
    }

    /// The region that light of a patch can reach.
    pub(super) fn probe(&self, patch: &ChartPatch) -> Probe {
        match &self.form {
            NormalForm::Flat(flat) => flat.probe(patch),
            NormalForm::Ball { center, axes, .. } => face_frustum(*center, 0.0, axes, patch),
        }
    }

    /// The flux of a patch \[W\]. It is an upper bound on discs and on balls with a texture.
    pub(super) fn flux_bound(&self, patch: &ChartPatch) -> Rgb {
        match &self.form {
            NormalForm::Flat(flat) => {
                let whole = patch.corners();
                let outline = match flat.area {
                    Area::Parallelogram { .. } => whole.to_vec(),
                    Area::Triangle(_) => cut(&whole, |place| 1.0 - place.x - place.y),
                    Area::Disk { .. } => {
                        if DVec2::ZERO.clamp(patch.from, patch.to).length_squared() >= 1.0 {
                            return Rgb::BLACK;
                        }
                        whole.to_vec()
                    }
                };
                let flux = self.exitance * flat.scale;
                match &self.pattern {
                    Some(pattern) => flux * pattern.integral_bound(&outline),
                    None => flux * area(&outline),
                }
            }
            NormalForm::Ball { radius, .. } => {
                let flux = self.exitance * (radius * radius * rectangle_solid_angle(patch));
                match &self.pattern {
                    Some(pattern) => flux * pattern.peak(),
                    None => flux,
                }
            }
        }
    }

    /// The ray at fractions `at` across a patch.
    #[inline]
    pub(super) fn emit(&self, patch: &ChartPatch, at: DVec2) -> Emission {
        let place = patch.at(at);
        match &self.form {
            NormalForm::Flat(flat) => {
                let (origin, [x, y]) = flat.area.axes();
                let start = surface_point(origin + x * place.x + y * place.y, flat.normal);
                let is_lit = flat.area.holds(place);
                Emission {
                    ray: start.spawn(flat.direction),
                    measure: if is_lit {
                        flat.scale * patch.area()
                    } else {
                        0.0
                    },
                    color: self.pattern.as_ref().map(|it| it.value(place)),
                }
            }
            NormalForm::Ball {
                center,
                radius,
                axes,
            } => {
                let (direction, jacobian) = face_sample(axes, place);
                let start = surface_point(*center + direction * *radius, direction);
                Emission {
                    ray: start.spawn(direction),
                    measure: radius * radius * jacobian * patch.area(),
                    color: self.pattern.as_ref().map(|it| it.value_along(direction)),
                }
            }
        }
    }
}

impl FlatLight {
    /// `None` for a part without area, and for light along the part itself.
    fn new(area: Area, direction: DVec3) -> Option<Self> {
        /// A cosine below this is rounding.
        const GRAZING: f64 = 1e-12;
        let (_, [x, y]) = area.axes();
        let cross = x.cross(y);
        let scale = cross.length();
        let normal = cross.try_normalize()?;
        let normal = if normal.dot(direction) < 0.0 {
            -normal
        } else {
            normal
        };
        let duals = [y.cross(cross), cross.cross(x)].map(|it| it / (scale * scale));
        let is_usable = duals.iter().all(|dual| dual.is_finite());
        (is_usable && normal.dot(direction) > GRAZING).then_some(Self {
            area,
            normal,
            direction,
            duals,
            scale,
        })
    }

    /// The place on its plane from which light would come to a point, and its way from there \[m\].
    fn origin_of(&self, point: DVec3) -> (DVec2, f64) {
        let (origin, _) = self.area.axes();
        let offset = point - origin;
        let distance = offset.dot(self.normal) / self.normal.dot(self.direction);
        let back = offset - self.direction * distance;
        let place = DVec2::new(self.duals[0].dot(back), self.duals[1].dot(back));
        (place, distance)
    }

    /// The beam of a patch, between planes along its light.
    fn probe(&self, patch: &ChartPatch) -> Probe {
        let (origin, [x, y]) = self.area.axes();
        let (across, other) = self.direction.any_orthonormal_pair();
        // One side along an edge, as light sees it: a rectangle's beam is then no wider than the patch.
        let along = x - self.direction * x.dot(self.direction);
        let across = along.try_normalize().map_or([across, other], |along| {
            [along, self.direction.cross(along).normalize()]
        });
        let corners = patch.corners().map(|at| origin + x * at.x + y * at.y);
        let ranges = across.map(|axis| {
            let places = corners.map(|corner| corner.dot(axis));
            let low = places.into_iter().fold(f64::INFINITY, f64::min);
            let high = places.into_iter().fold(f64::NEG_INFINITY, f64::max);
            [low, high]
        });
        Probe::Prism { across, ranges }
    }
}
